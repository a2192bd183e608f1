# SPDX-License-Identifier: LGPL-3.0-or-later
"""A series of frames for ParaView: OUT/series.pvd."""

import os
from pathlib import Path

from .files import write_atomically


class Series:
    """Frames of a moving surface: FOLDER/NAME.pvd and NAME/0000.vtu, ... for ParaView.

    Parameters
    ----------
    folder : path; name : str
    until : float or None, go on with the series that is there, its frames up to this time [s]
    """

    def __init__(self, folder, name="series", until=None):
        self.index, self.frames = Path(folder) / f"{name}.pvd", Path(folder) / name
        self.entries = []
        if until is not None and self.index.is_file():
            lines = self.index.read_text().splitlines()
            entries = [line for line in lines if "<DataSet" in line]
            self.entries = [e for e in entries if float(e.split('"')[1]) <= until + 1e-9]

    def write(self, shell, time, **fields):
        """Add the present state of a shell at a time [s] or load level.

        fields : further nodal values by name, (n,) or (n, 3) in the surface's numbering, on rank 0
        """
        positions, directors = shell.positions(), shell.directors()
        if shell.comm.rank:
            return
        import meshio

        self.frames.mkdir(parents=True, exist_ok=True)
        surface = shell.surface
        kind = {3: "triangle", 4: "quad", 9: "quad9"}[surface.cells.shape[1]]
        path = self.frames / f"{len(self.entries):04d}.vtu"
        part = path.with_suffix(".part.vtu")
        displacements = positions - surface.points
        data = {"displacement": displacements, "director": directors} | fields
        meshio.Mesh(positions, [(kind, surface.cells)], point_data=data).write(part)
        os.replace(part, path)
        self.entries.append(
            f'    <DataSet timestep="{float(time):.9g}" file="{path.parent.name}/{path.name}"/>'
        )
        lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">']
        lines += ["  <Collection>", *self.entries, "  </Collection>", "</VTKFile>", ""]
        write_atomically(self.index, "\n".join(lines))

# SPDX-License-Identifier: LGPL-3.0-or-later
"""A series of frames for ParaView: OUT/series.pvd."""

import os
from pathlib import Path

import numpy as np

from shellform.fem.shell import Shell

from .files import write_atomically
from .stretch import stretch_of_cells

WRINKLES = "wrinkling", "crest", "wrinkle_strain"  # cell data, those of `Wrinkling`


class Series:
    """Frames of a moving surface: FOLDER/NAME.pvd and NAME/0000.vtu, ... for ParaView.

    Parameters
    ----------
    folder : path; name : str
    until : float or None, go on with the series that is there, its frames up to this time [s]
    """

    def __init__(self, folder: str | Path, name: str = "series", until: float | None = None):
        self.index, self.frames = Path(folder) / f"{name}.pvd", Path(folder) / name
        self.lines: list[str] = []
        if until is not None and self.index.is_file():
            lines = [one for one in self.index.read_text().splitlines() if "<DataSet" in one]
            self.lines = [one for one in lines if float(one.split('"')[1]) <= until + 1e-9]

    def write(self, shell: Shell, time: float, stretch: bool = False, **fields: np.ndarray) -> None:
        """Add the present state of a shell at a time [s] or load level.

        stretch : whether cells get theirs, see stretch.py
        fields : further nodal values by name, (n,) or (n, 3) in the surface's numbering, on rank 0

        Cells of a relaxed sheet have `wrinkling` (0 taut, 1 wrinkled, 2 slack), `crest` and
        `wrinkle_strain`, see `Shell.wrinkling`.
        """
        positions, directors = shell.positions(), shell.directors()
        wrinkles = shell.wrinkling() if shell.relaxed else None
        if shell.comm.rank:
            return
        # only here: runs without frames need it not, and other ranks do not either
        import meshio

        self.frames.mkdir(parents=True, exist_ok=True)
        surface = shell.surface
        kind = {3: "triangle", 4: "quad", 9: "quad9"}[surface.cells.shape[1]]
        path = self.frames / f"{len(self.lines):04d}.vtu"
        part = path.with_suffix(".part.vtu")
        displacements = positions - surface.points
        data = {"displacement": displacements, "director": directors} | fields
        cells = {}
        if wrinkles is not None:
            named = zip(WRINKLES, wrinkles, strict=True)
            cells = {name: [values] for name, values in named}
        if stretch:
            cells["stretch"] = [stretch_of_cells(positions, directors, surface)]
        meshio.Mesh(positions, [(kind, surface.cells)], data, cells).write(part)
        os.replace(part, path)
        self.lines.append(
            f'    <DataSet timestep="{float(time):.9g}" file="{path.parent.name}/{path.name}"/>'
        )
        lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">']
        lines += ["  <Collection>", *self.lines, "  </Collection>", "</VTKFile>", ""]
        write_atomically(self.index, "\n".join(lines))

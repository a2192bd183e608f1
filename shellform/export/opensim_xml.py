# SPDX-License-Identifier: LGPL-3.0-or-later
"""OpenSim's documents of external loads and of forces of coordinates."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree import ElementTree

from shellform.results.files import write_atomically

from .coordinate_forces import Fit

VERSION = "40000"  # of the format: read by OpenSim 4.0 and newer
FORCE, POINT, TORQUE = "{}_force_v", "{}_force_p", "{}_torque_"  # columns of a body, before x, y, z


def write_external_loads(path: Path, datafile: str, bodies: Iterable[str]) -> None:
    """Write an ExternalLoads document, of loads along the ground's axes at points in the ground."""
    top, objects = _document("ExternalLoads", "garment")
    for body in bodies:
        force = ElementTree.SubElement(objects, "ExternalForce", name=f"garment_{body}")
        entries = {
            "appliesForce": "true",
            "applied_to_body": body,
            "force_expressed_in_body": "ground",
            "point_expressed_in_body": "ground",
            "force_identifier": FORCE.format(body),
            "point_identifier": POINT.format(body),
            "torque_identifier": TORQUE.format(body),
        }
        for tag, text in entries.items():
            ElementTree.SubElement(force, tag).text = text
    ElementTree.SubElement(top[0], "datafile").text = datafile
    _write(path, top)


def write_coordinate_forces(path: Path, fits: Mapping[str, Fit]) -> None:
    """Write a ForceSet of an ExpressionBasedCoordinateForce for each coordinate."""
    top, objects = _document("ForceSet", "garment")
    for name, found in fits.items():
        force = ElementTree.SubElement(
            objects, "ExpressionBasedCoordinateForce", name=f"garment_{name}"
        )
        share = f"{100 * found.left / found.size:.0f} %" if found.size else "all"
        force.append(
            ElementTree.Comment(
                f" fitted from {found.low:.3f} to {found.high:.3f} rad; left over "
                f"{found.left:.3g} N m rms, {share} of the torque's {found.size:.3g} N m "
            )
        )
        ElementTree.SubElement(force, "appliesForce").text = "true"
        ElementTree.SubElement(force, "coordinate").text = name
        ElementTree.SubElement(force, "expression").text = found.expression()
    _write(path, top)


def _document(kind, name):
    top = ElementTree.Element("OpenSimDocument", Version=VERSION)
    body = ElementTree.SubElement(top, kind, name=name)
    objects = ElementTree.SubElement(body, "objects")
    ElementTree.SubElement(body, "groups")
    return top, objects


def _write(path, top):
    ElementTree.indent(top)
    text = ElementTree.tostring(top, encoding="unicode")
    write_atomically(path, f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n')

# SPDX-License-Identifier: LGPL-3.0-or-later
"""shellform: clothing mechanics.

A garment of director shells (Man, Swan, Rahmatalla, "A clothing modeling framework for uniform and
armor system design"), its fabric, its supports and loads. The names below are loaded when first
used, so that reading a fabric card or drawing a picture does not start the finite elements.
"""

from importlib import import_module

__version__ = "0.1.0"

_HOMES = {
    "Fabric": "material.fabric",
    "FabricError": "material.fabric",
    "Ply": "material.laminate",
    "NotConverged": "statics.load_stepping",
    "Shell": "fem.shell",
    "Statics": "statics.load_stepping",
}

__all__ = ["Fabric", "FabricError", "NotConverged", "Ply", "Shell", "Statics"]


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module 'shellform' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)

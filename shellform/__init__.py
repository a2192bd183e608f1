# SPDX-License-Identifier: LGPL-3.0-or-later
"""shellform: clothing mechanics.

A garment of director shells in contact with a moving body, and the torque it exerts about the
wearer's joints (Man, Swan, Rahmatalla, "A clothing modeling framework for uniform and armor system
design").

    import shellform as sf

has all that is listed below; `meshes` makes and reads the surfaces. A name is loaded when first
used, so that reading a fabric card or drawing a picture does not start the finite elements.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import writable_folders
from .all_ranks import watch_exceptions
from .launcher import refuse_another

if TYPE_CHECKING:
    from contact.body.blended_surface import BlendedSurface
    from contact.body.flesh_bed import Flesh
    from contact.body.rigid_surface import RigidSurface
    from contact.body.segments import Body, Fixed, Segment
    from contact.solver.friction import Friction
    from meshes import MeshError

    from .bench.run import fabric_tests
    from .contact_coupling.contact import Contact
    from .contact_coupling.self_contact import SelfContact
    from .dynamics.explicit import Newmark
    from .dynamics.implicit import ImplicitNewmark
    from .dynamics.mass_spring import Particles
    from .errors import CompilerError, NotConverged, Stopped, Unstable
    from .fem.shell import Shell
    from .material.card import read_fabric
    from .material.fabric import Fabric, FabricError
    from .material.laminate import Ply
    from .motion.capture.read_motion import read_motion
    from .motion.gait.strides import strides
    from .motion.gait.synthetic_walk import synthetic_walk
    from .motion.wearer import Wearer
    from .results.joint_torque import Torque
    from .results.ledger import Ledger
    from .scene.scene import Scene
    from .simulation.check import check
    from .simulation.ensemble import resume, run
    from .statics.buckling import buckling_loads
    from .statics.load_stepping import Statics
    from .statics.path_following import follow

__version__ = "0.1.0"

__all__ = [  # noqa: RUF022, in the order a reader meets them
    # fabrics
    "Fabric",
    "Ply",
    "read_fabric",
    "fabric_tests",
    # sheets, at rest and in motion
    "Shell",
    "Statics",
    "follow",
    "buckling_loads",
    "Newmark",
    "ImplicitNewmark",
    "Particles",
    # bodies and contact
    "Body",
    "Segment",
    "RigidSurface",
    "BlendedSurface",
    "Fixed",
    "Flesh",
    "Friction",
    "Contact",
    "SelfContact",
    # the moving wearer
    "read_motion",
    "synthetic_walk",
    "Wearer",
    "strides",
    # results
    "Ledger",
    "Torque",
    # scenes
    "Scene",
    "check",
    "run",
    "resume",
    # what a run can end with
    "FabricError",
    "MeshError",
    "NotConverged",
    "Unstable",
    "CompilerError",
    "Stopped",
]

_HOMES = {
    "BlendedSurface": "contact.body.blended_surface",
    "Body": "contact.body.segments",
    "CompilerError": "shellform.errors",
    "Contact": "shellform.contact_coupling.contact",
    "Fabric": "shellform.material.fabric",
    "FabricError": "shellform.material.fabric",
    "Fixed": "contact.body.segments",
    "Flesh": "contact.body.flesh_bed",
    "Friction": "contact.solver.friction",
    "ImplicitNewmark": "shellform.dynamics.implicit",
    "Ledger": "shellform.results.ledger",
    "MeshError": "meshes",
    "Newmark": "shellform.dynamics.explicit",
    "NotConverged": "shellform.errors",
    "Particles": "shellform.dynamics.mass_spring",
    "Ply": "shellform.material.laminate",
    "RigidSurface": "contact.body.rigid_surface",
    "Scene": "shellform.scene.scene",
    "Segment": "contact.body.segments",
    "SelfContact": "shellform.contact_coupling.self_contact",
    "Shell": "shellform.fem.shell",
    "Statics": "shellform.statics.load_stepping",
    "Stopped": "shellform.errors",
    "Torque": "shellform.results.joint_torque",
    "Unstable": "shellform.errors",
    "Wearer": "shellform.motion.wearer",
    "buckling_loads": "shellform.statics.buckling",
    "check": "shellform.simulation.check",
    "fabric_tests": "shellform.bench.run",
    "follow": "shellform.statics.path_following",
    "read_fabric": "shellform.material.card",
    "read_motion": "shellform.motion.capture.read_motion",
    "resume": "shellform.simulation.ensemble",
    "run": "shellform.simulation.ensemble",
    "strides": "shellform.motion.gait.strides",
    "synthetic_walk": "shellform.motion.gait.synthetic_walk",
}

refuse_another()
writable_folders.NOTES += writable_folders.provide()
watch_exceptions()


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'shellform' has no attribute '{name}'")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value  # not asked for again
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, *(name for name in globals() if name.startswith("__"))])

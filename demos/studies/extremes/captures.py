# SPDX-License-Identifier: LGPL-3.0-or-later
"""Captures at the extremes: rates, gaps, noise, jumps, turns, labels and headers.

A level synthetic walk is taken down by markers on the three points of every segment, spoilt, read
again by `shellform.motion.capture.read_motion`, and held against itself: the motion is known in
every frame.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from shellform.motion.capture.markers import Markers
from shellform.motion.capture.noise import residual_noise
from shellform.motion.capture.read_motion import read_markers, recording
from shellform.motion.capture.segment_map import SegmentMap
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.wearer import Wearer

ENDS = ("J1", "J2", "M")


@cache
def walk(rate=200.0):
    """A level walk of two strides, without the standing before it."""
    return synthetic_walk(strides=2, obstacle=0.0, rate=rate, stand=0.0)


def points_map(names):
    """Map of markers that sit on the points themselves."""
    markers = {f"{name}_{end}": (f"{name}.{end}",) for name in names for end in ENDS}
    return SegmentMap(
        "points", markers, {}, {name: {end: f"{name}_{end}" for end in ENDS} for name in names}
    )


def markers_of(rec):
    """Markers on the points of a recording."""
    names = tuple(f"{name}.{end}" for name in rec.points for end in ENDS)
    tracks = np.concatenate(list(rec.points.values()), axis=1)
    return Markers(names, rec.times, tracks, rec.rate, "walk")


def read(markers, **options):
    """The recording of markers on points, sizes and lean left as they are."""
    names = dict.fromkeys(name.split(".")[0] for name in markers.names)
    return recording(markers, points_map(names), rigid=False, **options)


def thinned(every):
    """Every so-manyth frame of the walk at 2000 Hz."""
    whole = markers_of(walk(2000.0))
    return replace(
        whole, times=whole.times[::every], positions=whole.positions[::every],
        rate=whole.rate / every,
    )  # fmt: skip


def off(rec, known, margin=0.4):
    """Greatest distance of the joints of a recording from those of a known one [m], inside."""
    one, other = (Wearer(r, [], from_rest=False) for r in (rec, known))
    a, b = one.new_joints(), other.new_joints()
    begin, end = max(one.start, other.start) + margin, min(one.end, other.end) - margin
    return max(
        float(np.linalg.norm(
            one.joint_state(t, a).centres - other.joint_state(t, b).centres, axis=1
        ).max())
        for t in np.linspace(begin, end, 301)
    )  # fmt: skip


def spoilt(change, rate=200.0):
    """Markers of the walk with positions changed in place by `change(positions, frame)`."""
    whole = markers_of(walk(rate))
    positions = whole.positions.copy()
    change(positions, len(positions) // 2)
    return replace(whole, positions=positions)


def set_aside(size, frames=None, marker=None):
    """Change: one marker, or all, set aside by `size` [m] for some frames, or for good."""

    def change(positions, k):
        stop = None if frames is None else k + frames
        positions[k:stop, slice(None) if marker is None else marker, 0] += size

    return change


def noisy(rms, seed=0):
    """Change: noise of a length of `rms` [m] on all markers."""

    def change(positions, _):
        rng = np.random.default_rng(seed)
        positions += rms / np.sqrt(3) * rng.standard_normal(positions.shape)

    return change


def noise_left(rms, cutoff=6.0):
    """Noise of places [m] and of accelerations [m/s^2] in a recording, and what is predicted."""
    dirty, clean = read(spoilt(noisy(rms)), cutoff=cutoff), read(markers_of(walk()), cutoff=cutoff)
    error = np.concatenate([dirty.points[n] - clean.points[n] for n in clean.points], axis=1)
    bent = np.diff(error, 2, axis=0) * clean.rate**2
    inner = slice(40, -40)
    measured = [float(np.sqrt(np.mean(np.sum(e[inner] ** 2, axis=2)))) for e in (error, bent)]
    return measured, residual_noise(rms, clean.rate, cutoff), dirty


def turning(angle):
    """The walk along an arc: every frame turned about a vertical through it, the path as well."""
    rec = walk()
    pelvis = rec.points["pelvis"][:, 1] * [1.0, 1.0, 0.0]
    yaw = np.linspace(0.0, angle, len(rec.times))
    turn = np.zeros((len(yaw), 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(yaw)
    turn[:, 1, 0], turn[:, 0, 1], turn[:, 2, 2] = np.sin(yaw), -np.sin(yaw), 1.0
    steps = np.einsum("nij,nj->ni", turn[:-1], np.diff(pelvis, axis=0))
    path = np.vstack([pelvis[:1], pelvis[0] + np.cumsum(steps, axis=0)])
    points = {
        name: np.einsum("nij,npj->npi", turn, track - pelvis[:, None]) + path[:, None]
        for name, track in rec.points.items()
    }
    return replace(rec, points=points)


def knee(rec, side="right"):
    """Angle (n,) between thigh and shank [rad]."""
    thigh, shank = (np.diff(rec.points[f"{side}_{part}"][:, :2], axis=1)[:, 0]
                    for part in ("thigh", "shank"))  # fmt: skip
    across = np.linalg.norm(np.cross(thigh, shank), axis=1)
    return np.arctan2(across, np.sum(thigh * shank, axis=1))


HEADER = (
    "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
    "{rate}\t{rate}\t{frames}\t{count}\t{unit}\n"
)


def trc(path, markers, rate=None, frames=None, count=None, unit="m"):
    """A TRC file of markers; its header may lie."""
    head = HEADER.format(
        rate=rate or f"{markers.rate:g}", frames=frames or len(markers.times),
        count=count or len(markers.names), unit=unit,
    )  # fmt: skip
    lines = ["Frame#\tTime\t" + "\t\t\t".join(markers.names), "\t\tX1\tY1\tZ1"]
    for k, frame in enumerate(markers.positions):
        cells = "\t".join(f"{value:.6f}" for value in frame.ravel())
        lines.append(f"{k + 1}\t{markers.times[k]:.3f}\t{cells}")
    path.write_text(head + "\n".join(lines) + "\n")
    return path


def rows():
    """Rows (direction, value, verdict, figure), as in bodies.py."""
    from demos.studies.extremes.bodies import row

    out = []

    def against(markers, bar, cutoff=6.0):
        rec = read(markers, cutoff=cutoff)
        far = off(rec, read(markers_of(walk(2000.0)), cutoff=cutoff))
        notes = [n for n in rec.notes if any(w in n for w in ("jump", "filled", "shake"))]
        said = f"joints within {1e3 * far:.2g} mm" + (f"; told: {notes[0]}" if notes else "")
        return ("converges" if far < bar else "degrades: joints off by more than 5 mm"), said

    for every, cutoff in ((1, 6.0), (20, 6.0), (100, 6.0), (200, 6.0), (200, 3.0), (200, None)):
        name = f"{2000 / every:g} Hz, cutoff {cutoff or 'none'}" + (" Hz" if cutoff else "")
        out.append(row(
            "rate of a capture", name, lambda e=every, c=cutoff: against(thinned(e), 5e-3, cutoff=c)
        ))  # fmt: skip
    for frames in (1, 20, 21):

        def gap(positions, k, n=frames):
            positions[k : k + n, 3] = np.nan

        out.append(
            row("gap of a marker", f"{5 * frames} ms", lambda g=gap: against(spoilt(g), 5e-3))
        )
    for rms in (1e-3, 5e-3, 20e-3):

        def left(size=rms):
            (place, bent), _, rec = noise_left(size)
            noted = any("shake" in note for note in rec.notes)
            far = f"{1e3 * place:.1f} mm, {bent:.1f} m/s^2 left" + (", told" if noted else "")
            return ("converges" if place < 1e-3 else "degrades: noise is left"), far

        out.append(row("noise of markers", f"{1e3 * rms:g} mm rms", left))
    for size, frames in ((0.03, 1), (0.5, 10), (0.05, None), (0.5, None)):
        stays = "stays" if frames is None else f"{5 * frames} ms"
        out.append(row(
            "marker jumps", f"{1e3 * size:g} mm, {stays}",
            lambda s=size, f=frames: against(spoilt(set_aside(s, f, 3)), 5e-3),
        ))  # fmt: skip
    out.append(row(
        "capture jumps", "0.5 m, stays", lambda: against(spoilt(set_aside(0.5)), 5e-3)
    ))  # fmt: skip

    def turned(angle):
        rec, straight = read(markers_of(turning(angle))), read(markers_of(walk()))
        bent = np.abs(knee(rec) - knee(straight)).max()
        a, b = rec.facts["stride_length"], straight.facts["stride_length"]
        return (
            "converges" if bent < np.radians(1.0) else "degrades: knees bend otherwise"
        ), f"knee angle within {np.degrees(bent):.2f} degrees; stride {a:.2f}, straight {b:.2f} m"

    out.append(row("turning walk", "90 degrees", lambda: turned(np.pi / 2)))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "walk.trc"
        for name, change in (
            ("frames 9 in the header", {"frames": 9}),
            ("markers 3 in the header", {"count": 3}),
            ("rate 60 Hz in the header", {"rate": 60}),
            ("unit furlong", {"unit": "furlong"}),
            ("no unit", {"unit": ""}),
        ):

            def header(given=change):
                markers = read_markers(trc(path, markers_of(walk()), **given), up="z")
                return "converges", "; ".join(markers.notes)

            out.append(tuple(
                cell.replace(folder, "") for cell in row("malformed file", name, header)
            ))  # fmt: skip
    return out

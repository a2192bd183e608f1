# SPDX-License-Identifier: LGPL-3.0-or-later
"""A walker made up of known joint centres, its markers under several label sets, as files."""

import numpy as np
import pytest

THIGH, SHANK, KNEE, ANKLE = 0.42, 0.41, 0.055, 0.044
PW, PD = 0.25, 0.13  # width and depth of the walker's pelvis [m]

# labels by public captures: BMC; OpenSim's Rajagopal; Camargo; OpenCap; Plug-in Gait
BMC = {
    "asis": "{S}.ASIS", "psis": "{S}.PSIS", "knee": "{S}.Knee", "knee_in": "{S}.Knee.Medial",
    "ankle": "{S}.Ankle", "ankle_in": "{S}.Ankle.Medial", "heel": "{S}.Heel", "toe": "{S}.MT2",
    "toe_out": "{S}.MT5",
}  # fmt: skip
LATERAL = {k: v for k, v in BMC.items() if not k.endswith("_in")}
RAJAGOPAL = {**LATERAL, "toe": "{S}.Toe", "t1": "{S}.TH1", "t2": "{S}.TH2", "t3": "{S}.TH3"}
CAMARGO = {
    "asis": "{S}_ASIS", "psis": "{S}_PSIS", "knee": "{S}_Knee_Lat", "ankle": "{S}_Ankle_Lat",
    "heel": "{S}_Heel", "toe": "{S}_Toe_Tip", "toe_out": "{S}_Toe_Lat", "t1": "{S}_Thigh_Upper",
    "t2": "{S}_Thigh_Front", "t3": "{S}_Thigh_Rear",
}  # fmt: skip
OPENCAP = {
    "asis": "{s}.ASIS_study", "psis": "{s}.PSIS_study", "knee": "{s}_knee_study",
    "knee_in": "{s}_mknee_study", "ankle": "{s}_ankle_study", "ankle_in": "{s}_mankle_study",
    "heel": "{s}_calc_study", "toe": "{s}_toe_study", "toe_out": "{s}_5meta_study",
}  # fmt: skip
PLUG_IN = {
    "asis": "{S}ASI", "psis": "{S}PSI", "knee": "{S}KNE", "ankle": "{S}ANK", "heel": "{S}HEE",
    "toe": "{S}TOE", "hip_c": "{S}FEP", "knee_c": "{S}FEO", "ankle_c": "{S}TIO",
}  # fmt: skip
IOR = {
    "asis": "{S}ASI", "psis": "{S}PSI", "knee": "{S}LE", "knee_in": "{S}ME", "ankle": "{S}LM",
    "ankle_in": "{S}MM", "heel": "{S}CA", "toe_in": "{S}FM", "toe_out": "{S}VM", "s1": "{S}HF",
    "s2": "{S}TT",
}  # fmt: skip
HELEN_HAYES = {
    "asis": "{S}.ASIS", "sacrum": "V.Sacral", "t1": "{S}.Thigh", "knee": "{S}.Knee",
    "s1": "{S}.Shank", "ankle": "{S}.Ankle", "heel": "{S}.Heel", "toe": "{S}.Toe",
    "shoulder": "{S}.Shoulder",
}  # fmt: skip
PLUG_IN_MARKERS = {
    "asis": "{S}ASI", "psis": "{S}PSI", "t1": "{S}THI", "knee": "{S}KNE", "s1": "{S}TIB",
    "ankle": "{S}ANK", "heel": "{S}HEE", "toe": "{S}TOE", "shoulder": "{S}SHO", "neck": "C7",
}  # fmt: skip
CMU = {
    "asis": "{S}FWT", "psis": "{S}BWT", "t1": "{S}THI", "knee": "{S}KNE", "s1": "{S}SHN",
    "ankle": "{S}ANK", "heel": "{S}HEE", "toe": "{S}TOE", "toe_out": "{S}MT5", "shoulder": "{S}SHO",
}  # fmt: skip
POSE2SIM = {
    "hip_c": "{S}Hip", "knee_c": "{S}Knee", "ankle_c": "{S}Ankle", "heel": "{S}Heel",
    "toe": "{S}BigToe", "toe_out": "{S}SmallToe", "shoulder": "{S}Shoulder", "neck": "Neck",
}  # fmt: skip
KINECT = {
    "hip_c": "HIP_{side}", "knee_c": "KNEE_{side}", "ankle_c": "ANKLE_{side}", "toe": "FOOT_{side}",
    "neck": "NECK",
}  # fmt: skip
SKELETON = {
    "hip_c": "{side}UpLeg", "knee_c": "{side}Leg", "ankle_c": "{side}Foot", "toe": "{side}ToeBase",
    "neck": "Neck",
}  # fmt: skip
# static trial and walk of one set: what is taken off between them
GAIT2392 = {
    "asis": "{S}.ASIS", "sacrum": "V.Sacral", "t1": "{S}.Thigh.Upper", "t2": "{S}.Thigh.Front",
    "t3": "{S}.Thigh.Rear", "knee": "{S}.Knee.Lat", "knee_in": "{S}.Knee.Med",
    "s1": "{S}.Shank.Upper", "s2": "{S}.Shank.Front", "s3": "{S}.Shank.Rear",
    "ankle": "{S}.Ankle.Lat", "ankle_in": "{S}.Ankle.Med", "heel": "{S}.Heel",
    "toe": "{S}.Toe.Tip", "toe_out": "{S}.Toe.Lat",
}  # fmt: skip
TAKEN_OFF = ("knee", "knee_in", "ankle", "ankle_in")


def along(position, *axes_and_steps):
    """A point moved by steps along axes given frame by frame."""
    return position + sum(step * axis for axis, step in axes_and_steps)


def walker(labels, speed=1.2, bend=0.0, seconds=3.5, rate=100.0, twist=0.0):
    """Names, tracks (n, m, 3) [m] and true joint centres of a walk along a line or an arc.

    A stride takes 1 s, so its length is `speed` in m. The path turns by `bend` [rad/s] to the
    left; thighs turn about their own axis by `twist` [rad].
    """
    t = np.arange(round(seconds * rate)) / rate
    yaw, one = bend * t, np.ones_like(t)
    ahead = np.stack([np.cos(yaw), np.sin(yaw), 0 * t], axis=1)
    right = np.stack([np.sin(yaw), -np.cos(yaw), 0 * t], axis=1)
    up = np.stack([0 * t, 0 * t, one], axis=1)
    if bend:
        r = speed / bend
        place = np.stack([r * np.sin(yaw), r - r * np.cos(yaw), 0.95 * one], axis=1)
    else:
        place = np.stack([speed * t, 0 * t, 0.95 * one], axis=1)
    names, tracks, truth = [], [], {}
    for side, sign in (("right", 1.0), ("left", -1.0)):
        phase = 2 * np.pi * t + (0 if sign > 0 else np.pi)
        swing, flex = 0.22 * np.sin(phase)[:, None], 0.3 * (1 + np.cos(phase))[:, None]
        out = sign * right
        hip = along(
            place,
            (ahead, -(0.24 * PD + 9.9e-3)),
            (up, -(0.30 * PW + 10.9e-3)),
            (out, 0.33 * PW + 7.3e-3),
        )
        fore = np.cos(swing) * ahead + np.sin(swing) * up
        down = np.sin(swing) * ahead - np.cos(swing) * up
        angle = twist * np.sin(2 * phase)[:, None]
        axis = np.cos(angle) * out + np.sin(angle) * fore
        front = np.cos(angle) * fore - np.sin(angle) * out
        knee = hip + THIGH * down
        calf = np.sin(swing - flex) * ahead - np.cos(swing - flex) * up
        shin = np.cos(swing - flex) * ahead + np.sin(swing - flex) * up
        ankle = knee + SHANK * calf
        heel = along(ankle, (ahead, -0.05), (up, -0.06))
        toe = along(ankle, (ahead, 0.15), (up, -0.07))
        where = {
            "asis": along(place, (out, PW / 2)),
            "psis": along(place, (out, 0.05), (ahead, -PD)),
            "knee": along(knee, (axis, KNEE)), "knee_in": along(knee, (axis, -KNEE)),
            "ankle": along(ankle, (out, ANKLE)), "ankle_in": along(ankle, (out, -ANKLE)),
            "heel": heel, "toe": toe, "toe_out": along(toe, (out, 0.05), (ahead, -0.03)),
            "t1": along(hip, (down, 0.18), (axis, 0.09), (front, 0.01)),
            "t2": along(hip, (down, 0.26), (axis, 0.07), (front, 0.05)),
            "t3": along(hip, (down, 0.27), (axis, 0.08), (front, -0.04)),
            "t4": along(hip, (down, 0.35), (axis, 0.06), (front, 0.05)),
            "hip_c": hip, "knee_c": knee, "ankle_c": ankle,
            "s1": along(knee, (calf, 0.10), (shin, 0.06), (out, 0.05)),
            "s2": along(knee, (calf, 0.20), (shin, 0.05), (out, -0.03)),
            "s3": along(knee, (calf, 0.24), (shin, -0.04), (out, 0.05)),
            "midfoot": along(ankle, (ahead, 0.065), (up, -0.02), (out, -0.045)),
            "toe_in": along(toe, (out, -0.05), (ahead, 0.03)),
            "sacrum": along(place, (ahead, -PD)), "neck": along(place, (up, 0.5)),
            "shoulder": along(place, (up, 0.5), (out, 0.18)),
        }  # fmt: skip
        truth[side] = {"hip": hip, "knee": knee, "ankle": ankle}
        for place_name, label in labels.items():
            if "{" not in label and sign < 0:
                continue  # there is one of it
            label = label.replace("{S}", side[0].upper()).replace("{s}", side[0])
            names.append(label.replace("{side}", side.title()))
            tracks.append(where[place_name])
    return names, np.stack(tracks, axis=1), truth


def y_up(tracks):
    """The same with y up and x kept: (x, y, z) -> (x, z, -y)."""
    return np.stack([tracks[..., 0], tracks[..., 2], -tracks[..., 1]], axis=-1)


def write_trc(path, names, tracks, rate=100.0, unit="mm", doubled=False, said=None):
    """A TRC file; times rounded to 1 ms as cameras' programs do; `doubled`: tabs as OpenSim's."""
    tab = "\t\t" if doubled else "\t"
    values = [f"{rate:g}", f"{rate:g}", f"{len(tracks)}", f"{said or len(names)}", f" {unit}"]
    lines = [
        "PathFileType  4\t(X/Y/Z) C:\\walk.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate",
        tab.join(values) + f"\t{rate:g}",
        "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
        "\t\t" + "\t".join(f"{c}{k + 1}" for k in range(len(names)) for c in "XYZ"),
        "\t\t\t" if doubled else "",
    ]
    for k, frame in enumerate(tracks):
        cells = ["" if np.isnan(v) else repr(float(v)) for v in frame.ravel()]
        lines.append("\t".join([str(k + 1), f"{k / rate:.3f}", *cells]))
    path.write_text("\n".join(lines) + "\n")
    return path


def write_csv(path, names, tracks, rate=100.0, unit=None):
    ends = [f"{c} [{unit}]" if unit else c for c in "xyz"]
    lines = ["time," + ",".join(f"{n}_{e}" for n in names for e in ends)]
    for k, frame in enumerate(tracks):
        cells = ["" if np.isnan(v) else repr(float(v)) for v in frame.ravel()]
        lines.append(",".join([repr(k / rate), *cells]))
    path.write_text("\n".join(lines) + "\n")
    return path


def write_c3d(path, names, tracks, rate=100.0, unit="mm", up="+Z", groups=()):
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [rate]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(names)
    file["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    file.add_parameter("POINT", "X_SCREEN", ["+X"])
    file.add_parameter("POINT", "Y_SCREEN", [up])
    for name, members in groups:
        file.add_parameter("POINT", name, list(members))
    points = np.ones((4, len(names), len(tracks)))
    points[:3] = np.transpose(tracks, (2, 1, 0))
    file["data"]["points"] = points
    file.write(str(path))
    return path


WRITERS = {"trc": write_trc, "csv": write_csv, "c3d": write_c3d}
SCALE = {"m": 1.0, "cm": 100.0, "mm": 1000.0}

# a map of one limb, whose points are markers
DIRECT = """
[markers]
a = ["R.Heel"]
b = ["R.ASIS"]
c = ["side"]
[segments]
limb = { J1 = "a", J2 = "b", M = "c" }
"""

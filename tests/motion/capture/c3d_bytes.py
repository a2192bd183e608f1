# SPDX-License-Identifier: LGPL-3.0-or-later
"""C3D files byte by byte, in the order of each processor: what no library at hand writes.

After the user guide of c3d.org: a header of 512 bytes, parameters in blocks, points as whole
numbers of 2 bytes or as numbers of 4, rotations as 16 numbers and a residual each.
"""

import struct

import numpy as np

PROCESSORS = {"intel": 84, "dec": 85, "mips": 86}


class Writer:
    """Numbers in the byte order of a processor."""

    def __init__(self, order):
        self.order, self.end = order, ">" if order == "mips" else "<"

    def whole(self, value):
        return struct.pack(f"{self.end}H", int(value) & 0xFFFF)

    def real(self, values):
        values = np.atleast_1d(np.asarray(values, float)).ravel()
        if self.order == "mips":
            return values.astype(">f4").tobytes()
        if self.order == "dec":  # 4 times larger, halves exchanged
            words = (values * 4).astype("<f4").view("<u2").reshape(-1, 2)[:, ::-1]
            return np.ascontiguousarray(words).tobytes()
        return values.astype("<f4").tobytes()

    def parameter(self, group, name, value, last=False):
        if isinstance(value, list) and value and isinstance(value[0], str):
            width = max(len(v) for v in value)
            data = "".join(v.ljust(width) for v in value).encode()
            kind, sizes = -1, [width, len(value)]
        elif isinstance(value, float):
            kind, sizes, data = 4, [], self.real(value)
        else:
            kind, sizes, data = 2, [], self.whole(value)
        body = struct.pack("bB", kind, len(sizes)) + bytes(sizes) + data + b"\0"
        head = struct.pack("bb", len(name), group) + name.encode()
        return head + self.whole(0 if last else len(body) + 2) + body

    def group(self, number, name, last=False):
        body = b"\0"
        head = struct.pack("bb", len(name), -number) + name.encode()
        return head + self.whole(0 if last else len(body) + 2) + body


def write_c3d_bytes(
    path, names, tracks, rate=100.0, order="intel", whole=False, unit="mm", up="+Z",
    header_rate=None, labels=None, residual=0.0, poses=None,
):  # fmt: skip
    """A C3D file of tracks (n, m, 3), NaN for gaps, and of poses, name -> (n, 4, 4)."""
    w, n, m = Writer(order), len(tracks), len(names)
    labels = names if labels is None else labels
    scale = np.nanmax(np.abs(tracks)) / 32000 if m else 1.0
    poses = {} if poses is None else poses
    lists = [labels[k : k + 255] for k in range(0, len(labels), 255)]
    point = {"USED": m, "FRAMES": n, "SCALE": float(scale if whole else -scale), "RATE": rate}
    point |= {"LABELS" + (str(k + 1) if k else ""): part for k, part in enumerate(lists)}
    point |= {"UNITS": [unit], "X_SCREEN": ["+X"], "Y_SCREEN": [up], "DATA_START": 0}
    groups = {"POINT": point, "ANALOG": {"USED": 0}}
    if poses:
        groups["ROTATION"] = {"USED": len(poses), "DATA_START": 0, "RATE": rate, "RATIO": 1}
        groups["ROTATION"] |= {"FRAMES": n, "LABELS": list(poses)}

    def section():
        out = b""
        for k, (name, values) in enumerate(groups.items(), 1):
            out += w.group(k, name)
            for key, value in values.items():
                out += w.parameter(k, key, value)
        return out + b"\0\0"

    blocks = -(-(4 + len(section())) // 512)
    start = 2 + blocks
    groups["POINT"]["DATA_START"] = start
    gap = ~np.isfinite(tracks).all(axis=2)
    filled = np.where(gap[..., None], 0.0, tracks)
    sign = np.where(gap, -1.0, residual)[..., None]
    if whole:
        table = np.concatenate([np.rint(filled / scale), sign], axis=2).astype("i2")
        data = table.astype(">i2" if order == "mips" else "<i2").tobytes()
    else:
        data = w.real(np.concatenate([filled, sign], axis=2))
    data += bytes(-len(data) % 512)
    if poses:
        groups["ROTATION"]["DATA_START"] = start + len(data) // 512
        stack = np.stack(list(poses.values()), axis=1)  # (n, k, 4, 4)
        columns = np.swapaxes(stack, 2, 3).reshape(n, len(poses), 16)
        more = w.real(np.concatenate([columns, np.zeros((n, len(poses), 1))], axis=2))
        data += more + bytes(-len(more) % 512)
    parameters = bytes([1, 0x50, blocks, PROCESSORS[order]]) + section()
    parameters += bytes(512 * blocks - len(parameters))
    head = bytes([2, 0x50]) + w.whole(m) + w.whole(0) + w.whole(1) + w.whole(n) + w.whole(10)
    head += w.real(scale if whole else -scale) + w.whole(start) + w.whole(0)
    head += w.real(rate if header_rate is None else header_rate)
    path.write_bytes(head + bytes(512 - len(head)) + parameters + data)
    return path

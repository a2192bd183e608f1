# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the header of a C3D file says, in the byte order of any of its three processors.

The header's words of two bytes: 2 points, 3 analog values a frame, 4 and 5 first and last frame, 7
and 8 scale (negative: numbers of 4 bytes), 9 first block of data, 11 and 12 frames a second; blocks
of 512 bytes. The fourth byte of the parameters names the processor: 84 Intel, 85 DEC, 86 MIPS
(c3d.org, user guide). DEC's numbers of 4 bytes have their halves exchanged and are 4 times larger.
"""

import struct
from pathlib import Path
from typing import NamedTuple

BLOCK = 512
INTEL, DEC, MIPS = 84, 85, 86


class Header(NamedTuple):
    """points, analog : values a frame; first, last : frames; scale; block : first of data;
    rate [Hz]; processor : 84, 85 or 86; size : bytes of the file."""

    points: int
    analog: int
    first: int
    last: int
    scale: float
    block: int
    rate: float
    processor: int
    size: int

    def bytes_of(self, frames: int) -> int:
        """Length [bytes] of a file with so many frames."""
        frame = (4 * self.points + self.analog) * (4 if self.scale < 0 else 2)
        return BLOCK * (self.block - 1) + frames * frame


def header_of(path: str | Path) -> Header:
    """Header of a C3D file.

    Raises
    ------
    ValueError
        When it is none, or cut off before its parameters.
    """
    path = Path(path)
    with path.open("rb") as file:
        head = file.read(BLOCK)
        if len(head) < BLOCK or head[1] != 0x50 or head[0] < 2:
            raise ValueError(f"{path}: no C3D file, or cut off in its header; copy it again")
        file.seek(BLOCK * (head[0] - 1))
        section = file.read(4)
    if len(section) < 4:
        raise ValueError(f"{path}: cut off before its parameters; copy it again")
    processor = section[3] if section[3] in (INTEL, DEC, MIPS) else INTEL
    end = ">" if processor == MIPS else "<"
    points, analog, first, last = struct.unpack_from(f"{end}4H", head, 2)
    (block,) = struct.unpack_from(f"{end}H", head, 16)
    scale, rate = (number(head[k : k + 4], processor) for k in (12, 20))
    size = path.stat().st_size
    return Header(points, analog, first, last, scale, block, rate, processor, size)


def number(four: bytes, processor: int) -> float:
    """A number of 4 bytes as a processor writes it."""
    if processor == MIPS:
        return struct.unpack(">f", four)[0]
    if processor == DEC:
        return struct.unpack("<f", four[2:] + four[:2])[0] / 4.0
    return struct.unpack("<f", four)[0]


def check_length(header: Header, path: str | Path, frames: int | None = None) -> None:
    """Refuse a file shorter than its header says, before a library meets its end.

    Parameters
    ----------
    frames : number of them as a library finds it, None: as the header tells, where it can
    """
    if frames is None:
        if not (0 < header.first <= header.last < 65535) or header.block < 2:
            return  # more frames than two bytes count
        frames = header.last - header.first + 1
    told = header.bytes_of(frames)
    if header.size < told:
        raise ValueError(
            f"{path}: cut off, {header.size} bytes of the {told} its header tells of; copy it again"
        )

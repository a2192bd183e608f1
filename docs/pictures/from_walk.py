# SPDX-License-Identifier: LGPL-3.0-or-later
"""The README's picture: key frames and torque out of out/walk/walk.png, which `make walk` draws.

make walk
.venv/bin/python docs/pictures/from_walk.py
"""

from pathlib import Path

from PIL import Image

HERE = Path(__file__).parent
DRESSING = 0.375  # share of the picture's height that shows the dressing above
COLOURS = 48


def main():
    picture = Image.open(HERE.parents[1] / "out/walk/walk.png").convert("RGB")
    width, height = picture.size
    below = picture.crop((0, int(DRESSING * height), width, height))
    below = below.resize((1200, round(1200 * below.height / width)), Image.LANCZOS)
    below.quantize(COLOURS, dither=Image.Dither.NONE).save(HERE / "walk.png", optimize=True)


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays as text for a page: little-endian bytes in base64, with type and shape.

Positions are rounded to a tenth of a millimetre in 16 bits, colours to 254 steps in 8: a picture
shows no more. 255 stands for no value.
"""

import base64
import json
from typing import Any

import numpy as np

NONE = 255  # of a colour
STEPS = 254


def packed(values: np.ndarray) -> dict[str, Any]:
    """An array as a dict of `type` (numpy's name), `shape`, `base64`."""
    values = np.asarray(values)
    little = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
    text = base64.b64encode(little.tobytes()).decode("ascii")
    return {"type": values.dtype.name, "shape": list(values.shape), "base64": text}


def unpacked(entry: dict[str, Any]) -> np.ndarray:
    """The array of `packed`."""
    kind = np.dtype(entry["type"]).newbyteorder("<")
    return np.frombuffer(base64.b64decode(entry["base64"]), kind).reshape(entry["shape"])


def rounded_places(places: np.ndarray, step: float) -> np.ndarray:
    """Places [m] as int16, in steps [m].

    Raises
    ------
    ValueError where they do not fit
    """
    counts = np.rint(places / step)
    if counts.size and not np.abs(counts).max() < 2**15:
        raise ValueError(f"a place lies {np.abs(places).max():.3g} m from the wearer: too far off")
    return counts.astype(np.int16)


def rounded_colours(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Values as uint8, 0 at `low` to 254 at `high`, clipped; 255 where there is none (nan)."""
    span = max(high - low, 1e-300)
    steps = np.clip(np.rint((values - low) / span * STEPS), 0, STEPS)
    return np.where(np.isnan(values), NONE, steps).astype(np.uint8)


def as_json(data: Any) -> str:
    """JSON that may stand inside a script element of a page: no '<' in it, nan as null."""
    text = json.dumps(_finite(data), separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _finite(data):
    """Plain values, with None for what is not finite."""
    if isinstance(data, dict):
        return {str(key): _finite(value) for key, value in data.items()}
    if isinstance(data, np.ndarray):
        return _finite(data.tolist())
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    if isinstance(data, np.generic):
        return _finite(data.item())
    if isinstance(data, float) and not np.isfinite(data):
        return None
    return data

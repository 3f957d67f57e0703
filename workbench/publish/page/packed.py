"""Numbers as a page carries them: short, and read at once by a browser."""

import base64
import json
from collections.abc import Mapping, Sequence

import numpy as np


def floats(values: Sequence[float] | np.ndarray) -> str:
    """Numbers with seven digits: little-endian 32-bit floats in base 64."""
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")


LEVELS = 65535
"""Of a channel in `shorts`: from its least value to its largest."""


def shorts(channels: Mapping[str, np.ndarray]) -> str:
    """Channels of equal length, each with 1/65535 of its range, as JSON.

    By name the least value and the step, and all values as little-endian 16-bit integers in base 64, one channel behind
    the other. NaN is the least, and an infinity the end on its side.
    """
    scales, parts = {}, []
    for name, values in channels.items():
        known = values[np.isfinite(values)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
        step = (high - low) / LEVELS
        levels = np.rint((np.nan_to_num(values, nan=low, posinf=high, neginf=low) - low) / (step or 1.0))
        scales[name] = [float(f"{low:.8g}"), float(f"{step:.8g}")]
        parts.append(levels.astype("<u2").tobytes())
    content = {"channels": scales, "values": base64.b64encode(b"".join(parts)).decode("ascii")}
    return json.dumps(content, separators=(",", ":"))


def in_script(content: object) -> str:
    """JSON that may stand in a script element."""
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")

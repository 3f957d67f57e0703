"""Numbers as a page carries them: short, and read at once by a browser."""

import base64
import json
from collections.abc import Mapping, Sequence

import numpy as np

FAR = 1e3
"""Times their range that numbers are away from 0 at most where seven digits tell them apart."""


def floats(values: Sequence[float] | np.ndarray) -> str:
    """Numbers, four digits of their range at least: little-endian floats in base 64, of 64 bits behind a colon."""
    numbers = np.asarray(values, dtype=float)
    known = numbers[np.isfinite(numbers)]
    is_near = known.size < 2 or float(np.max(np.abs(known))) <= FAR * float(np.ptp(known)) or np.ptp(known) == 0.0
    code = base64.b64encode(numbers.astype("<f4" if is_near else "<f8").tobytes()).decode("ascii")
    return code if is_near else f":{code}"


LEVELS = 65535
"""Of a channel in `shorts`: from its least value to its largest."""


MOST = 1e150
"""No value is beyond it."""


def shorts(channels: Mapping[str, np.ndarray], units: Mapping[str, str] | None = None) -> str:
    """Channels of equal length, each with 1/65535 of its range, as JSON.

    By name the least value and the step, and all values as little-endian 16-bit integers in base 64, one channel behind
    the other. NaN is the least, and an infinity the end on its side. `units` are told beside them.
    """
    scales, parts = {}, []
    for name, given in channels.items():
        values = np.clip(given, -MOST, MOST, where=np.isfinite(given), out=np.array(given, dtype=float))
        known = values[np.isfinite(values)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
        step = (high - low) / LEVELS
        levels = np.rint((np.nan_to_num(values, nan=low, posinf=high, neginf=low) - low) / (step or 1.0))
        scales[name] = [float(f"{low:.8g}"), float(f"{step:.8g}")]
        parts.append(levels.astype("<u2").tobytes())
    content = {"channels": scales, "values": base64.b64encode(b"".join(parts)).decode("ascii")}
    return in_script({**content, "units": dict(units or {})})


def in_script(content: object) -> str:
    """JSON that may stand in a script element."""
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")

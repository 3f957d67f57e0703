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
    values = np.array([*channels.values()], dtype=float)
    finite = np.isfinite(values)
    np.clip(values, -MOST, MOST, out=values, where=finite)
    low = np.min(values, axis=1, initial=MOST, where=finite, keepdims=True)
    high = np.max(values, axis=1, initial=-MOST, where=finite, keepdims=True)
    known = low <= high
    low, high = np.where(known, low, 0.0), np.where(known, high, 0.0)
    if not finite.all():
        values = np.where(finite, values, np.where(values == np.inf, high, low))
    step = (high - low) / LEVELS
    levels = np.rint((values - low) / np.where(step == 0.0, 1.0, step)).astype("<u2")
    scales = {name: [float(f"{low[i, 0]:.8g}"), float(f"{step[i, 0]:.8g}")] for i, name in enumerate(channels)}
    content = {"channels": scales, "values": base64.b64encode(levels.tobytes()).decode("ascii")}
    return in_script({**content, "units": dict(units or {})})


def in_script(content: object) -> str:
    """JSON that may stand in a script element."""
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")

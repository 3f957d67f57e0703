"""Numbers on a page of results, read as its script reads them."""

import base64
import json

import numpy as np


def read_floats(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype="<f4").astype(float)


def read_shorts(text: str) -> dict[str, np.ndarray]:
    content = json.loads(text)
    levels = np.frombuffer(base64.b64decode(content["values"]), dtype="<u2").reshape(len(content["channels"]), -1)
    scales = content["channels"].items()
    return {name: low + step * row for (name, (low, step)), row in zip(scales, levels, strict=True)}

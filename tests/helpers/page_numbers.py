"""What is on a page of results: its text, its pictures, and its numbers as its script reads them."""

import base64
import json
import re

import numpy as np


def text_of(page: str) -> str:
    """A page without its scripts and what its pictures are made of."""
    return re.sub('src="data:[^"]*"', 'src="picture"', re.sub("<script.*?</script>", "", page, flags=re.DOTALL))


def pictures_of(page: str) -> list[bytes]:
    """The pictures that a page holds."""
    return [base64.b64decode(code) for code in re.findall('src="data:image/png;base64,([^"]*)"', page)]


def read_floats(text: str) -> np.ndarray:
    kind = "<f8" if text.startswith(":") else "<f4"
    return np.frombuffer(base64.b64decode(text.removeprefix(":")), dtype=kind).astype(float)


def read_shorts(text: str) -> dict[str, np.ndarray]:
    content = json.loads(text)
    levels = np.frombuffer(base64.b64decode(content["values"]), dtype="<u2").reshape(len(content["channels"]), -1)
    scales = content["channels"].items()
    return {name: low + step * row for (name, (low, step)), row in zip(scales, levels, strict=True)}

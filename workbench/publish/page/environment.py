"""What all pages have in common: their frame, how text, tables and pictures look, and what makes these move."""

import base64
import importlib.util
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import CodeType
from typing import TYPE_CHECKING, Any

from jinja2 import BytecodeCache, Environment, FileSystemLoader
from jinja2.bccache import Bucket
from markupsafe import Markup

from workbench.publish.page.live import live
from workbench.publish.page.packed import in_script
from workbench.publish.pictures import Picture
from workbench.publish.words import plain_name

if TYPE_CHECKING:
    import pandas as pd

HERE = Path(__file__).parent

BOKEH = ("bokeh.min.js", "bokeh-api.min.js")
"""Of what Bokeh brings for a browser: it draws lines and points, and reads what `page.js` asks of it."""


class _InMemory(BytecodeCache):
    """Compiled templates of files, which all pages of this process share: to compile them takes as long as a page."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, str], CodeType | None] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        bucket.code = self._kept.get((bucket.key, bucket.checksum))

    def dump_bytecode(self, bucket: Bucket) -> None:
        self._kept[bucket.key, bucket.checksum] = bucket.code


_COMPILED = _InMemory()


def page_environment(folder: Path) -> Environment:
    """Where templates of pages are rendered that are to lie in `folder`: they extend "frame.html" and fill its blocks
    title, kind, picture, summary, style, body and scripts. Nothing of a page is fetched; its pictures are those of
    `folder`/figures.

    "parts.html" has what pages show alike: `show` a table with its notes, `draw` a picture, `drawn_elsewhere` one that
    exists as a file alone. "every_case.html", which is included, shows `section`, all cases of a study: sketches are
    large, and only what is included is written piece by piece.
    """
    environment = Environment(
        loader=FileSystemLoader(HERE), autoescape=True, keep_trailing_newline=True, bytecode_cache=_COMPILED
    )
    environment.filters["plain"] = plain_name
    environment.globals |= {
        "style_sheet": Markup(_asset("page.css")),
        "script": Markup(_asset("page.js")),
        "bokeh": bokeh,
        "image": lambda name: _image(folder / "figures" / f"{name}.png"),
        "moving": _moving,
        "are_words": _are_words,
        "formats": lambda name: [
            ending for ending in ("pdf", "svg", "png") if (folder / "figures" / f"{name}.{ending}").exists()
        ],
    }
    return environment


@cache
def _asset(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


@cache
def bokeh() -> Markup:
    """Bokeh's scripts, as they stand in a page."""
    spec = importlib.util.find_spec("bokeh")
    assert spec is not None  # a dependency of the program
    assert spec.submodule_search_locations is not None
    scripts = Path(spec.submodule_search_locations[0]) / "server" / "static" / "js"
    texts = [(scripts / name).read_text(encoding="utf-8").replace("</script", "<\\/script") for name in BOKEH]
    return Markup("\n".join(texts))


def _image(path: Path) -> str:
    """A picture's address that is the picture itself."""
    return f"data:image/png;base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"


NUMBER = re.compile(r"[<>≤≥±x\s]*[-+]?[.\d]")
"""How a cell with a number begins."""


def _are_words(frame: "pd.DataFrame") -> list[bool]:
    """Which columns of a table hold words, and are aligned to the left."""
    filled = [[text for cell in frame.iloc[:, i] if (text := str(cell))] for i in range(frame.shape[1])]
    return [any(not NUMBER.match(text) for text in column) for column in filled]


def _moving(picture: Picture) -> Markup:
    """A picture's numbers and looks as JSON, empty where the page cannot draw it."""
    content: Mapping[str, Any] | None = live(picture.figure)
    return Markup("" if content is None else in_script(content))

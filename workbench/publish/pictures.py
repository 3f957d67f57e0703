"""Figures as files: each as PDF (for a thesis), SVG (for a page) and PNG, with its caption in it."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from workbench.errors import visible
from workbench.parallel.chunks import in_chunks
from workbench.publish.figure_text import drawable
from workbench.publish.folders import anew, made
from workbench.publish.page_format import asked_format
from workbench.publish.refit import refit
from workbench.publish.style import figure_style


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure, and what it shows in words; `section` is the part of a page that it belongs to, where it has one."""

    figure: Figure
    caption: str
    section: str = ""


FORMATS = ("pdf", "svg", "png")

NOT_ANEW: Any = {"figure.constrained_layout.use": False}
"""A figure that is saved has the layout engine that it had, or none."""


def _lay_out(figure: Figure) -> None:
    """Put the parts of a figure in their places, once for all formats of files: the same in each.

    Where a page format is asked for (`figures_at`), the figure is drawn for that.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    with figure_style():
        figure.set_dpi(mpl.rcParams["savefig.dpi"])  # text is not as wide in dots of another size
        if (page := asked_format()) is not None:
            refit(figure, page)
        engine.execute(figure)
    with mpl.rc_context(NOT_ANEW):
        figure.set_layout_engine(None)  # with any, "none" included, each format is drawn once more for its sake


def save(
    figure: Figure, name: str, folder: Path, formats: tuple[str, ...] = FORMATS, *, caption: str = ""
) -> list[Path]:
    """Write a figure in each format, the same bytes for the same content; returns the paths.

    Its caption goes into the files: without one its title.
    """
    made(folder)
    caption = visible(caption or figure.get_suptitle())
    said: dict[str, dict[str, Any]] = {
        "pdf": {"CreationDate": None, "Subject": caption},
        "svg": {"Date": None, "Description": caption},
        "png": {"Description": caption},
    }
    paths = [anew(folder / f"{name}.{ending}") for ending in formats]
    with _laid_out(figure):
        for path, ending in zip(paths, formats, strict=True):
            figure.savefig(path, metadata=said[ending])
    return paths


def save_all(pictures: Mapping[str, Picture], folder: Path) -> None:
    """Write figures in every format, several at a time; a page that is made of them has them laid out."""
    for picture in pictures.values():
        with _laid_out(picture.figure):
            pass
    named = list(pictures.items())

    def written(places: Sequence[int]) -> list[list[Path]]:
        return [save(named[k][1].figure, named[k][0], folder, caption=named[k][1].caption) for k in places]

    jobs = None if sys.platform == "linux" else 1  # processes draw beside each other, threads share what settings are
    with closing(in_chunks(written, range(len(named)), jobs=jobs)) as chunks:
        for _ in chunks:
            pass


@contextmanager
def _laid_out(figure: Figure) -> Iterator[None]:
    """While inside, it can be drawn, with its parts in their places."""
    with drawable(figure), figure_style(), mpl.rc_context(NOT_ANEW):
        _lay_out(figure)
        yield


def caption_of(path: Path) -> str:
    """The caption in a picture that `save` wrote as PNG; "" where there is none."""
    from PIL import Image

    with Image.open(path) as image:
        return str(image.info.get("Description", ""))

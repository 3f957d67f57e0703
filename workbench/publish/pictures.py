"""Figures as files: each as PDF (for a thesis), SVG (for a page) and PNG, and with its caption on a page."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

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


def lay_out(figure: Figure) -> None:
    """Put the parts of a figure in their places, once for all formats: the same in each."""
    engine = figure.get_layout_engine()
    if engine is None:
        return
    with figure_style():
        engine.execute(figure)
    with mpl.rc_context(NOT_ANEW):
        figure.set_layout_engine(None)  # with any, "none" included, each format is drawn once more for its sake


def save(figure: Figure, name: str, folder: Path, formats: tuple[str, ...] = FORMATS) -> list[Path]:
    """Write a figure in each format, the same bytes for the same content; returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    undated: dict[str, dict[str, Any]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
    paths = [folder / f"{name}.{ending}" for ending in formats]
    with figure_style(), mpl.rc_context(NOT_ANEW):
        for path, ending in zip(paths, formats, strict=True):
            figure.savefig(path, metadata=undated.get(ending))
    return paths

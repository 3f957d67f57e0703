"""Figures as files: each as PDF (for a thesis), SVG (for a page) and PNG, and with its caption on a page."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from workbench.publish.style import figure_style


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure, and what it shows in words; `section` is the part of a page that it belongs to, where it has one."""

    figure: Figure
    caption: str
    section: str = ""


FORMATS = ("pdf", "svg", "png")


def save(figure: Figure, name: str, folder: Path, formats: tuple[str, ...] = FORMATS) -> list[Path]:
    """Write a figure in each format, the same bytes for the same content; returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    undated: dict[str, dict[str, Any]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
    paths = [folder / f"{name}.{ending}" for ending in formats]
    with figure_style():
        for path, ending in zip(paths, formats, strict=True):
            figure.savefig(path, metadata=undated.get(ending))
    return paths

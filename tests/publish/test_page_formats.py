"""Figures for a page: of its width, with text of its size, nothing over anything else."""

import warnings
from itertools import combinations
from pathlib import Path

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.errors import UserError
from workbench.publish.page_format import FORMATS, PageFormat, figures_at, page_format
from workbench.publish.pictures import caption_of, save
from workbench.publish.style import WIDTH, figure_style

LONG = "more words than a narrow panel has room for"


def made(rows: int, columns: int, legend: str = "best", words: str = LONG) -> Figure:
    """A figure of panels with long words everywhere."""
    with figure_style():
        figure = Figure(figsize=(WIDTH, 2.4 * rows + 0.4))
        FigureCanvasAgg(figure)
        figure.suptitle("the title of all")
        for axes in figure.subplots(rows, columns, squeeze=False).ravel():
            axes.set_title(words)
            axes.set_xlabel(words)
            axes.set_ylabel("force (N)")
            for number in range(3):
                axes.plot([0.0, 1.0], [number, 2e4], label=f"{words} {number}")
            beside = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0)}
            axes.legend(**(beside if legend == "outside" else {"loc": legend}))
        return figure


def drawn(figure: Figure, page: str, folder: Path) -> tuple[float, float]:
    """Width and height of a figure in mm after it was saved for a page."""
    with warnings.catch_warnings(), figures_at(page):
        warnings.simplefilter("error")
        save(figure, "picture", folder, ("png",), caption="what it shows, ± 5 µm")
    width, height = (25.4 * size for size in figure.get_size_inches())
    return width, height


@pytest.mark.parametrize("page", ["ieee", "thesis"])
@pytest.mark.parametrize(("rows", "columns", "legend"), [(1, 1, "best"), (2, 1, "outside"), (2, 2, "upper center")])
def test_nothing_lies_over_anything_else(page: str, rows: int, columns: int, legend: str, tmp_path: Path) -> None:
    figure, asked = made(rows, columns, legend), FORMATS[page]
    width, _ = drawn(figure, page, tmp_path)
    assert width == pytest.approx(asked.width) or width == pytest.approx(asked.double)
    figure.canvas.draw()
    whole = figure.bbox.padded(2.0)
    boxes = [axes.get_tightbbox() for axes in figure.axes]
    for box in boxes:
        assert whole.x0 <= box.x0 < box.x1 <= whole.x1
        assert whole.y0 <= box.y0 < box.y1 <= whole.y1
    for one, other in combinations(boxes, 2):
        assert not one.padded(-2.0).overlaps(other.padded(-2.0))


def test_text_has_the_size_of_the_page_and_none_is_too_small(tmp_path: Path) -> None:
    figure = made(1, 1)
    drawn(figure, "84 mm, 10 pt", tmp_path)
    (axes,) = figure.axes
    assert axes.xaxis.label.get_fontsize() == pytest.approx(10.0)
    assert axes.get_xticklabels()[0].get_fontsize() == pytest.approx(10.0)
    assert figure.get_suptitle() == "", "it is the caption's"
    figure = made(1, 1)
    drawn(figure, "elsevier", tmp_path)
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert legend.get_texts()[0].get_fontsize() >= 6.0


def test_panels_that_would_be_narrow_go_below_each_other(tmp_path: Path) -> None:
    figure = made(1, 2)
    _, height = drawn(figure, "ieee", tmp_path)
    first, second = (axes.get_position() for axes in figure.axes)
    assert first.y0 > second.y1
    assert height > 100.0


def test_a_figure_of_many_panels_takes_two_columns(tmp_path: Path) -> None:
    figure = made(4, 3, words="a few words")
    width, _ = drawn(figure, "ieee", tmp_path)
    assert width == pytest.approx(181.9)


def test_the_caption_is_in_the_picture(tmp_path: Path) -> None:
    drawn(made(1, 1), "ieee", tmp_path)
    assert caption_of(tmp_path / "picture.png") == "what it shows, ± 5 µm"
    save(made(1, 1), "titled", tmp_path, ("png",))
    assert caption_of(tmp_path / "titled.png") == "the title of all"


def test_without_a_page_a_figure_stays_as_it_is(tmp_path: Path) -> None:
    figure = made(1, 2)
    save(figure, "picture", tmp_path, ("png",))
    assert figure.get_size_inches().tolist() == [WIDTH, 2.8]


def test_formats_by_name_and_by_width() -> None:
    assert page_format("ieee") is FORMATS["ieee"]
    assert page_format("84 mm") == PageFormat(84.0, 8.0)
    assert page_format("84mm, 9.5 pt") == PageFormat(84.0, 9.5)
    with pytest.raises(UserError, match='did you mean "elsevier"'):
        page_format("elsvier")

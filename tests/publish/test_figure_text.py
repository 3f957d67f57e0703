"""Text in figures: what matplotlib cannot set or its font does not have is drawn all the same, without a warning."""

from pathlib import Path

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.publish.figure_text import BOX, LONGEST, boxed, drawable, lacking, literal, mathematics_fails
from workbench.publish.pictures import caption_of, save
from workbench.publish.style import figure_style

ODD = (
    "$",
    "$$",
    r"$\frac{1}{$",
    "$x_{a_b}_c$",
    r"$\undefined$",
    "摩擦 friction",
    "\x1b[31m",
    "\u202eabc",
    "👩",
    "a\tb",
    "$摩$",
)


@pytest.mark.parametrize("text", ODD)
def test_a_figure_with_any_text_is_drawn(tmp_path: Path, text: str) -> None:
    with figure_style():
        figure = Figure()
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        axes.plot([literal(text), "b"], [1.0, 2.0], label=text)
        axes.set(title=text, xlabel=text, ylabel=text)
        axes.legend()
        figure.suptitle(text)
    paths = save(figure, "figure", tmp_path, ("png", "svg"))
    assert all(path.stat().st_size > 1000 for path in paths)
    assert figure.get_suptitle() == text
    assert axes.title.get_parse_math()
    assert "\x1b" not in caption_of(paths[0])


def test_text_that_can_be_drawn_stays(tmp_path: Path) -> None:
    figure = Figure()
    title = figure.suptitle("friction of é, $F_C$ and $x^2$ (N)")
    with drawable(figure):
        assert title.get_text() == "friction of é, $F_C$ and $x^2$ (N)"
        assert title.get_parse_math()


def test_boxes() -> None:
    assert lacking("friction é") == ""
    assert lacking("摩擦摩 é Δ") == "摩擦"
    assert boxed("摩擦 é") == f"{BOX}{BOX} é"
    assert literal("5 $") == r"5 \$"
    assert mathematics_fails("$x_1$") == ""
    assert "Unknown symbol" in mathematics_fails(r"$\undefined$")
    assert mathematics_fails("$" + "{" * 5000 + "$")


def test_lines_are_set_one_by_one(caplog: pytest.LogCaptureFixture) -> None:
    assert mathematics_fails("rotating\n$R^2$ = 1") == ""
    assert caplog.records == []


def test_a_line_that_leaves_no_room_is_cut(tmp_path: Path) -> None:
    """A legend as wide as its figure and wider: no layout finds room for the axes."""
    long = "at rest " * 50
    with figure_style():
        figure = Figure(layout="constrained")
        axes = figure.subplots()
        axes.plot([0.0, 1.0], label=long)
        axes.set_title(f"short\n{'$x$' * 100}")
        legend = axes.legend()
    save(figure, "cut", tmp_path, ("png",))
    (label,) = legend.get_texts()
    assert label.get_text() == long
    with drawable(figure):
        assert label.get_text() == f"{long[:LONGEST]}... (400 characters)"
        assert axes.get_title() == f"short\n{('$x$' * 100)[:LONGEST]}... (300 characters)"

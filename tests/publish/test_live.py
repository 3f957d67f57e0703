"""A figure on a page has the numbers and the looks of the figure on paper, or none."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.transforms import Affine2D
from page_numbers import read_floats

from workbench.publish.page.live import live
from workbench.publish.page.marks import ZOOM, plain_text


def drawn(draw: Callable[[Axes], object], **axes: Any) -> tuple[dict[str, Any], Axes]:
    """The panel of a figure with one, and what it was drawn in."""
    figure = Figure()
    FigureCanvasAgg(figure)
    panel = figure.subplots(subplot_kw=axes)
    draw(panel)
    content = live(figure)
    assert content is not None
    return content["panels"][0], panel


def is_refused(draw: Callable[[Axes], object]) -> bool:
    figure = Figure()
    FigureCanvasAgg(figure)
    draw(figure.subplots())
    return live(figure) is None


def test_a_line_has_its_numbers_and_looks() -> None:
    def draw(axes: Axes) -> None:
        axes.plot([0.0, 1.0, 2.0], [3.0, -1.0, 5.0], color="#0072B2", linestyle="--", linewidth=1.5, label="error")
        axes.set(title="Error", xlabel="time (s)", ylabel="error (mm)", xlim=(0.0, 2.0))
        axes.legend()

    panel, _ = drawn(draw)
    (line,) = panel["marks"]
    assert line["kind"] == "line"
    assert read_floats(line["x"]).tolist() == pytest.approx([0.0, 1.0, 2.0], abs=1e-6)
    assert read_floats(line["y"]).tolist() == pytest.approx([3.0, -1.0, 5.0])
    assert (line["color"], line["width"], len(line["dash"])) == ("#0072b2", 2.0, 2)
    assert panel["title"] == "Error"
    assert (panel["x"]["label"], panel["x"]["range"], panel["y"]["label"]) == ("time (s)", [0.0, 2.0], "error (mm)")
    (entry,) = panel["legend"]
    assert entry["label"] == "error"
    assert entry["marks"] == [line["id"]]
    assert entry["line"]["color"] == line["color"]


def test_points_with_bars_are_one_entry_of_the_legend() -> None:
    def draw(axes: Axes) -> None:
        axes.errorbar([1.0, 2.0], [3.0, 4.0], yerr=[[0.5, 0.5], [1.0, 1.0]], fmt="s", capsize=2.0, label="mean")
        axes.legend()

    panel, _ = drawn(draw)
    (entry,) = panel["legend"]
    assert entry["marker"]["kind"] == "square"
    assert set(entry["marks"]) == {mark["id"] for mark in panel["marks"]}
    bars = next(mark for mark in panel["marks"] if mark["kind"] == "line")
    ends = read_floats(bars["y"])
    assert ends[np.isfinite(ends)].tolist() == pytest.approx([2.5, 4.0, 3.5, 5.0])


def test_lines_and_bands_from_edge_to_edge() -> None:
    def draw(axes: Axes) -> None:
        axes.axvline(2.0)
        axes.axhline(-1.0)
        axes.axhspan(0.1, 0.2, color="#e4e4e4")
        axes.axvspan(5.0, 6.0)

    panel, _ = drawn(draw)
    spans = {mark["along"]: mark["at"] for mark in panel["marks"] if mark["kind"] == "span"}
    assert spans == {"height": 2.0, "width": -1.0}
    across, along = [mark for mark in panel["marks"] if mark["kind"] == "box"]
    assert (across["left"], across["right"]) == (None, None)
    assert (across["bottom"], across["top"]) == pytest.approx((0.1, 0.2))
    assert (along["left"], along["right"], along["top"]) == (5.0, 6.0, None)


def test_a_scale_that_the_page_lacks_is_drawn_as_on_paper_and_told_as_it_is() -> None:
    def draw(axes: Axes) -> None:
        axes.plot([0.0, 10.0, 125.0], [1.0, 2.0, 3.0], marker="o", linestyle="none")
        axes.set_xscale("symlog", linthresh=10.0)
        axes.set_xticks([0.0, 10.0, 125.0], ["rest", "10", "125"])
        axes.set_yscale("log")

    panel, axes = drawn(draw)
    points = panel["marks"][0]
    placed = axes.xaxis.get_transform().transform(np.array([0.0, 10.0, 125.0]))
    assert read_floats(points["x"]).tolist() == pytest.approx(placed.tolist())
    assert read_floats(points["said_x"]).tolist() == [0.0, 10.0, 125.0]
    assert (panel["x"]["scale"], panel["y"]["scale"]) == ("linear", "log")
    assert [label for _, label in panel["x"]["ticks"]] == ["rest", "10", "125"]
    assert [place for place, _ in panel["x"]["ticks"]] == pytest.approx(placed.tolist())
    assert "said_y" not in points


def test_fields_of_colour_and_words() -> None:
    def draw(axes: Axes) -> None:
        axes.pcolormesh(np.array([[0.0, 1.0], [0.5, 0.25]]), cmap="Greys", vmin=0.0, vmax=1.0)
        axes.text(0.5, 0.5, "7 of 9", ha="center", va="center")
        axes.text(0.5, 0.5, "of all draws", transform=axes.transAxes)

    panel, _ = drawn(draw)
    cells, words = panel["marks"]
    assert cells["colors"][:2] == ["#ffffff", "#000000"]
    assert read_floats(cells["left"]).tolist() == [0.0, 1.0, 0.0, 1.0]
    assert (words["text"], words["x"], words["align"], words["baseline"]) == ("7 of 9", 0.5, "center", "middle")
    assert panel["notes"] == ["of all draws"]


def test_panels_that_share_an_axis_say_so() -> None:
    figure = Figure()
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, sharex=True)
    below.set_xlabel("time (s)")
    above.plot([0.0, 1.0], [0.0, 1.0])
    content = live(figure)
    assert content is not None
    assert [panel["x"]["shared"] for panel in content["panels"]] == [0, 0]
    assert [panel["y"]["shared"] for panel in content["panels"]] == [0, 1]
    assert [panel["x"]["label"] for panel in content["panels"]] == ["time (s)", "time (s)"]


@pytest.mark.parametrize(
    "draw",
    [
        lambda axes: axes.add_patch(Rectangle((0.0, 0.0), 1.0, 1.0, hatch="//")),
        lambda axes: axes.add_patch(Circle((0.0, 0.0), 1.0)),
        lambda axes: axes.plot([0.0], [0.0], marker="p"),
        lambda axes: axes.plot([0.2], [0.2], marker="o", transform=axes.transAxes),
        lambda axes: axes.plot([0.0, 1.0], [0.0, 1.0], transform=Affine2D().rotate(0.1) + axes.transData),
        lambda axes: axes.plot([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], marker="o", markevery=2),
        lambda axes: axes.fill_between([0.0, 1.0], [0.0, 1.0], hatch="//"),
        lambda axes: axes.fill_between([0.0, 1.0], [0.0, 1.0], facecolor="none"),
        lambda axes: axes.add_patch(Rectangle((0.0, 0.0), 1.0, 1.0, angle=45.0)),
        lambda axes: axes.axhline(0.5, xmin=0.2, xmax=0.4),
        lambda axes: axes.axhspan(0.1, 0.2, xmax=0.4),
        lambda axes: axes.axhline(np.nan),
        lambda axes: axes.hist([1.0, 2.0, 2.0], histtype="step"),
        lambda axes: axes.hexbin([0.0, 1.0], [0.0, 1.0]),
        lambda axes: axes.vlines([0.0, 1.0], 0.0, 1.0, colors=["red", "blue"]),
        lambda axes: axes.pcolormesh(np.array([[0.0, np.nan], [0.5, 0.25]])),
        lambda axes: axes.text(0.5, 0.5, "turned", rotation=90),
        lambda axes: axes.annotate("there", (0.5, 0.5), (0.2, 0.2), arrowprops={"arrowstyle": "->"}),
        lambda axes: axes.twinx().plot([0.0], [1.0]),
        lambda axes: axes.inset_axes((0.5, 0.5, 0.3, 0.3)),
        lambda axes: axes.figure.text(0.5, 0.5, "beside"),
    ],
)
def test_what_the_page_cannot_draw_stays_a_picture(draw: Callable[[Axes], object]) -> None:
    assert is_refused(draw)


def test_markers_that_point_aside_are_turned() -> None:
    panel, _ = drawn(lambda axes: [axes.plot([0.0], [0.0], marker) for marker in ("<", ">", "|")])
    kinds = [(mark["marker"]["kind"], mark["marker"]["angle"]) for mark in panel["marks"]]
    assert kinds == [("triangle", 0.5 * np.pi), ("triangle", -0.5 * np.pi), ("dash", 0.5 * np.pi)]


def test_what_a_logarithmic_axis_does_not_reach() -> None:
    def draw(axes: Axes) -> None:
        axes.set_yscale("log")
        axes.set_ylim(0.1, 100.0)
        axes.plot([0.0, 1.0, 2.0, 3.0], [1.0, 0.0, 10.0, 20.0])
        axes.bar([0.0], [5.0])

    panel, _ = drawn(draw)
    box, line = sorted(panel["marks"], key=lambda mark: mark["kind"])
    assert (box["bottom"], box["top"]) == (0.1, 5.0)
    y = read_floats(line["y"])
    assert y[np.isfinite(y)].tolist() == pytest.approx([1.0, 10.0, 20.0])


def test_a_gap_in_a_noisy_line_stays_one() -> None:
    values = np.random.default_rng(1).normal(size=60_000)
    values[20_000:40_000] = np.nan
    panel, _ = drawn(lambda axes: axes.plot(np.arange(60_000.0), values))
    x, y = (read_floats(panel["marks"][0][name]) for name in ("x", "y"))
    (gap,) = np.flatnonzero(np.isnan(y))
    assert (x[gap - 1], x[gap + 1]) == (19_999.0, 40_000.0)


def test_numbers_far_from_zero_keep_their_digits() -> None:
    x = 1e6 + np.linspace(0.0, 0.5, 50)
    panel, _ = drawn(lambda axes: axes.plot(x, np.sin(20.0 * x), marker="o", linestyle="none"))
    assert read_floats(panel["marks"][0]["x"]) == pytest.approx(x, abs=1e-6)


def test_a_fit_goes_with_its_curve() -> None:
    def draw(axes: Axes) -> None:
        axes.plot([0.0, 1.0], [0.0, 1.0], color="#0072B2")
        axes.plot([0.0, 1.0], [0.1, 0.9], color="#0072B2", label="measured")
        axes.plot([0.0, 1.0], [0.3, 0.3], color="#D55E00", label="other")
        axes.legend()

    panel, _ = drawn(draw)
    assert [len(entry["marks"]) for entry in panel["legend"]] == [2, 1]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000), st.integers(2, 3000))
def test_a_simplified_curve_is_the_same_to_the_eye(seed: int, size: int) -> None:
    generator = np.random.default_rng(seed)
    x, y = np.cumsum(generator.normal(size=(2, size)) * generator.exponential(size=(2, 1)), axis=1)
    panel, axes = drawn(lambda axes: axes.plot(x, y))
    (line,) = panel["marks"]
    corners = axes.transData.transform(np.column_stack([read_floats(line["x"]), read_floats(line["y"])]))
    away = np.array([_distance(point, corners) for point in axes.transData.transform(np.column_stack([x, y]))])
    assert away.max() <= 0.5 / ZOOM


def _distance(point: np.ndarray, corners: np.ndarray) -> float:
    """From a point to a polygon, in pixels."""
    if len(corners) == 1:
        return float(np.hypot(*(corners[0] - point)))
    start, step = corners[:-1], np.diff(corners, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", step, step), 1e-300)
    share = np.clip(np.einsum("ij,ij->i", point - start, step) / square, 0.0, 1.0)
    return float(np.min(np.hypot(*(start + share[:, None] * step - point).T)))


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("R$^2$ = 0.99", "R² = 0.99"),
        ("-40 x$^{3}$ + 5 x", "-40 x³ + 5 x"),
        (r"$\mathdefault{10^{-4}}$", "10⁻⁴"),
        ("a^2", "a^2"),
    ],
)
def test_words_without_tex(text: str, plain: str) -> None:
    assert plain_text(text) == plain

"""The sweep on the page: a slider as an axis, drawn while it is computed; a click takes the bench to a point."""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from typing import Any, Literal

import numpy as np
from bokeh.document import Document
from bokeh.layouts import column, row
from bokeh.models import ColumnDataSource
from bokeh.models.widgets.buttons import Button
from bokeh.models.widgets.inputs import Select, Spinner
from bokeh.models.widgets.markups import Div
from bokeh.plotting import figure

from workbench.bench.knobs import Knob
from workbench.bench.looks import WIDGETS, Options
from workbench.bench.loop import BenchLoop
from workbench.bench.outcome import Outcome
from workbench.bench.sweep import POINTS, places, swept
from workbench.metrics.registry import columns, names_along
from workbench.publish.along import SHOWN
from workbench.publish.style import COLOURS
from workbench.publish.tables import with_unit
from workbench.study.report.shown_figures import FIGURES

BATCH = 10
"""Points that are drawn at a time."""

NUMBERS: list[tuple[str, str]] = [(name, words) for name, words in FIGURES if name != "limit_cycle"]


class SweepPanel:
    """A figure of the run over one of the knobs that are shown."""

    def __init__(
        self,
        document: Document,
        loop: Callable[[], BenchLoop],
        knobs: Callable[[], Sequence[Knob]],
        go: Callable[[Knob, float], None],
    ) -> None:
        self._document, self._loop, self._knobs, self._go = document, loop, knobs, go
        self._workers, self._turn = ThreadPoolExecutor(1), count()
        self._running = -1
        self._knob: Knob | None = None
        self._source = ColumnDataSource(data={"x": [], "y": []})
        self._choose = Select(title="over", options=[], stylesheets=[WIDGETS], name="sweep_knob", width=190)
        numbers: Options = [*NUMBERS]
        self._column = Select(
            title="figure",
            options=numbers,
            value="rms_error_m",
            stylesheets=[WIDGETS],
            name="sweep_figure",
            width=170,
        )
        self._points = Spinner(
            title="points", low=3, high=2000, step=1, value=POINTS, stylesheets=[WIDGETS], name="sweep_points", width=90
        )
        start = Button(label="Sweep", stylesheets=[WIDGETS], name="sweep_start", margin=(22, 5, 5, 5))
        start.on_click(self._start)
        self._words = Div(text="", stylesheets=[WIDGETS], name="sweep_words", margin=(26, 5, 5, 5))
        self._shown = self._plot("linear")
        self._place = column(Div(), sizing_mode="stretch_width")
        controls = row(self._choose, self._column, self._points, start, self._words, styles={"flex-wrap": "wrap"})
        self.layout = column(
            Div(text="<b>Sweep</b>: one slider as an axis; click a point to go there", stylesheets=[WIDGETS]),
            controls,
            self._place,
            sizing_mode="stretch_width",
            name="sweep",
        )
        self._source.selected.on_change("indices", lambda _attr, _old, new: self._clicked(new))

    def _plot(self, kind: Literal["linear", "log"]) -> Any:
        plot = figure(
            height=260,
            sizing_mode="stretch_width",
            x_axis_type=kind,
            tools="tap,pan,box_zoom,reset,save",
            name=f"sweep {kind}",
        )
        plot.toolbar.logo = None
        plot.toolbar.autohide = True
        plot.line("x", "y", source=self._source, line_color=COLOURS[0], line_width=1.4)
        plot.scatter("x", "y", source=self._source, size=6, color=COLOURS[0], nonselection_alpha=0.6)
        return plot

    def offer(self, outcome: Outcome) -> None:
        """Offer the knobs that are shown now, and the figures that the run has."""
        figures = outcome.figures
        called = names_along(outcome.run.plant.axis)
        numbers: Options = [one for one in NUMBERS if isinstance(figures.get(called[one[0]]), float)]
        self._column.options = numbers or [*NUMBERS]
        options: Options = [(knob.key, knob.label) for knob in self._knobs()]
        if options != self._choose.options:
            self._choose.options = options
            names = [knob.key for knob in self._knobs()]
            self._choose.value = self._choose.value if self._choose.value in names else (names or [""])[0]

    def _start(self) -> None:
        knob = next((knob for knob in self._knobs() if knob.key == self._choose.value), None)
        if knob is None:
            return
        loop, name = self._loop(), str(self._column.value)
        self._knob, self._running = knob, next(self._turn)
        values = [knob.at(place) for place in places(int(self._points.value or POINTS))]
        values = sorted({value for value in values if value > 0.0 or not knob.logarithmic})
        plot = self._plot("log" if knob.logarithmic else "linear")  # with ranges of its own
        self._place.children = [Div()]
        self._shown = plot
        axis = loop.parsed.axis
        described = columns(axis)[list(columns(axis))[list(columns()).index(name)]]
        along = SHOWN[axis]
        unit, factor = (along.unit, along.factor) if described.unit == axis else (described.unit, 1.0)
        plot.xaxis[0].axis_label = with_unit(knob.label, knob.shown or knob.unit)
        plot.yaxis[0].axis_label = with_unit(dict(FIGURES)[name], unit)
        self._source.selected.indices = []
        self._source.data = {"x": [], "y": []}
        self._workers.submit(self._sweep, self._running, loop, knob, values, name, factor)

    def _sweep(self, turn: int, loop: BenchLoop, knob: Knob, values: list[float], name: str, factor: float) -> None:
        """In a thread of its own; a newer sweep ends it."""
        batch: dict[str, list[float]] = {"x": [], "y": []}
        for number, (value, found) in enumerate(swept(loop, knob, values, name, lambda: self._running != turn), 1):
            batch["x"].append(value / knob.factor)
            batch["y"].append(math.nan if found is None else factor * found)
            if number % BATCH == 0 or number == len(values):
                self._document.add_next_tick_callback(_call(self._draw, turn, batch, number, len(values)))
                batch = {"x": [], "y": []}

    def _draw(self, turn: int, batch: dict[str, list[float]], number: int, of: int) -> None:
        if turn == self._running:
            self._source.stream(dict(batch))
            if self._place.children != [self._shown]:  # an empty plot has no ranges to draw
                self._place.children = [self._shown]
            found = int(np.count_nonzero(np.isfinite(np.asarray(self._source.data["y"], dtype=float))))
            lacking = f", {of - found} of them without this figure" if found < of else ""
            self._words.text = f"{number} of {of} points" if number < of else f"{of} points{lacking}"

    def _clicked(self, indices: Sequence[int]) -> None:
        if indices and self._knob is not None:
            self._go(self._knob, float(self._source.data["x"][indices[0]]) * self._knob.factor)


def _call(function: Callable[..., None], *arguments: Any) -> Callable[[], None]:
    """A callback without arguments: Bokeh keeps none that are partial twice."""
    return lambda: function(*arguments)

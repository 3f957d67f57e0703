"""A scope in the browser: a Bokeh figure, with curves of the run at hand and of the one that is pinned beside it."""

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, HoverTool
from bokeh.models.annotations.labels import Label
from bokeh.models.annotations.legends import Legend, LegendItem
from bokeh.plotting import figure

from workbench.bench.exports import export_tools
from workbench.bench.outcome import Outcome
from workbench.bench.scopes import SCOPES, View
from workbench.publish.style import COLOURS

MOST_CURVES = 4
"""Of a scope, for either run."""

HERE, PINNED = "here", "pinned"

HEIGHT = 250
"""Pixels."""

LEAST_WIDTH = 330
"""Pixels: two in a row on a screen, one on a telephone."""

DASHED = "6 4"

LEGEND_COLUMNS = 4

SHARED = frozenset({"reference position", "-1", "recorded position", "recorded pressure 1", "recorded pressure 2"})
"""Curves that are the same for both runs, or would only be in the way: not drawn again of the pinned one."""


class ScopeFigure:
    """One scope. Its curves stay the same objects from run to run: only their numbers travel to the browser."""

    def __init__(self, name: str) -> None:
        scope = SCOPES[name]
        self.name, self._find = name, scope.view
        self.figure = figure(
            height=HEIGHT,
            sizing_mode="stretch_width",
            min_width=LEAST_WIDTH,
            styles={"flex": f"1 1 {LEAST_WIDTH}px"},
            title=scope.title,
            x_axis_type="log" if scope.log_x else "linear",
            y_axis_type="log" if scope.log_y else "linear",
            tools="pan,box_zoom,reset,save",
            toolbar_location="above",
            output_backend="canvas",
            match_aspect=name == "nyquist",
            name=f"scope_{name}",
        )
        self.figure.add_tools(HoverTool(tooltips="($x, $y)", visible=False))
        self.figure.toolbar.logo = None
        self.figure.toolbar.autohide = True
        self._sources: dict[tuple[str, int], ColumnDataSource] = {}
        self._items: dict[tuple[str, int], LegendItem] = {}
        for run in (PINNED, HERE):  # the run at hand is drawn last, on top
            for number in range(MOST_CURVES):
                self._add(run, number)
        named = {f"{run} {i}": self._sources[run, i] for run in (HERE, PINNED) for i in range(MOST_CURVES)}
        self.figure.add_tools(*export_tools(self.figure, name, named))
        legend: Any = Legend(items=[], orientation="horizontal", ncols=LEGEND_COLUMNS, margin=2, spacing=8)
        legend.padding = 2
        legend.label_text_font_size = "11px"
        self.figure.add_layout(legend, "above")
        self._note = Label(x=8, y=8, x_units="screen", y_units="screen", text="", text_font_size="12px")
        self.figure.add_layout(self._note)

    def _add(self, run: str, number: int) -> None:
        source = ColumnDataSource(data=_nothing())
        style = {"line_width": 1.6} if run == HERE else {"line_width": 1.4, "line_dash": DASHED, "line_alpha": 0.9}
        colours = COLOURS[:MOST_CURVES] if run == HERE else COLOURS[MOST_CURVES : 2 * MOST_CURVES]
        line: Any = self.figure.line("x", "y", source=source, line_color=colours[number], **style)
        self._sources[run, number] = source
        self._items[run, number] = LegendItem(label="", renderers=[line])

    def show(self, here: Outcome, pinned: Outcome | None) -> None:
        """Draw a run, and the pinned one beside it."""
        view = self._find(here)
        shown = self._fill(HERE, view)
        shown += self._fill(PINNED, None if pinned is None else self._find(pinned))
        self._say(view)
        legend = self.figure.legend[0]
        shown = shown if len(shown) > 1 else []
        if legend.items != shown:
            legend.items = shown

    def _fill(self, run: str, view: View | None) -> list[LegendItem]:
        shown = []
        curves = () if view is None else [one for one in view.curves if run == HERE or one.name not in SHARED]
        for number in range(MOST_CURVES):
            source, item = self._sources[run, number], self._items[run, number]
            if number >= len(curves):
                if len(source.data["x"]):
                    source.data = _nothing()
                continue
            curve = curves[number]
            points: dict[str, Any] = {"x": curve.x, "y": curve.y}
            source.data = points
            source.name = curve.name if run == HERE else f"{curve.name}, pinned"
            item.label = {"value": curve.name if run == HERE else PINNED}
            if run == HERE or not number:  # of the pinned run one stands for all
                shown.append(item)
        return shown

    def _say(self, view: View) -> None:
        """Axes and notes, where they are others than before."""
        for axis, words in ((self.figure.xaxis[0], view.x), (self.figure.yaxis[0], view.y)):
            if axis.axis_label != words:
                axis.axis_label = words
        if self._note.text != view.note:
            self._note.text = view.note


def _nothing() -> dict[str, Any]:
    return {"x": np.empty(0), "y": np.empty(0)}

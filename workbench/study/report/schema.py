"""What a study file may ask of its results: probes, tables, figures, and pages."""

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from workbench.toml.file_names import FileName
from workbench.toml.quantities import Second
from workbench.toml.reading import Strict
from workbench.toml.units import si

MOST_PANELS, MOST_CURVES = 40, 400
"""Of a figure, one above the other, and of a panel: more nobody reads, and no picture can be so high."""

MOST_ROWS, MOST_TABLES = 10_000, 1000
"""Of a table, and of a study, which would write them for minutes."""

LONGEST_TEXT, MOST_LINES = 400, 8
"""Of a text in a figure: characters and lines."""

MOST_DIGITS = 17
"""Of a number: more a double does not have."""

NARROWEST, FARTHEST = 1e-9, 1e30
"""Of a range that is drawn: its width as a share of its ends, and how far these may be."""


def _span(ends: tuple[float, float]) -> tuple[float, float]:
    size = max(map(abs, ends))
    if not all(map(math.isfinite, ends)) or size > FARTHEST or abs(ends[1] - ends[0]) <= NARROWEST * size:
        raise ValueError(f"got {list(ends)}, expected two different numbers, none beyond {FARTHEST:g}")
    return ends


def _short(text: str) -> str:
    if len(text) > LONGEST_TEXT or text.count("\n") >= MOST_LINES:
        got = f"{len(text)} characters on {text.count(chr(10)) + 1} lines"
        raise ValueError(f"has {got}, expected at most {LONGEST_TEXT} on {MOST_LINES}")
    return text


Words = Annotated[str, AfterValidator(_short)]
"""Text in a figure, which has room for so much."""

Span = Annotated[tuple[float, float], AfterValidator(_span)]
"""The ends of an axis."""

Digits = Annotated[int, Field(ge=1, le=MOST_DIGITS)]
"""Significant digits of a number that is shown."""


class Probe(Strict):
    """[probes.NAME]: one more figure of each run, a column of that name behind the others (SI).

    Events are upward crossings of the signal `event` through `event_level`: `interval` is the mean time between
    them, `change` the mean change of `signal` from one to the next; every other figure is taken from the first to
    the last event where there are events, else over the window of the metrics. `share_below` is the share of time
    in which |signal| is below `level`; `decay_rate` (1/s) that at which the signal approaches its final value.
    """

    signal: str
    """Of the plant, or of the controller's state."""
    take: Literal[
        "maximum", "minimum", "peak_to_peak", "mean", "rms", "final", "share_below", "decay_rate", "interval", "change"
    ]
    """What is taken of it."""
    level: float | None = None
    """Of `share_below`."""
    event: str | None = None
    """Signal whose upward crossings are events."""
    event_level: float = 0.0
    """Level that it crosses."""
    cases: list[str] = []
    """The cases that have the column; by default all."""

    @model_validator(mode="after")
    def _complete(self) -> "Probe":
        if (self.take == "share_below") != (self.level is not None):
            raise ValueError("level belongs to take = share_below, which needs one")
        if self.take in ("interval", "change") and self.event is None:
            raise ValueError(f'take = "{self.take}" needs an event')
        return self


SHARES = ("share", "share_below")
"""What is a share of cases, whatever the unit of their values."""

LEVELLED = ("share_below", "quantile")
"""What is taken at a level."""


class Summary(Strict):
    """What is taken of the values of several cases, where a table or a panel is `over` the axes that tell these apart.

    Cases without a value are left out. `share` counts those that have one of the words in `of`, `share_below` those
    whose magnitude is below `level`; `quantile` interpolates linearly; `standard_deviation` is that of a sample.
    """

    take: (
        Literal["mean", "median", "minimum", "maximum", "standard_deviation", "quantile", "share", "share_below"] | None
    ) = None
    """What is taken, with `over`."""
    level: float | str | None = None
    """Of `quantile`, from 0 to 1, and of `share_below`, a quantity."""
    of: list[str] = []
    """The words that a `share` counts."""

    @model_validator(mode="after")
    def _has_what_it_takes(self) -> "Summary":
        if (self.take in LEVELLED) != (self.level is not None):
            raise ValueError('level belongs to take = "quantile" and "share_below", which need one')
        if (self.take == "share") != bool(self.of):
            raise ValueError('of belongs to take = "share", which needs the words that count')
        if self.take == "quantile" and not 0.0 <= si(self.level, "1") <= 1.0:
            raise ValueError(f"level: got {self.level}, expected a share from 0 to 1")
        return self


def _check_summaries(over: Sequence[str], summaries: Mapping[str, Summary]) -> None:
    """Raise ValueError where some of what has these names has nothing to take, or something and no several cases."""
    for name, summary in summaries.items():
        if over and summary.take is None:
            raise ValueError(f'{name}: expected a take such as "median" for its cases over {" and ".join(over)}')
        if not over and summary.take is not None:
            raise ValueError(f'{name}: take = "{summary.take}" needs over, such as over = ["draw"]')


class Column(Summary):
    """One column of a table over an axis: a figure of the results, beside its published values by axis value.

    `against` holds values by axis value for each of the table's `references`. `where` picks its cases among those of
    the table, as where columns come from different references. What is smaller than `least`, a number in the unit
    shown, or an error than its solver error, is shown as "< least".
    """

    result: str
    """A column of results.csv."""
    label: str
    """Its heading."""
    unit: str = "1"
    """In which it is shown; 1: as it is stored."""
    digits: Digits = 4
    """Significant ones."""
    published: dict[str, float] = {}
    """Values to hold it against, by axis value."""
    against: dict[str, dict[str, float]] = {}
    """The same for each of the table's `references`."""
    where: dict[str, Any] = {}
    """Picks its cases among those of the table."""
    least: float = Field(0.0, ge=0.0)
    """What is smaller is shown as less than this."""


class Row(Summary):
    """One row of a table of single figures; `against` holds a value for each of the table's `references`."""

    where: dict[str, Any] = {}
    """Picks the case."""
    result: str
    """A column of results.csv."""
    label: str
    """What the row is called."""
    unit: str = "1"
    """In which it is shown."""
    digits: Digits = 4
    """Significant ones."""
    published: float | None = None
    """The value to hold it against."""
    against: dict[str, float] = {}
    """The same for each of the table's `references`."""
    remark: str = ""
    """Behind the numbers."""
    least: float = Field(0.0, ge=0.0)
    """What is smaller is shown as less than this."""


class TableSpec(Strict):
    """[[tables]]: `columns` over the values of the axis `index`, or `rows` of single figures; never both.

    `compared_with` heads the values under `published`: "reference" where they come from a formula or from another
    computation and are printed nowhere; `source` says where. Further ones, by name, have their source in `references`
    and their values under `against`: a column each, with the difference from it. With `across`, another axis, the
    values of one column stand side by side, each with its place among its neighbours above and below (none with
    `places` = false): the smallest in magnitude first, a power by its value; those below what is told apart share a
    place.
    """

    name: FileName
    """Of its files."""
    title: str
    """Above it."""
    source: str = ""
    """Where published values come from."""
    note: str = ""
    """Below it."""
    compared_with: Literal["published", "reference"] = "published"
    """What the values under `published` are called."""
    references: dict[str, str] = {}
    """Further values to hold it against: their sources by name."""
    index: str | None = None
    """The axis of its lines."""
    index_label: str = ""
    """Heading of that axis."""
    across: str | None = None
    """A second axis, whose values stand side by side."""
    places: bool | None = None
    """Whether each value has its place among its neighbours."""
    over: list[str] = []
    """Axes, such as `draw`, of whose cases each figure takes what its `take` says."""
    where: dict[str, Any] = {}
    """Picks its cases."""
    columns: list[Column] = Field([], max_length=MOST_CURVES)
    """Of a table over an axis."""
    rows: list[Row] = Field([], max_length=MOST_ROWS)
    """Of a table of single figures."""

    @model_validator(mode="after")
    def _one_form(self) -> "TableSpec":
        if bool(self.rows) == bool(self.columns) or bool(self.columns) != (self.index is not None):
            raise ValueError("expected index with columns, or rows")
        if self.across is not None and (len(self.columns) != 1 or self.columns[0].published or self.columns[0].against):
            raise ValueError("across: expected index with one column, without published values")
        if self.compared_with in self.references:
            raise ValueError(f'references: "{self.compared_with}" is that of `published`, with its source in `source`')
        if self.places is not None and self.across is None:
            raise ValueError("places: belongs to a table with across")
        headings = [(column.label, column.unit) for column in self.columns]
        if len(set(headings)) < len(headings):
            raise ValueError("two columns have the same label: expected different ones")
        for axis in (self.index, self.across):
            if axis in self.over:
                raise ValueError(f'over: "{axis}" is an axis of the table')
        figures: Sequence[Column | Row] = (*self.columns, *self.rows)
        _check_summaries(self.over, {f'"{each.label}"': each for each in figures})
        return self


class Curve(Summary):
    """One line of a panel: a signal of the run that `where` picks, or a column of the results over an axis.

    One without a label, behind one that has a label, goes on with the line before it: the same of another run.
    """

    y: str
    """A signal, or a column of the results."""
    x: str | None = None
    """By default the panel's."""
    where: dict[str, Any] = {}
    """Picks the run, or the cases."""
    label: Words = ""
    """In the legend; without one the line before goes on."""
    fit: Literal["line", "cubic"] | None = None
    """Regression drawn beside it, written into the legend."""
    band: tuple[float, float] | None = None
    """Two quantiles, from 0 to 1, between which it is shaded, with `over`."""
    published: dict[str, float] = {}
    """Values to draw beside it, by axis value."""
    style: Literal["line", "points", "reference"] = "line"
    """How it is drawn."""

    @model_validator(mode="after")
    def _has_a_band(self) -> "Curve":
        if self.band is not None and not 0.0 <= self.band[0] < self.band[1] <= 1.0:
            raise ValueError(f"band: got {list(self.band)}, expected two quantiles from 0 to 1, the lower one first")
        if self.band is not None and (self.take is None or self.take in SHARES):
            raise ValueError("band: belongs to a take of values over several cases")
        return self


class Panel(Strict):
    """One pair of axes. Units are those shown; limits and `levels`, horizontal lines by label, are numbers in them.
    Without `x_unit` it is that of the signal, of the column, or of the axis as the study writes its values; without
    `y_unit` that of the curves where all have one. "1" shows values as they are stored, without a unit.

    `measured_rpm` draws the measured friction of [friction_curves] at that speed of rotation under signals over
    velocity; how far each of them is off it goes to the table `validation`.
    """

    title: Words = ""
    """Above the panel."""
    x: str = "time"
    """A signal, a column of the results or an axis."""
    x_label: Words
    """Without the unit."""
    y_label: Words
    """Without the unit."""
    x_unit: str | None = None
    """In which x is shown."""
    y_unit: str | None = None
    """In which y is shown."""
    x_range: Span | None = None
    """Ends of the axis, in the unit shown."""
    y_range: Span | None = None
    """The same of y."""
    start: Second = 0.0
    """Time from which signals are drawn."""
    end: Second | None = None
    """Time to which they are."""
    legend: Literal[
        "best",
        "upper left",
        "upper center",
        "upper right",
        "center left",
        "center",
        "center right",
        "lower left",
        "lower center",
        "lower right",
        "outside",
    ] = "best"
    """Where it stands."""
    levels: dict[Words, float] = Field({}, max_length=MOST_CURVES)
    """Horizontal lines by label."""
    measured_rpm: float | None = None
    """Draws the measured friction of [friction_curves] at this speed of rotation."""
    note: Words = ""
    """In the panel."""
    over: list[str] = []
    """Axes, such as `draw`, of whose cases each curve takes what its `take` says, in a panel of results."""
    curves: list[Curve] = Field(min_length=1, max_length=MOST_CURVES)
    """What is drawn."""

    @model_validator(mode="after")
    def _measured_over_velocity(self) -> "Panel":
        if self.measured_rpm is not None and self.x != "velocity":
            raise ValueError('measured_rpm draws measured friction over velocity: expected x = "velocity"')
        return self

    @model_validator(mode="after")
    def _takes_of_several(self) -> "Panel":
        if self.x in self.over:
            raise ValueError(f'over: "{self.x}" is the axis of the panel')
        _check_summaries(self.over, {f'curve of "{curve.y}"': curve for curve in self.curves})
        return self


class FigureSpec(Strict):
    """[[figures]]: panels one above the other."""

    name: FileName
    """Of its files."""
    title: Words
    """Above it."""
    source: str = ""
    """Where published curves come from."""
    panels: list[Panel] = Field(min_length=1, max_length=MOST_PANELS)
    """One above the other."""

"""What may stand in a study file. TOML, data only: a study can run no code."""

from functools import partial
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictFloat, model_validator

from workbench.files import Strict
from workbench.simulation.simulate import DEFAULT_TOLERANCE, METHODS
from workbench.units import QuantityError, si

Raw = StrictFloat | str
"""A quantity whose unit depends on its place; converted when the case is resolved."""

Metre = Annotated[float, BeforeValidator(partial(si, unit="m"))]
Second = Annotated[float, BeforeValidator(partial(si, unit="s"))]
Hertz = Annotated[float, BeforeValidator(partial(si, unit="Hz"))]
Radian = Annotated[float, BeforeValidator(partial(si, unit="rad"))]


def rpm_si(value: Any) -> float:
    """A speed of rotation in rad/s; unlike elsewhere a bare number is in rpm, the unit of the axis' name."""
    try:
        speed = si(f"{value} rpm" if isinstance(value, int | float) and not isinstance(value, bool) else value, "rad/s")
    except QuantityError:
        raise QuantityError(f'got {value!r}, expected a speed of rotation, such as 460 or "460 rpm"') from None
    if speed < 0.0:
        raise QuantityError(f"got {value!r}, expected a speed that is not negative")
    return speed


Rotation = Annotated[float, BeforeValidator(rpm_si)]


MOST_SAMPLES = 2e7
"""Samples of one run: more would not fit into the memory of a small machine."""


class PlantTable(Strict):
    """[plant]: the truth."""

    model: str
    parameters: str
    bristle: Literal["helical", "isotropic", "anisotropic"] = "helical"
    inertia: Literal["own", "mass"] = "own"
    rotation: Literal["voltage", "servo", "ideal", "scheduled"] = "voltage"
    minimum_helical_speed: Annotated[float, BeforeValidator(partial(si, unit="m/s")), Field(gt=0.0)] | None = None
    start: Literal["turning", "standstill"] = "turning"
    flow: Literal["derived", "chapter3"] = "derived"
    command: Literal["force", "voltage"] = "force"
    start_position: Metre = 0.0
    set: dict[str, Raw] = {}
    scale: dict[str, float] = {}
    spread: dict[str, float] = {}

    @model_validator(mode="after")
    def _minimum_is_used(self) -> "PlantTable":
        if self.minimum_helical_speed is not None and self.rotation != "scheduled":
            raise ValueError('minimum_helical_speed belongs to rotation = "scheduled"')
        return self


class BeliefTable(Strict):
    """[belief]: what controllers believe; by default what the study declares of its plant."""

    parameters: str | None = None
    flow: Literal["derived", "chapter3"] | None = None
    set: dict[str, Raw] = {}


class ChannelTable(Strict):
    """One sensor. The converter's step is `resolution`, or `range` over 2 to the power of `bits`.

    `calibration_error` is the peak of a smooth error over a `calibration_travel` of the measured value, and
    `calibration_seed` draws its curve.
    """

    noise: Raw = 0.0
    resolution: Raw | None = None
    range: Raw | None = None
    bits: int | None = Field(None, ge=1, le=32)
    anti_alias: Hertz = Field(0.0, ge=0.0)
    offset: Raw = 0.0
    gain_error: float = Field(0.0, gt=-1.0)
    calibration_error: Raw | None = None
    calibration_travel: Raw | None = None
    calibration_seed: int = Field(1, ge=0)

    @model_validator(mode="after")
    def _one_way(self) -> "ChannelTable":
        if (self.range is None) != (self.bits is None) or (self.bits and self.resolution is not None):
            raise ValueError("expected either resolution, or range together with bits")
        if (self.calibration_error is None) != (self.calibration_travel is None):
            raise ValueError("expected calibration_error together with calibration_travel")
        return self


class SensorsTable(Strict):
    """[sensors]: ideal where nothing is said."""

    delay: Second = Field(0.0, ge=0.0)
    position: ChannelTable = ChannelTable()
    pressure_1: ChannelTable = ChannelTable()
    pressure_2: ChannelTable = ChannelTable()
    rotation_speed: ChannelTable = ChannelTable()
    motor_current: ChannelTable = ChannelTable()


class SimulationTable(Strict):
    """[simulation]: how long, how exactly."""

    duration: Second = Field(gt=0.0)
    transient: Second = Field(0.0, ge=0.0)
    sample_time: Second = Field(1e-3, gt=0.0)
    seed: int = Field(0, ge=0)
    method: Literal[tuple(METHODS)] = "dormand_prince"  # type: ignore[valid-type]
    step: Second = Field(1e-4, gt=0.0)
    tolerance: float = Field(DEFAULT_TOLERANCE, gt=0.0, le=1e-2)

    @model_validator(mode="after")
    def _fits(self) -> "SimulationTable":
        if self.transient >= self.duration:
            raise ValueError(f"transient {self.transient:g} s leaves nothing of the duration of {self.duration:g} s")
        if not 1.0 <= self.duration / self.sample_time <= MOST_SAMPLES:
            raise ValueError(
                f"duration {self.duration:g} s at a sample_time of {self.sample_time:g} s: expected between 1 and "
                f"{MOST_SAMPLES:g} samples"
            )
        return self


class Probe(Strict):
    """[probes.NAME]: one more figure of each run, a column of that name behind the others (SI).

    Events are upward crossings of the signal `event` through `event_level`: `interval` is the mean time between
    them, `change` the mean change of `signal` from one to the next; every other figure is taken from the first to
    the last event where there are events, else over the window of the metrics. `share_below` is the share of time
    in which |signal| is below `level`; `decay_rate` (1/s) that at which the signal approaches its final value.
    """

    signal: str
    take: Literal[
        "maximum", "minimum", "peak_to_peak", "mean", "rms", "final", "share_below", "decay_rate", "interval", "change"
    ]
    level: float | None = None
    event: str | None = None
    event_level: float = 0.0
    cases: list[str] = []

    @model_validator(mode="after")
    def _complete(self) -> "Probe":
        if (self.take == "share_below") != (self.level is not None):
            raise ValueError("level belongs to take = share_below, which needs one")
        if self.take in ("interval", "change") and self.event is None:
            raise ValueError(f'take = "{self.take}" needs an event')
        return self


class Column(Strict):
    """One column of a table over an axis: a figure of the results, beside its published values by axis value."""

    result: str
    label: str
    unit: str = "1"
    digits: int = 4
    published: dict[str, float] = {}


class Row(Strict):
    """One row of a table of single figures."""

    where: dict[str, Any] = {}
    result: str
    label: str
    unit: str = "1"
    digits: int = 4
    published: float | None = None
    remark: str = ""


class TableSpec(Strict):
    """[[tables]]: `columns` over the values of the axis `index`, or `rows` of single figures; never both.

    `compared_with` heads the values under `published`: "reference" where they come from a formula or from another
    computation and are printed nowhere.
    """

    name: str = Field(pattern=r"^[A-Za-z0-9_.-]+$")
    title: str
    source: str = ""
    note: str = ""
    compared_with: Literal["published", "reference"] = "published"
    index: str | None = None
    index_label: str = ""
    where: dict[str, Any] = {}
    columns: list[Column] = []
    rows: list[Row] = []

    @model_validator(mode="after")
    def _one_form(self) -> "TableSpec":
        if bool(self.rows) == bool(self.columns) or bool(self.columns) != (self.index is not None):
            raise ValueError("expected index with columns, or rows")
        headings = [(column.label, column.unit) for column in self.columns]
        if len(set(headings)) < len(headings):
            raise ValueError("two columns have the same label: expected different ones")
        return self


class Curve(Strict):
    """One line of a panel: a signal of the run that `where` picks, or a column of the results over an axis.

    One without a label, behind one that has a label, goes on with the line before it: the same of another run.
    """

    y: str
    x: str | None = None
    where: dict[str, Any] = {}
    label: str = ""
    fit: Literal["line", "cubic"] | None = None
    published: dict[str, float] = {}
    style: Literal["line", "points", "reference"] = "line"


class Panel(Strict):
    """One pair of axes. Units are those shown; limits and `levels`, horizontal lines by label, are numbers in them.

    `measured_rpm` draws the measured friction of [friction_curves] at that speed of rotation under signals over
    velocity; how far each of them is off it goes to the table `validation`.
    """

    title: str = ""
    x: str = "time"
    x_label: str
    y_label: str
    x_unit: str = "s"
    y_unit: str = "1"
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    start: Second = 0.0
    end: Second | None = None
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
    levels: dict[str, float] = {}
    measured_rpm: float | None = None
    note: str = ""
    curves: list[Curve] = Field(min_length=1)

    @model_validator(mode="after")
    def _measured_over_velocity(self) -> "Panel":
        if self.measured_rpm is not None and self.x != "velocity":
            raise ValueError('measured_rpm draws measured friction over velocity: expected x = "velocity"')
        return self


class FigureSpec(Strict):
    """[[figures]]: panels one above the other."""

    name: str = Field(pattern=r"^[A-Za-z0-9_.-]+$")
    title: str
    source: str = ""
    panels: list[Panel] = Field(min_length=1)


class Account(Strict):
    """One way to count: the sum of columns of the results."""

    label: str
    columns: list[str] = Field(min_length=1)


class BreakEvenTable(Strict):
    """[[break_even]]: where along the axis the sum of some columns is less than at its first value, by each account."""

    name: str = Field(pattern=r"^[A-Za-z0-9_.-]+$")
    title: str
    axis: str = "rpm"
    where: dict[str, Any] = {}
    accounts: list[Account] = Field(min_length=1)
    note: str = ""


class FrictionCurvesTable(Strict):
    """[friction_curves]: hold the bristle laws against measured friction-velocity curves of a rotating rod.

    `measured` is a file of static parameters, `parameters` what the laws know; effects are fitted at `fit_rpm` and
    checked at `check_rpm`; power is told at `speed`. `reference_slope` has, by rpm, the slope that rotation adds at v
    = 0 and by regression.
    """

    measured: str
    parameters: str
    fit_rpm: list[float] = Field(min_length=1)
    check_rpm: list[float] = Field(min_length=1)
    speed: Annotated[float, BeforeValidator(partial(si, unit="m/s"))]
    reference_slope: dict[str, tuple[float, float]] = {}


class ComparisonTable(Strict):
    """[comparison]: make a page that compares compensation with rotation out of the results.

    `plain` names the controllers without friction compensation, whose rotated cases are the avoidance; `steps` the
    references that are judged by steady-state error and limit cycles; errors that differ by less than `negligible` are
    level.
    """

    plain: list[str] = Field(min_length=1)
    steps: list[str] = []
    negligible: Metre = Field(1e-6, gt=0.0)
    assumptions: list[str] = []


class CaseTables(Strict):
    """What one case is made of, after cases, scenario and axes have been filled in."""

    plant: PlantTable
    belief: BeliefTable = BeliefTable()
    sensors: SensorsTable = SensorsTable()
    simulation: SimulationTable
    controllers: dict[str, dict[str, Any]] = {}
    references: dict[str, dict[str, Any]] = {}
    rpm: Rotation = 0.0
    controller: str | None = None
    reference: str | None = None


OVERRIDES = ("plant", "belief", "sensors", "simulation", "controllers", "references", "axes")
"""What a [cases.NAME] may change of the study; a [scenarios.NAME] the same without axes."""


class StudyFile(Strict):
    """A whole study file. What cases fill in is checked in each case, not here.

    `records` names signals that every case writes into a file of its own, as a rig would.
    """

    title: str
    source: str = ""
    question: str = ""
    plant: dict[str, Any] = {}
    belief: dict[str, Any] = {}
    sensors: dict[str, Any] = {}
    simulation: dict[str, Any] = {}
    controllers: dict[str, dict[str, Any]] = {}
    references: dict[str, dict[str, Any]] = {}
    axes: dict[str, list[Any]] = {}
    scenarios: dict[str, dict[str, Any]] = {}
    cases: dict[str, dict[str, Any]] = {}
    probes: dict[str, Probe] = {}
    records: list[str] = []
    tables: list[TableSpec] = []
    figures: list[FigureSpec] = []
    break_even: list[BreakEvenTable] = []
    comparison: ComparisonTable | None = None
    friction_curves: FrictionCurvesTable | None = None

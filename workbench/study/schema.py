"""What may stand in a study file. TOML, data only: a study can run no code."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from plants.laws.lugre import LUGRE
from workbench.simulation.setup import DEFAULT_TOLERANCE, Integrator
from workbench.study.report.schema import MOST_TABLES, FigureSpec, Probe, TableSpec
from workbench.study.uncertainty_schema import UncertaintyTable
from workbench.toml.quantities import AxisNumber, Hertz, Length, MetrePerSecond, Raw, Rotation, Second
from workbench.toml.reading import Strict

MOST_SAMPLES = 2e7
"""Samples of one run: more would not fit into the memory of a small machine."""

MOST_STEPS = 1e10
"""Fixed steps of one run, which take half an hour: more are a slip of the pen."""

MOST_DELAY = 1e6
"""Samples by which readings may be late."""

LEAST_TOLERANCE = 1e-14
"""Below it doubles have no digits, and no step is short enough."""


class FmuVariableTable(Strict):
    """A variable of an FMU, and the unit that it is taken to be in where the FMU says none."""

    variable: str
    unit: str | None = None


class PlantTable(Strict):
    """[plant]: the truth. With `fmu` an FMU stands in the place of the model, whose inputs and outputs are mapped."""

    model: str
    parameters: str
    fmu: str | None = None
    inputs: dict[str, str | FmuVariableTable] = {}
    outputs: dict[str, str | FmuVariableTable] = {}
    start_values: dict[str, Raw] = {}
    turned: Literal["rod", "cylinder"] | None = None
    bristle: Literal["helical", "isotropic", "anisotropic"] = "helical"
    inertia: Literal["own", "mass"] = "own"
    rotation: Literal["voltage", "servo", "ideal", "scheduled", "switched"] = "servo"
    motor_limits: bool = True
    motor: Literal["printed", "consistent"] = "printed"
    minimum_helical_speed: Annotated[MetrePerSecond, Field(gt=0.0)] | None = None
    switch_speed: Annotated[MetrePerSecond, Field(gt=0.0)] | None = None
    start: Literal["turning", "standstill"] = "turning"
    friction: str = LUGRE.name
    flow: Literal["derived", "chapter3"] = "derived"
    command: Literal["force", "voltage", "current"] = "force"
    start_position: Length = AxisNumber(0.0)
    set: dict[str, Raw] = {}
    scale: dict[str, float] = {}
    spread: dict[str, float] = {}

    @model_validator(mode="after")
    def _mapping_is_used(self) -> "PlantTable":
        for name in ("inputs", "outputs", "start_values"):
            if self.fmu is None and name in self.model_fields_set:
                raise ValueError(f"{name} belongs to fmu, the name of an FMU's file")
        return self

    @model_validator(mode="after")
    def _minimum_is_used(self) -> "PlantTable":
        if self.minimum_helical_speed is not None and self.rotation != "scheduled":
            raise ValueError('minimum_helical_speed belongs to rotation = "scheduled"')
        if (self.switch_speed is not None) != (self.rotation == "switched"):
            raise ValueError('switch_speed belongs to rotation = "switched", which needs one')
        return self


class BeliefTable(Strict):
    """[belief]: what controllers believe; by default what the study declares of its plant, with LuGre's friction.

    `friction` names the law that they believe in: what it has no place for is believed to be 0.
    """

    parameters: str | None = None
    friction: str = LUGRE.name
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
    """[sensors]: ideal where nothing is said.

    `friction_gauge` adds what no rig has: the true friction, for a controller of that type and for no other.
    """

    delay: Second = Field(0.0, ge=0.0)
    position: ChannelTable = ChannelTable()
    pressure_1: ChannelTable = ChannelTable()
    pressure_2: ChannelTable = ChannelTable()
    rotation_speed: ChannelTable = ChannelTable()
    motor_current: ChannelTable = ChannelTable()
    friction_gauge: bool = False


class SimulationTable(Strict):
    """[simulation]: how long, how exactly.

    `hold_limit`: how long the last dwell of a reference may be made where it is too short to tell a limit cycle.
    """

    duration: Second = Field(gt=0.0)
    transient: Second = Field(0.0, ge=0.0)
    sample_time: Second = Field(1e-3, gt=0.0)
    seed: int = Field(0, ge=0)
    method: str = Integrator().method
    step: Second = Field(1e-4, gt=0.0)
    tolerance: float = Field(DEFAULT_TOLERANCE, ge=LEAST_TOLERANCE, le=1e-2)
    hold_limit: Second = Field(120.0, ge=0.0)

    @model_validator(mode="after")
    def _fits(self) -> "SimulationTable":
        if self.transient >= self.duration:
            raise ValueError(f"transient {self.transient:g} s leaves nothing of the duration of {self.duration:g} s")
        if not 1.0 <= self.duration / self.sample_time <= MOST_SAMPLES:
            raise ValueError(
                f"duration {self.duration:g} s at a sample_time of {self.sample_time:g} s: expected between 1 and "
                f"{MOST_SAMPLES:g} samples"
            )
        if "step" in self.model_fields_set and (steps := self.duration / self.step) > MOST_STEPS:
            raise ValueError(
                f"step {self.step:g} s: makes {steps:g} steps of the duration of {self.duration:g} s, expected at most "
                f"{MOST_STEPS:g}"
            )
        if self.hold_limit / self.sample_time > MOST_SAMPLES:
            raise ValueError(
                f"hold_limit {self.hold_limit:g} s at a sample_time of {self.sample_time:g} s: expected at most "
                f"{MOST_SAMPLES:g} samples"
            )
        return self


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

    @model_validator(mode="after")
    def _delay_is_kept(self) -> "CaseTables":
        if (samples := self.sensors.delay / self.simulation.sample_time) > MOST_DELAY:
            raise ValueError(
                f"sensors.delay: {samples:g} samples are kept on their way, expected at most {MOST_DELAY:g}"
            )
        return self


OVERRIDES = ("plant", "belief", "sensors", "simulation", "controllers", "references", "axes")
"""What a [cases.NAME] may change of the study; [machines.NAME] and [scenarios.NAME] the same without axes."""


class StudyFile(Strict):
    """A study file without the sections of other questions. What cases fill in is checked in each case, not here.

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
    machines: dict[str, dict[str, Any]] = {}
    scenarios: dict[str, dict[str, Any]] = {}
    cases: dict[str, dict[str, Any]] = {}
    probes: dict[str, Probe] = {}
    records: list[str] = []
    tables: list[TableSpec] = Field([], max_length=MOST_TABLES)
    figures: list[FigureSpec] = Field([], max_length=MOST_TABLES)
    uncertainty: UncertaintyTable | None = None

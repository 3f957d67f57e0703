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
    """Its name in the FMU."""
    unit: str | None = None
    """In which it is where the FMU does not say."""


class PlantTable(Strict):
    """[plant]: the truth. With `fmu` an FMU stands in the place of the model, whose inputs and outputs are mapped."""

    model: str
    """A plant that `workbench list plants` shows; `by_rpm` is non-rotating at rpm 0 and rotating elsewhere."""
    parameters: str
    """A named set, or a parameter file relative to the study."""
    fmu: str | None = None
    """The file of an FMU, relative to the study, that is run in the place of the model's equations."""
    inputs: dict[str, str | FmuVariableTable] = {}
    """Of the model, each with the FMU's variable that it is."""
    outputs: dict[str, str | FmuVariableTable] = {}
    """Of the model, states and what is measured, each with the FMU's variable that it is."""
    start_values: dict[str, Raw] = {}
    """Parameters and starts of the FMU, by its own names."""
    turned: Literal["rod", "cylinder"] | None = None
    """The part that a motor turns where rpm is not 0; a `cylinder` has an inertia of its own."""
    bristle: Literal["helical", "isotropic", "anisotropic"] = "helical"
    """How friction along and around depend on each other: as the thesis prints it, alike, or apart."""
    inertia: Literal["own", "mass"] = "own"
    """Of a rotating plant: `rotary_inertia` of the parameters, or the moving mass at the piston's surface."""
    rotation: Literal["voltage", "servo", "ideal", "scheduled", "switched"] = "servo"
    """How rpm is held.

    By a speed servo; by the constant voltage believed to hold it; imposed; with less of it while the piston moves by
    itself; or only while the piston moves slowly along or rests.
    """
    motor_limits: bool = True
    """Whether torque, current, voltage and speed of the motor have ends; `false` lifts them, of truth and belief."""
    motor: Literal["printed", "consistent"] = "printed"
    """Motor constants as printed, or with the back-emf constant equal to the torque constant."""
    minimum_helical_speed: Annotated[MetrePerSecond, Field(gt=0.0)] | None = None
    """Below which a scheduled rotation never lets the contact fall; by default the speed of the axis `rpm`."""
    switch_speed: Annotated[MetrePerSecond, Field(gt=0.0)] | None = None
    """Of the piston, below which a switched rotation comes on; it goes off above 1.5 times as much."""
    start: Literal["turning", "standstill"] = "turning"
    """Whether the rod turns at t = 0."""
    friction: str = LUGRE.name
    """The true plant's law, one of `workbench list friction_laws`."""
    flow: Literal["derived", "chapter3"] = "derived"
    """Through the valve: as derived (thesis 3.22), or without the factor 1/2 under the root."""
    command: Literal["force", "voltage", "current"] = "force"
    """Of the model `drive`: what moves it."""
    start_position: Length = AxisNumber(0.0)
    """From mid-stroke, the origin of positions."""
    set: dict[str, Raw] = {}
    """Values in the place of the set's, of effects too; a plain name sets both directions of motion."""
    scale: dict[str, float] = {}
    """Factors on parameters, of both directions of motion."""
    spread: dict[str, float] = {}
    """How many standard deviations of the parameter file one deviation of a drawn parameter is."""

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
    """[belief]: what controllers believe; by default what the study declares of its plant, with LuGre's friction."""

    parameters: str | None = None
    """The set or file that is believed; by default the plant's as it is declared."""
    friction: str = LUGRE.name
    """The law that is believed; what it has no place for is believed to be 0."""
    flow: Literal["derived", "chapter3"] | None = None
    """The believed flow law; by default the plant's."""
    set: dict[str, Raw] = {}
    """Believed values in the place of the set's."""


class ChannelTable(Strict):
    """One sensor. Offset, gain and calibration act on the filtered and delayed value, before noise and converter."""

    noise: Raw = 0.0
    """Standard deviation of a sample."""
    resolution: Raw | None = None
    """The converter's step."""
    range: Raw | None = None
    """Of the converter, with `bits`."""
    bits: int | None = Field(None, ge=1, le=32)
    """Of the converter: its step is the range over 2 to this power."""
    anti_alias: Hertz = Field(0.0, ge=0.0)
    """Cutoff of a first-order filter before the converter; 0: none."""
    offset: Raw = 0.0
    """Added to what is measured."""
    gain_error: float = Field(0.0, gt=-1.0)
    """Relative: 0.01 shows 1 % too much."""
    calibration_error: Raw | None = None
    """Peak of a smooth error over the measured value."""
    calibration_travel: Raw | None = None
    """Range, centred at 0, over which that error is made."""
    calibration_seed: int = Field(1, ge=0)
    """Draws the curve of that error, so that repeats with other seeds share one sensor."""

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
    """Age of the positions and pressures that a controller sees; not of what the motor's drive reads."""
    position: ChannelTable = ChannelTable()
    """The position's sensor."""
    pressure_1: ChannelTable = ChannelTable()
    """The first chamber's."""
    pressure_2: ChannelTable = ChannelTable()
    """The second chamber's."""
    rotation_speed: ChannelTable = ChannelTable()
    """That of the speed of rotation."""
    motor_current: ChannelTable = ChannelTable()
    """That of the motor's current."""
    friction_gauge: bool = False
    """A hypothetical gauge of the true friction, for a controller of that type and no other."""


class SimulationTable(Strict):
    """[simulation]: how long, how exactly."""

    duration: Second = Field(gt=0.0)
    """Of every run."""
    transient: Second = Field(0.0, ge=0.0)
    """Left out of the figures."""
    sample_time: Second = Field(1e-3, gt=0.0)
    """Of controllers and sensors."""
    seed: int = Field(0, ge=0)
    """Of noise and draws; the same gives the same noise in every case."""
    method: str = Integrator().method
    """One of `workbench list integrators`."""
    step: Second = Field(1e-4, gt=0.0)
    """Of a method with a fixed step."""
    tolerance: float = Field(DEFAULT_TOLERANCE, ge=LEAST_TOLERANCE, le=1e-2)
    """Relative, of a method with error control."""
    hold_limit: Second = Field(120.0, ge=0.0)
    """How long the last dwell may be made where it is too short to tell a limit cycle; 0: never."""

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
    """A study file without the sections of other questions. What cases fill in is checked in each case, not here."""

    title: str
    """Of the study and its pages."""
    source: str = ""
    """Where the machine, or what is asked, comes from."""
    question: str = ""
    """What the study answers, in a sentence."""
    plant: dict[str, Any] = {}
    """The truth."""
    belief: dict[str, Any] = {}
    """What controllers believe."""
    sensors: dict[str, Any] = {}
    """What is measured, and how well."""
    simulation: dict[str, Any] = {}
    """How long, how exactly."""
    controllers: dict[str, dict[str, Any]] = {}
    """By name; the `type` and its settings are those of `workbench list controllers`."""
    references: dict[str, dict[str, Any]] = {}
    """By name; the kinds are those of `workbench list references`."""
    axes: dict[str, list[Any]] = {}
    """Lists of values; the study is their product, the last changing fastest."""
    machines: dict[str, dict[str, Any]] = {}
    """By name: laid over the study, before any scenario, so that controllers believe them."""
    scenarios: dict[str, dict[str, Any]] = {}
    """By name: laid over the truth alone."""
    cases: dict[str, dict[str, Any]] = {}
    """By name: parts of a study that differ in more than a value; each may have axes of its own."""
    probes: dict[str, Probe] = {}
    """By name: further columns of the results."""
    records: list[str] = []
    """Signals that every case writes into a file of its own, as a rig would."""
    tables: list[TableSpec] = Field([], max_length=MOST_TABLES)
    """Tables of the results."""
    figures: list[FigureSpec] = Field([], max_length=MOST_TABLES)
    """Figures of the results, or of signals."""
    uncertainty: UncertaintyTable | None = None
    """Machines that may be met."""

"""What may stand in an experiment file."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, StrictFloat, StrictInt, model_validator

from plants.axis import AXES
from plants.equation import NEGATIVE, ROTARY
from workbench.errors import nearest
from workbench.parameters.sets import known_units
from workbench.toml import reading as files
from workbench.toml.file_names import FileName

Raw = StrictFloat | str
"""A quantity whose unit depends on its place."""

CHANNELS: Mapping[str, str] = {
    "time": "s",
    "valve_voltage": "V",
    "position": "m",
    "pressure_1": "Pa",
    "pressure_2": "Pa",
    "supply_pressure": "Pa",
    "spool_position": "m",
    "motor_voltage": "V",
    "motor_current": "A",
    "rotation_speed": "rad/s",
    "rotation_angle": "rad",
    "pump_speed": "rad/s",
    "command": "1",
    "force": "N",
    "velocity": "m/s",
    "acceleration": "m/s^2",
}
"""Every channel that a record may have, with its SI unit along a straight axis."""

Method = Literal["thesis", "simulation", "both"]
"""How parameters are found."""

METHODS: tuple[Method, ...] = get_args(Method)

NUISANCES: Mapping[str, str] = {
    "pressure_1_offset": "Pa",
    "pressure_2_offset": "Pa",
    "pressure_1_gain": "1",
    "pressure_2_gain": "1",
    "position_calibration": "m",
}
"""Systematic errors of sensors that a fit by simulation may find beside the parameters; each with its unit."""


Direction = Literal["forward", "backward", "rotary"]
"""Of a contact's motion."""

SUFFIXES: Mapping[str, str] = {"forward": "", "backward": f"_{NEGATIVE}", "rotary": f"_{ROTARY}"}
"""What stands behind a friction parameter's name in each direction."""

FRICTION = ("coulomb", "stribeck", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
"""The parameters of friction."""

FLOWING = ("valve_flow_gain", "bulk_modulus", "sonic_conductance", "polytropic_exponent")
"""What two pressures tell of a valve, of oil or air."""

STATIC = "static"
"""Coulomb and Stribeck friction together: shown, never fitted."""

Published = Literal[
    "coulomb", "stribeck", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping"
]
"""What printed tables show, in their order."""

PUBLISHED: tuple[str, ...] = get_args(Published)


class PlantTable(files.Strict):
    """[plant]: what is believed."""

    model: str
    """A plant that `workbench list plants` shows."""
    parameters: str = ""
    """A named set, or a parameter file relative to the experiment."""
    turned: Literal["rod"] | None = None
    """That the rod turns."""
    bristle: Literal["helical", "isotropic", "anisotropic"] = "helical"
    """As in a study."""
    rotation: Literal["motor", "ideal"] = "motor"
    """Whether the recorded voltage turns the rod, or the recorded speed."""
    flow: Literal["derived", "chapter3"] = "derived"
    """As in a study."""
    set: dict[str, Raw] = {}
    """Values in the place of the set's; without `parameters` all of them."""
    scale: dict[str, float] = {}
    """Factors on parameters."""


class Bound(files.Strict):
    """Limits of a free parameter."""

    min: Raw | None = None
    """Smallest value."""
    max: Raw | None = None
    """Largest value."""


class FitTable(files.Strict):
    """[fit]: what is free, and how it is found."""

    free: list[str] | None = None
    """Names of what is fitted; by default friction, in the directions of the records."""
    method: Method | None = None
    """How `workbench identify` finds parameters; `--method` takes another. By default both ways, or by simulation
    alone where no channel shows friction."""
    bounds: dict[str, Bound] = {}
    """By parameter; they may also stand right in [fit], under the parameter's name."""

    @model_validator(mode="before")
    @classmethod
    def _bounds_by_name(cls, data: object) -> object:
        if not isinstance(data, dict):
            return data
        names = {name for axis in AXES for name in known_units(axis)}
        named = {key: value for key, value in data.items() if isinstance(value, dict) and key in names}
        rest = {key: value for key, value in data.items() if key not in named}
        return {**rest, "bounds": {**rest.get("bounds", {}), **named}} if named else rest


class ChannelTable(files.Strict):
    """One channel: its column, unit, and for raw counts value = scale * number + offset, in that unit."""

    column: str | Annotated[StrictInt, Field(ge=0)]
    """Its name, or its number from 0 where the file has no header."""
    unit: str = "1"
    """Of the column."""
    scale: float = 1.0
    """Factor on raw counts: scale * number + offset, in the unit."""
    offset: Raw = 0.0
    """A number in the unit, or a quantity."""
    anti_alias: Raw = 0.0
    """Cutoff (Hz) of a first-order filter before the converter, which the simulated reading passes too; 0: none."""


class RecordTable(files.Strict):
    """[[records]]: one record, or several of the same kind."""

    file: str = ""
    """Relative to the experiment; a pattern such as `run_*.csv` stands for several."""
    files: dict[str, str] = {}
    """In its place: by channel, one file each, with a column of the time."""
    use: Literal["fit", "held_out"] = "fit"
    """Whether it is fitted to, or tests what was found."""
    label: str = ""
    """What it is called; by default the file's name."""
    skip: Annotated[StrictInt, Field(ge=0)] = 0
    """Rows left out at the start."""
    rows: Annotated[StrictInt, Field(gt=0)] | None = None
    """Rows taken; by default all."""
    sample_time: Raw | None = None
    """Of an even grid on which unevenly sampled channels are put, by a curve through their samples."""
    rpm: Annotated[StrictFloat, Field(ge=0.0)] | str = 0.0
    """The speed of rotation that was set, or the column that holds it."""

    @model_validator(mode="after")
    def _one_or_many(self) -> "RecordTable":
        if bool(self.file) == bool(self.files):
            raise ValueError("expected either file, or files: one for each channel")
        return self


class TruthTable(files.Strict):
    """[truth]: what is behind simulated records, against which an error is told."""

    parameters: str
    """The set or file behind simulated records."""
    sensors: dict[str, Raw] = {}
    """The true errors of its sensors."""


Printed = Annotated[float, Field(allow_inf_nan=True)]
"""A printed number; nan where none is printed."""


class PublishedTable(files.Strict):
    """[[published]]: a printed table beside which the thesis's method is to be shown.

    `static` is Coulomb and Stribeck friction together.
    """

    table: FileName
    """Name of its files."""
    title: str
    """Above it."""
    source: str = ""
    """Where it is printed."""
    note: str = ""
    """Below it."""
    direction: Direction
    """Of the motion."""
    rpm: list[float] = [0.0]
    """Speeds of rotation, one a column."""
    values: dict[str, list[Printed]]
    """By parameter: one SI number a speed, nan where none is printed."""
    std: dict[str, list[Printed]] = {}
    """The same of standard deviations."""

    @model_validator(mode="after")
    def _one_value_a_speed(self) -> "PublishedTable":
        for name, numbers in [*self.values.items(), *self.std.items()]:
            if name not in PUBLISHED:
                raise ValueError(f'unknown parameter "{name}"; {nearest(name, PUBLISHED)}')
            if len(numbers) != len(self.rpm):
                raise ValueError(f"{name} has {len(numbers)} values, expected {len(self.rpm)}: one for each rpm")
        return self


class FigureTable(files.Strict):
    """[[figures]]: friction over velocity, or how a parameter depends on rpm."""

    name: FileName
    """Of its files."""
    title: str
    """Above it."""
    rpm: float = 0.0
    """Friction over velocity at this speed."""
    parameter: Literal[""] | Published = ""
    """In place of that: how this one depends on the speed."""


class ExperimentFile(files.Strict):
    """A whole experiment file; `design` is checked where a motion is designed."""

    title: str
    """Of the experiment and its pages."""
    source: str = ""
    """Where the records come from."""
    plant: PlantTable
    """What is believed to have made the records."""
    fit: FitTable = Field(default_factory=FitTable)
    """What is free."""
    channels: dict[str, ChannelTable]
    """By name: time, valve_voltage, position, pressure_1, ..."""
    sensors: dict[str, Raw] = {}
    """Standard deviations of systematic errors that the fit may find.

    They are `pressure_1_offset`, `pressure_1_gain` and those of `_2`, `position_calibration`.
    """
    records: list[RecordTable] = Field(min_length=1)
    """The files."""
    truth: TruthTable | None = None
    """Of simulated records."""
    published: list[PublishedTable] = []
    """Printed tables to stand beside what is found."""
    figures: list[FigureTable] = []
    """Beside those that are always drawn."""
    design: dict[str, Any] = {}
    """What a motion is designed for: docs/design.md."""

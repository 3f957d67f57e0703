"""What may stand in an experiment file."""

from collections.abc import Mapping
from typing import Annotated, Literal, get_args

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

STATIC = "static"
"""Coulomb and Stribeck friction together: shown, never fitted."""

Published = Literal[
    "coulomb", "stribeck", "static", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping"
]
"""What printed tables show, in their order."""

PUBLISHED: tuple[str, ...] = get_args(Published)


class PlantTable(files.Strict):
    """[plant]: what is believed. `scale` multiplies parameters, as in a study; `set` has all without `parameters`.

    With `turned` the rod turns, by a motor or (`rotation` "ideal") with the speed that was recorded.
    """

    model: str
    parameters: str = ""
    turned: Literal["rod"] | None = None
    bristle: Literal["helical", "isotropic", "anisotropic"] = "helical"
    rotation: Literal["motor", "ideal"] = "motor"
    flow: Literal["derived", "chapter3"] = "derived"
    set: dict[str, Raw] = {}
    scale: dict[str, float] = {}


class Bound(files.Strict):
    """Limits of a free parameter."""

    min: Raw | None = None
    max: Raw | None = None


class FitTable(files.Strict):
    """[fit]: what is free, and how it is found. `bounds` takes what stands under a parameter's own name."""

    free: list[str] | None = None
    method: Method = "both"
    bounds: dict[str, Bound] = {}

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
    """One channel: its column, unit, and for raw counts value = scale * number + offset, in that unit.

    `column` is a name, or a number from 0, as a file without a header needs it. `offset` may be a quantity with a unit
    of its own. `anti_alias` (Hz) is the cutoff of a
    first-order filter before the converter: the simulated reading passes it too.
    """

    column: str | Annotated[StrictInt, Field(ge=0)]
    unit: str = "1"
    scale: float = 1.0
    offset: Raw = 0.0
    anti_alias: Raw = 0.0


class RecordTable(files.Strict):
    """One record, or several of the same kind where `file` is a pattern such as "run_*.csv".

    `files` are in the place of `file` where every channel has a file of its own, with a column of the time in each.

    Of each file `skip` rows at its start are left out, and `rows` taken (default: all). `sample_time` puts unevenly
    sampled channels on an even grid of that step, by a curve through their samples. `rpm` is the speed of rotation that
    was set, or the name of the column that holds it.
    """

    file: str = ""
    files: dict[str, str] = {}
    use: Literal["fit", "held_out"] = "fit"
    label: str = ""
    skip: Annotated[StrictInt, Field(ge=0)] = 0
    rows: Annotated[StrictInt, Field(gt=0)] | None = None
    sample_time: Raw | None = None
    rpm: Annotated[StrictFloat, Field(ge=0.0)] | str = 0.0

    @model_validator(mode="after")
    def _one_or_many(self) -> "RecordTable":
        if bool(self.file) == bool(self.files):
            raise ValueError("expected either file, or files: one for each channel")
        return self


class TruthTable(files.Strict):
    """[truth]: what is behind simulated records, against which an error is told: parameters, and `sensors`' errors."""

    parameters: str
    sensors: dict[str, Raw] = {}


Printed = Annotated[float, Field(allow_inf_nan=True)]
"""A printed number; nan where none is printed."""


class PublishedTable(files.Strict):
    """[[published]]: a printed table beside which the thesis's method is to be shown.

    One entry a speed of rotation in `rpm` for every parameter in `values`, and in `std`; SI, nan where nothing is
    printed. `static` is Coulomb and Stribeck friction together.
    """

    table: FileName
    title: str
    source: str = ""
    note: str = ""
    direction: Direction
    rpm: list[float] = [0.0]
    values: dict[str, list[Printed]]
    std: dict[str, list[Printed]] = {}

    @model_validator(mode="after")
    def _one_value_a_speed(self) -> "PublishedTable":
        for name, numbers in [*self.values.items(), *self.std.items()]:
            if name not in PUBLISHED:
                raise ValueError(f'unknown parameter "{name}"; {nearest(name, PUBLISHED)}')
            if len(numbers) != len(self.rpm):
                raise ValueError(f"{name} has {len(numbers)} values, expected {len(self.rpm)}: one for each rpm")
        return self


class FigureTable(files.Strict):
    """[[figures]]: friction over velocity at `rpm`, or how a `parameter` depends on rpm."""

    name: FileName
    title: str
    rpm: float = 0.0
    parameter: Literal[""] | Published = ""


class ExperimentFile(files.Strict):
    """A whole experiment file."""

    title: str
    source: str = ""
    plant: PlantTable
    fit: FitTable = Field(default_factory=FitTable)
    channels: dict[str, ChannelTable]
    sensors: dict[str, Raw] = {}
    records: list[RecordTable] = Field(min_length=1)
    truth: TruthTable | None = None
    published: list[PublishedTable] = []
    figures: list[FigureTable] = []

"""Experiment files: the plant that is believed, the channels of the records, the records, and what is to be fitted."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from glob import glob
from pathlib import Path
from typing import NamedTuple

from plants.axis import unit_along
from plants.effects.attach import meant
from plants.effects.curves import acting
from plants.equation import NEGATIVE, fields, to_array
from plants.interface import Plant
from plants.registry import PLANTS
from workbench.errors import UserError, nearest, spelled
from workbench.parameters.sets import (
    FLOW_SHARE,
    NEUTRAL,
    build,
    known_units,
    nearby,
    parameter_path,
    parameter_value,
    plain_name,
    read_deviations,
    read_parameters,
)
from workbench.records.channels import ChannelSpec, channels_of, quantity
from workbench.records.schema import (
    NUISANCES,
    Bound,
    ExperimentFile,
    FigureTable,
    PlantTable,
    PublishedTable,
    Raw,
    RecordTable,
)
from workbench.toml import reading as files
from workbench.toml.units import QuantityError, si


@dataclass(frozen=True)
class RecordSpec:
    """One file of a record; `rpm` is a number, or the column that holds it. `places` is the file of each channel: this
    one, where not every channel has its own.

    `skip` rows are left out and `rows` taken (None: all); `sample_time` (s) of the grid that uneven samples are put on.
    """

    path: Path
    use: str
    label: str
    rpm: float | str
    skip: int = 0
    rows: int | None = None
    sample_time: float | None = None
    places: Mapping[str, Path] = field(default_factory=dict)

    @property
    def end(self) -> float:
        """The row before which it ends; infinite where it takes all."""
        return float("inf") if self.rows is None else self.skip + self.rows

    @property
    def is_there(self) -> bool:
        """Whether all its files are."""
        return all(path.exists() for path in (self.path, *self.places.values()))


@dataclass(frozen=True)
class Experiment:
    """An experiment file, checked and in SI; the records are not read yet.

    `values` are the declared parameters by canonical name: where a parameter's two directions have one value there is
    no `_negative` name. The plant has those effects of which a parameter is not neutral, or is named in [fit]. `free`
    is None where the file says nothing. `deviations` are the standard deviations of declared values, of those that have
    one. `accuracies` are the standard deviations of the sensors' systematic errors (`NUISANCES`) that a fit may find.
    `design` is the table of that name as it was written. `said` are parameters whose value the file itself says.
    """

    path: Path
    title: str
    source: str
    plant: Plant
    flow: str
    declared: str
    values: Mapping[str, float]
    free: tuple[str, ...] | None
    bounds: Mapping[str, tuple[float, float]]
    method: str | None
    channels: Mapping[str, ChannelSpec]
    accuracies: Mapping[str, float]
    records: tuple[RecordSpec, ...]
    truth: Mapping[str, float] | None
    published: tuple[PublishedTable, ...] = ()
    figures: tuple[FigureTable, ...] = ()
    true_sensors: Mapping[str, float] = field(default_factory=dict)
    deviations: Mapping[str, float] = field(default_factory=dict)
    design: Mapping[str, object] = field(default_factory=dict)
    said: frozenset[str] = frozenset()

    def source_of(self, name: str) -> str:
        """Where a declared value is from, in words."""
        here = name in self.said or plain_name(name) in self.said
        return f"as declared: {self.path.name if here else self.declared}"

    def parameters(self, changes: Mapping[str, float] | None = None) -> NamedTuple:
        """The plant's parameters, declared or with `changes` by canonical name.

        Raises:
            UserError: the values do not serve the plant.
        """
        return build(self.plant.Parameters, {**self.values, **(changes or {})}, self.flow)

    @property
    def freed(self) -> str:
        """What a fit is free to change, in words."""
        if self.free is not None:
            return ", ".join(self.free) or "nothing"
        return f"{', '.join(self.plant.unknown) or 'friction'} in the directions of the records"

    def known_values(self) -> dict[str, float]:
        """Every parameter of the declared plant by canonical name, and those declared that the plant lacks."""
        names = [item.name for item in fields(self.plant.Parameters)]
        return {**self.values, **dict(zip(names, to_array(self.parameters()).tolist(), strict=True))}


OF_STUDIES = {"cases", "axes", "controllers", "references", "simulation"}
"""Tables of studies that no experiment has."""


def is_experiment(data: Mapping[str, object]) -> bool:
    """Whether the content of a TOML file is that of an experiment."""
    records = data.get("records")
    return "channels" in data or (isinstance(records, list) and any(isinstance(item, dict) for item in records))


def read_experiment(path: Path) -> Experiment:
    """Read and check an experiment file, to the last name and unit.

    Raises:
        UserError: the first mistake, with file, line and key.
    """
    data, text = files.read_toml(path)
    if not is_experiment(data) and data.keys() & OF_STUDIES:
        raise UserError(f"{path}: this is a study, not an experiment; workbench run {path}, or wb.Study, runs it")
    content = files.validate(ExperimentFile, data, path, text)
    try:
        return _resolved(content, path)
    except files.SchemaError as mistake:
        raise files.at(path, text, mistake.key, mistake.message) from None


def _resolved(content: ExperimentFile, path: Path) -> Experiment:
    bare = _plant(content.plant)
    values = _declared(content.plant, path.parent, bare.axis)
    felt = [name for name, value in acting(values).items() if value != NEUTRAL.get(name)]
    plant = bare.with_effects(*meant(bare, [*felt, *(content.fit.free or ()), *content.fit.bounds]))
    try:
        build(plant.Parameters, values, content.plant.flow)
    except UserError as error:
        raise files.SchemaError(("plant", "parameters"), f"does not serve {plant.name}: {error}") from None
    truth = None
    if content.truth is not None:
        truth = _set_values(content.truth.parameters, path.parent, ("truth", "parameters"), plant.axis)
    names, channels = parameter_names(plant), channels_of(content.channels, plant)
    return Experiment(
        path,
        content.title,
        content.source,
        plant,
        content.plant.flow,
        content.plant.parameters or "[plant.set]",
        values,
        None if content.fit.free is None else _free(content.fit.free, [*names, *values], values),
        _bounds(content.fit.bounds, names, values, known_units(plant.axis)),
        content.fit.method,
        channels,
        _accuracies(content.sensors, plant.axis),
        _records(content.records, path.parent, channels),
        truth,
        tuple(content.published),
        tuple(content.figures),
        {} if content.truth is None else _sensors(content.truth.sensors, ("truth", "sensors"), plant.axis),
        _deviations(content.plant, path.parent, bare.axis, values),
        content.design,
        frozenset({*content.plant.set, *content.plant.scale}),
    )


def parameter_names(plant: Plant) -> list[str]:
    """Canonical names of the plant's parameters, `_negative` ones included."""
    return [item.name for item in fields(plant.Parameters) if item.name != FLOW_SHARE]


def _plant(table: PlantTable) -> Plant:
    known = PLANTS.working()
    if table.model not in known:
        raise files.SchemaError(("plant", "model"), f'unknown plant "{table.model}"; {nearest(table.model, known)}')
    plant = known[table.model]
    if table.turned is None:
        return plant
    try:
        return plant.with_turning_rod(table.bristle, imposed=table.rotation == "ideal")
    except ValueError as error:
        raise files.SchemaError(("plant", "turned"), str(error)) from None


def _set_values(name: str, folder: Path, key: files.Key, axis: str) -> dict[str, float]:
    try:
        return dict(read_parameters(parameter_path(name, folder), axis))
    except UserError as error:
        raise files.SchemaError(key, str(error)) from None


def _declared(table: PlantTable, folder: Path, axis: str) -> dict[str, float]:
    """The declared values; a plain name in [plant.set] sets both directions, unless the other is set too."""
    values = _set_values(table.parameters, folder, ("plant", "parameters"), axis) if table.parameters else {}
    for name, value in table.set.items():
        try:
            number = parameter_value(name, value, axis)
        except (UserError, QuantityError) as error:
            raise files.SchemaError(("plant", "set", name), str(error)) from None
        values[name] = number
        if (other := f"{name}_{NEGATIVE}") not in table.set:
            values.pop(other, None)
    for name, ratio in table.scale.items():
        if name not in values:
            raise files.SchemaError(("plant", "scale", name), f"unknown parameter; {nearby(name, values)}")
        values |= {each: values[each] * ratio for each in (name, f"{name}_{NEGATIVE}") if each in values}
    return values


def _deviations(table: PlantTable, folder: Path, axis: str, values: Mapping[str, float]) -> dict[str, float]:
    """Standard deviations of the declared values: those of the set; none of what [plant.set] says."""
    if not table.parameters:
        return {}
    found = dict(read_deviations(parameter_path(table.parameters, folder), axis))
    for name, ratio in table.scale.items():
        found |= {each: found[each] * ratio for each in (name, f"{name}_{NEGATIVE}") if each in found}
    known = {name: std for name, std in found.items() if name in values and std > 0.0}
    return {name: std for name, std in known.items() if not {name, plain_name(name)} & table.set.keys()}


def _free(free: list[str], names: list[str], values: Mapping[str, float]) -> tuple[str, ...]:
    """The free parameters; a plain name frees each direction that has a value of its own."""
    found: dict[str, None] = {}
    for i, name in enumerate(free):
        if name not in names:
            raise files.SchemaError(("fit", "free", i), f'unknown parameter "{name}"; {nearby(name, names)}')
        found[name] = None
        if f"{name}_{NEGATIVE}" in values:
            found[f"{name}_{NEGATIVE}"] = None
    return tuple(found)


def _bounds(
    table: Mapping[str, Bound], names: list[str], values: Mapping[str, float], units: Mapping[str, str]
) -> dict[str, tuple[float, float]]:
    bounds = {}
    for name, bound in table.items():
        if name not in names:
            raise files.SchemaError(("fit", name), f"unknown parameter; {nearby(name, names)}")
        limits = []
        for key, value, default in (("min", bound.min, -float("inf")), ("max", bound.max, float("inf"))):
            try:
                limits.append(default if value is None else si(value, units[name]))
            except QuantityError as error:
                raise files.SchemaError(("fit", name, key), str(error)) from None
        if limits[0] >= limits[1]:
            raise files.SchemaError(("fit", name), "expected a min below max")
        declared = values.get(name, values.get(plain_name(name)))
        if declared is not None and not limits[0] <= declared <= limits[1]:
            got = f"the declared value {declared:.6g} {units[name]} is outside these bounds"
            raise files.SchemaError(("fit", name), f"{got}; widen them, or start from another value with [plant.set]")
        bounds[name] = (limits[0], limits[1])
    return bounds


def _accuracies(table: Mapping[str, Raw], axis: str) -> dict[str, float]:
    found = _sensors(table, ("sensors",), axis)
    for name, number in found.items():
        if number < 0.0:
            raise files.SchemaError(
                ("sensors", name), f"got {spelled(table[name])}, expected a value that is not negative"
            )
    return found


def _sensors(table: Mapping[str, Raw], place: files.Key, axis: str) -> dict[str, float]:
    """Errors of sensors (SI) by name."""
    found = {}
    for name, value in table.items():
        if name not in NUISANCES:
            raise files.SchemaError((*place, name), f"unknown key; {nearest(name, NUISANCES)}")
        found[name] = quantity(value, unit_along(NUISANCES[name], axis), (*place, name))
    return found


def _records(tables: list[RecordTable], folder: Path, channels: Mapping[str, ChannelSpec]) -> tuple[RecordSpec, ...]:
    specs: list[RecordSpec] = []
    for i, table in enumerate(tables):
        step = None if table.sample_time is None else quantity(table.sample_time, "s", ("records", i, "sample_time"))
        if step is not None and step <= 0.0:
            raise files.SchemaError(("records", i, "sample_time"), f"got {step:g} s, expected a time above 0")
        if table.files:
            places = _places(table.files, folder, channels, ("records", i, "files"))
            found = [(next(iter(places.values())), places)]
        else:
            pattern = any(mark in table.file for mark in "*?[")
            paths = sorted(map(Path, glob(str(folder / table.file)))) if pattern else [folder / table.file]
            # A pattern without a file stays: whoever reads the records says that there is none.
            found = [(path, dict.fromkeys(channels, path)) for path in paths or [folder / table.file]]
        for path, places in found:
            label = table.label or path.stem
            spec = RecordSpec(path, table.use, label, table.rpm, table.skip, table.rows, step, places)
            _check_apart(spec, specs, ("records", i, "files" if table.files else "file"))
            specs.append(spec)
    return tuple(specs)


def _check_apart(spec: RecordSpec, before: Sequence[RecordSpec], key: files.Key) -> None:
    """A record has rows of its own: what is fitted twice counts twice, and what is fitted and held out tests nothing.

    Raises:
        SchemaError: it shares rows with one that came before.
    """
    for other in before:
        if other.places == spec.places and other.skip < spec.end and spec.skip < other.end:
            uses = "both times" if other.use == spec.use else "once for the fit and once held out"
            message = f"rows of {spec.path} are used already, {uses}; take others with skip and rows, or another file"
            raise files.SchemaError(key, message)


def _places(
    table: Mapping[str, str], folder: Path, channels: Mapping[str, ChannelSpec], key: files.Key
) -> dict[str, Path]:
    """The file of each channel but the time, which is in all."""
    names = {channel.called: name for name, channel in channels.items() if name != "time"}
    for called in table:
        if called not in names:
            raise files.SchemaError((*key, called), f"no channel of [channels]; {nearest(called, names)}")
    if lacking := [called for called in names if called not in table]:
        raise files.SchemaError(key, f"no file for {' and '.join(lacking)}; name one, or leave the channel out")
    return {names[called]: folder / file for called, file in table.items()}

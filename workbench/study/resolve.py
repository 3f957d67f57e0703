"""From the tables of a case to everything that a run depends on: plant, belief, controllers, reference, sensors."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from controllers import rotation_on_demand, speed_servo
from controllers.interface import Controller
from controllers.open_loop import OPEN_LOOP
from controllers.registry import CONTROLLERS
from controllers.rotation_on_demand import SCHEDULED_ROTATION, SWITCHED_ROTATION
from controllers.settings import ANY, Setting, settings_of, usable
from plants.equation import fields
from plants.friction_gauge import gauged
from plants.interface import Plant
from plants.motor import current_limit
from plants.plugins import Registry
from plants.registry import PLANTS
from workbench.errors import UserError, nearest
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.simulate import Feed, Integrator, Loop, Setup
from workbench.study.believed import designing
from workbench.study.parameter_tables import build_belief, build_truth
from workbench.study.reference_tables import KINDS
from workbench.study.schema import CaseTables
from workbench.study.sensor_tables import build_sensors
from workbench.study.study import Case, Study, located
from workbench.toml import reading as files
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError, si

T = TypeVar("T")

MODELS = ("by_rpm", "non_rotating", "rotating", "drive")
"""Models of [plant] that stand for several plants; any registered plant's own name serves too."""

ROTATED_BY = {
    "servo": ("motor_voltage",),
    "voltage": ("motor_voltage",),
    "scheduled": tuple(SCHEDULED_ROTATION),
    "switched": tuple(SWITCHED_ROTATION),
    "ideal": ("surface_speed",),
}
"""The input of the plant that each kind of rotation drives."""

SIGMAS = 3.0
"""The noise band of the limit-cycle judge, in standard deviations of the position noise."""


@dataclass(frozen=True)
class Resolved:
    """A case ready to run. `band` (m) is what the sensors cannot tell from rest; `settings` are the controller's, and
    `belief` is what it believes of the plant. `hold_limit` (s) is how long its last dwell may be made.
    """

    setup: Setup
    transient: float
    band: float
    settings: Any = None
    belief: Any = None
    hold_limit: float = 0.0

    @property
    def signal(self) -> ReferenceSignal | None:
        """What drives the run: its reference, or in open loop what is fed to an input."""
        return self.setup.reference or next((feed.signal for feed in self.setup.feeds), None)


def resolve(study: Study, case: Case) -> Resolved:
    """Build what a case runs.

    Raises:
        UserError: whatever is wrong, with file, line and key.
    """
    try:
        return _resolve(files.conform(CaseTables, case.tables), case)
    except SchemaError as mistake:
        errors = [located(study, case, each.key, each.message) for each in (mistake, *mistake.others)]
        raise files.lines_of(errors) from None


def _resolve(tables: CaseTables, case: Case) -> Resolved:
    plant = _plant(tables)
    parameters = build_truth(plant, tables, case.folder)
    belief = build_belief(plant, tables, case)
    turning = 0.0 if tables.plant.start == "standstill" else _rotation(plant, parameters, tables)[1]
    state, _ = plant.equilibrium(parameters, turning)
    state = state._replace(position=tables.plant.start_position)  # all else that the machine is given is believed
    state = _within_limits(state, parameters)
    rotation_speed, surface_speed = _rotation(plant, belief, tables)
    rotary, inputs = _rotary(plant, belief, rotation_speed, surface_speed, tables)
    loop, settings, reference, feeds = _position_loop(plant, belief, tables, case.folder)
    plant = _gauged(plant, loop.controller, tables)
    sensors = build_sensors(tables.sensors)
    position = sensors.channels["position"]
    simulation = tables.simulation
    setup = Setup(
        plant,
        parameters,
        state,
        inputs,
        simulation.duration,
        loop,
        reference,
        rotary,
        rotation_speed,
        feeds,
        sensors,
        Integrator(simulation.method, simulation.step, simulation.tolerance),
        simulation.sample_time,
        simulation.seed,
    )
    band = max(SIGMAS * position.noise, position.resolution)
    return Resolved(setup, simulation.transient, band, settings, belief, simulation.hold_limit)


def _within_limits(state: Any, parameters: Any) -> Any:
    """The state with no more current than the motor's limit: a rod that takes more to turn will slow down."""
    if "motor_current" not in state._fields:
        return state
    limit = float(current_limit(parameters.motor))
    return state._replace(motor_current=min(max(state.motor_current, -limit), limit))


def _gauged(plant: Plant, controller: Controller, tables: CaseTables) -> Plant:
    """The plant with the hypothetical friction gauge for the controller that is made for it, else as it is.

    So every other controller gets NaN in its place, whatever [sensors] says.
    """
    if not controller.gauge:
        return plant
    if not tables.sensors.friction_gauge:
        raise SchemaError(
            ("sensors", "friction_gauge"),
            f'is missing: controller type "{controller.name}" needs a gauge of the true friction, which no rig has; '
            "write friction_gauge = true to say so, or take another type",
        )
    try:
        return gauged(plant)
    except ValueError as error:
        raise SchemaError(("sensors", "friction_gauge"), str(error)) from None


def _rotation(plant: Plant, parameters: Any, tables: CaseTables) -> tuple[float, float]:
    """The wanted speed of rotation (rad/s) and of the piston's surface (m/s); of a schedule, those at rest."""
    if not plant.rotary_command:
        return tables.rpm, 0.0
    with designing("rotation", plant, parameters, ("rpm",)):
        radius, minimum = parameters.motor.piston_radius, tables.plant.minimum_helical_speed
    return (tables.rpm, tables.rpm * radius) if minimum is None else (minimum / radius, minimum)


def _rotary(
    plant: Plant, belief: Any, rotation_speed: float, surface_speed: float, tables: CaseTables
) -> tuple[Loop | None, Any]:
    """What controls the rotation, if anything does, and the inputs, as believed, without what it then gives."""
    rotation, command = tables.plant.rotation, plant.rotary_command
    believed, inputs = plant.equilibrium(belief, surface_speed)
    if not command or (command == "surface_speed" and "rotation" not in tables.plant.model_fields_set):
        return None, inputs
    if command not in ROTATED_BY[rotation]:
        raise SchemaError(
            ("plant", "rotation"),
            f'"{rotation}" drives {" or ".join(ROTATED_BY[rotation])}, and {plant.name} is rotated by its {command}; '
            "expected another rotation, or another model",
        )
    if rotation in ("ideal", "voltage"):
        return None, inputs
    current = getattr(believed, "motor_current", 0.0)
    settings: Any
    if rotation == "servo":
        controller, settings = speed_servo.SPEED_SERVO, speed_servo.Settings(rotation_speed, current)
    elif tables.plant.switch_speed is not None:  # it belongs to "switched"
        controller = SWITCHED_ROTATION[command]
        settings = rotation_on_demand.Settings(rotation_speed, current, switch_speed=tables.plant.switch_speed)
    else:
        controller, settings = SCHEDULED_ROTATION[command], rotation_on_demand.Settings(rotation_speed, current)
    with designing(f'"{rotation}"', plant, belief, ("plant", "rotation")):
        gains = controller.design(settings, belief, tables.simulation.sample_time)
    return Loop(controller, gains), inputs._replace(**{command: 0.0})


def _registered(registry: Registry[T], name: str, key: files.Key, shorthands: tuple[str, ...] = ()) -> T:
    """The plant or controller of that name."""
    known, broken = registry.working(), registry.broken()
    if name in known:
        return known[name]
    if name in broken:
        raise SchemaError(key, broken[name])
    hint = nearest(name, dict.fromkeys((*shorthands, *known)))
    raise SchemaError(key, f'unknown {registry.kind.__name__.lower()} "{name}"; {hint}')


def _plant(tables: CaseTables) -> Plant:
    table, rpm = tables.plant, tables.rpm
    model = table.model
    if model == "by_rpm":
        model = "rotating" if rpm else "non_rotating"
    if model == "rotating":
        model = f"rotating_{table.bristle}{'_ideal' if table.rotation == 'ideal' else ''}"
    elif model == "drive":
        model = f"drive_{table.command}"
    plant = _registered(PLANTS, model, ("plant", "model"), MODELS)
    if rpm and not plant.rotary_command:
        raise SchemaError(("rpm",), f'plant "{model}" does not rotate: expected rpm 0 (or model = "by_rpm")')
    return plant


def _chosen(kind: str, name: str | None, available: dict[str, Any]) -> str | None:
    """The name that an axis gives, or that of the only one there is."""
    if name is None and len(available) > 1:
        *others, last = available
        message = f'there is "{others[0]}" too: expected an axis {kind} that says which'
        raise SchemaError((f"{kind}s", last), message)
    return name or next(iter(available), None)


def _position_loop(
    plant: Plant, belief: Any, tables: CaseTables, folder: Path
) -> tuple[Loop, Any, ReferenceSignal | None, tuple[Feed, ...]]:
    """The controller with its gains, its settings, its reference (None in open loop), and what is fed to inputs."""
    name = _chosen("controller", tables.controller, tables.controllers)
    if name is None:
        raise SchemaError(("controllers",), "is missing: expected a table such as [controllers.p]")
    controller, settings = _controller(name, tables, plant.command_unit)
    key = ("controllers", name)
    with designing(f'type "{tables.controllers[name]["type"]}"', plant, belief, key):
        if controller.choose is not None:
            controller = controller.choose(settings, belief)
        gains = controller.design(settings, belief, tables.simulation.sample_time)
    unit, target = "m", ""
    if controller is OPEN_LOOP:
        target = settings.input or plant.command
        units = {item.name: item.unit for item in fields(plant.Inputs)}
        if target not in units:
            raise SchemaError((*key, "input"), f'plant {plant.name} has no input "{target}"; {nearest(target, units)}')
        unit = units[target]
    reference_name = _chosen("reference", tables.reference, tables.references)
    if reference_name is None:
        return Loop(controller, gains), settings, None, ()
    signal = _reference(reference_name, tables.references[reference_name], unit, folder)
    if target:
        return Loop(controller, gains), settings, None, (Feed(target, signal, settings.hold == "linear"),)
    return Loop(controller, gains), settings, signal, ()


def _controller(name: str, tables: CaseTables, command_unit: str) -> tuple[Controller, Any]:
    key = ("controllers", name)
    table = dict(tables.controllers[name])
    if "type" not in table:
        hint = nearest("", CONTROLLERS.working())
        raise SchemaError((*key, "type"), f"is missing; this key is needed here; {hint}")
    controller = _registered(CONTROLLERS, str(table.pop("type")), (*key, "type"))
    declared, offered = settings_of(controller.Settings), usable(controller)
    mistakes = [
        SchemaError((*key, item), f"unknown key; {nearest(item, [*offered, 'type'])}")
        for item in table
        if item not in declared
    ]
    mistakes += [
        SchemaError((*key, item.name), "is missing; this key is needed here")
        for item in declared.values()
        if item.name not in table and item.default is None
    ]
    if mistakes:
        raise files.together(mistakes)
    values: dict[str, Any] = {}
    for item, value in table.items():
        try:
            values[item] = _setting_value(declared[item], value, command_unit)
        except QuantityError as error:
            raise SchemaError((*key, item), str(error)) from None
    settings: Any = controller.Settings
    return controller, settings(**values)


def _setting_value(item: Setting, value: Any, command_unit: str) -> float | str:
    """A setting's value in SI, or its choice.

    Raises:
        QuantityError: the wrong unit, out of its range, or no such choice.
    """
    if item.unit:
        number = si(value, item.unit, command_unit)
        if not item.about.admits(number):
            raise QuantityError(f"got {json.dumps(value)}, expected {item.about.expected}")
        return number
    if not isinstance(value, str) or (item.choices != (ANY,) and value not in item.choices):
        expected = "a name" if item.choices == (ANY,) else f"one of {', '.join(item.choices)}"
        raise QuantityError(f"got {value!r}, expected {expected}")
    return value


def _reference(name: str, table: dict[str, Any], unit: str, folder: Path) -> ReferenceSignal:
    key = ("references", name)
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        message = "is missing; this key is needed here" if kind is None else f'unknown kind "{kind}"'
        raise SchemaError((*key, "kind"), f"{message}; {nearest(str(kind), KINDS)}")
    try:
        return files.conform(KINDS[kind], table).build(unit, folder)
    except SchemaError as error:
        raise files.together(
            [SchemaError((*key, *each.key), each.message) for each in (error, *error.others)]
        ) from None
    except UserError as error:
        raise SchemaError(key, str(error)) from None

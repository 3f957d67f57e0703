"""From the tables of a case to everything that a run depends on: plant, belief, controllers, reference, sensors."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from controllers import rotation_on_demand, speed_servo
from controllers.interface import Controller
from controllers.rotation_on_demand import SCHEDULED_ROTATION, SWITCHED_ROTATION
from plants.effects.attach import meant
from plants.effects.curves import acting
from plants.friction_gauge import gauged
from plants.interface import Plant
from plants.laws.registry import LAWS
from plants.motor import current_limit
from plants.registry import PLANTS
from workbench.errors import UserError
from workbench.parameters.sets import NEUTRAL
from workbench.simulation.integrators.registry import INTEGRATORS
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.setup import Feed, Integrator, Loop, Setup
from workbench.study.believed import designing
from workbench.study.controller_tables import ControllerCase, parse_controller
from workbench.study.fmu_plant import ForeignPlant, check_sees, foreign_plant
from workbench.study.models import MODELS
from workbench.study.overrides import Overrides, overridden
from workbench.study.parameter_tables import ParameterValues, build_belief, build_truth, read_values
from workbench.study.registered import registered
from workbench.study.schema import CaseTables
from workbench.study.sensor_tables import build_sensors
from workbench.study.study import Case, Study, located
from workbench.toml import reading as files
from workbench.toml.quantities import along_axis
from workbench.toml.reading import SchemaError

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


@dataclass(frozen=True, eq=False)
class ParsedCase:
    """A case whose tables are read: what is left to do is to build it, with these overrides or with others.

    `axis` is the unit of its plant's positions, "m" or "rad".
    """

    study: Study
    case: Case
    tables: CaseTables
    values: ParameterValues
    controller: ControllerCase
    axis: str

    def resolve(self, overrides: Overrides | None = None) -> Resolved:
        """What the case runs with `overrides`, by default its own.

        Raises:
            UserError: whatever does not serve the plant, with file, line and key.
        """
        try:
            return _resolve(self, self.case.overrides if overrides is None else overrides)
        except SchemaError as mistake:
            raise _located(self.study, self.case, mistake) from None


ReadValues = Callable[[CaseTables, Case, str], ParameterValues]


def parse_case(study: Study, case: Case, read: ReadValues = read_values) -> ParsedCase:
    """Read the tables of a case, with `read` what they say of parameters.

    Raises:
        UserError: whatever is wrong in them, with file, line and key.
    """
    try:
        tables = files.conform(CaseTables, case.tables)
        plant = _plant(tables)
        values = read(tables, case, plant.axis)
        return ParsedCase(study, case, tables, values, parse_controller(tables, plant, case.folder), plant.axis)
    except SchemaError as mistake:
        raise _located(study, case, mistake) from None


def resolve(study: Study, case: Case, overrides: Overrides | None = None) -> Resolved:
    """Build what a case runs, with `overrides` in place of its own.

    Raises:
        UserError: whatever is wrong, with file, line and key.
    """
    return parse_case(study, case).resolve(overrides)


def _located(study: Study, case: Case, mistake: SchemaError) -> UserError:
    return files.lines_of((mistake, *mistake.others), lambda each: located(study, case, each.key, each.message))


def _resolve(parsed: ParsedCase, overrides: Overrides) -> Resolved:
    case, wanted = parsed.case, parsed.controller
    tables = overridden(parsed.tables, overrides, parsed.values.deviations, parsed.axis)
    plant, believed = _plants(tables, parsed.values.true)
    parameters = build_truth(plant, tables, parsed.values)
    belief = build_belief(believed, tables, case.declared, parsed.values)
    foreign = None
    if tables.plant.fmu is None:
        state = _start(plant, parameters, tables)
    else:
        foreign = _foreign(parsed, tables, plant, believed, parameters)
        plant, parameters, state = foreign.plant, foreign.limits, foreign.state
    rotation_speed, surface_speed = _rotation(believed, belief, tables)
    rotary, inputs = _rotary(believed, belief, rotation_speed, surface_speed, tables)
    settings = wanted.settings._replace(**overrides.settings)
    loop = _position_loop(wanted, settings, believed, belief, tables.simulation.sample_time)
    if foreign is not None:
        inputs = foreign.inputs(inputs)
        check_sees(foreign, loop, tables.simulation.sample_time, ("controllers", wanted.name))
        if rotary is not None:
            check_sees(foreign, rotary, tables.simulation.sample_time, ("plant", "rotation"))
    plant = _gauged(plant, loop.controller, tables)
    sensors = build_sensors(tables.sensors, plant.axis)
    position = sensors.channels["position"]
    simulation = tables.simulation
    registered(INTEGRATORS, simulation.method, ("simulation", "method"))
    reference, feeds = wanted.signal, tuple[Feed, ...]()
    if wanted.fed and wanted.signal is not None:
        reference, feeds = None, (Feed(wanted.fed, wanted.signal, settings.hold == "linear"),)
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
        None if foreign is None else foreign.machine,
    )
    band = max(SIGMAS * position.noise, position.resolution)
    return Resolved(setup, simulation.transient, band, settings, belief, simulation.hold_limit)


def _start(plant: Plant, parameters: Any, tables: CaseTables) -> NamedTuple:
    """Where a plant of ours starts."""
    turning = 0.0 if tables.plant.start == "standstill" else _rotation(plant, parameters, tables)[1]
    try:
        state, _ = plant.equilibrium(parameters, turning)
    except OverflowError:
        raise SchemaError(
            ("plant",),
            "no number can hold where this machine rests: a value of it, or its rotation, is too large",
        ) from None
    start = ("plant", "start_position")
    state = state._replace(position=along_axis(tables.plant.start_position, plant.axis, start))
    return _within_limits(state, parameters)  # all else that the machine is given is believed


def _foreign(parsed: ParsedCase, tables: CaseTables, plant: Plant, model: Plant, declared: Any) -> ForeignPlant:
    """The FMU in the place of the model."""
    if plant.effects:
        message = f"gives the machine {plant.effects[0]}, and an FMU has effects of its own; leave it out"
        raise SchemaError(("plant", "parameters"), message)
    foreign = foreign_plant(tables, parsed.case, model, declared, parsed.study.allow_fmu)
    if (fed := parsed.controller.fed) and fed not in foreign.plant.Inputs._fields:
        raise SchemaError(("controllers", parsed.controller.name, "input"), f"[plant.inputs] does not map {fed}")
    return foreign


def _position_loop(
    wanted: ControllerCase, settings: NamedTuple, plant: Plant, belief: NamedTuple, sample_time: float
) -> Loop:
    """The controller with its gains, designed for what it believes of the plant."""
    controller = wanted.controller
    with designing(f'type "{wanted.type}"', plant, belief, ("controllers", wanted.name)):
        if controller.choose is not None:
            controller = controller.choose(settings, belief)
        return Loop(controller, controller.design(settings, belief, sample_time))


def _within_limits(state: NamedTuple, parameters: Any) -> NamedTuple:
    """The state with no more current than the motor's limit: a rod that takes more to turn will slow down."""
    current = state._asdict().get("motor_current")
    if current is None:
        return state
    limit = float(current_limit(parameters.motor))
    return state._replace(motor_current=min(max(current, -limit), limit))


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
    plant: Plant, belief: NamedTuple, rotation_speed: float, surface_speed: float, tables: CaseTables
) -> tuple[Loop | None, NamedTuple]:
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
    settings: NamedTuple
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


def _plants(tables: CaseTables, values: Mapping[str, float]) -> tuple[Plant, Plant]:
    """The plant with the friction law of [plant] and the effects that are not neutral in these values; and as
    controllers know it: with the law that it has by itself, and without effects.
    """
    bare = _plant(tables)
    felt = [name for name, value in acting(values).items() if value != NEUTRAL.get(name)]
    plant = bare.with_effects(*meant(bare, felt))
    law = registered(LAWS, tables.plant.friction, ("plant", "friction"))
    if "friction" not in tables.plant.model_fields_set:
        return plant, bare
    try:
        return plant.with_friction(law), bare
    except ValueError as error:
        raise SchemaError(("plant", "friction"), str(error)) from None


def _plant(tables: CaseTables) -> Plant:
    table, rpm = tables.plant, tables.rpm
    models = {"by_rpm": "non_rotating", "rotating": "non_rotating", "drive": f"drive_{table.command}"}
    plant = registered(PLANTS, models.get(table.model, table.model), ("plant", "model"), MODELS)
    turns = table.model == "rotating" or (rpm and (table.turned or table.model == "by_rpm"))
    if (turns or table.turned) and not plant.rotary_command:
        try:
            turning = plant.with_turning_rod(table.bristle, imposed=table.rotation == "ideal")
        except ValueError as error:
            raise SchemaError(("plant", "turned"), str(error)) from None
        plant = turning if turns else plant
    if rpm and not plant.rotary_command:
        raise SchemaError(("rpm",), f'plant "{plant.name}" does not rotate: expected rpm 0 (or turned = "rod")')
    return plant

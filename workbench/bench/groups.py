"""The groups in which the bench shows its controls, and what choosing a name does."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from controllers.registry import CONTROLLERS
from workbench.bench.knobs import Choice, Control
from workbench.bench.loop import BenchLoop
from workbench.bench.measured import RECORD, MeasuredLoop
from workbench.bench.offered import controller, effects, machine, motion
from workbench.bench.outcome import Outcome

GROUPS: Mapping[str, str] = {
    "controller": "Controller and gains",
    "machine": "Machine and rotation",
    "friction": "Friction of the machine",
    "effects": "Effects that the machine has",
    "belief": "What the controller believes",
    "reference": "Reference",
    "sensors": "Sensors",
    "run": "Duration and exactness",
}
"""Groups by name, with their titles, in the order in which they are offered."""

_OFFERED: Mapping[str, Callable[[Outcome], list[Control]]] = {
    "controller": lambda outcome: controller.controller_controls(outcome.loop),
    "machine": lambda outcome: machine.machine_controls(outcome.loop),
    "friction": lambda outcome: machine.friction_controls(outcome.loop),
    "effects": effects.effect_controls,
    "belief": lambda outcome: machine.belief_controls(outcome.loop),
    "reference": lambda outcome: motion.reference_controls(outcome.loop),
    "sensors": lambda outcome: motion.sensor_controls(outcome.loop),
    "run": lambda outcome: motion.run_controls(outcome.loop),
    "record": lambda outcome: motion.record_controls(outcome.loop),
}


def groups_of(loop: BenchLoop) -> dict[str, str]:
    """The groups that a loop has, with their titles: what a record drives has no controller, and no sensors to set."""
    if not isinstance(loop, MeasuredLoop):
        return dict(GROUPS)
    return {"record": "Record", **{name: GROUPS[name] for name in ("machine", "friction", "effects")}}


def controls_of(group: str, outcome: Outcome) -> list[Control]:
    """The controls of a group, as they stand for a loop; of names those that serve it."""
    return [_serving(outcome.loop, one) if isinstance(one, Choice) else one for one in _OFFERED[group](outcome)]


def _serving(loop: BenchLoop, choice: Choice) -> Choice:
    """A choice without the names that the loop cannot take as it is."""
    options = [
        (name, words)
        for name, words in choice.options
        if name == choice.value or chosen(loop, choice.key, name) is not None
    ]
    return replace(choice, options=options)


def chosen(loop: BenchLoop, key: str, name: str) -> BenchLoop | None:
    """The loop with another name at `key`, None where it cannot take it: a controller or a reference may be new to it,
    and then starts with what it has in common with the present one, as far as that serves.
    """
    if key == RECORD and isinstance(loop, MeasuredLoop):
        return loop.with_record(name)
    if key == "controller":
        known = CONTROLLERS.working().get(name)
        gauged = loop.changed({"sensors.friction_gauge": True}) if known is not None and known.gauge else loop
        tried = [gauged.with_table(key, name, table) for table in controller.starting_tables(loop, name)]
    elif key == "reference":
        tried = [loop.with_table(key, name, motion.starting_table(loop, name))]
    else:
        tried = [loop.changed({key: name})]
    return next((one for one in tried if one.serves), None)

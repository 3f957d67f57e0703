"""Effects that no list has: it is to be said that something is unexplained, on which balance and over which signals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .effects import FLUID, OIL
from .forms import Draw, Drawing, Form, sign, single
from .machines import AIR, HAND, KINDS, LINEAR, ROTARY, Rig

VALVE_SIGNALS = ("valve_voltage", "command", "spool_position")


def friction_bump(rig: Rig, draw: Draw) -> Form:
    """Up to four times as much friction over 3 to 8 % of the travel at one place."""
    place, width = rig.travel * draw.uniform(-0.5, 0.5), rig.travel * draw.uniform(0.03, 0.08)
    return single(lambda s: {"bump": 3.0 * s, "bump_place": place, "bump_width": width})


def force_step(rig: Rig, draw: Draw) -> Form:
    """Up to twice the friction at rest, from one time on, in the middle of the record."""
    time = rig.duration * draw.uniform(0.35, 0.65)
    return single(lambda s: {"step": 2.0 * rig.level * s, "step_time": time}, sign(draw))


def relief(rig: Rig, draw: Draw) -> Form:
    """Chamber 1 loses flow above 45 to 60 % of the supply pressure; up to that of the largest speed at 20 % more."""
    supply = rig.machine.supply_pressure
    flow = rig.machine.area_1 * rig.speed
    if rig.kind == AIR:
        flow *= 1.185 * (supply + 1e5) / 1e5
    slope, start = flow / (0.2 * supply), supply * draw.uniform(0.45, 0.6)
    return single(lambda s: {"relief": slope * s, "relief_pressure": start})


def wearing_friction(rig: Rig, draw: Draw) -> Form:
    """Friction that loses up to 80 % over the reversals, most of it in 4 to 10 of them."""
    count = draw.uniform(4.0, 10.0)
    return single(lambda s: {"wear": 0.8 * s, "wear_count": count})


def cubic_force(rig: Rig, draw: Draw) -> Form:
    """A force with the cube of the position: up to four times the friction at the travel's end."""
    return single(lambda s: {"cubic": 4.0 * rig.level / rig.travel**3 * s})


def velocity_notch(rig: Rig, draw: Draw) -> Form:
    """A resistance around one speed alone: up to the friction at rest, at 30 to 60 % of the largest speed."""
    speed = rig.speed * draw.uniform(0.3, 0.6)
    return single(lambda s: {"notch": rig.level * s, "notch_speed": speed, "notch_width": 0.12 * rig.speed}, sign(draw))


def flow_window(rig: Rig, draw: Draw) -> Form:
    """Flow that is lost around one velocity: up to a third of that velocity's."""
    speed = rig.speed * draw.uniform(0.25, 0.5) * sign(draw)
    flow = rig.machine.area_1 * abs(speed) / 3.0
    if rig.kind == AIR:
        flow *= 1.185 * (0.5 * rig.machine.supply_pressure + 1e5) / 1e5
    return single(lambda s: {"window": flow * s, "window_speed": speed, "window_width": 0.12 * rig.speed})


def fading_drive(rig: Rig, draw: Draw) -> Form:
    """A drive's force falls behind with the square of its command: up to 80 % at its limit."""
    return single(lambda s: {"fading": 0.8 * s})


@dataclass(frozen=True)
class Unlisted:
    """An effect that has no name in the program: its balance, and the signals of which naming any one is right."""

    name: str
    draw: Drawing
    balance: str
    signals: Sequence[str]
    kinds: Sequence[str] = KINDS
    by_hand: bool = True

    def may_be(self, kind: str, motion: str) -> bool:
        """Whether a machine that is moved in this way may have it, and show it."""
        return kind in self.kinds and (self.by_hand or motion != HAND)


UNLISTED: Mapping[str, Unlisted] = {
    item.name: item
    for item in (
        Unlisted("friction_bump", friction_bump, "force", ("position",)),
        Unlisted("force_step", force_step, "force", ("time",)),
        Unlisted("relief", relief, "flow", ("pressure_1", "load_pressure", "pressure_2"), FLUID),
        Unlisted("wearing_friction", wearing_friction, "force", ("time", "reversals", "velocity")),
        Unlisted("cubic_force", cubic_force, "force", ("position",)),
        Unlisted("velocity_notch", velocity_notch, "force", ("velocity",)),
        Unlisted("flow_window", flow_window, "flow", ("velocity", *VALVE_SIGNALS), OIL),
        Unlisted(
            "fading_drive",
            fading_drive,
            "force",
            ("command", "force", "torque", "acceleration"),
            (LINEAR, ROTARY),
            False,
        ),
    )
}
"""`signals`: as report.json calls them."""

"""Effects by the names that the program gives them: which machines may have them, what their parameters truly are."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from . import flow_effects as flow
from . import motion_effects as motion
from .forms import Drawing
from .machines import AIR, DIFFERENTIAL, EQUAL, HAND, KINDS
from .parameters import Machine

FLUID, OIL = (EQUAL, DIFFERENTIAL, AIR), (EQUAL, DIFFERENTIAL)


@dataclass(frozen=True)
class Effect:
    """An effect: its forms on a rig, the balance of which it is a term, the kinds of machine that may have it.

    One of a sensor is not told where a hand moves the mass: there the sensor says what the motion was. `signed`:
    whether either sign may be.
    """

    draw: Drawing
    balance: str
    kinds: Sequence[str] = KINDS
    by_hand: bool = True
    signed: bool = False

    @property
    def name(self) -> str:
        """As the program has it."""
        return self.draw.__name__

    def may_be(self, kind: str, motion: str) -> bool:
        """Whether a machine that is moved in this way may have it, and show it."""
        return kind in self.kinds and (self.by_hand or motion != HAND)


EFFECTS: Mapping[str, Effect] = {
    effect.name: effect
    for effect in (
        Effect(motion.direction_asymmetry, "force", signed=True),
        Effect(
            motion.position_dependent_friction, "force", FLUID, signed=True
        ),  # of a drive nobody declares the stroke
        Effect(motion.pressure_dependent_friction, "force", FLUID),
        Effect(motion.frictional_memory, "force"),
        Effect(motion.rising_static_friction, "force"),
        Effect(motion.quadratic_drag, "force"),
        Effect(motion.viscous_drift, "force", signed=True),
        Effect(motion.constant_load, "force", signed=True),
        Effect(motion.spring_load, "force", signed=True),
        Effect(flow.valve_deadband, "flow", FLUID),
        Effect(flow.internal_leakage, "flow", OIL),
        Effect(flow.internal_air_leakage, "flow", (AIR,)),
        Effect(flow.supply_droop, "flow", OIL),
        Effect(flow.entrained_air, "flow", OIL),
        Effect(flow.unequal_areas, "flow", OIL, signed=True),
        Effect(flow.command_delay, "valve", by_hand=False),
        Effect(flow.backlash, "sensor", by_hand=False),
        Effect(flow.pressure_sensor_offset, "sensor", FLUID, signed=True),
        Effect(flow.valve_hysteresis, "valve", FLUID),
        Effect(flow.valve_gain_curve, "flow", FLUID, signed=True),
        Effect(flow.valve_gain_asymmetry, "flow", FLUID, signed=True),
        Effect(flow.external_leakage, "flow", FLUID),
        Effect(flow.position_dependent_volume, "flow", (EQUAL,)),
        Effect(flow.position_dependent_area, "flow", FLUID, signed=True),
        Effect(flow.sensor_nonlinearity, "sensor", by_hand=False, signed=True),
        Effect(flow.sensor_lag, "sensor", by_hand=False),
        Effect(motion.cogging, "force", signed=True),
        Effect(motion.cushion, "force"),
        Effect(motion.presliding_curve, "force", signed=True),
        Effect(motion.maxwell_slip, "force"),
        Effect(motion.viscous_warming, "force", signed=True),
        Effect(flow.spool_stiction, "valve", FLUID),
        Effect(flow.supply_ripple, "flow", FLUID, signed=True),
        Effect(motion.compliant_load, "force"),
    )
}
"""Every effect that diagnosis may name."""

True_ = Callable[[Machine, Machine], float]
"""(machine with the effect, machine without) -> a parameter (SI) by the program's definition."""


def _as_it_is(field: str) -> True_:
    return lambda machine, without: float(getattr(machine, field))


def _negative(field: str) -> True_:
    """A friction parameter of the negative direction."""
    return lambda machine, without: float(getattr(machine, field) * getattr(machine, f"{field}_ratio"))


def _same(*names: str) -> dict[str, True_]:
    return {name: _as_it_is(name) for name in names}


TRUE_PARAMETERS: Mapping[str, Mapping[str, True_]] = {
    "direction_asymmetry": {f"{name}_negative": _negative(name) for name in ("coulomb", "stribeck", "viscous")},
    "position_dependent_friction": _same("friction_gradient", "friction_curvature"),
    "pressure_dependent_friction": _same("friction_per_pressure"),
    "frictional_memory": _same("memory_time"),
    "rising_static_friction": _same("static_rise", "static_rise_time", "static_rise_distance"),
    "quadratic_drag": {"drag_coefficient": _as_it_is("drag")},
    "viscous_drift": _same("viscous_drift"),
    "viscous_warming": {"warming_share": _as_it_is("warming"), **_same("warming_time")},
    "presliding_curve": _same("dahl_exponent"),
    "maxwell_slip": _same("slip_level", "slip_stiffness"),
    "constant_load": {"load_force": _as_it_is("load"), "load_torque": _as_it_is("load")},
    "spring_load": {"spring_stiffness": _as_it_is("spring")},
    "cushion": _same("cushion_stiffness", "cushion_start"),
    "cogging": _same("cogging_cosine", "cogging_sine", "cogging_pitch"),
    "compliant_load": {
        "compliant_share": _as_it_is("hung_share"),
        "compliant_frequency": lambda machine, without: machine.hung_frequency / (2.0 * np.pi),
        "compliant_damping": _as_it_is("hung_damping"),
    },
    "valve_deadband": {
        "valve_overlap": _as_it_is("overlap_positive"),
        "valve_overlap_negative": _as_it_is("overlap_negative"),
    },
    "valve_gain_curve": {"valve_gain_curvature": _as_it_is("gain_curve")},
    "valve_gain_asymmetry": {"valve_gain_ratio": _as_it_is("gain_ratio")},
    "internal_leakage": {"leakage_coefficient": _as_it_is("leakage")},
    "internal_air_leakage": {"leakage_conductance": _as_it_is("leakage")},
    "external_leakage": {"external_leakage_1": _as_it_is("leak_1"), "external_leakage_2": _as_it_is("leak_2")},
    "supply_droop": {"droop_resistance": _as_it_is("droop")},
    "supply_ripple": {
        "ripple_cosine": lambda machine, without: machine.ripple * float(np.sin(machine.ripple_phase)),
        "ripple_sine": lambda machine, without: machine.ripple * float(np.cos(machine.ripple_phase)),
        "ripple_frequency": lambda machine, without: machine.ripple_frequency / (2.0 * np.pi),
    },
    "entrained_air": {"air_fraction": _as_it_is("air")},
    "unequal_areas": {"area_ratio": lambda machine, without: machine.area_2 / without.area_2},
    "position_dependent_volume": {"volume_share": _as_it_is("following")},
    "position_dependent_area": _same("area_gradient"),
    "command_delay": {"command_delay": _as_it_is("delay")},
    "valve_hysteresis": {"valve_hysteresis": _as_it_is("play")},
    "spool_stiction": {"spool_stiction": lambda machine, without: machine.spool_band / machine.spool_gain},
    "backlash": {"backlash_width": _as_it_is("backlash")},
    "sensor_nonlinearity": {
        "position_ripple_cosine": _as_it_is("sensor_cosine"),
        "position_ripple_sine": _as_it_is("sensor_sine"),
        "position_ripple_pitch": _as_it_is("sensor_pitch"),
    },
    "sensor_lag": {"position_sensor_lag": _as_it_is("sensor_lag")},
    "pressure_sensor_offset": {"pressure_1_offset": _as_it_is("offset_1")},
}
"""Of each effect, by the program's names."""


def true_parameters(name: str, machine: Machine, without: Machine) -> dict[str, float]:
    """The true values (SI) of an effect's parameters, by the program's names."""
    return {parameter: true(machine, without) for parameter, true in TRUE_PARAMETERS[name].items()}

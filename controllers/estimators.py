"""The friction estimators by the type of the controller that is built on them, and which settings are whose."""

from typing import NamedTuple

from controllers.believed_friction import ROTATION_SETTINGS
from controllers.friction_observer import Estimate
from controllers.friedland_park import friedland_park
from controllers.lugre_observer import friction_feedforward, lugre_adaptive, lugre_observer
from controllers.measured_force import friction_gauge, load_pressure
from controllers.static_map import no_estimate, static_map
from controllers.tafazoli import tafazoli


class FrictionEstimator(NamedTuple):
    """An estimator, what it is, and the settings that are its own."""

    estimate: Estimate
    summary: str
    settings: tuple[str, ...] = ()


ESTIMATORS = {
    "uncompensated": FrictionEstimator(no_estimate, "no friction estimate: the laws alone"),
    "load_pressure": FrictionEstimator(
        load_pressure,
        "no friction model, the measured load force A P_L in its place",
        ("pressure_time_constant",),
    ),
    "static_map": FrictionEstimator(
        static_map, "believed Stribeck curve of the velocity", ("reversal_speed", *ROTATION_SETTINGS)
    ),
    "tafazoli": FrictionEstimator(
        tafazoli,
        "Tafazoli's model-based estimate (modified Tustin map, blended near rest)",
        ("blend_velocity", *ROTATION_SETTINGS),
    ),
    "friedland_park": FrictionEstimator(
        friedland_park,
        "Friedland-Park observer, Tafazoli's modification",
        ("observer_gain", "exponent", *ROTATION_SETTINGS),
    ),
    "lugre": FrictionEstimator(lugre_observer, "LuGre observer", ("injection", "sliding_rate", *ROTATION_SETTINGS)),
    "lugre_adaptive": FrictionEstimator(
        lugre_adaptive,
        "LuGre observer with adaptive theta",
        ("injection", "sliding_rate", "adaptation", *ROTATION_SETTINGS),
    ),
    "friction_feedforward": FrictionEstimator(
        friction_feedforward, "LuGre friction of the reference's motion", ROTATION_SETTINGS
    ),
    "friction_gauge": FrictionEstimator(friction_gauge, "the true friction, from a gauge that no rig has (an oracle)"),
}
"""Friction estimators by the type of the controller that is built on them."""

VELOCITY_SETTINGS = ("velocity", "velocity_time_constant", "position_noise", "jerk_density")

ORACLE = "friction_gauge"
"""The one that is given what no rig measures."""

WITHOUT_VELOCITY = ("uncompensated", "load_pressure", "friction_feedforward", ORACLE)
"""Estimators that have no use for the velocity: in a valve inversion it then counts for nothing."""


def without_use(name: str, law: str, hydraulic: bool) -> frozenset[str]:
    """Settings that neither the estimator `name` nor the law uses, on a plant with a valve or without."""
    others = {setting for estimator in ESTIMATORS.values() for setting in estimator.settings}
    idle = others.difference(ESTIMATORS[name].settings)
    if not hydraulic:
        idle.update(("feedforward", "lead", *ROTATION_SETTINGS))  # a drive has no velocity gain, no valve, and no motor
    if name in WITHOUT_VELOCITY and law == "valve_inversion":
        idle.update(VELOCITY_SETTINGS)
    if name == "load_pressure":
        idle.update(("force_rate", "washout", "compression", "kp", "kd", "ka", "feedforward", *VELOCITY_SETTINGS))
    return frozenset(idle)

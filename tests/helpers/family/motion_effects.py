"""Effects of friction and of loads: what resists the motion."""

import numpy as np

from .forms import Column, Draw, Form, sign, single
from .machines import ROTARY, Rig, between


def direction_asymmetry(rig: Rig, draw: Draw) -> Form:
    """Negative over positive direction, of Coulomb, Stribeck and viscous friction: 3^(+-s)."""
    names = ("coulomb", "stribeck", "viscous")
    columns = {n: (lambda s, n=n: {f"{n}_ratio": float(3.0**s)}) for n in names}
    acting = (("coulomb",), ("viscous",), ("coulomb", "stribeck"), ("coulomb", "viscous"))[draw.integers(4)]
    way = sign(draw)
    return Form(columns, {name: way * (1.0 if name != "viscous" else sign(draw)) for name in acting})


def position_dependent_friction(rig: Rig, draw: Draw) -> Form:
    """Level times 1 + b1 xi + b2 xi^2, xi = 2 x / stroke: up to 0.9, and up to 3 or -0.9."""
    columns: dict[str, Column] = {
        "gradient": lambda s: {"friction_gradient": 0.9 * s},
        "curvature": lambda s: {"friction_curvature": 3.0 * s},
    }
    if draw.random() < 0.5:
        return Form(columns, {"gradient": sign(draw)})
    return Form(columns, {"curvature": 1.0 if draw.random() < 0.6 else -0.3})


def pressure_dependent_friction(rig: Rig, draw: Draw) -> Form:
    """Level + c |P1 - P2|, c up to half the piston's area."""
    return single(lambda s: {"friction_per_pressure": 0.5 * s * rig.machine.area_1})


def frictional_memory(rig: Rig, draw: Draw) -> Form:
    """The level follows the velocity by a lag of up to 0.1 s (Hess and Soom 1990)."""
    return single(lambda s: {"memory_time": 0.1 * abs(s)})


def rising_static_friction(rig: Rig, draw: Draw) -> Form:
    """Stribeck friction times up to 1 + 5 r, dr/dt = (1 - r)/T - |slip| r/D (Dieterich 1979)."""
    time, distance = between(draw, 0.2, 3.0), rig.presliding * draw.uniform(1.5, 6.0)
    return single(lambda s: {"static_rise": 5.0 * s, "static_rise_time": time, "static_rise_distance": distance})


def viscous_drift(rig: Rig, draw: Draw) -> Form:
    """Viscosity times 1 + d t: by the end up to three times as much more, or nearly none."""
    return single(lambda s: {"viscous_drift": s / rig.duration}, float(draw.choice([-0.9, 3.0])))


def viscous_warming(rig: Rig, draw: Draw) -> Form:
    """Viscosity times 1 + w (1 - exp(-t/T)), T 15 to 60 % of the record: w down to -0.9 or up to 2."""
    time = rig.duration * draw.uniform(0.15, 0.6)
    return single(lambda s: {"warming": s, "warming_time": time}, -0.9 if draw.random() < 0.7 else 2.0)


def presliding_curve(rig: Rig, draw: Draw) -> Form:
    """The bristle's rate with Dahl's exponent n, 3^(+-s); LuGre's is 1 (Dahl 1968)."""
    return single(lambda s: {"dahl_exponent": float(3.0**s)}, sign(draw))


def maxwell_slip(rig: Rig, draw: Draw) -> Form:
    """A second element in parallel, up to as strong as the first, that gives way after 3 to 20 times its deflection."""
    deflection = rig.presliding * between(draw, 3.0, 20.0)
    return single(lambda s: {"slip_level": rig.level * s, "slip_stiffness": rig.level * s / deflection})


# --- forces ----------------------------------------------------------------------------------------------------


def quadratic_drag(rig: Rig, draw: Draw) -> Form:
    """Up to the friction at rest, three times, at the largest speed."""
    return single(lambda s: {"drag": 3.0 * rig.level / rig.speed**2 * s})


def constant_load(rig: Rig, draw: Draw) -> Form:
    """Up to twice the friction at rest."""
    return single(lambda s: {"load": 2.0 * rig.level * s}, sign(draw))


def spring_load(rig: Rig, draw: Draw) -> Form:
    """Up to twice the friction at rest at the end of the travel, towards the middle or away from it."""
    return single(lambda s: {"spring": 2.0 * rig.level / rig.travel * s}, 1.0 if draw.random() < 0.7 else -1.0)


def cogging(rig: Rig, draw: Draw) -> Form:
    """Up to the friction at rest over a pitch: 4 to 30 in the travel, or on a turning axis a turn's part."""
    pitch = 2.0 * np.pi / draw.integers(1, 13) if rig.kind == ROTARY else rig.travel / draw.uniform(4.0, 30.0)
    angle = draw.uniform(0.0, 2.0 * np.pi)
    columns: dict[str, Column] = {
        "cosine": lambda s: {"cogging_cosine": rig.level * s, "cogging_pitch": float(pitch)},
        "sine": lambda s: {"cogging_sine": rig.level * s, "cogging_pitch": float(pitch)},
    }
    return Form(columns, {"cosine": float(np.cos(angle)), "sine": float(np.sin(angle))})


def cushion(rig: Rig, draw: Draw) -> Form:
    """A spring from 40 to 70 % of the travel on, towards one end: up to five times the friction at the travel's end."""
    start = draw.uniform(0.4, 0.7)
    stiffness, place = 5.0 * rig.level / ((1.0 - start) * rig.travel), sign(draw) * start * rig.travel
    return single(lambda s: {"cushion_stiffness": stiffness * s, "cushion_start": place})


def compliant_load(rig: Rig, draw: Draw) -> Form:
    """Up to 90 % of the mass hangs on a spring of 3 to 40 Hz, damped by 1 to 10 %."""
    frequency, damping = 2.0 * np.pi * between(draw, 3.0, 40.0), between(draw, 0.01, 0.1)
    return single(lambda s: {"hung_share": 0.9 * s, "hung_frequency": frequency, "hung_damping": damping})

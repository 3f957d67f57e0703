"""The true parameters of one machine, and its effects, which do nothing at their defaults."""

from typing import NamedTuple

HYDRAULIC, PNEUMATIC, DRIVE = 0.0, 1.0, 2.0
"""What moves the mass: oil, air, or a force."""


class Machine(NamedTuple):
    """SI; along a turning axis rad, N m and kg m^2 stand for m, N and kg.

    `flow_gain` is that of oil in m^2/(s Pa^0.5), or of air the sonic conductance in m^3/(s Pa) over the spool's limit.
    """

    actuator: float
    mass: float
    coulomb: float
    stribeck: float
    viscous: float
    stribeck_velocity: float
    bristle_stiffness: float
    bristle_damping: float
    command_gain: float = 1.0  # N a unit of a drive's command
    command_limit: float = 10.0
    stroke: float = 1.0
    area_1: float = 0.0
    area_2: float = 0.0
    dead_volume_1: float = 0.0  # hoses and ends
    dead_volume_2: float = 0.0
    following: float = 1.0  # share by which volumes follow the position: 0 frozen at mid-stroke
    supply_pressure: float = 0.0
    tank_pressure: float = 0.0
    flow_gain: float = 0.0
    bulk_modulus: float = 1e9
    critical_ratio: float = 0.35
    polytropic: float = 1.2
    spool_gain: float = 1.0  # m/V
    spool_time: float = 1.0
    spool_limit: float = 1.0
    # --- effects: friction
    coulomb_ratio: float = 1.0  # negative direction over positive
    stribeck_ratio: float = 1.0
    viscous_ratio: float = 1.0
    friction_gradient: float = 0.0
    friction_curvature: float = 0.0
    friction_per_pressure: float = 0.0
    memory_time: float = 0.0
    static_rise: float = 0.0
    static_rise_time: float = 1.0
    static_rise_distance: float = 1e-4
    viscous_drift: float = 0.0
    warming: float = 0.0
    warming_time: float = 1.0
    dahl_exponent: float = 1.0
    slip_level: float = 0.0  # of the second element
    slip_stiffness: float = 0.0
    # --- effects: forces
    drag: float = 0.0
    load: float = 0.0
    spring: float = 0.0
    cogging_cosine: float = 0.0
    cogging_sine: float = 0.0
    cogging_pitch: float = 1.0
    cushion_stiffness: float = 0.0
    cushion_start: float = 0.0  # beyond it, or where negative below it
    hung_share: float = 0.0  # of the mass that hangs on a spring
    hung_frequency: float = 1.0  # rad/s
    hung_damping: float = 0.05
    # --- effects: flow
    overlap_positive: float = 0.0
    overlap_negative: float = 0.0
    leakage: float = 0.0
    droop: float = 0.0
    air: float = 0.0
    leak_1: float = 0.0  # to the tank
    leak_2: float = 0.0
    gain_curve: float = 0.0
    gain_ratio: float = 1.0  # of negative openings over positive ones
    area_gradient: float = 0.0
    ripple: float = 0.0
    ripple_frequency: float = 1.0  # rad/s
    ripple_phase: float = 0.0
    # --- effects: valve and command
    delay: float = 0.0
    play: float = 0.0  # of the command, full width
    spool_band: float = 0.0
    # --- effects: sensors
    backlash: float = 0.0
    offset_1: float = 0.0
    sensor_cosine: float = 0.0
    sensor_sine: float = 0.0
    sensor_pitch: float = 1.0
    sensor_lag: float = 0.0
    # --- what no list has
    bump: float = 0.0  # of the level, at one place
    bump_place: float = 0.0
    bump_width: float = 1.0
    step: float = 0.0  # force from one time on
    step_time: float = 0.0
    relief: float = 0.0  # m^3/(s Pa) beyond a pressure in chamber 1
    relief_pressure: float = 0.0
    wear: float = 0.0  # share of the level that is lost
    wear_count: float = 1.0  # reversals
    cubic: float = 0.0
    notch: float = 0.0  # N, at one speed
    notch_speed: float = 0.0
    notch_width: float = 1.0
    window: float = 0.0  # m^3/s or kg/s that is lost at one velocity
    window_speed: float = 0.0
    window_width: float = 1.0
    fading: float = 0.0  # of a drive's force with the square of the command

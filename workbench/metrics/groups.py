"""The program's own metrics: figures that are found together, each from the same signals, with what they mean."""

import numpy as np

from plants.friction import friction_in
from plants.motor import Motor
from workbench.metrics import friction, power, rotation, tracking
from workbench.metrics.interface import Column, Figures, Metric, Observed
from workbench.metrics.window import find_dwells


def tracking_figures(observed: Observed) -> Figures:
    run, reference, window = observed.run, observed.reference, observed.window
    if reference is None or run.reference is None:
        return {}
    asked, position = (values[window.samples] for values in (run.reference[0], run.state("position")))
    error, samples = asked - position, window.samples
    lag = gain = None
    if reference.fundamental is not None and window.periods > 0:
        lag, gain = tracking.phase_lag_and_gain(run.time[samples], asked, position, reference.fundamental)
    return {
        "phase_lag_deg": lag,
        "gain_ratio": gain,
        "rms_error_m": tracking.root_mean_square(error),
        "max_error_m": float(np.max(np.abs(error))),
    }


def dwells_figures(observed: Observed) -> Figures:
    from workbench.metrics.rest import rest_figures  # who only names columns does without statistics and compiled code

    run, reference = observed.run, observed.reference
    if reference is None or run.reference is None:
        return {}
    signals, dwells = run.signals, find_dwells(run.time, reference, observed.transient)
    if not dwells:
        return {}
    settling = tracking.settling_time(run.time, signals["reference_position"], signals["error"], dwells)
    return rest_figures(observed.rests()) | {"settling_time_s": settling}


def cost_figures(observed: Observed) -> Figures:
    run, window = observed.run, observed.window
    signals, samples = run.signals, window.samples
    figures: dict[str, float | None] = {
        "stuck_fraction": power.stuck_fraction(signals["velocity"][samples]),
        "control_effort_V": power.control_effort(run.command[samples], run.plant.command_unit),
        **power.mean_powers(signals, samples),
    }
    if "rotation_speed" in signals:
        figures.update(rotation.real_speed(signals["rotation_speed"][samples]))
    if isinstance(motor := getattr(run.parameters, "motor", None), Motor):
        figures.update(rotation.motor_figures(signals, samples, motor))
    if (law := friction_in(run.parameters)) is not None:
        figures["below_stribeck_fraction"] = rotation.below_stribeck_fraction(signals, samples, law)
    if "acceleration" in signals:
        figures["jerk_rms_m_per_s3"] = power.jerk_rms(run.time[samples], signals["acceleration"][samples])
    return figures


def friction_figures(observed: Observed) -> Figures:
    run, window = observed.run, observed.window
    signals, samples = run.signals, window.samples
    if "axial_friction" not in signals:
        return {}
    velocity, force = signals["velocity"][samples], signals["axial_friction"][samples]
    slope, r_squared = friction.line(velocity, force)
    energy = friction.hysteresis(run.time[samples], velocity, force)
    return {
        "friction_slope_N_s_per_m": slope,
        "friction_r_squared": r_squared,
        "friction_hysteresis_J": energy if energy is None else energy / max(1, window.periods),
    }


LAG = Metric(
    "lag",
    (
        Column(
            "phase_lag_deg",
            "deg",
            "phase(reference) - phase(position), in (-180, 180], positive where the position is late: "
            "least-squares fits of the reference's fundamental, its harmonics and a drift, over whole "
            "periods; none of a rod that hardly moves",
        ),
        Column("gain_ratio", "1", "amplitude of the position over that of the reference, by the same fits"),
    ),
    tracking_figures,
)

STEADY_STATE = Metric(
    "steady_state",
    (
        Column("steady_state_error_m", "m", "|mean error over the last 20 % of a dwell|, the largest over the dwells"),
        Column(
            "steady_state_max_error_m",
            "m",
            "largest |error| over the last 20 % of a dwell, the largest over the dwells: the error of a "
            "step, which a loop that hunts does not hide in its mean",
        ),
    ),
    dwells_figures,
)

ERRORS = Metric(
    "errors",
    (
        Column("rms_error_m", "m", "root mean square of reference less true position, over the window"),
        Column("max_error_m", "m", "largest magnitude of the same"),
    ),
    tracking_figures,
)

SETTLING = Metric(
    "settling",
    (
        Column(
            "settling_time_s",
            "s",
            "from the jump with which a dwell begins until the error stays within 2 % of the jump, the "
            "largest over such dwells; none if any does not settle",
        ),
    ),
    dwells_figures,
)

LIMIT_CYCLE = Metric(
    "limit_cycle",
    (
        Column(
            "limit_cycle",
            "1",
            "none, decaying, too_short or sustained, as `workbench.metrics.limit_cycle` judges each "
            "dwell; the worst counts. `workbench.study.run_on` makes the last dwell longer where it is "
            "too short, and takes these three and the two steady-state errors from there",
        ),
        Column("limit_cycle_amplitude_m", "m", "mean amplitude, peak to peak, of that dwell's cycles"),
        Column("limit_cycle_period_s", "s", "mean period of the same"),
    ),
    dwells_figures,
)

COST = Metric(
    "cost",
    (
        Column("stuck_fraction", "1", "share of the window's samples slower than 0.1 mm/s"),
        Column("hydraulic_power_W", "W", "mean over the window of load pressure times flow (thesis 4.16)"),
        Column("supply_power_W", "W", "mean of supply pressure times flow: what the pump pays"),
        Column("rotation_power_W", "W", "mean of rotary friction times surface speed (thesis 4.17, 4.18)"),
        Column("motor_electric_power_W", "W", "mean of voltage times current at the motor's terminals"),
        Column(
            "total_power_W", "W", "hydraulic plus rotary (thesis 4.19); hydraulic alone where the plant does not rotate"
        ),
        Column("motor_loss_W", "W", "mean of what enters at the motor's terminals less what reaches the rod"),
        Column("paid_power_W", "W", "supply plus motor electric power; the supply alone where nothing rotates"),
        Column(
            "rotation_speed_mean_rpm", "rpm", "mean of the rod's real speed over the window, where the plant rotates"
        ),
        Column("rotation_speed_min_rpm", "rpm", "the least of it"),
        Column("rotation_speed_max_rpm", "rpm", "the largest of it"),
        Column(
            "below_stribeck_fraction",
            "1",
            "share of the window's samples in which the contact slides (along the helix, where the rod "
            "turns) slower than the Stribeck velocity of the true friction along",
        ),
        Column(
            "torque_limited_fraction",
            "1",
            "share of the window's samples with the motor at its limit of torque, current or voltage",
        ),
        Column(
            "motor_torque_rms_N_m",
            "N m",
            "root mean square of the motor's torque K_t i: beside it stands its nominal torque",
        ),
        Column("control_effort_V", "V", "root mean square of the realised command, where that is a voltage"),
        Column(
            "jerk_rms_m_per_s3", "m/s^3", "root mean square of the central differences of acceleration, over the window"
        ),
    ),
    cost_figures,
)

FRICTION = Metric(
    "friction",
    (
        Column(
            "friction_slope_N_s_per_m",
            "N s/m",
            "slope of the straight line, with intercept, of axial friction on velocity, over the window",
        ),
        Column("friction_r_squared", "1", "share of the friction's variance that this line explains"),
        Column(
            "friction_hysteresis_J",
            "J",
            "energy per period (over the window where there is none) in half the difference between "
            "accelerating and decelerating friction at equal velocity; 0 for any F(v)",
        ),
    ),
    friction_figures,
)

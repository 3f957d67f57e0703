"""The figures of a finished run: what a row of results.csv says of it.

The window is t >= transient; where the reference repeats, the last whole number of its periods in there.
A dwell is a span in which the reference is constant; those that end after the transient count.

    outcome                   the run in words; one that diverged has no other figure
    phase_lag_deg             phase(reference) - phase(position), in (-180, 180], positive where the position is
                              late: least-squares fits of sin, cos and 1 at the reference's fundamental, over
                              whole periods
    gain_ratio                amplitude of the position over that of the reference, by the same fits
    steady_state_error_m      |mean error over the last 20 % of a dwell|, the largest over the dwells
    rms_error_m               root mean square of reference less true position, over the window
    max_error_m               largest magnitude of the same
    settling_time_s           from the jump with which a dwell begins until the error stays within 2 % of the jump,
                              the largest over such dwells; none if any does not settle
    limit_cycle               none, decaying or sustained, as `workbench.metrics.limit_cycle` judges each dwell;
                              the worst counts
    limit_cycle_amplitude_m   mean amplitude, peak to peak, of that dwell's cycles
    limit_cycle_period_s      mean period of the same
    stuck_fraction            share of the window's samples slower than 0.1 mm/s
    hydraulic_power_W         mean over the window of load pressure times flow (thesis 4.16)
    supply_power_W            mean of supply pressure times flow: what the pump pays
    rotation_power_W          mean of rotary friction times surface speed (thesis 4.17, 4.18)
    motor_electric_power_W    mean of voltage times current at the motor's terminals
    total_power_W             hydraulic plus rotary (thesis 4.19); hydraulic alone where the plant does not rotate
    control_effort_V          root mean square of the realised command, where that is a voltage
    jerk_rms_m_per_s3         root mean square of the central differences of acceleration, over the window
    friction_slope_N_s_per_m  of the straight line, with intercept, of axial friction on velocity, over the window
    friction_r_squared        share of the friction's variance that this line explains
    friction_hysteresis_J     energy per period (over the window where there is none) in half the difference between
                              accelerating and decelerating friction at equal velocity; 0 for any F(v)
    solver_error_m            largest distance of the positions from a finer integration; the study runner adds it

A figure that does not apply is None, never 0.
"""

from collections.abc import Collection, Mapping

import numpy as np

from workbench.metrics import friction, limit_cycle, power, tracking
from workbench.metrics.window import Window, find_dwells, find_window
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.simulate import Run

COLUMNS: tuple[str, ...] = (
    "outcome",
    "phase_lag_deg",
    "gain_ratio",
    "steady_state_error_m",
    "rms_error_m",
    "max_error_m",
    "settling_time_s",
    "limit_cycle",
    "limit_cycle_amplitude_m",
    "limit_cycle_period_s",
    "stuck_fraction",
    "hydraulic_power_W",
    "supply_power_W",
    "rotation_power_W",
    "motor_electric_power_W",
    "total_power_W",
    "control_effort_V",
    "jerk_rms_m_per_s3",
    "friction_slope_N_s_per_m",
    "friction_r_squared",
    "friction_hysteresis_J",
    "solver_error_m",
)
"""The figures of results.csv, in its order."""

TRACKING = frozenset({"phase_lag_deg", "gain_ratio", "rms_error_m", "max_error_m"})
DWELLS = frozenset(
    {"steady_state_error_m", "settling_time_s", "limit_cycle", "limit_cycle_amplitude_m", "limit_cycle_period_s"}
)
FRICTION = frozenset({"friction_slope_N_s_per_m", "friction_r_squared", "friction_hysteresis_J"})
COST = frozenset(COLUMNS) - TRACKING - DWELLS - FRICTION - {"outcome", "solver_error_m"}
"""Which of them are found together."""

Figures = Mapping[str, float | str | None]


def evaluate(
    run: Run,
    reference: ReferenceSignal | None,
    transient: float,
    resolution: float = 0.0,
    only: Collection[str] = COLUMNS,
) -> dict[str, float | str | None]:
    """All of `COLUMNS` but `solver_error_m`, in their order; None where a figure does not apply.

    Args:
        run: the finished run.
        reference: what the position was asked to do; in open loop the signal that drove it, which then only sets the
            window.
        transient: time (s) at the start that is left out.
        resolution: the larger of three standard deviations of the position noise and the sensor's step (m): the band
            of the limit-cycle verdict.
        only: the columns that are wanted; what takes long and is not stays None.
    """
    figures: dict[str, float | str | None] = dict.fromkeys(COLUMNS[:-1])
    figures["outcome"] = run.outcome
    window = None if run.diverged else find_window(run.time, reference, transient)
    if window is None:
        return figures
    if not COST.isdisjoint(only):
        figures.update(_cost(run, window))
    if not FRICTION.isdisjoint(only):
        figures.update(_friction(run, window))
    if reference is not None and run.reference is not None:
        if not TRACKING.isdisjoint(only):
            figures.update(_tracking(run, reference, window))
        if not DWELLS.isdisjoint(only):
            figures.update(_dwells(run, reference, transient, resolution))
    return figures


def _tracking(run: Run, reference: ReferenceSignal, window: Window) -> Figures:
    assert run.reference is not None
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


def _dwells(run: Run, reference: ReferenceSignal, transient: float, resolution: float) -> Figures:
    signals, dwells = run.signals, find_dwells(run.time, reference, transient)
    if not dwells:
        return {}
    time, error, velocity = run.time, signals["error"], signals["velocity"]
    forcing = run.loop.controller.forcing
    forced = 0.0 if forcing is None else 1.0 / forcing(run.loop.gains)
    cycle = limit_cycle.worst(
        [limit_cycle.judge(time[i], error[i], velocity[i], resolution, transient, forced) for i in dwells]
    )
    return {
        "steady_state_error_m": tracking.steady_state_error(run.time, signals["error"], dwells, transient),
        "settling_time_s": tracking.settling_time(run.time, signals["reference_position"], signals["error"], dwells),
        "limit_cycle": cycle.verdict,
        "limit_cycle_amplitude_m": cycle.amplitude,
        "limit_cycle_period_s": cycle.period,
    }


def _cost(run: Run, window: Window) -> Figures:
    signals, samples = run.signals, window.samples
    figures: dict[str, float | None] = {
        "stuck_fraction": power.stuck_fraction(signals["velocity"][samples]),
        "control_effort_V": power.control_effort(run.command[samples], run.plant.command_unit),
        **power.mean_powers(signals, samples),
    }
    if "acceleration" in signals:
        figures["jerk_rms_m_per_s3"] = power.jerk_rms(run.time[samples], signals["acceleration"][samples])
    return figures


def _friction(run: Run, window: Window) -> Figures:
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

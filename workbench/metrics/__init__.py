"""The figures of a finished run: what a row of results.csv says of it.

The window is t >= transient; where the reference repeats, the last whole number of its periods in there.
A dwell is a span in which the reference is constant; those that end after the transient count.

    outcome                   the run in words; one that diverged has no other figure
    phase_lag_deg             phase(reference) - phase(position), in (-180, 180], positive where the position is
                              late: least-squares fits of the reference's fundamental, its harmonics and a drift, over
                              whole periods; none of a rod that hardly moves
    gain_ratio                amplitude of the position over that of the reference, by the same fits
    steady_state_error_m      |mean error over the last 20 % of a dwell|, the largest over the dwells
    steady_state_max_error_m  largest |error| over the last 20 % of a dwell, the largest over the dwells: the error of a
                              step, which a loop that hunts does not hide in its mean
    rms_error_m               root mean square of reference less true position, over the window
    max_error_m               largest magnitude of the same
    settling_time_s           from the jump with which a dwell begins until the error stays within 2 % of the jump,
                              the largest over such dwells; none if any does not settle
    limit_cycle               none, decaying, too_short or sustained, as `workbench.metrics.limit_cycle` judges each
                              dwell; the worst counts. `workbench.study.run_on` makes the last dwell longer where it
                              is too short, and takes these three and the two steady-state errors from there
    limit_cycle_amplitude_m   mean amplitude, peak to peak, of that dwell's cycles
    limit_cycle_period_s      mean period of the same
    stuck_fraction            share of the window's samples slower than 0.1 mm/s
    hydraulic_power_W         mean over the window of load pressure times flow (thesis 4.16)
    supply_power_W            mean of supply pressure times flow: what the pump pays
    rotation_power_W          mean of rotary friction times surface speed (thesis 4.17, 4.18)
    motor_electric_power_W    mean of voltage times current at the motor's terminals
    total_power_W             hydraulic plus rotary (thesis 4.19); hydraulic alone where the plant does not rotate
    motor_loss_W              mean of what enters at the motor's terminals less what reaches the rod
    paid_power_W              supply plus motor electric power; the supply alone where nothing rotates
    rotation_speed_mean_rpm   mean of the rod's real speed over the window, where the plant rotates
    rotation_speed_min_rpm    the least of it
    rotation_speed_max_rpm    the largest of it
    below_stribeck_fraction   share of the window's samples in which the contact slides (along the helix, where the rod
                              turns) slower than the Stribeck velocity of the true friction along
    torque_limited_fraction   share of the window's samples with the motor at its limit of torque, current or voltage
    motor_torque_rms_N_m      root mean square of the motor's torque K_t i: beside it stands its nominal torque
    control_effort_V          root mean square of the realised command, where that is a voltage
    jerk_rms_m_per_s3         root mean square of the central differences of acceleration, over the window
    friction_slope_N_s_per_m  of the straight line, with intercept, of axial friction on velocity, over the window
    friction_r_squared        share of the friction's variance that this line explains
    friction_hysteresis_J     energy per period (over the window where there is none) in half the difference between
                              accelerating and decelerating friction at equal velocity; 0 for any F(v)
    solver_error_m            largest distance of the positions from a finer integration; the study runner adds it
    solver_rms_error_m        by how much the finer integration changes rms_error_m; the study runner adds it. Where a
                              loop sticks and slips irregularly the positions part, and the figure hardly does

A figure that does not apply is None, never 0.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from workbench.metrics.window import find_window

if TYPE_CHECKING:
    from workbench.metrics.rest import Rest
    from workbench.simulation.references import ReferenceSignal
    from workbench.simulation.run import Run

COLUMNS: tuple[str, ...] = (
    "outcome",
    "phase_lag_deg",
    "gain_ratio",
    "steady_state_error_m",
    "steady_state_max_error_m",
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
    "motor_loss_W",
    "paid_power_W",
    "rotation_speed_mean_rpm",
    "rotation_speed_min_rpm",
    "rotation_speed_max_rpm",
    "below_stribeck_fraction",
    "torque_limited_fraction",
    "motor_torque_rms_N_m",
    "control_effort_V",
    "jerk_rms_m_per_s3",
    "friction_slope_N_s_per_m",
    "friction_r_squared",
    "friction_hysteresis_J",
    "solver_error_m",
    "solver_rms_error_m",
)
"""The figures of results.csv, in its order."""

SOLVER = ("solver_error_m", "solver_rms_error_m")
"""Those that take a second run, which the study runner makes."""

AT_REST = (
    "steady_state_error_m",
    "steady_state_max_error_m",
    "limit_cycle",
    "limit_cycle_amplitude_m",
    "limit_cycle_period_s",
)
"""The columns that a longer dwell tells better."""

TRACKING = frozenset({"phase_lag_deg", "gain_ratio", "rms_error_m", "max_error_m"})
DWELLS = frozenset({*AT_REST, "settling_time_s"})
FRICTION = frozenset({"friction_slope_N_s_per_m", "friction_r_squared", "friction_hysteresis_J"})
COST = frozenset(COLUMNS) - TRACKING - DWELLS - FRICTION - {"outcome", *SOLVER}
"""Which of them are found together."""

Figures = Mapping[str, float | str | None]


def evaluate(
    run: "Run",
    reference: "ReferenceSignal | None",
    transient: float,
    resolution: float = 0.0,
    only: Collection[str] = COLUMNS,
    rests: "Sequence[Rest] | None" = None,
) -> dict[str, float | str | None]:
    """All of `COLUMNS` but those of `SOLVER`, in their order; None where a figure does not apply.

    Args:
        run: the finished run.
        reference: what the position was asked to do; in open loop the signal that drove it, which then only sets the
            window.
        transient: time (s) at the start that is left out.
        resolution: the larger of three standard deviations of the position noise and the sensor's step (m): the band
            of the limit-cycle verdict.
        only: the columns that are wanted; what takes long and is not stays None.
        rests: what the run does where its reference rests (`rests_of`), where that has been found before.
    """
    from workbench.metrics import groups  # who only names the columns does without statistics and compiled code
    from workbench.metrics.rest import rests_of

    figures: dict[str, float | str | None] = dict.fromkeys(COLUMNS[: -len(SOLVER)])
    figures["outcome"] = run.outcome
    window = None if run.diverged else find_window(run.time, reference, transient)
    if window is None:
        return figures
    if not COST.isdisjoint(only):
        figures.update(groups.cost_figures(run, window))
    if not FRICTION.isdisjoint(only):
        figures.update(groups.friction_figures(run, window))
    if reference is not None and run.reference is not None:
        if not TRACKING.isdisjoint(only):
            figures.update(groups.tracking_figures(run, reference, window))
        if not DWELLS.isdisjoint(only):
            known = rests_of(run, reference, transient, resolution) if rests is None else rests
            figures.update(groups.dwells_figures(run, reference, transient, known))
    return figures

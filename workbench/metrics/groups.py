"""The figures of a run in groups: those that are found together, each from the same signals."""

from collections.abc import Sequence

import numpy as np

from plants.friction import Friction
from plants.motor import Motor
from workbench.metrics import Figures, friction, power, rotation, tracking
from workbench.metrics.rest import Rest, rest_figures
from workbench.metrics.window import Window, find_dwells
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.run import Run


def tracking_figures(run: Run, reference: ReferenceSignal, window: Window) -> Figures:
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


def dwells_figures(run: Run, reference: ReferenceSignal, transient: float, rests: Sequence[Rest]) -> Figures:
    signals, dwells = run.signals, find_dwells(run.time, reference, transient)
    if not dwells:
        return {}
    settling = tracking.settling_time(run.time, signals["reference_position"], signals["error"], dwells)
    return rest_figures(rests) | {"settling_time_s": settling}


def cost_figures(run: Run, window: Window) -> Figures:
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
    if isinstance(law := getattr(run.parameters, "friction", None), Friction):
        figures["below_stribeck_fraction"] = rotation.below_stribeck_fraction(signals, samples, law)
    if "acceleration" in signals:
        figures["jerk_rms_m_per_s3"] = power.jerk_rms(run.time[samples], signals["acceleration"][samples])
    return figures


def friction_figures(run: Run, window: Window) -> Figures:
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

"""The figures of the loop of chapter 3."""

from dataclasses import replace

import numpy as np
import pytest
from support import registered

from controllers.pid import PID, Gains
from controllers.velocity import filtered_differentiator
from workbench.metrics.evaluate import evaluate
from workbench.metrics.window import find_window
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Loop, Run, simulate

GAINS = Gains(500.0, 0.0, 0.0, 0.0, 0.0, filtered_differentiator(0.002, 0.001))
REFERENCE = Sine(0.03, 0.9)


def chapter3(rpm: float) -> Run:
    return simulate(
        registered(
            "rotating_helical" if rpm else "non_rotating",
            rpm=rpm,
            flow="chapter3",
            duration=5.0,
            loop=Loop(PID, GAINS),
            reference=REFERENCE,
        )
    )


@pytest.fixture(scope="module")
def still() -> Run:
    return chapter3(0.0)


@pytest.fixture(scope="module")
def turning() -> Run:
    return chapter3(460.0)


def test_chapter_3_at_rest(still: Run) -> None:
    figures = evaluate(still, REFERENCE, 1.1)
    assert figures["phase_lag_deg"] == pytest.approx(8.55, abs=0.15)
    assert figures["friction_r_squared"] == pytest.approx(0.910, abs=0.004)
    assert figures["rotation_power_W"] is None
    assert figures["motor_electric_power_W"] is None
    assert figures["total_power_W"] == figures["hydraulic_power_W"]


def test_chapter_3_at_460_rpm(still: Run, turning: Run) -> None:
    figures, at_rest = evaluate(turning, REFERENCE, 1.1), evaluate(still, REFERENCE, 1.1)
    assert figures["phase_lag_deg"] == pytest.approx(7.65, abs=0.15)
    assert figures["friction_slope_N_s_per_m"] == pytest.approx(2700.0, rel=0.015)
    assert figures["friction_r_squared"] == pytest.approx(1.0, abs=1e-5)
    assert float(figures["friction_hysteresis_J"] or 0.0) < 0.02 * float(at_rest["friction_hysteresis_J"] or 0.0)
    parts = float(figures["hydraulic_power_W"] or 0.0) + float(figures["rotation_power_W"] or 0.0)
    assert figures["total_power_W"] == pytest.approx(parts)
    assert float(figures["motor_electric_power_W"] or 0.0) > float(figures["rotation_power_W"] or 0.0)


def test_hydraulic_power_is_what_friction_dissipates(still: Run) -> None:
    # Over whole periods the mass and the oil give back what they stored: the means of P_L Q_L and F v agree.
    figures, window = evaluate(still, REFERENCE, 1.1), find_window(still.time, REFERENCE, 1.1)
    assert window is not None
    dissipated = np.mean((still.signals["axial_friction"] * still.signals["velocity"])[window.samples])
    assert figures["hydraulic_power_W"] == pytest.approx(dissipated, rel=2e-3)


def test_effort_is_that_of_the_realised_command(still: Run) -> None:
    # P control far from saturation: 500 V/m times the error.
    figures = evaluate(still, REFERENCE, 1.1)
    assert figures["control_effort_V"] == pytest.approx(500.0 * float(figures["rms_error_m"] or 0.0), rel=5e-3)


def test_evaluation_leaves_the_run_alone(still: Run) -> None:
    copy = replace(still, states=still.states.copy())
    before = copy.states.copy()
    first = evaluate(copy, REFERENCE, 1.1)
    assert np.array_equal(copy.states, before)
    assert evaluate(copy, REFERENCE, 1.1) == first

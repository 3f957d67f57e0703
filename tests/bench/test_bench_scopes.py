"""What the scopes show: no extreme is lost, amplitudes and margins are right, and what a machine lacks is said."""

import numpy as np
import pytest
from benches import short
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from workbench.bench.figures_table import figures_table
from workbench.bench.opened import opened
from workbench.bench.outcome import Outcome, outcome_of
from workbench.bench.scopes import SCOPES, thinned


@given(arrays.arrays(float, st.integers(1, 5000), elements=st.floats(-1e6, 1e6)), st.integers(2, 50))
def test_thinned_curves_keep_their_extremes(values: np.ndarray, buckets: int) -> None:
    kept = thinned(values, buckets=buckets)
    assert kept[0] == 0
    assert kept[-1] == values.size - 1
    assert np.all(np.diff(kept) > 0)
    assert values[kept].max() == values.max()
    assert values[kept].min() == values.min()
    assert kept.size <= max(2 * buckets + 2, 2 * buckets)


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return outcome_of(opened(None))


def test_curves_are_those_of_the_run_in_readers_units(outcome: Outcome) -> None:
    view = SCOPES["position"].view(outcome)
    assert (view.x, view.y) == ("time (s)", "position (mm)")
    asked, went = view.curves
    assert (asked.name, went.name) == ("reference position", "position")
    assert went.y.max() == pytest.approx(1e3 * outcome.run.signals["position"].max())
    friction = SCOPES["friction"].view(outcome).curves[0]
    late = outcome.run.time >= outcome.loop.resolved.transient
    assert friction.y.max() == outcome.run.signals["axial_friction"][late].max()
    assert SCOPES["rotation"].view(outcome).curves[0].y[-1] == pytest.approx(120.0, rel=0.02)


def test_a_spectrum_has_the_amplitude_of_a_sine(outcome: Outcome) -> None:
    loop = outcome.loop.changed({"simulation.duration": 1.1 + 5.0 / 0.9})  # five periods behind the transient
    found = outcome_of(loop)
    curve = SCOPES["spectrum"].view(found).curves[0]
    peak = int(np.argmax(curve.y))
    assert curve.x[peak] == pytest.approx(0.9, rel=0.06)
    error = found.figures["rms_error_m"]
    assert isinstance(error, float)
    assert curve.y[peak] == pytest.approx(1e3 * np.sqrt(2.0) * error, rel=0.03)


def test_the_loop_gain_is_that_of_python_control(outcome: Outcome) -> None:
    import control

    gain = outcome.loop_gain
    assert not isinstance(gain, str)
    curve = SCOPES["bode"].view(outcome).curves[0]
    system = control.ss(gain.a, gain.b, gain.c, 0.0, gain.sample_time)
    some = slice(0, None, 20)
    expected = np.abs(np.asarray(control.frequency_response(system, 2.0 * np.pi * curve.x[some]).complex).ravel())
    assert curve.y[some] == pytest.approx(20.0 * np.log10(expected), abs=1e-5)


def test_what_a_machine_lacks_is_said() -> None:
    drive = outcome_of(short("rotary_drive", controller="lugre"))
    assert SCOPES["pressures"].view(drive).note == "rotary current has none"
    assert SCOPES["position"].view(drive).y == "position (deg)"
    for scope in SCOPES.values():
        view = scope.view(drive)
        assert bool(view.curves) != bool(view.note)


def test_the_table_has_the_columns_of_the_results(outcome: Outcome) -> None:
    table = figures_table(outcome, outcome)
    lag = outcome.figures["phase_lag_deg"]
    assert isinstance(lag, float)
    assert f"<td>{lag:.2f} deg</td>" in table
    assert table.count("<tr>") == 3
    assert "limit cycle" not in table  # none applies to a sine

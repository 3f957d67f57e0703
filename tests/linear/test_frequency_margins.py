"""Margins and stability of sampled transfer functions, against python-control and by hand."""

import control
import numpy as np
import pytest

from workbench.linear.margins import Response, is_stable, margins_of

H, LAG = 1e-3, 12e-3
SPEED = 0.03
FREQUENCIES = np.geomspace(0.1, 3000.0, 300)
Z = np.exp(1j * FREQUENCIES * H)


@pytest.mark.filterwarnings("ignore:(divide by zero|invalid value):RuntimeWarning")  # its own root at z = 1
@pytest.mark.parametrize(("gain", "integral"), [(40.0, 0.0), (20.0, 100.0), (200.0, 0.0)])
def test_margins_are_those_of_python_control(gain: float, integral: float) -> None:
    """A loop short enough for its polynomials: (K + K_i / s) / (s (tau s + 1)) sampled; the last one is unstable."""
    s = control.tf("s")
    model = control.sample_system(control.ss((gain + integral / s) / (s * (LAG * s + 1.0))), H, "zoh")
    a, b, c = model.A, model.B, model.C
    found = margins_of(a, b, c, H, SPEED)
    gm, pm, _, at_phase, at_gain, _ = control.stability_margins(control.tf(model), method="poly")
    np.testing.assert_allclose(Response(a, b, c, H)(FREQUENCIES), model(Z), rtol=1e-8)
    assert found.phase_frequency == pytest.approx(at_gain, rel=1e-5)
    assert found.gain_frequency == pytest.approx(at_phase, rel=1e-4)
    assert abs(found.phase_deg) == pytest.approx(abs(pm), abs=1e-3)
    assert abs(found.gain_dB) == pytest.approx(abs(20.0 * np.log10(gm)), abs=1e-3)
    assert found.stable == bool(np.all(np.abs(control.feedback(model, 1).poles()) < 1.0))


def test_an_integrator_has_its_gain_margin_at_the_nyquist_frequency() -> None:
    """K h / (z - 1) is stable for K h < 2, and crosses the negative axis nowhere below."""
    found = margins_of(np.eye(1), np.eye(1), 0.2 * np.eye(1), H, SPEED)
    assert found.gain_dB == pytest.approx(20.0)
    assert found.gain_frequency == pytest.approx(np.pi / H)
    assert not margins_of(np.eye(1), np.eye(1), 2.1 * np.eye(1), H, SPEED).stable


def test_an_integrator_that_the_loop_does_not_see_is_no_instability() -> None:
    stable, seen = np.diag([0.5, 1.0]), np.ones((1, 2))
    assert is_stable(stable, np.array([[1.0], [0.0]]), 0.1 * seen)
    assert not is_stable(stable, np.array([[1.0], [-1.0]]), 0.1 * seen)

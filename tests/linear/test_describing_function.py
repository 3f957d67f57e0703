"""Describing functions against their closed forms, and the hunting study with what is predicted beside it."""

from pathlib import Path

import control
import numpy as np
import pandas as pd
import pytest
from published import outcome, said, shared_folder
from scipy.optimize import brentq
from support import registered

from controllers.pid import PID
from plants.friction import LuGre
from workbench.linear.describing_function import SteadyFriction, friction_loop, intersections, predict

STRIBECK = LuGre(370.0, 217.0, 2318.0, 0.032, 5.77e6, 2.28e4)


def pid(kp: float, ki: float, kd: float = 0.0) -> object:
    """Gains of a PID at 1 kHz."""
    return PID.design(PID.Settings(kp=kp, ki=ki, kd=kd), None, 1e-3)


@pytest.mark.parametrize("gain", [3.0, 2e-5])
def test_relay_feedback(gain: float) -> None:
    """k / (s (s + 1)^2) has the phase -180 degrees at w = 1, and the gain k/2 there: A = 4 M k / (2 pi)."""
    linear = control.ss(control.tf([gain], [1.0, 2.0, 1.0, 0.0]))
    (found,) = intersections(linear, control.relay_hysteresis_nonlinearity(2.0, 0.0))
    assert found.amplitude == pytest.approx(4.0 * 2.0 * gain / (2.0 * np.pi), rel=1e-6)
    assert found.frequency == pytest.approx(1.0, rel=1e-6)
    assert found.stable


def test_saturation() -> None:
    """python-control's own example: amplitude 3.3438, frequency sqrt(2), where 8 / (s^3 + 2 s^2 + 2 s + 1) is real."""
    linear = control.ss(control.tf([8.0], [1.0, 2.0, 2.0, 1.0]))
    (found,) = intersections(linear, control.saturation_nonlinearity(1.0))
    assert found.amplitude == pytest.approx(3.3438, abs=1e-3)
    assert found.frequency == pytest.approx(np.sqrt(2.0), rel=1e-6)


@pytest.mark.parametrize("amplitude", [1e-4, 0.01, 0.032, 0.3])
def test_static_friction_against_quadrature(amplitude: float) -> None:
    """Dawson's integral against the first Fourier coefficient by the midpoint rule."""
    angle = (np.arange(200_000) + 0.5) * np.pi / 200_000
    velocity = amplitude * np.sin(angle)
    force = 370.0 + 217.0 * np.exp(-((velocity / 0.032) ** 2))
    coefficient = 2.0 * np.mean(force * np.sin(angle))
    assert SteadyFriction(STRIBECK).describing_function(amplitude) == pytest.approx(coefficient / amplitude, rel=1e-8)


def test_without_static_friction_it_is_a_relay() -> None:
    relay = control.relay_hysteresis_nonlinearity(370.0, 0.0)
    friction = SteadyFriction(STRIBECK._replace(stribeck=0.0))
    assert friction.describing_function(0.02) == pytest.approx(relay.describing_function(0.02), rel=1e-12)


def test_rotation_makes_friction_viscous() -> None:
    """Far below the surface speed w the gain is g(w) / w, by thesis (3.45)."""
    level = 370.0 + 217.0 * np.exp(-((0.05 / 0.032) ** 2))
    gain = control.describing_function(SteadyFriction(STRIBECK, 0.05), [1e-5])[0]
    assert gain.real == pytest.approx(level / 0.05, rel=1e-6)


def test_loop_of_a_mass() -> None:
    """H(s) = s^2 / (M s^3 + (K_d + a2) s^2 + K_p s + K_i) from force to velocity."""
    setup = registered("drive_force", duration=1.0)
    linear = friction_loop(setup.plant, setup.parameters, pid(13600.0, 136000.0, 1360.0))
    s = 1j * np.geomspace(0.1, 1e3, 9)
    assert linear(s) == pytest.approx(s**2 / (34.0 * s**3 + (1360.0 + 2318.0) * s**2 + 13600.0 * s + 136000.0))


def test_loop_without_integral() -> None:
    """H(s) = s / (M s^2 + (K_d + a2) s + K_p)."""
    setup = registered("drive_force", duration=1.0)
    linear = friction_loop(setup.plant, setup.parameters, pid(13600.0, 0.0, 1360.0))
    s = 1j * np.geomspace(0.1, 1e3, 9)
    assert linear(s) == pytest.approx(s / (34.0 * s**2 + (1360.0 + 2318.0) * s + 13600.0))


def test_predicted_exactly_where_the_loop_of_a_mass_is_unstable() -> None:
    """Routh: stable up to K_i = K_p (K_d + a2) / M. Beyond, w^2 = K_p / M, but the cycle is not a stable one."""
    setup = registered("drive_force", duration=1.0)
    critical = 13600.0 * (1360.0 + 2318.0) / 34.0
    friction = SteadyFriction(STRIBECK)
    below = friction_loop(setup.plant, setup.parameters, pid(13600.0, 0.9 * critical, 1360.0))
    assert intersections(below, friction) == []
    above = friction_loop(setup.plant, setup.parameters, pid(13600.0, 1.1 * critical, 1360.0))
    (found,) = intersections(above, friction)
    assert found.frequency == pytest.approx(np.sqrt(13600.0 / 34.0), rel=1e-6)
    assert not found.stable
    assert predict(setup.plant, setup.parameters, pid(13600.0, 1.1 * critical, 1360.0)) is None


# --- the study ---


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, png_alone: None) -> Path:
    """Results of studies/hunting.toml, run by the command."""
    folder = outcome(shared_folder(tmp_path_factory), "hunting")
    assert "simulated against describing function" in said(folder)
    return folder


def test_hose_fed(folder: Path) -> None:
    """Verdicts and sizes as computed independently at two step sizes; the size to its last digit."""
    table = pd.read_csv(folder / "results.csv", keep_default_na=False).set_index(["case", "rpm"])
    rows = table[table.index.get_level_values("case").str.startswith("hose")]
    assert rows["limit_cycle"].tolist() == ["decaying", "sustained", "none", "sustained"]
    cycle, sampled = rows.iloc[1], rows.iloc[3]
    assert float(cycle["limit_cycle_amplitude_m"]) == pytest.approx(1.095e-3, abs=1e-6)
    assert float(cycle["limit_cycle_period_s"]) == pytest.approx(1.05, abs=5e-3)
    assert float(sampled["limit_cycle_amplitude_m"]) == pytest.approx(1.095e-3, rel=0.03)


def test_mass_of_34_kg(folder: Path) -> None:
    """Three stiff solvers: 7.26 mm, 5.126 s; 6.00 mm, 6.325 s; settling."""
    table = pd.read_csv(folder / "results.csv", keep_default_na=False).set_index("case")
    rows = table[table.index.str.startswith("mass")]
    assert rows["limit_cycle"].tolist() == ["sustained", "sustained", "none"]
    sizes = rows[["limit_cycle_amplitude_m", "limit_cycle_period_s"]].iloc[:2].astype(float).to_numpy()
    assert sizes == pytest.approx(np.array([[7.26e-3, 5.126], [6.0e-3, 6.325]]), rel=0.02)


def hose_fed_by_hurwitz(ki: float) -> tuple[float, float]:
    """Frequency (rad/s) and friction gain N (N s/m) at which the hose-fed loop is on the edge of stability.

    From M dv/dt = A P - (a2 + N) v, dP/dt = 4 beta/V_t (Q - A v), tau dQ/dt = B V - Q, V = -(K_p + K_i / s) x with
    K_p 100 V/m, the odd and the even part of the characteristic polynomial are 0 at s = jw (thesis, appendix B).
    """
    area, tau, mass, viscous, kp = 6.33e-4, 12e-3, 34.0, 2318.0, 100.0
    oil = 4.0 * 30e6 / (2.0 * 8.9e-6 + area * 60e-3)
    valve = 5.9e-4 * 6e-5 * np.sqrt(2.94e6 / 2.0)

    def damping(w: float) -> float:
        return ((area**2 * oil * w**2 - area * oil * valve * ki) / w**4 - mass) / tau

    def odd(w: float) -> float:
        return tau * mass * w**4 - (damping(w) + area**2 * oil * tau) * w**2 + area * oil * valve * kp

    frequency = brentq(odd, 3.0, 20.0, xtol=1e-13)
    return frequency, damping(frequency) - viscous


@pytest.mark.parametrize(("case", "ki"), [("hose_fed_ki_500", 500.0), ("hose_fed_ki_1000", 1000.0)])
def test_prediction_for_the_hose_fed_actuator(folder: Path, case: str, ki: float) -> None:
    """Its gain, the first harmonic over the amplitude, is the N of the edge of stability; w is the frequency there."""
    row = pd.read_csv(folder / "tables" / "limit_cycles.csv").set_index("case").loc[case]
    frequency, gain = hose_fed_by_hurwitz(ki)
    assert row["period (s), predicted"] == pytest.approx(2.0 * np.pi / frequency, rel=1e-3)
    amplitude = 0.5e-3 * row["peak to peak (mm), predicted"] * frequency
    angle = (np.arange(1000) + 0.5) * np.pi / 1000
    force = 370.0 + 217.0 * np.exp(-((amplitude * np.sin(angle) / 0.032) ** 2))
    assert 2.0 * np.mean(force * np.sin(angle)) / amplitude == pytest.approx(gain, rel=1e-3)


def test_predictions_beside_cycles(folder: Path) -> None:
    """It foresees a lasting cycle where the simulated one decays, one twice too large and too fast where it lasts, and
    none for the mass, as theory says."""
    table = pd.read_csv(folder / "tables" / "limit_cycles.csv", keep_default_na=False).set_index("case")
    assert table["verdict"].tolist() == ["decaying", *["sustained"] * 4]
    assert table["describing function"].tolist() == [*["predicted"] * 3, "none predicted", "none predicted"]
    assert table.loc["hose_fed_ki_500", "period, error (%)"] == ""
    lasting, mass = table.loc["hose_fed_ki_1000"], table.loc["mass_34_kg_kd_40"]
    for figure, unit in (("peak to peak", "mm"), ("period", "s")):
        predicted, simulated = (float(lasting[f"{figure} ({unit}), {kind}"]) for kind in ("predicted", "simulated"))
        assert float(lasting[f"{figure}, error (%)"]) == pytest.approx(100 * (predicted / simulated - 1), abs=0.15)
        assert mass[f"{figure} ({unit}), predicted"] == mass[f"{figure}, error (%)"] == ""

"""Velocity estimators against analytic responses, noise gains, and the Riccati equation."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from controllers.pid import Settings
from controllers.velocity import (
    Estimator,
    at_rest,
    design_estimator,
    estimate_velocity,
    filtered_differentiator,
    fir_differentiator,
    kalman,
)

H = 1e-3
T_V = 2e-3


def estimates(positions: np.ndarray, estimator: Estimator) -> np.ndarray:
    """Estimates along a record of positions, after a long time at its first value."""
    state = at_rest(float(positions[0]))
    found = np.empty(positions.size)
    for k, position in enumerate(positions):
        found[k], state = estimate_velocity(float(position), state, estimator)
    return found


@pytest.mark.parametrize("time_constant", [0.3e-3, T_V, 30e-3])
def test_differentiator_on_a_ramp_is_the_analytic_rise(time_constant: float) -> None:
    """s/(T s + 1) on x = v t gives v (1 - exp(-t/T)): gain 1, whatever T over h."""
    time, speed = H * np.arange(200), 0.02
    found = estimates(3e-3 + speed * time, filtered_differentiator(time_constant, H))
    assert found == pytest.approx(speed * (1.0 - np.exp(-time / time_constant)), abs=1e-12)


def test_differentiator_lags_by_its_time_constant() -> None:
    """Under constant acceleration a the estimate is a (t - T_v), up to a h^2/(12 T_v) of sampling."""
    time, acceleration = H * np.arange(400), 0.5
    found = estimates(0.5 * acceleration * time**2, filtered_differentiator(T_V, H))
    lag = time - found / acceleration
    assert lag[-1] == pytest.approx(T_V, abs=1.05 * H**2 / (12.0 * T_V))


def test_differentiator_on_a_sine_has_the_first_order_gain_and_phase() -> None:
    """i w/(1 + i w T_v) at 50 Hz, sampled at 100 kHz; h^2/(12 T_v) of extra lag is 1.3e-6 rad."""
    h, w = 1e-5, 2.0 * np.pi * 50.0
    time = h * np.arange(6000)
    found = estimates(np.sin(w * time), filtered_differentiator(T_V, h))
    late = time >= 0.04
    basis = np.column_stack([np.sin(w * time), np.cos(w * time)])[late]
    sine, cosine = np.linalg.lstsq(basis, found[late], rcond=None)[0]
    expected = 1j * w / (1.0 + 1j * w * T_V)
    assert [sine, cosine] == pytest.approx([expected.real, expected.imag], rel=1e-5)


@pytest.mark.parametrize(("sigma", "limit"), [(0.013e-3, 6.5e-3), (0.07e-3, 35e-3)])
def test_noise_gain_of_the_differentiator(sigma: float, limit: float) -> None:
    """White position noise sigma gives sigma (1 - E)/h sqrt(2/(1 + E)), E = exp(-h/T_v).

    For fast sampling that is sigma/T_v: 0.013 mm and 2 ms give 6.5 mm/s, 0.07 mm give 35 mm/s. At 1 kHz it is
    0.88 of that.
    """

    def deviation(sample_time: float) -> float:
        keep = np.exp(-sample_time / T_V)
        return sigma * (1.0 - keep) / sample_time * np.sqrt(2.0 / (1.0 + keep))

    assert deviation(1e-6) == pytest.approx(limit, rel=1e-3)
    assert deviation(H) == pytest.approx(0.878 * limit, rel=1e-3)
    noise = sigma * np.random.default_rng(5).standard_normal(100_000)
    for h in (1e-4, H):
        assert np.std(estimates(noise, filtered_differentiator(T_V, h))) == pytest.approx(deviation(h), rel=0.02)


@pytest.mark.parametrize(("noise", "density"), [(13e-6, 10.0), (70e-6, 1e3), (1e-6, 1e-2)])
def test_kalman_gain_solves_the_riccati_equation(noise: float, density: float) -> None:
    """K = P H'/(H P H' + R) with P from scipy's solver; Q is the integral of a white jerk over a sample."""
    model = np.array([[1.0, H, H * H / 2.0], [0.0, 1.0, H], [0.0, 0.0, 1.0]])
    row = np.array([[1.0, 0.0, 0.0]])
    q = density * np.array(
        [[H**5 / 20.0, H**4 / 8.0, H**3 / 6.0], [H**4 / 8.0, H**3 / 3.0, H**2 / 2.0], [H**3 / 6.0, H**2 / 2.0, H]]
    )
    scale = np.diag([1.0, 1.0 / H, 1.0 / H**2]) * noise  # states of one size, for a well-conditioned solution
    inverse = np.linalg.inv(scale)
    scaled_model, scaled_row = inverse @ model @ scale, row @ scale
    covariance = solve_discrete_are(scaled_model.T, scaled_row.T, inverse @ q @ inverse, np.array([[noise**2]]))
    gain = scale @ covariance @ scaled_row.T / (scaled_row @ covariance @ scaled_row.T + noise**2)
    estimator = kalman(noise, density, H)
    assert [estimator.b1, estimator.b2, estimator.b3] == pytest.approx(gain.ravel(), rel=1e-6)
    assert estimator.d == estimator.b2


def test_kalman_follows_constant_acceleration_without_bias() -> None:
    time = H * np.arange(3000)
    found = estimates(0.01 + 0.02 * time + 0.15 * time**2, kalman(13e-6, 10.0, H))
    late = time > 1.0
    assert found[late] == pytest.approx(0.02 + 0.3 * time[late], abs=1e-9)


def test_kalman_passes_less_noise_than_the_differentiator() -> None:
    """The design's own price: the output variance of the recursion, from its Lyapunov sum."""
    sigma = 13e-6
    estimator = kalman(sigma, 10.0, H)
    transition = np.array(estimator[:9]).reshape(3, 3)
    state, total = np.array(estimator[9:12]), estimator.d**2
    output = np.array(estimator[12:15])
    for _ in range(5000):
        total += (output @ state) ** 2
        state = transition @ state
    found = estimates(sigma * np.random.default_rng(6).standard_normal(50_000), estimator)
    assert np.std(found) == pytest.approx(sigma * np.sqrt(total), rel=0.1)
    assert np.std(found) < 5.7e-3 / 4.0


def test_estimators_are_still_at_rest() -> None:
    for estimator in (filtered_differentiator(T_V, H), kalman(13e-6, 10.0, H)):
        assert estimates(np.full(50, 0.0123), estimator) == pytest.approx(np.zeros(50), abs=1e-12)


def test_design_chooses_by_name() -> None:
    settings = Settings(1.0, velocity="filter", velocity_time_constant=T_V)
    assert design_estimator(settings, H) == filtered_differentiator(T_V, H)
    assert design_estimator(settings._replace(velocity="kalman"), H) == kalman(13e-6, 10.0, H)


@pytest.mark.parametrize(
    ("kind", "name"), [("filter", "velocity_time_constant"), ("kalman", "position_noise"), ("kalman", "jerk_density")]
)
def test_design_names_the_setting_that_does_not_serve(kind: str, name: str) -> None:
    settings = Settings(1.0, velocity=kind, velocity_time_constant=T_V)._replace(**{name: 0.0})
    with pytest.raises(ValueError, match=f"{name} is 0, expected a value above 0"):
        design_estimator(settings, H)


@pytest.mark.parametrize("order", [2, 16, 40])
def test_fir_is_exact_on_quadratics_in_the_interior(order: int) -> None:
    time = H * np.arange(300)
    found = fir_differentiator(0.4 - 0.3 * time + 2.0 * time**2, H, order)
    inner = slice(order // 2, -(order // 2))
    assert found.size == time.size
    assert found[inner] == pytest.approx(-0.3 + 4.0 * time[inner], abs=1e-10)
    assert np.all(found[: order // 2] == found[order // 2])
    assert np.all(found[-(order // 2) :] == found[-(order // 2) - 1])


def test_fir_noise_is_that_of_a_fitted_slope() -> None:
    """The slope of a line through n points h apart has variance 12 sigma^2/(h^2 n (n^2 - 1))."""
    sigma, n = 13e-6, 17
    found = fir_differentiator(sigma * np.random.default_rng(9).standard_normal(200_000), H, n - 1)
    assert np.std(found) == pytest.approx(sigma / H * np.sqrt(12.0 / (n * (n**2 - 1))), rel=0.02)


@pytest.mark.parametrize(("size", "order"), [(100, 15), (100, 0), (16, 16)])
def test_fir_refuses_odd_orders_and_short_records(size: int, order: int) -> None:
    with pytest.raises(ValueError, match=f"order {order}"):
        fir_differentiator(np.zeros(size), H, order)

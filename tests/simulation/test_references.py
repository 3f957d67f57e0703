"""References: derivatives against finite differences for any parameters, periods, dwells, jumps, records."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.simulation.references import Chirp, Multisine, Ramp, Recorded, Sine, Steps, Triangle

STEP = 1e-5
"""s. Central differences err by step^2/6 times the third derivative, and by rounding over the step."""


def number(low: float, high: float) -> Any:
    return st.floats(low, high, allow_nan=False)


def wave(sign: bool = False) -> Any:
    return number(-0.5 if sign else 1e-3, 0.5)


sines = st.builds(Sine, wave(), number(0.05, 5.0), wave(sign=True), number(-7.0, 7.0))
ramps = st.builds(Ramp, wave(sign=True), number(0.0, 1.0), number(1.5, 3.0))
triangles = st.builds(Triangle, wave(), number(0.05, 5.0), wave(sign=True))
multisines = st.builds(
    Multisine,
    wave(),
    number(0.05, 1.0),
    st.lists(st.integers(1, 9), min_size=1, max_size=5, unique=True).map(lambda found: tuple(sorted(found))),
)
chirps = st.builds(Chirp, wave(), number(0.05, 2.0), number(0.05, 5.0), number(0.5, 4.0))
steps = st.builds(
    Steps, st.lists(wave(sign=True), min_size=1, max_size=5).map(tuple), number(0.1, 1.0), number(0.0, 1.0)
)
records = st.builds(
    lambda values: Recorded(np.linspace(0.0, 2.0, len(values)), np.array(values)),
    st.lists(wave(sign=True), min_size=5, max_size=9),
)


def corners(reference: Any) -> np.ndarray:
    """Instants (s) at which the value or the speed jumps."""
    match reference:
        case Ramp(start=start, stop=stop):
            return np.array([start, stop])
        case Triangle(frequency=frequency):
            return (np.arange(-1, 40) * 0.5 + 0.25) / frequency
        case Steps(levels=levels, dwell=dwell, start=start):
            return start + dwell * np.arange(len(levels))
        case Chirp(sweep=sweep):
            return np.array([sweep])
        case Recorded(times=times):
            return times
    return np.array([np.inf])


@given(st.one_of(sines, ramps, triangles, multisines, chirps, steps, records))
@settings(max_examples=200, deadline=None)
def test_derivatives_equal_finite_differences(reference: Any) -> None:
    time = np.linspace(0.01, 3.0, 173)
    distance = np.min(np.abs(time[:, None] - corners(reference)[None, :]), axis=1)
    time = time[distance > 3.0 * STEP]
    before, at, after = (reference(time + shift) for shift in (-STEP, 0.0, STEP))
    for derivative in (1, 2):
        slope = (after[derivative - 1] - before[derivative - 1]) / (2.0 * STEP)
        size = 1.0 + np.max(np.abs(at[derivative]))
        assert at[derivative] == pytest.approx(slope, abs=1e-6 * size)


@given(st.one_of(sines, triangles, multisines))
@settings(max_examples=60, deadline=None)
def test_period_repeats_all_three(reference: Any) -> None:
    time = np.linspace(0.0, 1.0, 57) + 0.0123
    distance = np.min(np.abs(time[:, None] - corners(reference)[None, :]), axis=1)
    time = time[distance > 1e-9]
    for now, later in zip(reference(time), reference(time + reference.period), strict=True):
        assert later == pytest.approx(now, rel=1e-9, abs=1e-9 * (1.0 + np.max(np.abs(now))))


def test_sine_by_hand() -> None:
    """0.03 sin(2 pi 0.9 t) at a quarter period, and its speed 0.1696 m/s at 0."""
    position, velocity, acceleration = Sine(0.03, 0.9)(np.array([0.0, 0.25 / 0.9]))
    assert position == pytest.approx([0.0, 0.03], abs=1e-15)
    assert velocity == pytest.approx([0.169646, 0.0], abs=1e-6)
    assert acceleration == pytest.approx([0.0, -0.959325], abs=1e-6)
    assert Sine(0.03, 0.9).period == pytest.approx(1.111111, abs=1e-6)
    assert Sine(0.03, 0.9).fundamental == 0.9


def test_steps_jump_at_their_own_sample() -> None:
    """k h lies on either side of the jumps in floats (0.3 / 0.1 < 3); each takes the later value at its own sample."""
    time = 1e-3 * np.arange(3001)
    value, velocity, acceleration = Steps((0.01, -0.02, 0.03), dwell=0.7, start=0.3)(time)
    assert list(np.flatnonzero(np.diff(value)) + 1) == [300, 1000, 1700]
    assert list(value[[0, 299, 300, 999, 1000, 1700, 3000]]) == [0.0, 0.0, 0.01, 0.01, -0.02, 0.03, 0.03]
    assert not np.any(velocity)
    assert not np.any(acceleration)
    many = Steps(tuple(map(float, range(20))), dwell=0.1)(time)[0]
    assert list(np.flatnonzero(np.diff(many)) + 1) == list(range(100, 2000, 100))


@given(number(0.011, 0.9), number(0.0, 0.5), st.integers(1, 5))
@settings(max_examples=100, deadline=None)
def test_steps_are_constant_over_their_dwells(dwell: float, start: float, count: int) -> None:
    levels = tuple(float(i + 1) for i in range(count))
    reference = Steps(levels, dwell, start)
    spans = reference.dwells(4.6)
    assert len(spans) == sum(start + i * dwell < 4.6 for i in range(count))
    for level, (begin, end) in zip(levels, spans, strict=False):
        inside = np.linspace(begin + 1e-6, end - 1e-6, 11)
        assert np.all(reference(inside)[0] == level)
    assert spans[-1][1] == 4.6
    assert all(a[1] == b[0] for a, b in pairwise(spans))


def test_steps_beyond_the_end_have_no_dwell() -> None:
    assert Steps((1.0, 2.0, 3.0), 1.0).dwells(1.5) == [(0.0, 1.0), (1.0, 1.5)]


def test_ramp_dwells_before_and_after() -> None:
    reference = Ramp(0.02, start=0.5, stop=2.0)
    assert reference.dwells(3.0) == [(0.0, 0.5), (2.0, 3.0)]
    assert reference.dwells(1.0) == [(0.0, 0.5)]
    assert Ramp(0.02).dwells(1.0) == []
    np.testing.assert_allclose(Ramp(0.02, 0.5, offset=-0.01)(np.array([0.0, 1.5]))[0], [-0.01, 0.01], atol=1e-15)
    position, velocity, _ = reference(np.array([0.25, 0.5, 1.0, 2.0, 9.0]))
    assert position == pytest.approx([0.0, 0.0, 0.01, 0.03, 0.03], abs=1e-15)
    assert list(velocity) == [0.0, 0.02, 0.02, 0.0, 0.0]


def test_triangle_by_hand() -> None:
    """5 mm at 0.1 Hz: 2 mm/s up from 0, turning at 2.5 s and 7.5 s, where the later speed holds."""
    position, velocity, _ = Triangle(5e-3, 0.1)(np.array([0.0, 1.0, 2.5, 5.0, 7.5, 9.0]))
    assert position == pytest.approx([0.0, 2e-3, 5e-3, 0.0, -5e-3, -2e-3], abs=1e-15)
    assert velocity == pytest.approx([2e-3, 2e-3, -2e-3, -2e-3, 2e-3, 2e-3], abs=1e-15)


@given(multisines)
@settings(max_examples=60, deadline=None)
def test_multisine_starts_at_zero_and_reaches_its_amplitude(reference: Multisine) -> None:
    time = np.linspace(0.0, reference.period, 20_001)
    value = reference(time)[0]
    assert value[0] == pytest.approx(0.0, abs=1e-15)
    assert np.max(np.abs(value)) == pytest.approx(reference.amplitude, rel=2e-4)


def test_multisine_holds_its_harmonics_alone() -> None:
    """Equal amplitudes at harmonics 1, 3 and 7, by the discrete Fourier transform, besides a constant."""
    reference = Multisine(0.01, 0.5, (1, 3, 7))
    spectrum = np.abs(np.fft.rfft(reference(2.0 * np.arange(256) / 256)[0])) / 128.0
    present = spectrum[[1, 3, 7]]
    assert present == pytest.approx(np.full(3, present[0]), rel=1e-9)
    assert np.all(np.delete(spectrum, [0, 1, 3, 7]) < 1e-15)


def test_chirp_goes_from_its_start_to_its_end_frequency() -> None:
    """Phase: 2 pi (f0 t + (f1 - f0) t^2 / (2 T)): 10 cycles from 0 to 4 Hz in 5 s, then 4 a second: 17.6 in 6.9 s."""
    reference = Chirp(1.0, 0.0, 4.0, 5.0)
    time = np.linspace(0.0, 6.9, 69_001)
    value, velocity, _ = reference(time)
    rising = np.count_nonzero((value[:-1] < 0.0) & (value[1:] >= 0.0))
    assert rising == 17
    assert velocity[50_000] == pytest.approx(2.0 * np.pi * 4.0, rel=1e-9)
    assert np.max(np.abs(np.diff(value))) < 1.01 * 2.0 * np.pi * 4.0 * 1e-4


def test_record_hits_its_samples() -> None:
    times, values = np.arange(200) * 1e-3, np.random.default_rng(2).normal(size=200)
    reference = Recorded(times, values)
    assert reference(times)[0] == pytest.approx(values, abs=1e-14)
    outside = reference(np.array([-1.0, 5.0]))
    assert outside[0] == pytest.approx([values[0], values[-1]], abs=1e-14)
    assert not np.any(outside[1])
    assert not np.any(outside[2])


def test_record_of_a_sine_gives_its_derivatives() -> None:
    """A cubic spline through samples h apart errs by about w^4 h^4/384 in value, w^3 h^2/12 in curvature."""
    times = np.arange(0.0, 2.0, 1e-2)
    inner = np.linspace(0.5, 1.5, 333)
    expected = Sine(1.0, 1.0)(inner)
    for found, wanted, tolerance in zip(
        Recorded(times, np.sin(2.0 * np.pi * times))(inner), expected, (1e-7, 2e-5, 2e-2), strict=True
    ):
        assert found == pytest.approx(wanted, abs=tolerance)

"""The matrix algebra of the extended Kalman filter, written out in scalars so that it compiles into the loop.

Rows and matrices belong to velocity, load pressure and bristle (v, p, z); position is their integral and stands apart.
"""

from typing import Annotated, NamedTuple

import numpy as np

from plants.equation import Scalar, equation

DOUBLINGS = 10
"""The exponential is a Taylor polynomial over h / 2^10, squared ten times."""

FLOOR = 1e-3
"""Least variance of an estimate, as a share of its process noise of a sample."""


class Covariance(NamedTuple):
    """Covariance of the estimates of position, velocity, load pressure and bristle: the upper triangle."""

    xx: Annotated[float, "m^2"]
    xv: Annotated[float, "m^2/s"]
    xp: Annotated[float, "m Pa"]
    xz: Annotated[float, "m^2"]
    vv: Annotated[float, "m^2/s^2"]
    vp: Annotated[float, "m Pa/s"]
    vz: Annotated[float, "m^2/s"]
    pp: Annotated[float, "Pa^2"]
    pz: Annotated[float, "m Pa"]
    zz: Annotated[float, "m^2"]


class Noise(NamedTuple):
    """Variances a sample: of the two measurements, and of what the model does not know of each state."""

    measured_position: Annotated[float, "m^2"]
    measured_load_pressure: Annotated[float, "Pa^2"]
    position: Annotated[float, "m^2"]
    velocity: Annotated[float, "m^2/s^2"]
    load_pressure: Annotated[float, "Pa^2"]
    bristle: Annotated[float, "m^2"]


class Row(NamedTuple):
    """Three numbers that belong to velocity, load pressure and bristle."""

    v: Scalar
    p: Scalar
    z: Scalar


class Matrix(NamedTuple):
    """3 x 3 over velocity, load pressure and bristle, by rows."""

    v: Row
    p: Row
    z: Row


@equation
def scaled(a: Row, factor: Scalar, b: Row) -> Row:
    """a + factor b."""
    return Row(a.v + factor * b.v, a.p + factor * b.p, a.z + factor * b.z)


@equation
def dot(a: Row, b: Row) -> Scalar:
    return a.v * b.v + a.p * b.p + a.z * b.z


@equation
def row_times(a: Row, m: Matrix) -> Row:
    """a m, for a row a."""
    return Row(
        a.v * m.v.v + a.p * m.p.v + a.z * m.z.v,
        a.v * m.v.p + a.p * m.p.p + a.z * m.z.p,
        a.v * m.v.z + a.p * m.p.z + a.z * m.z.z,
    )


@equation
def times(a: Matrix, b: Matrix) -> Matrix:
    return Matrix(row_times(a.v, b), row_times(a.p, b), row_times(a.z, b))


@equation
def applied(m: Matrix, b: Row) -> Row:
    """m b, for a column b."""
    return Row(dot(m.v, b), dot(m.p, b), dot(m.z, b))


@equation
def one_plus(factor: Scalar, m: Matrix) -> Matrix:
    """1 + factor m."""
    return Matrix(
        scaled(Row(1.0, 0.0, 0.0), factor, m.v),
        scaled(Row(0.0, 1.0, 0.0), factor, m.p),
        scaled(Row(0.0, 0.0, 1.0), factor, m.z),
    )


@equation
def hold(rates: Row, jacobian: Matrix, sample_time: Scalar) -> tuple[Matrix, Row, Row, Scalar]:
    """Exact solution over a sample of d(delta)/dt = J delta + f, and of its first component's integral.

        delta(h) = E delta(0) + d,  integral of delta_v = R delta(0) + r

    Taylor series of order 6 over h / 2^`DOUBLINGS`, then doubled: two halves in a row make d + E d, E^2, R + R E,
    2 r + R d.

    Returns:
        E, d, R, r.
    """
    part = sample_time / 2.0**DOUBLINGS
    series = one_plus(part / 6.0, jacobian)
    series = one_plus(part / 5.0, times(jacobian, series))
    series = one_plus(part / 4.0, times(jacobian, series))
    series = one_plus(part / 3.0, times(jacobian, series))  # 2 phi_2
    mean = one_plus(part / 2.0, times(jacobian, series))  # phi_1
    power = one_plus(part, times(jacobian, mean))
    step = applied(mean, Row(part * rates.v, part * rates.p, part * rates.z))
    travel = Row(part * mean.v.v, part * mean.v.p, part * mean.v.z)
    rest = 0.5 * part**2 * dot(series.v, rates)
    for _ in range(DOUBLINGS):
        rest = 2.0 * rest + dot(travel, step)
        step = scaled(step, 1.0, applied(power, step))
        travel = scaled(travel, 1.0, row_times(travel, power))
        power = times(power, power)
    return power, step, travel, rest


@equation
def form(a: Row, b: Row, c: Covariance) -> Scalar:
    """a C b' with C the covariance of velocity, load pressure and bristle."""
    return (
        a.v * (c.vv * b.v + c.vp * b.p + c.vz * b.z)
        + a.p * (c.vp * b.v + c.pp * b.p + c.pz * b.z)
        + a.z * (c.vz * b.v + c.pz * b.p + c.zz * b.z)
    )


@equation
def predicted_covariance(c: Covariance, e: Matrix, travel: Row, noise: Noise) -> Covariance:
    """F C F' + Q with F the hold's: position 1 and `travel`, the others E. Symmetric since only one half is kept."""
    with_position = Row(c.xv, c.xp, c.xz)
    return Covariance(
        c.xx + 2.0 * dot(travel, with_position) + form(travel, travel, c) + noise.position,
        dot(e.v, with_position) + form(e.v, travel, c),
        dot(e.p, with_position) + form(e.p, travel, c),
        dot(e.z, with_position) + form(e.z, travel, c),
        form(e.v, e.v, c) + noise.velocity,
        form(e.v, e.p, c),
        form(e.v, e.z, c),
        form(e.p, e.p, c) + noise.load_pressure,
        form(e.p, e.z, c),
        form(e.z, e.z, c) + noise.bristle,
    )


class Column(NamedTuple):
    """Four numbers that belong to position, velocity, load pressure and bristle."""

    x: Scalar
    v: Scalar
    p: Scalar
    z: Scalar


@equation
def _joseph(ab: Scalar, a: Scalar, b: Scalar, own: Scalar, gain_a: Scalar, gain_b: Scalar, noise: Scalar) -> Scalar:
    """One element of (1 - K H) C (1 - K H)' + K R K': positive definite for any gain, which C - K H C is not.

    `ab` is the element, `a` and `b` are the covariances with the measured state, `own` is that state's variance.
    """
    return ab - gain_a * b - (a - gain_a * own) * gain_b + gain_a * gain_b * noise


@equation
def corrected(
    mean: Column, c: Covariance, with_measured: Column, own: Scalar, reading: Scalar, estimate: Scalar, noise: Scalar
) -> tuple[Column, Covariance]:
    """Means and covariance after the `reading` of one state, whose variance is `own`. Joseph's form."""
    m, total = with_measured, own + noise
    k = Column(m.x / total, m.v / total, m.p / total, m.z / total)
    off = reading - estimate
    return (
        Column(mean.x + k.x * off, mean.v + k.v * off, mean.p + k.p * off, mean.z + k.z * off),
        Covariance(
            _joseph(c.xx, m.x, m.x, own, k.x, k.x, noise),
            _joseph(c.xv, m.x, m.v, own, k.x, k.v, noise),
            _joseph(c.xp, m.x, m.p, own, k.x, k.p, noise),
            _joseph(c.xz, m.x, m.z, own, k.x, k.z, noise),
            _joseph(c.vv, m.v, m.v, own, k.v, k.v, noise),
            _joseph(c.vp, m.v, m.p, own, k.v, k.p, noise),
            _joseph(c.vz, m.v, m.z, own, k.v, k.z, noise),
            _joseph(c.pp, m.p, m.p, own, k.p, k.p, noise),
            _joseph(c.pz, m.p, m.z, own, k.p, k.z, noise),
            _joseph(c.zz, m.z, m.z, own, k.z, k.z, noise),
        ),
    )


@equation
def floored(c: Covariance, noise: Noise) -> Covariance:
    """The covariance with its diagonal at least `FLOOR` times the process noise: rounding cannot take it to 0."""
    return Covariance(
        *(np.maximum(c.xx, FLOOR * noise.position), c.xv, c.xp, c.xz),
        *(np.maximum(c.vv, FLOOR * noise.velocity), c.vp, c.vz),
        *(np.maximum(c.pp, FLOOR * noise.load_pressure), c.pz),
        np.maximum(c.zz, FLOOR * noise.bristle),
    )

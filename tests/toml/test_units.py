"""Units at the edge: known conversions, and every kind of quantity that is none."""

import math
from typing import Any

import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.toml.units import QuantityError, factor, si


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("2.94 MPa", "Pa", 2.94e6),
        ("1 bar", "Pa", 1e5),
        ("712 psi", "Pa", 4.909067e6),  # 1 psi = 6894.757 Pa
        ("460 rpm", "rad/s", 460.0 * math.pi / 30.0),
        ("8 mm", "m", 8e-3),
        ("-3 um", "m", -3e-6),
        ("12 ms", "s", 0.012),
        ("2318 N s/m", "N s/m", 2318.0),
        ("5.9e-4 m^2/(s Pa^0.5)", "m^2/(s Pa^0.5)", 5.9e-4),
        ("40 l/min", "m^3/s", 40e-3 / 60.0),
        ("0.6685 V/(rad/s)", "V s/rad", 0.6685),
        ("6 deg", "rad", math.pi / 30.0),
        ("5 %", "1", 0.05),
        ("1.5", "1", 1.5),
        (2940000, "Pa", 2.94e6),
    ],
)
def test_quantities(text: Any, unit: str, value: float) -> None:
    assert si(text, unit) == pytest.approx(value, rel=1e-6)


@given(st.floats(-1e6, 1e6))
def test_a_bare_number_is_si(number: float) -> None:
    assert si(number, "m") == number
    assert si(f"{number!r} mm", "m") == pytest.approx(1e-3 * number, rel=1e-12)


REGISTRY = pint.UnitRegistry()


@settings(deadline=None)  # the first quantity makes pint's registry
@given(
    st.floats(-1e9, 1e9, allow_subnormal=False),
    st.sampled_from([("mm", "m"), ("psi", "Pa"), ("rpm", "rad/s"), ("l/min", "m^3/s"), ("%", "1"), ("degC", "K")]),
)
def test_a_quantity_has_every_digit_that_pint_gives_it(number: float, units: tuple[str, str]) -> None:
    """A factor that is kept between runs is pint's; where two scales have other zeros there is none."""
    named, unit = units
    assert si(f"{number!r} {named}", unit) == REGISTRY.Quantity(number, REGISTRY.Unit(named)).to_base_units().magnitude


def test_gains_are_in_units_of_the_command() -> None:
    assert si("500 V/m", "command/m") == 500.0
    assert si("0.5 kN/mm", "command/m", command="N") == pytest.approx(5e5, rel=1e-12)
    with pytest.raises(QuantityError, match='got "500 N/m", expected a quantity in V/m'):
        si("500 N/m", "command/m")
    with pytest.raises(QuantityError, match='got "500 V/m", expected a quantity in N/m'):
        si("500 V/m", "command/m", command="N")


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        ("2.94 kg", "Pa", 'got "2.94 kg", expected a quantity in Pa, such as "1 Pa"'),
        ("8 furlon", "m", 'got "8 furlon", which is not a number with a unit'),
        ("1.5", "m", "without a unit (write a bare number, without quotes, for SI)"),
        ("8 mm", "1", 'got "8 mm", expected a plain number'),
        ("", "m", "which is not a number with a unit"),
        ("fast", "m/s", "which is not a number with a unit"),
        ("2 m)", "m", "which is not a number with a unit"),
        ("20 degC", "Pa", 'got "20 degC"'),
        (math.nan, "Pa", "got NaN"),
        ("nan Pa", "Pa", "got "),
        ("1,5 mm", "m", 'got "1,5 mm"'),  # not 15 mm
        ("1 m; 2", "m", 'got "1 m; 2"'),
        ("mm", "m", 'got "mm"'),
        ("60 rpm", "Hz", 'got "60 rpm", expected a quantity in Hz'),  # not 6.28 Hz
        ("1 Hz", "rad/s", 'got "1 Hz", expected a quantity in rad/s'),  # not 1 rad/s
        (True, "m", "got True"),
        ([1.0], "m", "got [1.0]"),
        (None, "m", "got None"),
    ],
)
def test_what_is_no_quantity(value: Any, unit: str, said: str) -> None:
    with pytest.raises(QuantityError) as caught:
        si(value, unit)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("unit", "shown", "ratio"),
    [("m", "mm", 1e3), ("Pa", "MPa", 1e-6), ("rad/s", "rpm", 30.0 / math.pi), ("1", "1", 1.0), ("1", "%", 100.0)],
)
def test_factor(unit: str, shown: str, ratio: float) -> None:
    assert factor(unit, shown) == pytest.approx(ratio, rel=1e-12)


@pytest.mark.parametrize("shown", ["kg", "furlon"])
def test_factor_refuses_another_dimension(shown: str) -> None:
    with pytest.raises(QuantityError, match=f'"{shown}" is not a unit of what is in m'):
        factor("m", shown)


@pytest.mark.parametrize("value", ["inf", math.inf])
def test_infinity_only_where_it_is_allowed(value: object) -> None:
    assert si(value, "m", infinite=True) == math.inf
    with pytest.raises(QuantityError, match="finite"):
        si(value, "m")

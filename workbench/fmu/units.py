"""Units of an FMU's variables beside those that are expected of them."""

import math
from collections.abc import Mapping

from workbench.fmu.description import Fmu, FmuUnit, FmuVariable
from workbench.toml.units import QuantityError, base_units, si, unit_written

RADIAN = "radian"


def factor_to(fmu: Fmu, variable: FmuVariable, unit: str, said: str | None = None) -> float:
    """What to multiply a value of a variable with to have it in SI `unit`.

    The variable's own unit counts, by the FMU's definition of it or, without one, by its name. Where a mapping has
    `said` a unit, that has to be as large; or, where it measures the same but for the radian, with which FMUs are not
    strict, it counts in the place of the variable's own.

    Raises:
        QuantityError: another dimension or size, a zero elsewhere (degC), or no unit at all.
    """
    own = _own(fmu, variable)
    _, expected = base_units(unit)
    if said is not None:
        scale, meant = base_units(said)
        if own is not None and _without_radian(meant) != _without_radian(own.exponents):
            raise QuantityError(f'"{variable.name}" is in {variable.unit}, which is no {said}')
        if meant != expected:
            raise QuantityError(f'"{said}" is not a unit of what is in {unit}')
        if own is not None and not _is_as_large(own, scale, meant):
            raise QuantityError(f'"{variable.name}" is in {variable.unit}, and not in {said}; leave the unit out')
        return scale
    if own is None and unit != "1":
        raise QuantityError(
            f'"{variable.name}" says no unit, expected {unit}: write {{ variable = "{variable.name}", unit = "..." }}'
        )
    if own is None:
        return 1.0
    if own.exponents != expected:
        called = _meant(own, variable.unit, unit)
        hint = f'; if that is meant, write {{ variable = "{variable.name}", unit = "{called}" }}' if called else ""
        raise QuantityError(f'"{variable.name}" is in {variable.unit or "no unit"}, expected {unit}{hint}')
    if own.offset != 0.0:
        raise QuantityError(f'"{variable.name}" is in {variable.unit}, whose zero is elsewhere; expected {unit}')
    return own.factor


def value_for(fmu: Fmu, variable: FmuVariable, value: float | str) -> float:
    """A quantity, or a number in SI, as a value of a variable in the unit that the FMU gives it.

    Raises:
        QuantityError: no quantity, another dimension, a unit where the variable has none.
    """
    own, named = _own(fmu, variable), unit_written(value)
    if own is None:
        return si(value, "1")
    if isinstance(value, str) and named:
        if _without_radian(base_units(named)[1]) != _without_radian(own.exponents):
            raise QuantityError(f'got "{value}", and "{variable.name}" is in {variable.unit}')
        return (si(value, named) - own.offset) / own.factor
    return (si(value, "1") - own.offset) / own.factor


def _own(fmu: Fmu, variable: FmuVariable) -> FmuUnit | None:
    """The unit of a variable; None where it has none."""
    if not variable.unit:
        return None
    defined = fmu.units.get(variable.unit)
    if defined is not None and not math.isnan(defined.factor):
        return defined
    try:
        return FmuUnit(base_units(variable.unit)[0], 0.0, base_units(variable.unit)[1])
    except QuantityError:
        return None


def _meant(own: FmuUnit, name: str, unit: str) -> str:
    """The unit that a mapping may say for a variable whose own lacks a radian: what it is called by name, or `unit`; ""
    where neither is as large.
    """
    expected = base_units(unit)[1]
    if _without_radian(own.exponents) != _without_radian(expected):
        return ""
    for said in (name, unit):
        try:
            scale, exponents = base_units(said)
        except QuantityError:
            continue
        if exponents == expected and _is_as_large(own, scale, exponents):
            return said
    return ""


def _is_as_large(own: FmuUnit, scale: float, exponents: Mapping[str, float]) -> bool:
    """Whether a unit of that scale is the variable's own, which may count radians, turns or degrees as bare numbers."""
    plain = (1.0,) if own.exponents == exponents else (1.0, 2.0 * math.pi, math.pi / 180.0)
    return own.offset == 0.0 and any(math.isclose(scale, angle * own.factor, rel_tol=1e-4) for angle in plain)


def _without_radian(exponents: Mapping[str, float]) -> dict[str, float]:
    return {name: power for name, power in exponents.items() if name != RADIAN}

"""What a study file may say of machines that may be met: [uncertainty]."""

from typing import Literal

from pydantic import Field, model_validator

from workbench.publish.words import plain_name
from workbench.toml.quantities import Raw
from workbench.toml.reading import Strict

MOST_DRAWS = 1_000_000
"""Machines that may be met."""


class FactorTable(Strict):
    """The range of a factor on a parameter: uniform in the factor, or in its logarithm."""

    min: float = Field(gt=0.0)
    """Smallest factor."""
    max: float = Field(gt=0.0)
    """Largest factor."""
    scale: Literal["log", "linear"] = "linear"
    """Uniform in the factor, or in its logarithm."""

    @model_validator(mode="after")
    def _in_order(self) -> "FactorTable":
        if self.min > self.max:
            raise ValueError(f"min {self.min:g} is above max {self.max:g}")
        return self


class NoiseTable(Strict):
    """The range of a sensor's noise, uniform."""

    min: Raw = 0.0
    """Smallest standard deviation."""
    max: Raw
    """Largest standard deviation."""


class UncertaintyTable(Strict):
    """[uncertainty]: machines that may be met. Each draw is one, the same for whatever is compared."""

    draws: int = Field(0, ge=0, le=MOST_DRAWS)
    """On how many machines `workbench run` simulates every case; 0: on the declared one."""
    friction: float = Field(1.0, ge=0.0)
    """By how many standard deviations of the parameter file each friction parameter is spread."""
    scale: dict[str, FactorTable] = {}
    """Factors on other parameters: mass, supply_pressure, bulk_modulus, ..."""
    noise: dict[str, NoiseTable] = {}
    """Of sensors, by channel."""
    calibration: bool = True
    """Whether offsets and gain errors are bounds, of which a draw has any share, and calibration curves are drawn."""
    seed: int = Field(1, ge=0)
    """Of the draws."""


def drawn_from(table: UncertaintyTable) -> list[str]:
    """From what machines are drawn beside their friction, in words."""
    parts = []
    for name, factor in table.scale.items():
        even = " (evenly in the logarithm)" if factor.scale == "log" else ""
        parts.append(f"{plain_name(name)} times {factor.min:g} to {factor.max:g}{even}")
    return parts + [f"noise of {plain_name(name)} {noise.min} to {noise.max}" for name, noise in table.noise.items()]

"""What a study file may say of machines that may be met: [uncertainty]."""

from typing import Literal

from pydantic import Field, model_validator

from workbench.toml.quantities import Raw
from workbench.toml.reading import Strict

MOST_DRAWS = 1_000_000
"""Machines that may be met."""


class FactorTable(Strict):
    """The range of a factor on a parameter: uniform in the factor, or in its logarithm."""

    min: float = Field(gt=0.0)
    max: float = Field(gt=0.0)
    scale: Literal["log", "linear"] = "linear"

    @model_validator(mode="after")
    def _in_order(self) -> "FactorTable":
        if self.min > self.max:
            raise ValueError(f"min {self.min:g} is above max {self.max:g}")
        return self


class NoiseTable(Strict):
    """The range of a sensor's noise, uniform."""

    min: Raw = 0.0
    max: Raw


class UncertaintyTable(Strict):
    """[uncertainty]: machines that may be met. Each draw is one.

    `friction`: standard deviations of the parameter set by which each friction parameter is spread. `scale`: factors
    on other parameters (mass, supply_pressure, bulk_modulus, ...). `noise`: of sensors, by channel. `calibration`: the
    sensors' offsets and gain errors are bounds, of which a draw has any share of either sign, and it draws the
    curves of their calibration errors. `draws`: on how many machines each case of `workbench run` is simulated.
    """

    draws: int = Field(0, ge=0, le=MOST_DRAWS)
    friction: float = Field(1.0, ge=0.0)
    scale: dict[str, FactorTable] = {}
    noise: dict[str, NoiseTable] = {}
    calibration: bool = True
    seed: int = Field(1, ge=0)

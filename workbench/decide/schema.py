"""What a study file may say of a decision: [decide]."""

import math
from functools import partial
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from workbench.toml.quantities import Metre, MetrePerSecond, Rotation, Second
from workbench.toml.reading import Strict
from workbench.toml.units import si

Watt = Annotated[float, BeforeValidator(partial(si, unit="W"))]

ERRORS = {"rms_error": "rms_error_m", "max_error": "max_error_m"}
"""What may count as the error, and the column of the results that it is."""

PUMP, HYDRAULIC, MOTOR, ROTARY = "supply_power_W", "hydraulic_power_W", "motor_electric_power_W", "rotation_power_W"

REAL_SPEED = "rotation_speed_mean_rpm"

POWERS = {"paid": (PUMP, MOTOR), "electric": (HYDRAULIC, MOTOR), "total": (HYDRAULIC, ROTARY)}
"""What may count as the power: the sum of these columns; a rod that does not rotate has the first alone."""


class DecideTable(Strict):
    """[decide]: an accuracy at a speed, within a power, with a probability; who can do that?

    `machine` names one of [machines] or of their files (default: the study's [plant] as it stands). The motion is a
    sine of that `amplitude` whose frequency follows from its peak speed, f = speed / (2 pi amplitude); `cycles` of its
    periods are simulated and the first is left out. `power_figure`: `paid` is what the pump and the motor's terminals
    take, `electric` has the power at the piston in place of the pump's, `total` is what arrives at the rod. `spread`
    is how many standard deviations of the parameter set friction is spread by; `speeds` and `spreads` are the map's, to
    which those asked for are added. Each controller is run at each of `rpm`; `plain` names those without friction
    compensation.

    `draws` machines serve to look for candidates, `fresh_draws` others to measure those that may be chosen, of each
    kind at most `contenders`. A loop that hunts while a step to `hold_level` is held for `hold_duration` is out
    (default: a quarter of the amplitude). `assumptions` are lines for the page.
    """

    machine: str | None = None
    accuracy: Metre = Field(gt=0.0)
    figure: Literal["rms_error", "max_error"] = "rms_error"
    speed: MetrePerSecond = Field(gt=0.0)
    amplitude: Metre = Field(gt=0.0)
    power: Watt = Field(gt=0.0)
    power_figure: Literal["paid", "electric", "total"] = "paid"
    probability: float = Field(0.9, gt=0.0, lt=1.0)
    spread: float = Field(1.0, ge=0.0)
    draws: int = Field(24, ge=2)
    fresh_draws: int = Field(200, ge=2)
    contenders: int = Field(3, ge=1)
    hold_level: Metre | None = Field(None, gt=0.0)
    hold_duration: Second = Field(10.0, gt=0.0)
    speeds: list[Annotated[MetrePerSecond, Field(gt=0.0)]] | None = Field(None, min_length=1)
    spreads: list[Annotated[float, Field(ge=0.0)]] | None = Field(None, min_length=1)
    rpm: list[Rotation] = Field(min_length=1)
    controllers: list[str] | None = Field(None, min_length=1)
    plain: list[str] = Field(min_length=1)
    cycles: int = Field(2, ge=2)
    assumptions: list[str] = []

    @model_validator(mode="after")
    def _each_once(self) -> "DecideTable":
        for name in ("speeds", "spreads", "rpm", "controllers"):
            values = getattr(self, name) or []
            if len(set(values)) < len(values):
                raise ValueError(f"{name} holds a value twice")
        return self

    def period(self, speed: float) -> float:
        """The period (s) of the sine whose peak speed (m/s) that is."""
        return 2.0 * math.pi * self.amplitude / speed

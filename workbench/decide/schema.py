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

    The motion is a sine whose frequency follows from its peak speed, f = speed / (2 pi amplitude). `power_figure`:
    `paid` is what the pump and the motor's terminals take, `electric` has the power at the piston in place of the
    pump's, `total` is what arrives at the rod. To `speeds` and `spreads` those asked for are added. A loop that hunts
    while the step is held is out.
    """

    machine: str | None = None
    """One of [machines] or of their files; by default [plant] as it stands."""
    accuracy: Metre = Field(gt=0.0)
    """Largest error that is allowed."""
    figure: Literal["rms_error", "max_error"] = "rms_error"
    """Which error counts."""
    speed: MetrePerSecond = Field(gt=0.0)
    """Peak speed of the sine."""
    amplitude: Metre = Field(gt=0.0)
    """Of the sine."""
    power: Watt = Field(gt=0.0)
    """Largest mean power of a run."""
    power_figure: Literal["paid", "electric", "total"] = "paid"
    """Which power counts."""
    probability: float = Field(0.9, gt=0.0, lt=1.0)
    """With which accuracy and power have to be kept."""
    spread: float = Field(1.0, ge=0.0)
    """Of friction, in standard deviations of the parameter file."""
    draws: int = Field(24, ge=2)
    """Machines on which candidates are looked for."""
    fresh_draws: int = Field(200, ge=2)
    """Other machines, on which those that may be chosen are measured."""
    contenders: int = Field(3, ge=1)
    """How many of each kind are measured at most."""
    hold_level: Metre | None = Field(None, gt=0.0)
    """Of the step that is held to see whether a loop hunts; by default a quarter of the amplitude."""
    hold_duration: Second = Field(10.0, gt=0.0)
    """For how long."""
    speeds: list[Annotated[MetrePerSecond, Field(gt=0.0)]] | None = Field(None, min_length=1)
    """Of the map."""
    spreads: list[Annotated[float, Field(ge=0.0)]] | None = Field(None, min_length=1)
    """Of the map."""
    rpm: list[Rotation] = Field(min_length=1)
    """Speeds of rotation at which every controller is a candidate."""
    controllers: list[str] | None = Field(None, min_length=1)
    """The candidates; by default all."""
    plain: list[str] = Field(min_length=1)
    """Those without friction compensation."""
    cycles: int = Field(2, ge=2)
    """Periods that are simulated; the first is left out."""
    assumptions: list[str] = []
    """Lines for the page."""

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

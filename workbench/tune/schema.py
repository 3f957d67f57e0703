"""What a study file may say of tuning: [tune]."""

from typing import Any, Literal

from pydantic import Field, model_validator

from workbench.errors import UserError, nearest
from workbench.study.study import Study
from workbench.toml.quantities import Length, MetrePerSecond, Raw, Rotation, Second, Speed
from workbench.toml.reading import Strict

METRICS = {
    "rms_error": "rms_error_m",
    "max_error": "max_error_m",
    "steady_state_error": "steady_state_error_m",
    "phase_lag": "phase_lag_deg",
    "power": "total_power_W",
    "electric_power": "motor_electric_power_W",
    "jerk": "jerk_rms_m_per_s3",
}
"""What an objective may weigh, and the column of the results that it is."""


class WeightsTable(Strict):
    """[tune.objective]: weights of metrics, each taken over that of the reference controller in the same case."""

    rms_error: float = Field(0.0, ge=0.0)
    max_error: float = Field(0.0, ge=0.0)
    steady_state_error: float = Field(0.0, ge=0.0)
    phase_lag: float = Field(0.0, ge=0.0)
    power: float = Field(0.0, ge=0.0)
    electric_power: float = Field(0.0, ge=0.0)
    jerk: float = Field(0.0, ge=0.0)

    @model_validator(mode="after")
    def _weighs_something(self) -> "WeightsTable":
        if not self.used:
            raise ValueError(f"all weights are 0; give at least one of {', '.join(METRICS)} a weight, such as 1")
        return self

    @property
    def used(self) -> dict[str, float]:
        """The weights that are not 0, by the column of the results."""
        return {METRICS[name]: weight for name, weight in self.model_dump().items() if weight}


class ConstraintsTable(Strict):
    """[tune.constraints]: what gains must keep to be returned.

    `saturated` is the largest share of time at the command's limit. Margins are those of the loop linearised while it
    slides at the largest speed of each reference, or at `margin_speed`. `limit_cycle`: none is sustained while the
    reference rests; where no reference does, at a step to `hold_level` that is held for `hold_duration`.
    """

    limit_cycle: bool = True
    saturated: float = Field(0.05, ge=0.0, le=1.0)
    gain_margin_dB: float = Field(6.0, ge=0.0)  # noqa: N815 - the unit's own spelling
    phase_margin_deg: float = Field(45.0, ge=0.0, lt=180.0)
    margin_speed: Speed | None = Field(None, gt=0.0)
    hold_level: Length | None = Field(None, gt=0.0)
    hold_duration: Second = Field(10.0, gt=0.0)


class BoundTable(Strict):
    """The range of one tuned number; what is left out is as documented with the controller."""

    min: Raw | None = None
    max: Raw | None = None
    scale: Literal["log", "linear"] | None = None


class RotationBound(Strict):
    """The range of a tuned speed of rotation."""

    min: Rotation
    max: Rotation

    @model_validator(mode="after")
    def _in_order(self) -> "RotationBound":
        if not self.min < self.max:
            raise ValueError(f"min {self.min:g} rad/s is not below max {self.max:g} rad/s")
        return self


class SpeedBound(Strict):
    """The range of a tuned threshold of a scheduled rotation."""

    min: MetrePerSecond = Field(gt=0.0)
    max: MetrePerSecond = Field(gt=0.0)

    @model_validator(mode="after")
    def _in_order(self) -> "SpeedBound":
        if not self.min < self.max:
            raise ValueError(f"min {self.min:g} m/s is not below max {self.max:g} m/s")
        return self


class RotationTable(Strict):
    """[tune.rotation]: the speed of rotation, or the threshold of a scheduled one, tuned beside the gains."""

    rpm: RotationBound | None = None
    minimum_helical_speed: SpeedBound | None = None

    @model_validator(mode="after")
    def _one(self) -> "RotationTable":
        if (self.rpm is None) == (self.minimum_helical_speed is None):
            raise ValueError("expected either rpm or minimum_helical_speed, with min and max")
        return self


class TuneTable(Strict):
    """[tune]: how gains are found; the same for every controller.

    `where` chooses the cases that count, `yardstick` is the reference controller, whose metrics with the gains of the
    study are the unit of the objective (default: the study's first). Under `gains` each controller may have the
    numbers that are tuned; otherwise all that its type documents a range for and that are not 0. Each combination of
    values on the axes that `per` names has a tuning of its own. `trials` are those of each of `seeds` searches, whose
    seeds are `seed` and those after it.
    """

    objective: WeightsTable
    constraints: ConstraintsTable = ConstraintsTable()
    where: dict[str, Any] = {}
    yardstick: str | None = None
    per: list[Literal["machine", "rpm"]] = []
    trials: int = Field(80, ge=1)
    seed: int = Field(1, ge=0)
    seeds: int = Field(3, ge=1)
    draws: int = Field(0, ge=0)
    quantile: float = Field(0.9, gt=0.0, lt=1.0)
    fresh_draws: int = Field(200, ge=0)
    rotation: RotationTable | None = None
    gains: dict[str, dict[str, BoundTable]] = {}

    @model_validator(mode="after")
    def _one_speed(self) -> "TuneTable":
        if self.rotation is not None and self.rotation.rpm is not None and "rpm" in self.per:
            raise ValueError("rpm is tuned itself ([tune.rotation]): it cannot be among per")
        return self


def tune_table(study: Study) -> TuneTable:
    """The [tune] of a study.

    Raises:
        UserError: it has none.
    """
    table = study.section(TuneTable)
    if table is None:
        raise UserError(
            f"{study.path}: has no [tune]; expected at least [tune.objective] with a weight, such as rms_error = 1"
        )
    return table


def reference_controller(study: Study) -> str:
    """The name of the controller whose metrics, with the gains of the study, are the unit of the objective.

    Raises:
        UserError: no [tune], or no such controller.
    """
    table, known = tune_table(study), study.file.controllers
    name = table.yardstick or next(iter(known))
    if name not in known:
        raise study.error(("tune", "yardstick"), f'unknown controller "{name}"; {nearest(name, known)}')
    return name

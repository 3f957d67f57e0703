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
    """Of `rms_error_m`."""
    max_error: float = Field(0.0, ge=0.0)
    """Of `max_error_m`."""
    steady_state_error: float = Field(0.0, ge=0.0)
    """Of `steady_state_error_m`."""
    phase_lag: float = Field(0.0, ge=0.0)
    """Of `phase_lag_deg`."""
    power: float = Field(0.0, ge=0.0)
    """Of `total_power_W`."""
    electric_power: float = Field(0.0, ge=0.0)
    """Of `motor_electric_power_W`."""
    jerk: float = Field(0.0, ge=0.0)
    """Of `jerk_rms_m_per_s3`."""

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

    Margins are those of the loop linearised while it slides. Limit cycles are looked for while the reference rests;
    where no reference does, at a step that is held.
    """

    limit_cycle: bool = True
    """Whether one that is sustained is forbidden."""
    saturated: float = Field(0.05, ge=0.0, le=1.0)
    """Largest share of time at the command's limit."""
    gain_margin_dB: float = Field(6.0, ge=0.0)  # noqa: N815 - the unit's own spelling
    """Smallest gain margin; 0: any."""
    phase_margin_deg: float = Field(45.0, ge=0.0, lt=180.0)
    """Smallest phase margin; 0: any."""
    margin_speed: Speed | None = Field(None, gt=0.0)
    """At which the loop is linearised; by default the reference's largest."""
    hold_level: Length | None = Field(None, gt=0.0)
    """Of the step that is held; by default a quarter of the largest level."""
    hold_duration: Second = Field(10.0, gt=0.0)
    """For how long."""


class BoundTable(Strict):
    """The range of one tuned number; what is left out is as documented with the controller."""

    min: Raw | None = None
    """Lower end of the range."""
    max: Raw | None = None
    """Upper end of the range."""
    scale: Literal["log", "linear"] | None = None
    """Whether its logarithm is searched."""


class RotationBound(Strict):
    """The range of a tuned speed of rotation."""

    min: Rotation
    """Slowest rotation."""
    max: Rotation
    """Fastest rotation."""

    @model_validator(mode="after")
    def _in_order(self) -> "RotationBound":
        if not self.min < self.max:
            raise ValueError(f"min {self.min:g} rad/s is not below max {self.max:g} rad/s")
        return self


class SpeedBound(Strict):
    """The range of a tuned threshold of a scheduled rotation."""

    min: MetrePerSecond = Field(gt=0.0)
    """Lowest threshold."""
    max: MetrePerSecond = Field(gt=0.0)
    """Highest threshold."""

    @model_validator(mode="after")
    def _in_order(self) -> "SpeedBound":
        if not self.min < self.max:
            raise ValueError(f"min {self.min:g} m/s is not below max {self.max:g} m/s")
        return self


class RotationTable(Strict):
    """[tune.rotation]: the speed of rotation, or the threshold of a scheduled one, tuned beside the gains."""

    rpm: RotationBound | None = None
    """Range of the speed of rotation."""
    minimum_helical_speed: SpeedBound | None = None
    """Range of the threshold of a scheduled one, on a logarithmic scale."""

    @model_validator(mode="after")
    def _one(self) -> "RotationTable":
        if (self.rpm is None) == (self.minimum_helical_speed is None):
            raise ValueError("expected either rpm or minimum_helical_speed, with min and max")
        return self


class TuneTable(Strict):
    """[tune]: how gains are found; the same for every controller."""

    objective: WeightsTable
    """Weights of what is made small."""
    constraints: ConstraintsTable = ConstraintsTable()
    """What gains must keep."""
    where: dict[str, Any] = {}
    """Values of axes that choose the cases that count."""
    yardstick: str | None = None
    """The controller whose figures are the unit of the objective; by default the first."""
    per: list[Literal["machine", "rpm"]] = []
    """Axes of which each combination has a tuning of its own."""
    trials: int = Field(80, ge=1)
    """Of each search."""
    seed: int = Field(1, ge=0)
    """Of the first search."""
    seeds: int = Field(3, ge=1)
    """How many searches there are of each controller."""
    draws: int = Field(0, ge=0)
    """Machines on which a trial is judged; 0: the declared one."""
    quantile: float = Field(0.9, gt=0.0, lt=1.0)
    """Of the objective over the draws."""
    fresh_draws: int = Field(200, ge=0)
    """Machines on which the result is run again."""
    rotation: RotationTable | None = None
    """Rotation tuned beside the gains."""
    gains: dict[str, dict[str, BoundTable]] = {}
    """By controller: what is tuned, and where it is searched; by default all that has a range and is not 0."""

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

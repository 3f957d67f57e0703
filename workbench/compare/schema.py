"""What a study file may say of a comparison: [comparison]."""

from pydantic import Field, model_validator

from workbench.toml.quantities import Metre, NewtonMetre
from workbench.toml.reading import Strict


class ComparisonTable(Strict):
    """[comparison]: make a page that compares compensation with rotation out of the results.

    `plain` names the controllers without friction compensation, whose rotated cases are the avoidance; `pressure` those
    that compensate by the measured load pressure, without a friction model; all others have a friction model. `steps`
    are the references that are judged by the largest error at the end of a dwell; what hunts in them never wins.
    Errors that differ by less than `negligible` are level. `probability` is that of the intervals of one scenario and
    reference together. The best of each class are measured again on `fresh_draws` plant samples that no choice has
    seen, and those behind them where they hunt there.
    `nominal_torque` (N m) is what the motor may deliver for good. `before` has for controllers with tuned gains the
    name of the one with the gains before: the page is of the tuned ones, and says which conclusions are others.
    `left_out` says what the study does not hold.
    """

    plain: list[str] = Field(min_length=1)
    pressure: list[str] = []
    steps: list[str] = []
    before: dict[str, str] = {}
    negligible: Metre = Field(1e-6, gt=0.0)
    probability: float = Field(0.95, gt=0.5, lt=1.0)
    fresh_draws: int = Field(0, ge=0)
    nominal_torque: NewtonMetre = Field(8.0, gt=0.0)
    left_out: list[str] = []
    assumptions: list[str] = []

    @model_validator(mode="after")
    def _families_apart(self) -> "ComparisonTable":
        if both := set(self.plain) & set(self.pressure):
            raise ValueError(f"{', '.join(sorted(both))}: in plain and in pressure; expected one of them")
        if self.fresh_draws == 1:
            raise ValueError("fresh_draws = 1 gives no interval; expected 0 (none) or at least 2, such as 20")
        return self

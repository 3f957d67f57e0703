"""What a study file may say of a comparison: [comparison]."""

from pydantic import Field, model_validator

from workbench.toml.quantities import Metre, NewtonMetre
from workbench.toml.reading import Strict


class ComparisonTable(Strict):
    """[comparison]: make a page that compares compensation with rotation out of the results."""

    plain: list[str] = Field(min_length=1)
    """Controllers without friction compensation; rotated, they are the avoidance."""
    pressure: list[str] = []
    """Controllers that compensate by the measured load pressure; all others have a friction model."""
    steps: list[str] = []
    """References judged by the largest error at the end of a dwell; what hunts in them never wins."""
    before: dict[str, str] = {}
    """By tuned controller the one with the gains before: the page says which verdicts would be others with those."""
    negligible: Metre = Field(1e-6, gt=0.0)
    """Difference of errors that does not count."""
    probability: float = Field(0.95, gt=0.5, lt=1.0)
    """Of the intervals that one verdict rests on, together."""
    fresh_draws: int = Field(0, ge=0)
    """Draws on which the best of each class are measured again, and those behind them where they hunt; 0: none."""
    nominal_torque: NewtonMetre = Field(8.0, gt=0.0)
    """What the motor may deliver for good; more is told."""
    left_out: list[str] = []
    """Lines for the page: what the study does not hold."""
    assumptions: list[str] = []
    """Lines for the page."""

    @model_validator(mode="after")
    def _families_apart(self) -> "ComparisonTable":
        if both := set(self.plain) & set(self.pressure):
            raise ValueError(f"{', '.join(sorted(both))}: in plain and in pressure; expected one of them")
        if self.fresh_draws == 1:
            raise ValueError("fresh_draws = 1 gives no interval; expected 0 (none) or at least 2, such as 20")
        return self

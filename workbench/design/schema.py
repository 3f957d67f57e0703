"""[design] of an experiment file: what a motion is for, and what the rig allows."""

from typing import Any, Literal

from pydantic import Field

from workbench.toml.quantities import Raw, Rotation, Second
from workbench.toml.reading import Strict


class LimitsTable(Strict):
    """[design.limits]: a rig must not exceed them. `low` and `high` are positions, `speed` that of the mass, pressures
    those of either chamber, `command` the size of what the controller gives.
    """

    low: Raw | None = None
    high: Raw | None = None
    speed: Raw | None = None
    least_pressure: Raw | None = None
    most_pressure: Raw | None = None
    command: Raw | None = None


class DesignTable(Strict):
    """[design]: hypotheses `between` which a motion decides (names of effects, or "none"), or parameters that it is to
    `identify`; the `sizes` of the effects' parameters where they are known; how long it may last.

    The loop is closed by a `controller`, as a study has one, or open. Each piece is run at one of the speeds `rpm`, and
    under one of the `loads` beside what is declared. `noise` is the standard deviation of a sample of each channel,
    taken every `sample_time`, by default that of the experiment's records.
    """

    between: list[str] = []
    identify: list[str] = []
    sizes: dict[str, Raw] = {}
    duration: Second = Field(60.0, gt=0.0)
    loop: Literal["closed", "open"] = "closed"
    controller: dict[str, Any] | None = None
    rpm: list[Rotation] = Field([0.0], min_length=1)
    loads: list[Raw] = Field([0.0], min_length=1)
    limits: LimitsTable = LimitsTable()
    noise: dict[str, Raw] = {}
    sample_time: Second | None = Field(None, gt=0.0)

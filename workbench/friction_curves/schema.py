"""What a study file may say of measured friction curves: [friction_curves]."""

from pydantic import Field

from workbench.toml.quantities import MetrePerSecond
from workbench.toml.reading import Strict


class FrictionCurvesTable(Strict):
    """[friction_curves]: hold the bristle laws against measured friction-velocity curves of a rotating rod.

    `measured` is a file of static parameters, `parameters` what the laws know; effects are fitted at `fit_rpm` and
    checked at `check_rpm`; power is told at `speed`. `reference_slope` has, by rpm, the slope that rotation adds at v
    = 0 and by regression.
    """

    measured: str
    parameters: str
    fit_rpm: list[float] = Field(min_length=1)
    check_rpm: list[float] = Field(min_length=1)
    speed: MetrePerSecond
    reference_slope: dict[str, tuple[float, float]] = {}

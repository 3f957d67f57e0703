"""What a study file may say of measured friction curves: [friction_curves]."""

from pydantic import Field

from workbench.toml.quantities import MetrePerSecond
from workbench.toml.reading import Strict


class FrictionCurvesTable(Strict):
    """[friction_curves]: hold the bristle laws against measured friction-velocity curves of a rotating rod."""

    measured: str
    """A file of static parameters by rpm and direction."""
    parameters: str
    """The set from which the laws predict every curve."""
    fit_rpm: list[float] = Field(min_length=1)
    """Speeds of rotation at which what the anisotropic law may lack is fitted."""
    check_rpm: list[float] = Field(min_length=1)
    """Speeds at which it is checked."""
    speed: MetrePerSecond
    """At which power is told."""
    reference_slope: dict[str, tuple[float, float]] = {}
    """By rpm: the slope that rotation adds at v = 0, and by regression."""

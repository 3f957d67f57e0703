"""The filters by which a plant is simulated beside records that show with noise what drives it."""

from collections.abc import Sequence
from dataclasses import replace

from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.beside import doubt_of, kept_beside
from workbench.diagnose.simulation.shooting import Shooting


def filtered(how: Shooting, motions: Sequence[Motion], values: Values, doubt: float = 1.0) -> Shooting:
    """The same with filters that know a plant with `values`, where such keep it beside its records, and `doubt` its
    force.
    """
    if not how.is_beside:
        return how
    setups = {
        motion.record: kept_beside(how.setups[motion.record], how.along, motion, values, doubt) for motion in motions
    }
    return replace(how, setups=setups)


def least_doubt(how: Shooting, motions: Sequence[Motion], values: Values) -> float:
    """That of filters with which a plant with `values` stays beside all of its records."""
    return max(doubt_of(how.setups[motion.record], how.along, motion, values) for motion in motions)

"""The filters by which a plant is simulated beside records, which know the contact as it goes.

A filter is linearised along a motion. The first goes along the smoothed one; the plant that it keeps beside the record
shows how the contact went, and the next is linearised along that (iterated: Jazwinski 1970, section 8.3).
"""

from collections.abc import Sequence
from dataclasses import replace

from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.beside import kept_beside
from workbench.diagnose.simulation.shooting import Shooting
from workbench.records.reading import Record
from workbench.simulation.setup import Setup

LINEARISED = 2
"""Times that a filter is found along the run that the one before led."""


def filtered(how: Shooting, motions: Sequence[Motion], values: Values) -> Shooting:
    """The same with filters that know a plant with `values`, where such keep it beside its records."""
    if not how.is_beside:
        return how
    setups = dict[Record, Setup]()
    for motion in motions:
        known = how.along, motion, values
        setups[motion.record] = kept_beside(how.setups[motion.record], *known)
        for _ in range(LINEARISED):
            ((_, run),) = replace(how, setups=setups).runs(motion, values)
            if run.diverged:
                break
            setups[motion.record] = kept_beside(setups[motion.record], *known, run)
    return replace(how, setups=setups)


def filtered_as(how: Shooting, other: Shooting) -> Shooting:
    """The same with the filters by which another way to simulate keeps the plant beside its records, if it does."""
    if not how.is_beside:
        return how
    setups = {
        record: replace(setup, loop=other.setups[record].loop, reference=other.setups[record].reference)
        for record, setup in how.setups.items()
    }
    return replace(how, setups=setups)

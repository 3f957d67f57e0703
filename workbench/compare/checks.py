"""What [comparison] asks of a study, checked before it runs: axes, draws, names, and two sides that can be compared."""

from collections.abc import Iterator

from plants.axis import LINEAR
from workbench.compare.schema import ComparisonTable
from workbench.simulation.references import Steps
from workbench.study.sections import Checked
from workbench.study.study import Study, check_name, named
from workbench.toml.reading import Key

AXES = ("reference", "controller", "rpm")
"""Those by which a comparison tells its candidates and motions apart."""


def check_comparison(table: ComparisonTable, checked: Checked) -> None:
    """Raise UserError for the first thing in [comparison] that the study's cases do not have."""
    study, cases = checked.study, checked.cases
    for item in checked.resolved[:1]:
        if item.setup.plant.axis != LINEAR:
            message = f"asks whether to rotate a rod, and {item.setup.plant.name} has none; ask by [[tables]]"
            raise study.error(("comparison",), message)
    for axis in AXES:
        if axis not in checked.axes:
            raise study.error(("comparison",), f'needs an axis "{axis}"; give it one under [axes], however short')
    if table.fresh_draws and (study.file.uncertainty is None or not study.file.uncertainty.draws):
        message = "needs draws from which the best are chosen; give [uncertainty] draws, or leave it out"
        raise study.error(("comparison", "fresh_draws"), message)
    known = {kind: dict.fromkeys(named(case, kind) for case in cases) for kind in ("controller", "reference")}
    for family in ("plain", "pressure"):
        for i, name in enumerate(getattr(table, family)):
            check_name(study, ("comparison", family, i), "controller", name, known["controller"])
    for i, name in enumerate(table.steps):
        check_name(study, ("comparison", "steps", i), "reference", name, known["reference"])
    _check_steps(table, checked)
    for pair in table.before.items():
        for name in pair:
            check_name(study, ("comparison", "before", pair[0]), "controller", name, known["controller"])


def _check_steps(table: ComparisonTable, checked: Checked) -> None:
    """What holds still is judged by where it stops, what moves by the whole way: neither by the other's error."""
    study = checked.study
    for case, item in zip(checked.cases, checked.resolved, strict=True):
        name, reference = named(case, "reference"), item.setup.reference
        if isinstance(reference, Steps) and name not in table.steps:
            raise study.error(("comparison", "steps"), f'"{name}" holds still between its steps; add it')
        if name in table.steps and (reference is None or not reference.dwells(item.setup.duration)):
            raise study.error(("comparison", "steps"), f'"{name}" does not hold still; leave it out')


WITHOUT_MODEL = ("load_pressure", "uncompensated")
"""Types of compensators that have none."""


def one_sided(table: ComparisonTable, checked: Checked) -> Iterator[str]:
    """What of a comparison's answer would come from a side that it lacks, in words."""
    study = checked.study
    rpms = {case.rpm for case in checked.cases}
    names = [named(case, "controller") for case in checked.cases]
    plain = [item.settings for name, item in zip(names, checked.resolved, strict=True) if name in table.plain]
    if 0.0 not in rpms or len(rpms) < 2:
        yield _told(study, ("comparison",), "has no case at rest beside one that turns: no field will have a verdict")
    if len(plain) == len(names):
        yield _told(study, ("comparison",), "has no controller that compensates: no field will have a verdict")
    elif plain and not any(getattr(settings, "feedforward", 0.0) for settings in plain):
        message = (
            "none has a feed-forward, and compensators have one: a margin of theirs may be the feed-forward's; add a "
            "PID with feedforward = 1"
        )
        yield _told(study, ("comparison", "plain"), message)


def misplaced(table: ComparisonTable, checked: Checked) -> Iterator[str]:
    """Which controllers without a friction model the page would call ones with one, in words."""
    study, cases = checked.study, checked.cases
    for name in dict.fromkeys(named(case, "controller") for case in cases):
        kind = next(case.tables["controllers"][name].get("type") for case in cases if named(case, "controller") == name)
        if kind in WITHOUT_MODEL and name not in (*table.plain, *table.pressure):
            message = f'"{name}" is of type "{kind}", which has no friction model; add it to pressure = [...]'
            yield _told(study, ("comparison",), message)


def _told(study: Study, key: Key, message: str) -> str:
    return str(study.error(key, message))

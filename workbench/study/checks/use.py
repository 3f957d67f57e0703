"""Whether every setting of a study is of use: whatever changes nothing in any case misleads."""

from collections.abc import Mapping, Sequence

from workbench.study.checks.settings import controller_settings, plant_settings
from workbench.study.layers import MACHINE
from workbench.study.resolve import Resolved
from workbench.study.study import Case, Study, located
from workbench.toml.reading import Key


def check_use(study: Study, cases: Sequence[Case], resolved: Sequence[Resolved]) -> None:
    """Raise UserError for a setting of plant or controller that changes nothing in any of these cases.

    What a machine says is no mistake: it is whole, whichever of its plants a study asks for.
    """
    without: dict[Key, tuple[Case, str]] = {}
    used: set[Key] = set()
    for case, item in zip(cases, resolved, strict=True):
        for key, message in {**plant_settings(case, item), **controller_settings(case, item)}.items():
            if message:
                without.setdefault(key, (case, message))
            else:
                used.add(key)
    for key, (case, message) in without.items():
        if key not in used and not _of_machine(study, case, key):
            raise located(study, case, key, message)


def _of_machine(study: Study, case: Case, key: Key) -> bool:
    """Whether the machine of a case says this."""
    table: object = study.file.machines.get(str(case.axes.get(MACHINE.axis)), {})
    for part in key:
        if not isinstance(table, Mapping) or part not in table:
            return False
        table = table[str(part)]
    return True

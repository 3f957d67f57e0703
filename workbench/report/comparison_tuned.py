"""What tuning changes in a comparison: the same cases with the gains before, and which conclusions are others then."""

import pandas as pd

from workbench.report.comparison import plain_name, verdicts
from workbench.study.report_schema import ComparisonTable


def of_tuned(spec: ComparisonTable, frame: pd.DataFrame) -> pd.DataFrame:
    """The results without controllers whose gains are those before."""
    return frame[~frame["controller"].isin(list(spec.before.values()))]


def changes(spec: ComparisonTable, frame: pd.DataFrame) -> list[str]:
    """In words, how many conclusions tuning changes and which; nothing where a study names no gains before."""
    if not spec.before:
        return []
    names = {old: new for new, old in spec.before.items()}
    old = frame[frame["controller"].isin(list(names))]
    old = old.assign(controller=old["controller"].map(names))
    before, after = verdicts(spec, old), verdicts(spec, of_tuned(spec, frame))
    changed = [key for key, verdict in after.items() if key in before and before[key].kind != verdict.kind]
    if not changed:
        return [f"No conclusion changes: {len(after)} of {len(after)} are the same."]
    return [
        f"{len(changed)} of {len(after)} conclusions are others with tuned gains than with those before.",
        *(_change(key, before[key].words, after[key].words) for key in changed),
    ]


def _change(key: tuple[str, str], before: str, after: str) -> str:
    scenario, reference = map(plain_name, key)
    return f"{scenario.capitalize()}, {reference}. Before: {before} Tuned: {after}"

"""What changes the verdicts: tuning, the machine, the draws. Like is held against like: the draws that all have met."""

from collections.abc import Mapping

import pandas as pd

from workbench.compare.candidates import Cell, of_tuned, with_all_axes
from workbench.compare.overview import cell_name
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import Verdict, verdicts


def changes(spec: ComparisonTable, frame: pd.DataFrame, found: Mapping[Cell, Verdict]) -> list[str]:
    """In words, which verdicts would be others with the gains before, with one draw, or without fresh draws."""
    frame = with_all_axes(frame)
    searched = verdicts(spec, frame)
    lines = []
    if spec.before:
        names = {old: new for new, old in spec.before.items()}
        old = frame[frame["controller"].isin(list(names))]
        old = old.assign(controller=old["controller"].map(names))
        alone = of_tuned(spec, frame)
        alone = alone[alone["controller"].isin(list(spec.before))]
        lines.append(_told("With the gains before tuning", verdicts(spec, old), verdicts(spec, alone)))
    draws = sorted(frame["draw"].unique())
    if len(draws) > 1:
        first = verdicts(spec, frame[frame["draw"] == draws[0]])
        condition = f"With draw {draws[0]} alone in place of all of the choice, taken at its word"
        lines.append(_told(condition, first, searched))
    if any(verdict.fresh for verdict in found.values()):
        lines.append(_told("With the draws from which the best were chosen", searched, found))
    return lines


def _told(condition: str, other: Mapping[Cell, Verdict], now: Mapping[Cell, Verdict]) -> str:
    common = [cell for cell in now if cell in other]
    apart = [cell for cell in common if other[cell].kind != now[cell].kind]
    if not apart:
        return f"{condition}, 0 of {len(common)} verdicts would be others."
    told = "; ".join(f"{cell_name(cell, True)} ({other[cell].kind} in place of {now[cell].kind})" for cell in apart)
    return f"{condition}, {len(apart)} of {len(common)} verdicts would be others: {told}."

"""The figures of a run as a table, beside those of the pinned one."""

import math
from html import escape

from workbench.bench.outcome import Outcome
from workbench.publish.along import SHOWN
from workbench.publish.tables import shown_number
from workbench.publish.words import plain_name
from workbench.study.report.shown_figures import FIGURES, column_along, shown_unit

DIGITS = 4


def figures_table(here: Outcome, pinned: Outcome | None) -> str:
    """An HTML table: a row for each run, a column for each figure that one of them has."""
    runs = [("here", here), *([("pinned", pinned)] if pinned is not None else [])]
    cells = [_cells(outcome) for _, outcome in runs]
    names = [name for name in cells[0] if any(row.get(name) for row in cells)]
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in names)
    rows = ""
    for (words, _), row in zip(runs, cells, strict=True):
        values = "".join(f"<td>{escape(row.get(name, ''))}</td>" for name in names)
        rows += f'<tr><th scope="row">{words}</th>{values}</tr>'
    return f"{_STYLE}<div><table><tr><td></td>{head}</tr>{rows}</table></div>"


_STYLE = """<style>
:host, .bk-clearfix { max-width: 100%; overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; white-space: nowrap; }
th, td { padding: 0.15em 0.7em 0.15em 0; text-align: left; }
th { font-weight: 600; color: var(--faint); }
</style>"""


def _cells(outcome: Outcome) -> dict[str, str]:
    figures = outcome.figures
    axis = outcome.run.plant.axis
    cells = {"outcome": outcome.run.outcome}
    for channel, rms in outcome.misfits.items():
        unit = outcome.units[channel]
        words = f"{plain_name(channel)} off, rms"
        cells[words] = SHOWN[axis].length(rms, DIGITS) if unit == axis else f"{shown_number(rms, DIGITS)} {unit}"
    for name, words in FIGURES:
        value = figures.get(column_along(name, axis))
        cells[words] = plain_name(value) if isinstance(value, str) else _number(name, value, axis)
    gain = outcome.loop_gain
    if isinstance(gain, str):
        cells["gain margin"] = cells["phase margin"] = "" if outcome.run.reference is None else "no steady slide"
    else:
        cells["gain margin"] = _margin(gain.margins.gain_dB, "dB")
        cells["phase margin"] = _margin(gain.margins.phase_deg, "deg")
    return cells


def _number(name: str, value: float | None, axis: str) -> str:
    if value is None:
        return ""
    unit, factor = shown_unit(name, axis)
    return f"{shown_number(factor * value, DIGITS)} {unit}"


def _margin(value: float, unit: str) -> str:
    return f"{value:.1f} {unit}" if math.isfinite(value) else "none" if value > 0.0 else "unstable"

"""The first thing on the page: scenario by motion, a field each with verdict, margin and price; one for each machine.

Colours survive print and colour blindness: Okabe and Ito's, lightened, and each field says its word.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from workbench.compare.candidates import MM, Candidate, Cell, HuntingCount
from workbench.compare.intervals import LEAST
from workbench.compare.report.words import millimetres, spread
from workbench.compare.result import Comparison, Kind, Verdict
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import within
from workbench.publish.words import plain_name, watts

COLOURS: dict[Kind, str] = {
    "compensate": "#9fc6e6",
    "avoid": "#f2b48a",
    "both": "#dfa9c6",
    "nothing needed": "#ffffff",
    "level": "#f5e79e",
    "cannot be told": "#d0d0d0",
    "none holds": "#a6a6a6",
    "no comparison": "#f4f4f4",
}

MEANING: dict[Kind, str] = {
    "compensate": "compensation at rest beats rotation, and the plain controller at rest",
    "avoid": "rotation with a plain controller beats compensation, and the plain controller at rest",
    "both": "a compensator on a rotating rod beats either alone",
    "nothing needed": "a plain controller at rest errs less than counts, or is beaten by nothing",
    "level": "the differences are within what counts",
    "cannot be told": "an interval reaches over what counts, or who hunts does so rarely: these draws do not tell",
    "none holds": "every candidate hunts or does not complete",
    "no comparison": "the study lacks a side",
}


@dataclass(frozen=True)
class Field:
    """One field: its verdict, and the margin and price under it (empty where there is none)."""

    word: Kind
    margin: str
    price: str

    @property
    def colour(self) -> str:
        """Its background."""
        return COLOURS[self.word]


@dataclass(frozen=True)
class Row:
    """A scenario: a field each reference, None where the study has no such case."""

    scenario: str
    fields: Sequence[Field | None]


@dataclass(frozen=True)
class Matrix:
    """The fields of one machine: a row a scenario that it meets, a column a reference."""

    machine: str
    references: Sequence[str]
    rows: Sequence[Row]

    @property
    def title(self) -> str:
        """What stands over it."""
        return title_of(self.machine)

    def narrowed(self, row: Row, column: int) -> dict[str, str]:
        """What the cases of a field share, as the table of all cases says it."""
        shared = {"machine": self.machine, "scenario": row.scenario, "reference": self.references[column]}
        return {name: plain_name(value) for name, value in shared.items() if value}


def matrices(comparison: Comparison) -> list[Matrix]:
    """One matrix for each machine, in the order of the results."""
    cells = list(comparison.verdicts)
    scenarios, references = (list(dict.fromkeys(cell[i] for cell in cells)) for i in (1, 2))
    made = []
    for machine in comparison.machines:
        met = {cell.scenario for cell in comparison.of(machine)}
        rows = [
            Row(scenario, [_field_at(comparison, Cell(machine, scenario, reference)) for reference in references])
            for scenario in scenarios
            if scenario in met
        ]
        made.append(Matrix(machine, references, rows))
    return made


def _field_at(comparison: Comparison, cell: Cell) -> Field | None:
    verdict = comparison.verdicts.get(cell)
    return None if verdict is None else _field(comparison.table, verdict)


def _field(table: ComparisonTable, verdict: Verdict) -> Field:
    return Field(verdict.kind, _margin(table, verdict), _price(table, verdict))


def _margin(table: ComparisonTable, verdict: Verdict) -> str:
    """Who it is, and how far from the rival: "pi at rest: 0.02 mm; x 1.8 (1.6 to 2.1) for p at 25 rpm"."""
    pair = verdict.pair
    if verdict.otherwise is not None:
        counts = ", ".join(f"{each.words} on {_counted(each.hunting)} draws" for each in verdict.rare.values())
        return f"{verdict.strictly} or {verdict.otherwise}: rests on who hunts rarely ({counts})"
    if pair is None:
        return "; ".join(f"{each.words}: {_size(table, each)}" for each in verdict.best.values())
    named, rival = (verdict.best[kind] for kind in pair)
    if verdict.kind == "nothing needed" and within(table, named):
        return f"{named.words}: {_size(table, named)}, within {millimetres(table.negligible)}"
    relation = verdict.relation(*pair)
    ratio, apart = relation.ratio, relation.difference.mean * MM
    told = f"{apart:+.3g} mm" if abs(apart) >= LEAST * MM else f"{millimetres(abs(apart) / MM)} apart"
    rest = ""
    if verdict.together is not None and verdict.together.word == "cannot be told from":
        both = verdict.best["both"]
        rest = f"; {both.words}, {_size(table, both)}, cannot be told from it"
    return f"{named.words}: {_size(table, named)}; {rival.words}: x {ratio.mean:.3g}{spread(ratio)}, {told}{rest}"


def _counted(hunting: HuntingCount) -> str:
    return f"{hunting.hunts} of {hunting.samples}"


def _size(table: ComparisonTable, candidate: Candidate) -> str:
    """The mean error of a candidate in mm."""
    return millimetres(candidate.mean_error(table.probability).mean)


def _price(table: ComparisonTable, verdict: Verdict) -> str:
    """What the rotating side pays where it is, or would be, chosen, beside what is paid at rest; torque, if much."""
    turning, still = verdict.turning, verdict.still
    if turning is None:
        return ""
    beside = "" if still is None else f" (at rest {watts(still.paid_power)})"
    torque, nominal = turning.motor_torque, table.nominal_torque
    much = f", {torque:.2g} N m rms of a nominal {nominal:g}" if torque > nominal else ""
    return f"rotating: {watts(turning.terminal_power)} at the terminals{much}, {watts(turning.paid_power)} paid{beside}"


@dataclass(frozen=True)
class KeyEntry:
    """A verdict as the key explains it."""

    word: Kind

    @property
    def colour(self) -> str:
        """The background of its fields."""
        return COLOURS[self.word]

    @property
    def meaning(self) -> str:
        """What it says."""
        return MEANING[self.word]


KEY = [KeyEntry(word) for word in COLOURS]
"""All of them."""

NOTATION = (
    "In a field: who stands for the class that is named, with the mean error; then the rival, x by how much its error "
    "is larger (geometric mean of the ratios on each draw, in brackets its interval), and the difference of the means."
)
"""What the numbers of a field are."""


def title_of(machine: str) -> str:
    """The machine's name over its matrix."""
    return plain_name(machine) if machine else "Verdicts"

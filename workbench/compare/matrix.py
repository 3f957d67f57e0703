"""The first thing on the page: scenario by motion, a field each with verdict, margin and price; one for each machine.

Colours survive print and colour blindness: Okabe and Ito's, lightened, and each field says its word.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.compare.candidates import MM, Cell
from workbench.compare.intervals import LEAST, Interval
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import Kind, Verdict, size_of, within
from workbench.compare.words import millimetres, spread
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

    kind: Kind
    margin: str
    price: str

    @property
    def word(self) -> str:
        """The verdict as the field says it."""
        return self.kind

    @property
    def colour(self) -> str:
        """Its background."""
        return COLOURS[self.kind]


@dataclass(frozen=True)
class Matrix:
    """The fields of one machine: a row a scenario that it meets, a column a reference."""

    machine: str
    references: list[str]
    rows: Mapping[str, list[Field | None]]


def matrices(spec: ComparisonTable, found: Mapping[Cell, Verdict]) -> list[Matrix]:
    """One matrix for each machine, in the order of the results."""
    machines, scenarios, references = (list(dict.fromkeys(cell[i] for cell in found)) for i in range(3))
    met = {(cell.machine, cell.scenario) for cell in found}
    return [
        Matrix(
            machine,
            references,
            {
                scenario: [
                    _field(spec, found[cell]) if (cell := Cell(machine, scenario, reference)) in found else None
                    for reference in references
                ]
                for scenario in scenarios
                if (machine, scenario) in met
            },
        )
        for machine in machines
    ]


def _field(spec: ComparisonTable, verdict: Verdict) -> Field:
    return Field(verdict.kind, _margin(spec, verdict), _price(spec, verdict))


def _margin(spec: ComparisonTable, verdict: Verdict) -> str:
    """Who it is, and how far from the rival: "pi at rest: 0.02 mm; x 1.8 (1.6 to 2.1) for p at 25 rpm"."""
    pair = verdict.pair
    if verdict.otherwise is not None:
        counts = ", ".join("{} on {} of {} draws".format(one.words, *one.hunting) for one in verdict.rare.values())
        return f"{verdict.strictly} or {verdict.otherwise}: rests on who hunts rarely ({counts})"
    if pair is None:
        return "; ".join(f"{one.words}: {millimetres(size_of(spec, one).mean)}" for one in verdict.best.values())
    one, other = (verdict.best[kind] for kind in pair)
    if verdict.kind == "nothing needed" and within(spec, one):
        return f"{one.words}: {millimetres(size_of(spec, one).mean)}, within {millimetres(spec.negligible)}"
    relation = verdict.relation(*pair)
    ratio: Interval = relation.ratio
    apart = relation.difference.mean * MM
    told = f"{apart:+.3g} mm" if abs(apart) >= LEAST * MM else f"{millimetres(abs(apart) / MM)} apart"
    rest = ""
    if verdict.together is not None and verdict.together.word == "cannot be told from":
        both = verdict.best["both"]
        rest = f"; {both.words}, {millimetres(size_of(spec, both).mean)}, cannot be told from it"
    return (
        f"{one.words}: {millimetres(size_of(spec, one).mean)}; {other.words}: x {ratio.mean:.3g}{spread(ratio)}, {told}"
        f"{rest}"
    )


def _price(spec: ComparisonTable, verdict: Verdict) -> str:
    """What the rotating side pays where it is, or would be, chosen, beside what is paid at rest; torque, if much."""
    one, still = verdict.turning, verdict.still
    if one is None:
        return ""
    beside = "" if still is None else f" (at rest {watts(still.paid)})"
    torque = one.mean("motor_torque_rms_N_m")
    much = f", {torque:.2g} N m rms of a nominal {spec.nominal_torque:g}" if torque > spec.nominal_torque else ""
    return (
        f"rotating: {watts(one.mean('motor_electric_power_W'))} at the terminals{much}, {watts(one.paid)} paid{beside}"
    )


def key() -> list[tuple[str, str, str]]:
    """Word, colour and meaning of each verdict."""
    return [(kind, COLOURS[kind], MEANING[kind]) for kind in COLOURS]


NOTATION = (
    "In a field: who stands for the class that is named, with the mean error; then the rival, x by how much its error "
    "is larger (geometric mean of the ratios on each draw, in brackets its interval), and the difference of the means."
)
"""What the numbers of a field are."""


def title_of(machine: str) -> str:
    """The machine's name over its matrix."""
    return plain_name(machine) if machine else "Verdicts"

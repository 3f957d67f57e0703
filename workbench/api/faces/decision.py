"""A decision as a notebook shows it."""

from dataclasses import dataclass

from workbench.decide.decision import Decision
from workbench.decide.report.answer import paragraph
from workbench.decide.report.tables import short_table
from workbench.decide.report.words import price, question
from workbench.publish.notebook import face


@dataclass(frozen=True, eq=False, repr=False)
class ShownDecision(Decision):
    """Shown by question and answer, and a row a candidate."""

    def _repr_html_(self) -> str:
        lines = [line for line in (paragraph(self), price(self)) if line]
        return face(question(self), lines=lines, table=short_table(self))

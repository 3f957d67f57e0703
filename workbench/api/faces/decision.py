"""A decision as a notebook shows it."""

from dataclasses import dataclass

from workbench.api.faces import told
from workbench.decide.report.answer import paragraph
from workbench.decide.report.axes import is_known
from workbench.decide.report.tables import short_table
from workbench.decide.report.trade_figure import trade_figure
from workbench.decide.report.words import price, question
from workbench.decide.result import Decision
from workbench.publish.notebook import face


@dataclass(frozen=True, eq=False, repr=False)
class ShownDecision(Decision):
    """Shown by question and answer, a row a candidate, and error against power where runs complete."""

    def __repr__(self) -> str:
        return told(question(self), self._lines)

    @property
    def _lines(self) -> list[str]:
        return [line for line in (paragraph(self), price(self)) if line]

    def _repr_html_(self) -> str:
        known = any(is_known(row) for row in self.asked.ordered)
        figure = trade_figure(self)[0] if known else None
        return face(question(self), lines=self._lines, table=short_table(self), figure=figure)

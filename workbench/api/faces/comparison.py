"""A comparison as a notebook shows it."""

from dataclasses import dataclass

from workbench.api.faces import told
from workbench.compare.report.figures import pictures_of
from workbench.compare.report.overview import answer
from workbench.compare.report.tables import finalist_table
from workbench.compare.result import Comparison
from workbench.publish.notebook import face
from workbench.publish.style import figure_style


@dataclass(frozen=True, eq=False, repr=False)
class ShownComparison(Comparison):
    """Shown by the answer of each machine, who stood for each class, and the errors over rpm of the first scenario."""

    def __repr__(self) -> str:
        return told(self.study.file.title, answer(self))

    def _repr_html_(self) -> str:
        with figure_style():
            drawn = next(iter(pictures_of(self).values()), None)
        return face(
            self.study.file.title,
            lines=answer(self),
            table=finalist_table(self),
            figure=None if drawn is None else drawn.figure,
        )

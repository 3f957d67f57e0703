"""An identification as a notebook shows it."""

from dataclasses import dataclass

from workbench.identify.report.figures.every import record_figures
from workbench.identify.report.folder import table_of
from workbench.identify.result import Identification
from workbench.publish.notebook import face


@dataclass(frozen=True, eq=False, repr=False)
class ShownIdentification(Identification):
    """Shown by the parameters, declared and identified, and the first record against the plant."""

    def _repr_html_(self) -> str:
        figures = record_figures(self)
        return face(self.experiment.title, table=table_of(self), figure=next(iter(figures.values()), None))

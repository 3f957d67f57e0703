"""An identification as a notebook shows it."""

from dataclasses import dataclass

from workbench.api.faces import told
from workbench.identify.report.figures.every import record_figures
from workbench.identify.report.folder import table_of
from workbench.identify.result import Identification
from workbench.publish.notebook import face


@dataclass(frozen=True, eq=False, repr=False)
class ShownIdentification(Identification):
    """Shown by the parameters, declared and identified, and the first record against the plant."""

    def __repr__(self) -> str:
        return told(self.experiment.title, [table_of(self).to_string(index=False)])

    def _repr_html_(self) -> str:
        figures = record_figures(self)
        return face(self.experiment.title, table=table_of(self), figure=next(iter(figures.values()), None))

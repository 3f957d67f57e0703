"""A diagnosis as a notebook shows it."""

from dataclasses import dataclass

from workbench.api.faces import told
from workbench.diagnose.report.figures.every import pictures_of
from workbench.diagnose.report.folder import tables_of
from workbench.diagnose.report.sureness import sureness
from workbench.diagnose.report.verdict import verdict_sentence
from workbench.diagnose.result import Diagnosis
from workbench.publish.notebook import face

DRAWN = ("simulation", "flow_time", "force_time")
"""Pictures by name, the most telling first: the plant simulated against what was measured, or else a residual."""


@dataclass(frozen=True, eq=False, repr=False)
class ShownDiagnosis(Diagnosis):
    """Shown by verdict, how sure it is, the error before and after, and the plant against its records."""

    def __repr__(self) -> str:
        return told(self.experiment.title, [verdict_sentence(self)])

    def _repr_html_(self) -> str:
        pictures, tables = pictures_of(self), tables_of(self)
        drawn = next((pictures[name] for name in DRAWN if name in pictures), None)
        return face(
            self.experiment.title,
            lines=[verdict_sentence(self), *sureness(self)],
            table=tables["error"].cells if "error" in tables else None,
            figure=None if drawn is None else drawn.figure,
        )

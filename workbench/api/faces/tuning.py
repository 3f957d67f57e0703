"""A tuning as a notebook shows it."""

from dataclasses import dataclass

from workbench.api.faces import told
from workbench.publish.notebook import face
from workbench.tune.report.history import history_picture
from workbench.tune.report.tables import brief, tables_of
from workbench.tune.report.words import first_lines
from workbench.tune.result import Tuning


@dataclass(frozen=True, eq=False, repr=False)
class ShownTuning(Tuning):
    """Shown by what was found in words, a row a controller, and the objective over the trials."""

    def __repr__(self) -> str:
        return told(self.study.file.title, first_lines(self))

    def _repr_html_(self) -> str:
        return face(
            self.study.file.title,
            lines=first_lines(self),
            table=brief(tables_of(self)["tuning"]),
            figure=history_picture(self).figure,
        )

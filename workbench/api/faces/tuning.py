"""A tuning as a notebook shows it."""

from dataclasses import dataclass

from workbench.publish.notebook import face
from workbench.tune.report.history import history_picture
from workbench.tune.report.tables import brief, tables_of
from workbench.tune.report.words import first_lines
from workbench.tune.result import Tuning


@dataclass(frozen=True, eq=False, repr=False)
class ShownTuning(Tuning):
    """Shown by what was found in words, a row a controller, and the objective over the trials."""

    def _repr_html_(self) -> str:
        return face(
            self.study.file.title,
            lines=first_lines(self),
            table=brief(tables_of(self)["tuning"]),
            figure=history_picture(self).figure,
        )

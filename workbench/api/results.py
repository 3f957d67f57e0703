"""Results of a study: the rows of results.csv, its tables and figures, and the signals of its cases."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from workbench.api.faces import shown_as
from workbench.api.plain import expect
from workbench.api.signals import UNITS, plot_signals
from workbench.errors import UserError, nearest
from workbench.metrics.registry import axis_of, names_along
from workbench.study import study as studies
from workbench.study.names import in_words, signal_units, unit_of_column, without_unit
from workbench.study.reading import read_study
from workbench.study.report.select import axes_of, columns_of, one_row
from workbench.study.sections import overlays_of
from workbench.study.store import STUDY_COPY, read_results, trajectory_path

if TYPE_CHECKING:
    from workbench.api.faces.comparison import ShownComparison
    from workbench.publish.notebook import NotebookFigure

SHOWN = ("outcome", "phase_lag_deg", "steady_state_error_m", "rms_error_m", "limit_cycle", "paid_power_W")
"""Columns that results show of themselves in a notebook, beside their axes, where some case has them."""


@dataclass(frozen=True, eq=False)
class CaseResult:
    """One case of a study: its row of results.csv, and its signals where they were kept.

    Example:
        >>> case = wb.Study(small_study).run(folder / "one", keep_trajectories=True).case(rpm=120)
        >>> case.row["outcome"], case.frame().shape[0]
        ('completed', 1001)
        >>> case.plot("axial_friction", against="velocity").axes[0].get_ylabel()
        'axial friction (N)'
    """

    row: pd.Series
    axes: Mapping[str, object]
    path: Path

    @property
    def kept(self) -> bool:
        """Whether its signals were kept."""
        return self.path.exists()

    def frame(self) -> pd.DataFrame:
        """Its signals, a row a sample, in SI; units in `attrs["units"]`, "1" also of signals in the command's unit.

        Raises:
            UserError: they were not kept.
        """
        if not self.kept:
            raise UserError(
                f"the signals of {in_words(self.axes) or 'the only case'} were not kept; run with "
                "keep_trajectories=True for all"
            )
        frame, units = pd.read_parquet(self.path), signal_units(axis_of([str(name) for name in self.row.index]))
        frame.attrs[UNITS] = {str(name): units.get(str(name), "1") for name in frame.columns}
        return frame

    def plot(self, *names: str, against: str = "time") -> "NotebookFigure":
        """A matplotlib figure of these signals, a panel for each unit, over time or another signal; SI units.

        Raises:
            UserError: no such signal, or none was kept.
        """
        return plot_signals(self.frame(), names, against, in_words(self.axes))


@dataclass(frozen=True, eq=False, repr=False)
class StudyResults:
    """What a finished study left in its folder.

    `frame` has a row a case: the axes, then the columns of results.csv with their units in the names.

    Example:
        >>> results = wb.Study(small_study).run(folder / "results")
        >>> results.frame[["rpm", "outcome"]].values.tolist()
        [[0, 'completed'], [120, 'completed']]
        >>> wb.StudyResults.read(folder / "results").frame.equals(results.frame)
        True
    """

    study: studies.Study
    folder: Path
    frame: pd.DataFrame

    @classmethod
    def read(cls, folder: str | Path) -> "StudyResults":
        """The results in a folder, of `workbench run` or `Study.run`.

        Raises:
            UserError: there are none.
        """
        expect(folder, str | Path, "StudyResults.read", "the path of a folder of results")
        path = Path(folder)
        frame = read_results(path)
        return cls(read_study(path / STUDY_COPY), path, frame)

    @property
    def tables(self) -> list[str]:
        """Names of the tables that the study asks for."""
        return sorted(path.stem for path in (self.folder / "tables").glob("*.csv"))

    @property
    def figures(self) -> list[str]:
        """Names of the figures that the study asks for."""
        return [spec.name for spec in self.study.file.figures]

    @property
    def comparison(self) -> "ShownComparison":
        """What a study with a table [comparison] says of compensation against rotation: `verdicts` by machine, scenario
        and reference, the candidates that they rest on, and what would change them.

        Raises:
            UserError: the study has no such table.
        """
        from workbench.api.faces.comparison import ShownComparison
        from workbench.compare.comparison import comparison_of

        return shown_as(ShownComparison, comparison_of(self.study, self.frame, self.folder))

    def table(self, name: str) -> pd.DataFrame:
        """A table of the study, as text ready to be read; or the axes with one column of the results, as numbers.

        Args:
            name: of a table, or of a column with or without its unit: "phase_lag" or "phase_lag_deg".

        Raises:
            UserError: there is neither.

        Example:
            >>> results = wb.Study(small_study).run(folder / "results", overwrite=True)
            >>> results.table("phase_lag").columns.tolist()
            ['rpm', 'phase_lag_deg']
        """
        if name in self.tables:
            return pd.read_csv(self.folder / "tables" / f"{name}.csv", dtype=str, keep_default_na=False)
        columns = {without_unit(str(column)): str(column) for column in self.frame.columns}
        columns |= {str(column): str(column) for column in self.frame.columns}
        if name not in columns:
            raise UserError(
                f'{self.folder}: no table and no column "{name}"; {nearest(name, [*self.tables, *columns])}'
            )
        return columns_of(self.frame, [columns[name]], {})

    def figure(self, name: str) -> "NotebookFigure":
        """A figure of the study, drawn anew; a notebook shows it.

        Raises:
            UserError: the study asks for no such figure.
        """
        from workbench.study.report.figures import draw

        spec = next((spec for spec in self.study.file.figures if spec.name == name), None)
        if spec is None:
            raise UserError(f'{self.folder}: no figure "{name}"; {nearest(name, self.figures)}')
        return draw(spec, self.frame, self.folder, overlays_of(self.study))

    def case(self, **axes: object) -> CaseResult:
        """The one case whose axes have these values.

        Raises:
            UserError: no such axis, no such case, or several.

        Example:
            >>> results = wb.Study(small_study).run(folder / "results", overwrite=True)
            >>> results.case(rpm=120).row["limit_cycle"] is None
            True
            >>> results.case()
            Traceback (most recent call last):
            workbench.errors.UserError: results: 2 cases for no condition, expected one
        """
        row = one_row(self.frame, axes, "results")
        own = {name: row[name] for name in axes_of(self.frame.columns)}
        return CaseResult(row, own, trajectory_path(self.folder, int(str(row.name))))

    def to_json(self) -> dict[str, object]:
        """Title, units and rows as plain data, for JSON; null where a metric does not apply."""
        return {
            "title": self.study.file.title,
            "units": {str(name): unit_of_column(str(name)) for name in self.frame.columns},
            "rows": json.loads(self.frame.to_json(orient="records", double_precision=15)),
        }

    def __repr__(self) -> str:
        return f'StudyResults("{self.study.file.title}", {len(self.frame)} cases, {self.folder})'

    def _repr_html_(self) -> str:
        from workbench.publish.notebook import face

        names = [str(name) for name in self.frame.columns]
        axes = axes_of(names)
        called = names_along(axis_of(names))
        shown = [called[name] for name in SHOWN if self.frame[called[name]].notna().any()]
        return face(
            self.study.file.title,
            lines=[f"{len(self.frame)} cases in {self.folder}"],
            table=self.frame[[*axes, *shown]],
            figure=self.figure(self.figures[0]) if self.figures else None,
        )

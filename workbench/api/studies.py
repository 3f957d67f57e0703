"""A study in Python: a file or a dictionary of the same content, its cases, and running it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import pandas as pd

from workbench.api.loops import LoopSetup
from workbench.api.plain import expect, plain_table
from workbench.api.results import StudyResults
from workbench.errors import UserError, nearest
from workbench.study import study as studies
from workbench.study.names import in_words
from workbench.study.plan import Plan, plan
from workbench.study.reading import read_study, study_of
from workbench.study.resolve import resolve
from workbench.study.rounds import run_rounds, with_draws
from workbench.study.runner import run_study
from workbench.study.sections import other_command
from workbench.study.store import read_results

Content = Mapping[str, object]
"""What a study file holds, as a dictionary; controllers and references may stand in it as `pid(kp=500)`."""


@dataclass(frozen=True)
class Study:
    """A study: plants, controllers, references and axes; its cases are the product of its axes.

    Args:
        source: the path of a study file, or its content as a dictionary (docs/study_files.md says what stands there).
        folder: where the files that a dictionary names are looked for.

    Raises:
        UserError: no such file, or unknown or missing keys.

    Example:
        >>> study = wb.Study({
        ...     "title": "P control, at rest about its axis and turning",
        ...     "plant": {"model": "by_rpm", "parameters": "owen2001_simulation"},
        ...     "axes": {"rpm": [0, 120]},
        ...     "controllers": {"p": wb.pid(kp=500)},
        ...     "references": {"sine": wb.sine("5 mm", "2 Hz")},
        ...     "simulation": {"duration": "1 s"},
        ... })
        >>> study.cases["rpm"].tolist()
        [0, 120]
        >>> study.setup(rpm=120)
        LoopSetup(rotating_helical, pid, rpm 120, 1 s)
    """

    source: str | Path | Content
    folder: str | Path = "."

    def __post_init__(self) -> None:
        _ = self.content  # a mistake is told here, not where the study is first used

    @cached_property
    def content(self) -> studies.Study:
        """The study as read."""
        if isinstance(self.source, str | Path):
            return read_study(Path(self.source))
        expect(self.source, Mapping, "study", "the path of a study file, or its content as a dictionary")
        return study_of(plain_table(self.source, "study"), "", Path(self.folder) / "study")

    @cached_property
    def plan(self) -> Plan:
        """Its cases, checked to the last key.

        Raises:
            UserError: the first mistake in a case, or a study that has nothing to run.
        """
        return _plan(self.content)

    @property
    def cases(self) -> pd.DataFrame:
        """A row a case, with the values of its axes."""
        return pd.DataFrame([self.plan.cases.columns(i) for i in range(len(self.plan.cases))])

    @property
    def warnings(self) -> list[str]:
        """What may be meant, and seldom is, such as a reference beyond the stroke."""
        return list(self.plan.warnings)

    @property
    def text(self) -> str:
        """As a study file."""
        if isinstance(self.source, str | Path):
            return self.content.text
        import tomli_w

        return tomli_w.dumps(plain_table(self.source, "study"))

    def setup(self, **axes: object) -> LoopSetup:
        """The loop of one case, ready to be simulated: that whose axes have these values.

        Raises:
            UserError: no such axis, or not one case.

        Example:
            >>> study = wb.Study("studies/thesis_chapter3.toml")
            >>> wb.simulate(study.setup(rpm=460)).outcome
            'completed'
        """
        for name in axes:
            if name not in self.plan.axes:
                raise UserError(f"{self.content.path}: no axis {name}; {nearest(name, self.plan.axes)}")
        cases = [self.plan.cases[int(place)] for place in self.plan.cases.where(axes)]
        if len(cases) != 1:
            number = f"{len(cases) or 'no'} case{'s' * (len(cases) != 1)}"
            raise UserError(
                f"{self.content.path}: {number} with {in_words(axes) or 'no condition'}, expected one; the axes are "
                f"{', '.join(self.plan.axes) or 'none'}"
            )
        return LoopSetup(resolve(self.content, cases[0]), self.content, cases[0])

    def run(
        self,
        out: str | Path,
        *,
        jobs: int | None = None,
        cluster: str | None = None,
        resume: bool = False,
        overwrite: bool = False,
        keep_trajectories: bool = False,
        draws: int | None = None,
        fresh_draws: int | None = None,
        allow_fmu: bool = False,
    ) -> StudyResults:
        """Run every case into the folder `out`, then make tables, figures and pages there, as `workbench run` does.

        Args:
            out: of the results; a study that was given as a dictionary is written there as study.toml too.
            jobs: cases at a time; default one a core. The results are the same, whatever their number.
            cluster: address of a dask scheduler to run on instead.
            resume: go on with the results in `out`.
            overwrite: replace them.
            keep_trajectories: keep the signals of every case, not only those that figures need.
            draws: of machines, in place of what the study says.
            fresh_draws: on which the best of a comparison are measured again, in place of what the study says.
            allow_fmu: run the FMUs that the study names, foreign code, which you trust.

        Raises:
            UserError: a mistake in the study, or a folder that does not serve.

        Example:
            >>> results = wb.Study(small_study).run(folder / "results", jobs=2)
            >>> results.frame["outcome"].tolist()
            ['completed', 'completed']
        """
        from workbench.study.report.folder import write_all

        if resume and overwrite:
            raise UserError("resume and overwrite: choose one")
        folder = Path(out)
        study = with_draws(replace(self.content, allow_fmu=allow_fmu), "draws", draws, "uncertainty", "draws")
        checked = _plan(with_draws(study, "fresh_draws", fresh_draws, "comparison", "fresh_draws"))
        planned = replace(checked, study=replace(checked.study, text=self.text))

        def run(some: Plan, into: Path, resume: bool, overwrite: bool) -> None:
            run_study(
                some,
                into,
                jobs=jobs,
                cluster=cluster,
                resume=resume,
                overwrite=overwrite,
                keep_all=keep_trajectories,
            )

        run_rounds(planned, folder, run, resume=resume, overwrite=overwrite)
        frame = read_results(folder)
        write_all(planned, frame, folder)
        return StudyResults(planned.study, folder, frame)

    def __repr__(self) -> str:
        return f'Study("{self.content.file.title}")'

    def _repr_html_(self) -> str:
        from workbench.publish.notebook import face
        from workbench.study.description import description

        return face(self.content.file.title, lines=description(self.plan))


def as_study(study: str | Path | Content | Study) -> Study:
    """A study, however it is given."""
    return study if isinstance(study, Study) else Study(study)


def _plan(study: studies.Study) -> Plan:
    if (other := other_command(study)) is not None:
        raise UserError(f"{study.path}: has [{other.name}] and no [references]; use wb.{other.command}")
    return plan(study)

"""The questions that have a command of their own: tune, decide, identify, diagnose, design; and a report of answers."""

import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from workbench.api.faces import shown_as
from workbench.api.plain import expect
from workbench.api.studies import Content, Study, as_study
from workbench.errors import UserError, nearest

AN_EXPERIMENT = "the path of an experiment file, as text or a Path"
"""What is expected where something else than an experiment is given."""

if TYPE_CHECKING:
    from workbench.api.faces.decision import ShownDecision
    from workbench.api.faces.diagnosis import ShownDiagnosis
    from workbench.api.faces.identification import ShownIdentification
    from workbench.api.faces.tuning import ShownTuning
    from workbench.design.result import Design
    from workbench.report.folder import Report


def tune(
    study: str | Path | Content | Study,
    out: str | Path | None = None,
    *,
    controllers: Sequence[str] = ("all",),
    trials: int | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
) -> "ShownTuning":
    """Find gains for the controllers of a study, with the same budget and objective for all (docs/tuning.md).

    Args:
        study: with a table [tune]: a file, its content, or a `Study`.
        out: folder for gain files, trials, tables, figures and tuning.html; without one nothing is kept.
        controllers: of the study; "all": every one, and a PD.
        trials: of each seed, in place of what [tune] says.
        jobs: searches at a time; default one a core.
        cluster: address of a dask scheduler whose workers score the trials of all searches instead.
        resume: go on with the trials in `out`.
        overwrite: replace what is there.

    Returns:
        what became of each controller: its gains, scores and trials.

    Raises:
        UserError: a mistake in the study, no such controller, or a folder that does not serve.

    Example:
        >>> tuning = wb.tune({**small_study, "axes": {}, "tune": {"seeds": 1, "objective": {"rms_error": 1}}},
        ...                  controllers=["p"], trials=3)
        >>> [len(result.trials) for result in tuning.tuned]
        [3]
    """
    from workbench.api.faces.tuning import ShownTuning
    from workbench.parallel.cluster import check_answer
    from workbench.tune.prepare import prepared
    from workbench.tune.report.folder import opened_folder, write_tuning
    from workbench.tune.run import tune_all

    asked = as_study(study)
    ready, names = prepared(asked.content, list(controllers), trials)
    ready = replace(ready, text=asked.text)
    check_answer(cluster)
    began = time.time()
    if out is None:
        with TemporaryDirectory() as folder, opened_folder(Path(folder)) as database:
            return shown_as(ShownTuning, tune_all(ready, names, database, jobs, cluster=cluster))
    with opened_folder(Path(out), resume=resume, overwrite=overwrite) as database:
        tuning = tune_all(ready, names, database, jobs, cluster=cluster)
        write_tuning(tuning, Path(out), began=began, jobs=jobs, cluster=cluster)
    return shown_as(ShownTuning, tuning)


def decide(
    study: str | Path | Content | Study,
    out: str | Path | None = None,
    *,
    machine: str | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
) -> "ShownDecision":
    """Say which controllers and speeds of rotation meet an accuracy within a power, and how probably.

    The probability is that of machines drawn as [uncertainty] says; its interval is exact (Clopper and Pearson).

    Args:
        study: with a table [decide]: a file, its content, or a `Study`.
        out: folder for decision.html, results, tables and figures; without one nothing is kept.
        machine: in place of the study's.
        jobs: runs at a time; default one a core.
        cluster: address of a dask scheduler to run on instead.
        resume: go on with the runs in `out`.
        overwrite: replace what is there.

    Returns:
        every run, and what suffices at each speed and spread.

    Raises:
        UserError: a mistake in the study, or a folder that does not serve.

    Example:
        >>> decision = wb.decide({
        ...     "title": "1 mm at 20 mm/s",
        ...     "plant": {"model": "non_rotating", "parameters": "owen2001_simulation"},
        ...     "controllers": {"feed": wb.pid(kp=500, feedforward=1)},
        ...     "uncertainty": {"scale": {"mass": {"min": 0.8, "max": 1.5}}},
        ...     "decide": {"accuracy": "1 mm", "speed": "20 mm/s", "amplitude": "1 mm", "power": "2 kW",
        ...                "plain": ["feed"], "rpm": [0], "draws": 2, "fresh_draws": 60, "hold_duration": "1 s"},
        ... })
        >>> decision.asked.answer().best.controller
        'feed'
    """
    from workbench.api.faces.decision import ShownDecision
    from workbench.decide.plan import plan_decision
    from workbench.decide.report.folder import opened_folder, write_decision
    from workbench.decide.run import decide as decided
    from workbench.parallel.cluster import check_answer

    began, asked = time.time(), as_study(study)
    checked = plan_decision(asked.content, machine)
    planned = replace(checked, study=replace(checked.study, text=asked.text))
    check_answer(cluster)
    if out is None:
        return shown_as(ShownDecision, decided(planned, jobs, cluster=cluster))
    with opened_folder(Path(out), planned, resume=resume, overwrite=overwrite) as runs:
        decision = decided(planned, jobs, kept=runs, cluster=cluster)
        write_decision(decision, Path(out), began, cluster or jobs)
    return shown_as(ShownDecision, decision)


def identify(
    experiment: str | Path, out: str | Path | None = None, *, method: str | None = None, overwrite: bool = False
) -> "ShownIdentification":
    """Find friction and other parameters of a plant in records of it (docs/experiments.md).

    By the thesis's method, from slow motions and load pressures, and by simulation error: the parameters with which the
    plant, driven by the measured input, shows what the sensors showed with the least sum of squared differences.

    Args:
        experiment: the path of an experiment file, with its records beside it.
        out: folder for identified.json, plant.toml, tables and figures; without one nothing is kept.
        method: "thesis", "simulation" or "both"; default what the file says.
        overwrite: replace what is in `out`.

    Returns:
        both methods' estimates with their deviations, and the corrected plant.

    Raises:
        UserError: a mistake in the file, a record that does not serve, or a folder that does not.

    Example:
        >>> identification = wb.identify(experiment, method="simulation")
        >>> sorted(identification.simulation.estimates)
        ['coulomb', 'coulomb_negative', 'viscous', 'viscous_negative']
    """
    from workbench.api.faces.identification import ShownIdentification
    from workbench.identify.identification import identify as identified
    from workbench.identify.report.folder import claimed_folder, write_identification
    from workbench.records.experiment import read_experiment
    from workbench.records.schema import METHODS

    expect(experiment, str | Path, "identify", AN_EXPERIMENT)
    if method is not None and method not in METHODS:
        raise UserError(f'method "{method}": {nearest(method, METHODS)}')
    content = read_experiment(Path(experiment))
    with claimed_folder(Path(out), overwrite) if out is not None else nullcontext():
        identification = identified(content, method)
        if out is not None:
            write_identification(identification, Path(out))
    return shown_as(ShownIdentification, identification)


def diagnose(experiment: str | Path, out: str | Path | None = None, *, overwrite: bool = False) -> "ShownDiagnosis":
    """Say what a plant lacks, by records of it, and how sure that is (docs/diagnosis.md).

    Args:
        experiment: the path of an experiment file, with its records beside it.
        out: folder for report.json, report.html, plant.toml, tables and figures; without one nothing is kept.
        overwrite: replace what is in `out`.

    Returns:
        effects with their parameters, what stays unexplained, errors before and after, and the `verdict`:
        "none_missing", "effect_found", "ambiguous", "unexplained", "undecided" or "rejected_on_held_out".

    Raises:
        UserError: a mistake in the file, channels that allow no balance, or a folder that does not serve.

    Example:
        >>> diagnosis = wb.diagnose(experiment)
        >>> diagnosis.verdict
        'none_missing'
    """
    from workbench.api.faces.diagnosis import ShownDiagnosis
    from workbench.diagnose.diagnose import diagnose as diagnosed
    from workbench.diagnose.report.folder import claimed_folder, write_diagnosis

    expect(experiment, str | Path, "diagnose", AN_EXPERIMENT)
    with claimed_folder(Path(out), overwrite) if out is not None else nullcontext():
        diagnosis = diagnosed(Path(experiment))
        if out is not None:
            write_diagnosis(diagnosis, Path(out))
    return shown_as(ShownDiagnosis, diagnosis)


def design(
    source: str | Path,
    out: str | Path | None = None,
    *,
    between: Sequence[str] = (),
    identify: Sequence[str] = (),
    duration: float | str | None = None,
    overwrite: bool = False,
) -> "Design":
    """Find the motion to record next: one that tells apart what is left open (docs/design.md).

    Args:
        source: the folder of a diagnosis, or the path of an experiment file.
        out: folder for design.json, design.html, the reference and a study; without one nothing is kept.
        between: effects to be told apart, or "none"; by default what a diagnosis left open.
        identify: parameters to be shown.
        duration: s, or "60 s": at most; by default what [design] says, else 60 s.
        overwrite: replace what is in `out`.

    Returns:
        the motion, what each hypothesis shows in it, and how surely it tells them apart.

    Raises:
        UserError: a mistake in the file, impossible limits, hypotheses that no motion tells apart, or a folder that
            does not serve.

    Example:
        >>> found = wb.design(experiment, between=["none", "backlash"], duration="4 s")
        >>> [one.name for one in found.hypotheses]
        ['nothing missing', 'backlash']
    """
    from workbench.design.design import design as designed
    from workbench.design.report.folder import claimed_folder, write_design
    from workbench.toml.units import QuantityError, si

    expect(source, str | Path, "design", "the path of an experiment file, or of a folder of diagnose")
    try:
        seconds = None if duration is None else si(duration, "s")
    except QuantityError as error:
        raise UserError(f"duration: {error}") from None
    with claimed_folder(Path(out), overwrite) if out is not None else nullcontext():
        found = designed(Path(source), between=between, identify=identify, duration=seconds)
        if out is not None:
            write_design(found, Path(out))
    return found


def report(
    folders: str | Path | Sequence[str | Path],
    out: str | Path,
    *,
    page: str | None = None,
    pdf: bool = False,
    overwrite: bool = False,
) -> "Report":
    """Put the tables, figures and words of results into one LaTeX document (docs/papers.md).

    Args:
        folders: one or several that `Study.run`, `tune`, `decide`, `identify` or `diagnose` wrote.
        out: folder for report.tex and what it needs.
        page: for which a study's figures are drawn anew: "ieee", "elsevier", "84 mm" or "84 mm, 9 pt".
        pdf: compile it too, with pdflatex.
        overwrite: replace an earlier report in `out`.

    Returns:
        the paths of the files, and what is not as it was asked for.

    Raises:
        UserError: no folder of results, a missing file, no such format, no LaTeX, or an `out` that does not serve.

    Example:
        >>> results = wb.Study(small_study).run(folder / "results")
        >>> wb.report(results.folder, folder / "paper").tex.name
        'report.tex'
    """
    from workbench.report.folder import write_report

    several = [folders] if isinstance(folders, str | Path) else list(folders)
    return write_report([Path(each) for each in several], Path(out), page, pdf=pdf, overwrite=overwrite)

"""What `workbench tune` leaves in its folder.

tuned/NAME.toml            gains of each controller, as a study names them
results.csv, trials.csv    a row a controller; a row a trial (SI)
tuning.html, tables/, figures/
results.sqlite             the trials, while they are found: optuna's tables
study.toml, run.json       the study, and what ran it
"""

from functools import partial
from pathlib import Path

import pandas as pd

from workbench.errors import UserError
from workbench.folders import held, remove, write_whole
from workbench.study.store import DATABASE, STUDY_COPY
from workbench.tune.gains import gain_file, history
from workbench.tune.study import Tuning
from workbench.tune.tuning import Tuned, infeasible

GAINS, RESULTS, TRIALS = "tuned", "results.csv", "trials.csv"
REPLACED = (STUDY_COPY, GAINS, RESULTS, TRIALS, "tuning.html", "tables", "figures", "run.json", DATABASE)
"""What a tuning may write, and replace; the database, which marks the folder as its own, last."""


def open_folder(folder: Path, *, resume: bool, overwrite: bool) -> Path:
    """Make the folder ready; returns where the trials go.

    Raises:
        UserError: it holds trials already, or files of the same names that are not of a tuning.
    """
    database = folder / DATABASE
    if resume and overwrite:
        raise UserError("--resume and --overwrite: choose one")
    if resume and not database.exists():
        raise UserError(f"{folder}: holds no trials to resume; leave --resume out")
    if database.exists() and not (resume or overwrite):
        raise UserError(f"{folder}: holds trials already; go on with --resume, start anew with --overwrite")
    foreign = held(folder, REPLACED)
    if foreign and not database.exists():
        raise UserError(f"{folder}: holds {foreign} that no tuning wrote; choose another folder with --out")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in () if resume else REPLACED:
            remove(folder / name)
    except OSError as error:
        raise UserError(f"{folder}: cannot be written ({error}); choose another folder with --out") from None
    return database


def write_tuning(tuning: Tuning, folder: Path) -> pd.DataFrame:
    """Write gains, results and trials; returns the results, a row a controller."""
    found = tuning.found
    (folder / STUDY_COPY).write_text(tuning.study.text, encoding="utf-8")
    (folder / GAINS).mkdir(exist_ok=True)
    for one in found:
        path = folder / GAINS / f"{one.task.name}.toml"
        if one.best is None:
            path.unlink(missing_ok=True)
        else:
            write_whole(path, partial(Path.write_text, data=gain_file(one), encoding="utf-8"))
    rows = pd.DataFrame([row for one in found for row in history(one)])
    write_whole(folder / TRIALS, lambda path: rows.to_csv(path, index=False, lineterminator="\n"))
    frame = pd.DataFrame([_row(one) for one in found])
    write_whole(folder / RESULTS, lambda path: frame.to_csv(path, index=False, lineterminator="\n"))
    return frame


def _row(one: Tuned) -> dict[str, object]:
    """What became of a controller: objective before and after, margins, quantiles, errors of each case."""
    row: dict[str, object] = {
        "controller": one.task.name,
        "outcome": "tuned" if one.score is not None else infeasible(one),
        "objective_before": one.start.value,
        "objective": None if one.score is None else one.score.value,
        "polish": one.polished,
    }
    for kind, quantiles in (("searched", one.on_searched), ("fresh", one.on_fresh)):
        for when, quantile in quantiles.items():
            row |= {f"{when}_on_{kind}_{key}": getattr(quantile, key) for key in ("value", "low", "high")}
    for when, score in (("before", one.start), ("after", one.score)):
        if score is None:
            continue
        row |= {f"gain_margin_dB_{when}": score.margins.gain_dB, f"phase_margin_deg_{when}": score.margins.phase_deg}
        for case, ran in zip(one.task.cases, score.ran, strict=True):
            label = "_".join(str(value) for value in case.columns.values()) or "case"
            row |= {f"{name}_{label}_{when}": value for name, value in ran.figures.items()}
    return row


def say_tuning(frame: pd.DataFrame) -> None:
    print(frame.T.to_string())

"""Score diagnosis on records of machines of many kinds, whose effects are known in units of what can be found at all.

    PYTHONPATH=tests/helpers python -m family.suite --set tuning --out DIR [--only NAME ...] [--first N] [--resume]

Makes the experiments of a set, diagnoses each, and prints the shares of right answers. `DIR` gets `results.csv` (the
same bytes whatever the number of jobs), `times.csv`, `summary.md`, and a folder for each case. `--make-only` makes the
records alone; with `--resume`, records and results that are in DIR already are taken, and failures tried again.
"""

import argparse
import importlib
import json
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Protocol

import pandas as pd

from .cases import SETS, Case, make_cases
from .making import TRUTH, make, truth_of
from .records import USES
from .scoring import score
from .summary import summary

DIAGNOSE = "workbench.diagnose.diagnose:diagnose"
"""module:function; called with the experiment's path, returns a diagnosis."""

RESULT, FAILURE = "result.json", "failure.txt"

Result = dict[str, Any]
"""`report`, as report.json holds it or with a `failure` in words; `make_s` and `diagnose_s`."""


@dataclass(frozen=True)
class Options:
    """How cases are run: `target` is the diagnosis as `DIAGNOSE`, or None to make records alone."""

    target: str | None = DIAGNOSE
    resume: bool = False
    keep_records: bool = False


class Answer(Protocol):
    """What a diagnosis gives."""

    def to_json(self) -> dict[str, object]:
        """As report.json holds it."""


def load(target: str) -> Callable[[Path], Answer]:
    """The function behind "module:function"."""
    module, _, name = target.partition(":")
    diagnose: Callable[[Path], Answer] = getattr(importlib.import_module(module), name)
    return diagnose


def run_case(case: Case, folder: Path, options: Options) -> Result:
    """Make and diagnose one case; its result is written to `folder` as it ends. A failure is a result, too."""
    folder.mkdir(parents=True, exist_ok=True)
    started = time.perf_counter()
    made = started
    report: dict[str, Any] = {}
    try:
        path = folder / "experiment.toml"
        if not (options.resume and _is_made(folder)):
            path = make(case, folder)
        made = time.perf_counter()
        if options.target is not None:
            report = load(options.target)(path).to_json()
    except Exception as failure:  # noqa: BLE001 - one case that fails must not end the suite
        report = {"failure": f"{type(failure).__name__}: {failure}".splitlines()[0]}
        (folder / FAILURE).write_text(traceback.format_exc(), encoding="utf-8")
    result = {"report": report, "make_s": made - started, "diagnose_s": time.perf_counter() - made}
    if report:
        (folder / RESULT).write_text(json.dumps(result, indent=2, default=float) + "\n", encoding="utf-8")
    if not options.keep_records:
        for use in USES:
            (folder / f"{use}.parquet").unlink(missing_ok=True)
    return result


def _is_made(folder: Path) -> bool:
    """Whether a case's experiment is whole: its file is written last."""
    return all((folder / name).exists() for name in ("experiment.toml", *(f"{use}.parquet" for use in USES)))


def _finished(folder: Path, options: Options) -> Result | None:
    """The stored result of a case, if it may be taken; failures are tried again."""
    if not options.resume:
        return None
    if options.target is None:
        return {"report": {}, "make_s": 0.0, "diagnose_s": 0.0} if _is_made(folder) else None
    if not (folder / RESULT).exists():
        return None
    result: Result = json.loads((folder / RESULT).read_text(encoding="utf-8"))
    return None if "failure" in result["report"] else result


def run_cases(
    cases: Iterable[Case],
    out: Path,
    options: Options,
    *,
    jobs: int = 2,
    tell: Callable[[str], None] = lambda line: None,
) -> dict[str, Result]:
    """Results of all cases by name, in the order of the cases."""
    cases = list(cases)
    results = {case.name: _finished(out / case.name, options) for case in cases}
    todo = [case for case in cases if results[case.name] is None]
    if jobs == 1:
        for case in todo:
            results[case.name] = done = run_case(case, out / case.name, options)
            tell(_line(case, done))
    elif todo:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            futures = {pool.submit(run_case, case, out / case.name, options): case for case in todo}
            for future in as_completed(futures):
                case = futures[future]
                results[case.name] = done = future.result()
                tell(_line(case, done))
    return {name: result for name, result in results.items() if result is not None}


def _line(case: Case, result: Result) -> str:
    report = result["report"]
    times = f"{result['make_s']:.1f} s, {result['diagnose_s']:.1f} s"
    if not report:
        return f"{case.name}: made ({times})"
    if "failure" in report:
        return f"{case.name}: failed, {report['failure']} ({times})"
    named = " ".join(effect["name"] for effect in report["effects"]) or "nothing"
    return f"{case.name}: {report['verdict']}, {named} ({times})"


def times_table(cases: Iterable[Case], results: dict[str, Result]) -> pd.DataFrame:
    """Seconds of each case."""
    return pd.DataFrame([{"case": c.name, **{k: results[c.name][k] for k in ("make_s", "diagnose_s")}} for c in cases])


def scores_table(cases: Iterable[Case], results: dict[str, Result], out: Path) -> pd.DataFrame:
    """Scores, one row each; a case that could not be made has no truth, and no right answer."""
    rows = []
    for case in cases:
        truth = truth_of(out / case.name) if (out / case.name / TRUTH).exists() else {}
        rows.append(score(case, results[case.name]["report"], truth))
    return pd.DataFrame(rows)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m family.suite", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--set", choices=SETS, default=SETS[0], dest="chosen")
    parser.add_argument("--only", nargs="+", default=[], help="effects, unlisted effects, or kinds of cases")
    parser.add_argument("--first", type=int, help="so many cases of each kind")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--diagnose", default=DIAGNOSE, help="module:function that takes an experiment's path")
    parser.add_argument("--resume", action="store_true", help="take the records and results that are in --out already")
    parser.add_argument("--keep-records", action="store_true")
    parser.add_argument("--make-only", action="store_true", help="make the records, diagnose nothing")
    return parser


def main(arguments: list[str] | None = None) -> None:
    """The command."""
    parser = _parser()
    given = parser.parse_args(arguments)
    try:
        cases = make_cases(given.chosen, given.only, given.first)
    except ValueError as mistake:
        parser.error(str(mistake))
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # the jobs share the processors
    options = Options(None if given.make_only else given.diagnose, given.resume, given.keep_records or given.make_only)
    given.out.mkdir(parents=True, exist_ok=True)
    results = run_cases(
        cases, given.out, options, jobs=given.jobs, tell=lambda line: print(line, file=sys.stderr, flush=True)
    )
    if given.make_only:
        return
    scores, times = scores_table(cases, results, given.out), times_table(cases, results)
    scores.to_csv(given.out / "results.csv", index=False)
    times.to_csv(given.out / "times.csv", index=False)
    text = summary(f"Diagnosis, set {given.chosen}", scores, times)
    (given.out / "summary.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()

"""Score diagnosis on records whose effects are known.

    PYTHONPATH=tests/helpers python -m diagnosis.suite --set tuning --out DIR [--only NAME ...] [--strength S ...]

Makes the experiments of a set, diagnoses each, and prints a confusion table and the shares of right answers. `DIR` gets
`results.csv` (the same bytes whatever the number of jobs), `times.csv`, `summary.md`, and a folder for each case.
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
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.diagnose.result import Diagnosis

from .cases import SETS, Case, make_cases
from .generator import USES, make_experiment
from .scoring import FAILED, add_floor_ratio, confusion, figures, score

DIAGNOSE = "workbench.diagnose.diagnose:diagnose"
"""module:function; called with the experiment's path, returns a diagnosis."""

RESULT = "result.json"


def load(target: str) -> Callable[[Path], Diagnosis]:
    """The function behind "module:function"."""
    module, _, name = target.partition(":")
    diagnose: Callable[[Path], Diagnosis] = getattr(importlib.import_module(module), name)
    return diagnose


def run_case(case: Case, folder: Path, target: str, keep_records: bool) -> dict[str, Any]:
    """Make and diagnose one case; its result is written to `folder` as it ends. A failure is a result, too."""
    started = time.perf_counter()
    path = make_experiment(folder, case.effects, case.seed, case.unlisted)
    made = time.perf_counter()
    try:
        report = load(target)(path).to_json()
    except Exception as failure:  # noqa: BLE001 - one case that fails must not end the suite
        report = {"effects": [{"name": FAILED}], "failure": f"{type(failure).__name__}: {failure}".splitlines()[0]}
        (folder / "failure.txt").write_text(traceback.format_exc(), encoding="utf-8")
    times = {"make_s": made - started, "diagnose_s": time.perf_counter() - made}
    result = {"report": report, **times}
    (folder / RESULT).write_text(json.dumps(result, indent=2, default=float) + "\n", encoding="utf-8")
    if not keep_records:
        for use in USES:
            (folder / f"{use}.parquet").unlink()
    return result


def _finished(folder: Path, resume: bool) -> dict[str, Any] | None:
    """The stored result of a case, if it may be taken; failures are tried again."""
    if not resume or not (folder / RESULT).exists():
        return None
    result: dict[str, Any] = json.loads((folder / RESULT).read_text(encoding="utf-8"))
    return None if "failure" in result["report"] else result


def run_cases(
    cases: Iterable[Case],
    out: Path,
    target: str = DIAGNOSE,
    *,
    jobs: int = 2,
    resume: bool = False,
    keep_records: bool = False,
    tell: Callable[[str], None] = lambda line: None,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Scores and times of all cases, one row each, in the order of the cases."""
    cases = list(cases)
    results = {case.name: _finished(out / case.name, resume) for case in cases}
    todo = [case for case in cases if results[case.name] is None]
    if jobs == 1:
        for case in todo:
            results[case.name] = run_case(case, out / case.name, target, keep_records)
            tell(_line(case, results[case.name]))
    elif todo:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            futures = {pool.submit(run_case, case, out / case.name, target, keep_records): case for case in todo}
            for future in as_completed(futures):
                case = futures[future]
                results[case.name] = future.result()
                tell(_line(case, results[case.name]))
    rows = [score(case, results[case.name]["report"]) for case in cases]
    times = [{"case": c.name, **{k: results[c.name][k] for k in ("make_s", "diagnose_s")}} for c in cases]
    return add_floor_ratio(pd.DataFrame(rows)), pd.DataFrame(times)


def _line(case: Case, result: dict[str, Any]) -> str:
    report = result["report"]
    named = " ".join(effect["name"] for effect in report.get("effects") or []) or "nothing"
    return f"{case.name}: {report.get('verdict', 'failed')}, {named} ({result['diagnose_s']:.1f} s)"


def main(arguments: list[str] | None = None) -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m diagnosis.suite", description=__doc__)
    parser.add_argument("--set", choices=SETS, default=SETS[0], dest="chosen")
    parser.add_argument("--only", nargs="+", default=[], help="effects, unlisted effects, or kinds of cases")
    parser.add_argument("--strength", nargs="+", type=float, default=[], help="of single effects")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--diagnose", default=DIAGNOSE, help="module:function that takes an experiment's path")
    parser.add_argument("--resume", action="store_true", help="take the results that are in --out already")
    parser.add_argument("--keep-records", action="store_true")
    options = parser.parse_args(arguments)
    try:
        cases = make_cases(options.chosen, options.only, options.strength)
    except ValueError as mistake:
        parser.error(str(mistake))
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # the jobs share the processors
    options.out.mkdir(parents=True, exist_ok=True)
    scores, times = run_cases(
        cases,
        options.out,
        options.diagnose,
        jobs=options.jobs,
        resume=options.resume,
        keep_records=options.keep_records,
        tell=lambda line: print(line, file=sys.stderr, flush=True),
    )
    scores.to_csv(options.out / "results.csv", index=False)
    times.to_csv(options.out / "times.csv", index=False)
    slowest = (
        f"{times['diagnose_s'].median():.1f} s a diagnosis (median), {times['diagnose_s'].max():.1f} s the longest"
    )
    summary = "\n\n".join(
        [f"# Diagnosis, set {options.chosen}: {len(cases)} cases", confusion(scores), figures(scores)]
    )
    (options.out / "summary.md").write_text(f"{summary}\n\n{slowest}\n", encoding="utf-8")
    print(f"{summary}\n\n{slowest}")


if __name__ == "__main__":
    main()

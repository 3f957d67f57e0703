"""How near the tuner comes to the optimum: against SciPy's differential evolution with ten times its budget.

    python benchmarks/tuning_optimum.py studies/tuning.toml p_feedforward pi pi_feedforward friedland_park

Both make the same objective small under the same constraints, between the same limits. Differential evolution (Storn
and Price 1997, constraints by the rule of Lampinen 2002) shares nothing with the tuner's search; what counts against
its budget are points that are run, not margins. Printed are the tuner's objective, by which share it is above
that of differential evolution with ten times the runs of one seed, and by which share five seeds differ.
"""

import argparse
import contextlib
import os
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.optimize import NonlinearConstraint, differential_evolution

from workbench.study.reading import read_study
from workbench.study.study import Study
from workbench.tune.evaluator import SEARCHED, Evaluator, evaluators_of
from workbench.tune.objective import margins_of
from workbench.tune.prepare import prepared
from workbench.tune.run import tune_all
from workbench.tune.schema import tune_table

TIMES, SEEDS = 10, 5
MEMBERS = 10
"""Of the population, for each gain."""


class Spent(Exception):  # noqa: N818 - no error
    """No run is left."""


def evolved(evaluator: Evaluator, runs: int) -> tuple[float, dict[str, float]]:
    """The least objective that differential evolution finds in so many runs, and where."""
    task, table = evaluator.task, evaluator.objective.table
    best: tuple[float, dict[str, float]] = (np.inf, {})
    count = 0

    def point_at(shares: np.ndarray) -> dict[str, float]:
        return {
            dimension.name: dimension.at(float(share)) for dimension, share in zip(task.dimensions, shares, strict=True)
        }

    def objective(shares: np.ndarray) -> float:
        nonlocal best, count
        if count >= runs:
            raise Spent
        count += 1
        point = point_at(shares)
        score = evaluator.on_draws(point)
        if not score.feasible or not np.isfinite(score.value):
            return 1e9
        if score.value < best[0]:
            judged = range(table.draws if table.constraints.limit_cycle else 0)
            if evaluator.hunting(point, judged, SEARCHED) > 1.0 - table.quantile + 1e-9:
                return 1e9
            best = (score.value, point)
        return score.value

    def beyond(shares: np.ndarray) -> list[float]:
        smallest = margins_of(task.declared(point_at(shares)), table.constraints)
        violations = evaluator.objective.violations(smallest, (), ())
        return [violations["gain margin"], violations["phase margin"]]

    with contextlib.suppress(Spent):
        differential_evolution(
            objective,
            [(0.0, 1.0)] * len(task.dimensions),
            popsize=MEMBERS,
            maxiter=10**6,
            tol=1e-9,
            seed=1,
            polish=False,
            constraints=NonlinearConstraint(beyond, -np.inf, 0.0),
        )
    return best


def compared(study: Study, name: str) -> str:
    """A line of the table."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        tuned = tune_all(study, [name], Path(folder) / "trials.sqlite").tuned[0]
    took = time.process_time() - began
    assert tuned.score is not None
    least, _ = evolved(evaluators_of(study, [name])[0], TIMES * tune_table(study).trials)
    above = 100.0 * (tuned.score.value / least - 1.0)
    differ = 100.0 * (tuned.seeds_differ or 0.0)
    return f"| {name} | {tuned.score.value:.6g} | {least:.6g} | {above:+.2f} | {differ:.2f} | {took:.1f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("study", type=Path)
    parser.add_argument("controller", nargs="+")
    parser.add_argument("--trials", type=int, default=None, help="of each seed; default: what [tune] says")
    options = parser.parse_args()
    study = read_study(options.study)
    study = study.with_section("tune", tune_table(study).model_copy(update={"seeds": SEEDS, "fresh_draws": 0}))
    print("| controller | tuned | differential evolution | above it, % | five seeds differ by, % | tuning CPU, s |")
    print("|---|---|---|---|---|---|")
    for name in options.controller:
        print(compared(prepared(study, [name], options.trials)[0], name), flush=True)


if __name__ == "__main__":
    main()

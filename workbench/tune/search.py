"""The search for gains: optuna's sampler, asked so that the same seed gives the same points whatever happens.

Points are asked for in batches of a fixed size, and each by a sampler with a seed of its own, that of the search and
the point's number. So neither the number of jobs nor a kill changes what is tried: a batch depends only on the trials
of those before it, and these are in the file.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
import optuna
from optuna.distributions import FloatDistribution
from optuna.samplers import TPESampler
from optuna.trial import FrozenTrial, TrialState, create_trial

from workbench.errors import UserError
from workbench.tune.goal import Score
from workbench.tune.space import Dimension, Point

BATCH = 4
"""Points that are asked for at once."""

STARTUP = 12
"""Points at random before the sampler learns."""

SHORT = 5
"""Significant digits with which a point is tried: what a gain file holds is what was tried."""

SCORE = "score"
"""The attribute of a trial that holds what its score was made of."""

IDENTITY = "identity"
"""The attribute of a search that says of which study it is."""

Judge = Callable[[Sequence[Point], float], Sequence[Score]]
"""Scores of points; given too the best value until now, above which a point may be given up."""


@contextmanager
def trials_in(database: Path, name: str, identity: str) -> Iterator[optuna.Study]:
    """The stored search of a controller, new or to go on with.

    Raises:
        UserError: it is of another study.
    """
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    storage = optuna.storages.RDBStorage(f"sqlite:///{database.resolve()}")
    try:
        stored = optuna.create_study(storage=storage, study_name=name, load_if_exists=True)
        known = stored.user_attrs.get(IDENTITY)
        if known is None:
            stored.set_user_attr(IDENTITY, identity)
        elif known != identity:
            raise UserError(
                f"{database.parent}: its trials of {name} are of another study, seed or version of the program; start "
                "anew with --overwrite, or choose another --out"
            )
        yield stored
    finally:
        storage.engine.dispose()


def search(
    stored: optuna.Study,
    dimensions: Sequence[Dimension],
    starts: Sequence[Point],
    judge: Judge,
    trials: int,
    seed: int,
    tell: Callable[[int], None] = lambda done: None,
) -> list[FrozenTrial]:
    """Finished trials, in order: first the `starts`, then the sampler's, until there are `trials` of them.

    Every batch is stored before the next one is asked for.
    """
    distributions = {one.name: FloatDistribution(one.low, one.high, log=one.logarithmic) for one in dimensions}
    done = stored.get_trials(deepcopy=False)
    tell(len(done))
    while len(done) < trials:
        first = len(done) // BATCH * BATCH
        known = done[:first]
        points = _asked(known, range(first, min(first + BATCH, trials)), distributions, starts, seed)
        points = points[len(done) - first :]  # a kill may have left a part of a batch
        best = min((one.value for one in known if is_candidate(one) and one.value is not None), default=np.inf)
        for point, score in zip(points, judge(points, best), strict=True):
            done.append(_finished(point, score, distributions))
            stored.add_trial(done[-1])
        tell(len(done))
    return done


def is_candidate(trial: FrozenTrial) -> bool:
    """Whether a trial may be the best: run to its end, constraints kept."""
    return trial.state == TrialState.COMPLETE and all(value <= 0.0 for value in trial.constraints.values())


def _asked(
    done: Sequence[FrozenTrial],
    numbers: range,
    distributions: Mapping[str, FloatDistribution],
    starts: Sequence[Point],
    seed: int,
) -> list[dict[str, float]]:
    """The points of these numbers; the sampler knows the trials that are `done`, and what it has just asked for."""
    points = []
    with catch_warnings():
        simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        memory = optuna.create_study()
        memory.add_trials(done)
        for number in numbers:
            own = int(np.random.default_rng([seed, number]).integers(2**31))
            memory.sampler = TPESampler(seed=own, n_startup_trials=STARTUP, multivariate=True)
            if number < len(starts):
                memory.enqueue_trial(dict(starts[number]))
            asked = memory.ask(dict(distributions))
            points.append({name: _short(value, distributions[name]) for name, value in asked.params.items()})
    return points


def _short(value: float, limits: FloatDistribution) -> float:
    return min(max(float(f"{value:.{SHORT}g}"), limits.low), limits.high)


def _finished(point: Point, score: Score, distributions: Mapping[str, Any]) -> FrozenTrial:
    """A trial as it is stored. One that was given up tells the sampler how far it came."""
    state = TrialState.PRUNED if score.pruned else TrialState.COMPLETE
    steps = {len(score.on_draws): score.value} if score.pruned else {}
    return create_trial(
        state=state,
        value=None if score.pruned else score.value,
        params=dict(point),
        distributions=dict(distributions),
        constraints=dict(score.violations),
        intermediate_values=steps,
        user_attrs={
            SCORE: {
                "nominal": score.nominal,
                "gain_margin_dB": score.margins.gain_dB,
                "phase_margin_deg": score.margins.phase_deg,
                "stable": score.margins.stable,
            }
        },
    )

"""What a decision would take, told from some of its runs, which are made and not kept."""

import time

from workbench.decide.batches import BatchRuns, batches
from workbench.decide.plan import Plan
from workbench.decide.run import compiled
from workbench.parallel.workers import job_count
from workbench.study.estimate import in_words

LONGEST = 3.0
"""s after which no further run is begun."""


def estimate(plan: Plan, jobs: int | None = None) -> str:
    """About how long a decision takes here with so many `jobs`, in words: candidates are run on the first draw, one
    after another, until that has taken `LONGEST`.

    Compiling is not counted: it is done once.
    """
    compiled(plan)
    asked = plan.table.speed, plan.table.spread
    wanted = [batch for candidate in plan.candidates for batch in batches("search", [(candidate, *asked)], range(1))]
    work, took = BatchRuns(plan, wanted, {}), list[float]()
    for place in range(len(wanted)):
        began = time.perf_counter()
        work([place])
        took.append(time.perf_counter() - began)
        if sum(took) > LONGEST:
            break
    later = took[1:] or took  # the first finds nothing in any cache
    each = sum(later) / len(later) / job_count(jobs)
    told = f"told from {len(took)} run{'s' * (len(took) > 1)}"
    if not plan.several:
        return f"about {in_words(each * plan.runs)} on this machine, {told}"
    fresh = in_words(each * plan.fresh_draws)
    return (
        f"about {in_words(each * plan.runs)} for the search on this machine, and {fresh} for the fresh draws of each "
        f"candidate, {told}"
    )

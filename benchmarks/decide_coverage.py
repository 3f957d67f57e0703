"""Is the probability that `workbench decide` prints right? Its choice on 1000 machines that it has not seen.

    python benchmarks/decide_coverage.py [--specifications 20] [--machines 1000] [--jobs 1]

Each specification draws speed, amplitude, spread of friction, probability and power over wide ranges, and takes as its
accuracy about the least error that any candidate has on one machine, so that it is met now and then. Of the candidate
that the answer names the share of further draws that do what is asked is held against the printed interval.
"""

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.decide.batches import batches, run_batches
from workbench.decide.candidate import candidate_results
from workbench.decide.plan import Plan, plan_decision
from workbench.decide.run import decide
from workbench.study.reading import read_study

MACHINES = ("thesis_simulation", "thesis_rig")

BEYOND = (1.0, 1.3)
"""The accuracy over the least error that any candidate has on one machine."""

STUDY = """\
title = "a specification"
[plant]
model = "by_rpm"
parameters = "owen2001_simulation"
[simulation]
seed = 1
[controllers.p]
type = "pid"
kp = "300 V/m"
[controllers.p_feedforward]
type = "pid"
kp = "300 V/m"
feedforward = 1
[controllers.lugre]
type = "lugre"
law = "valve_inversion"
[uncertainty]
seed = {seed}
scale.mass = {{ min = 0.8, max = 1.5 }}
scale.supply_pressure = {{ min = 0.9, max = 1.05 }}
scale.bulk_modulus = {{ min = 0.3, max = 1, scale = "log" }}
noise.position = {{ max = "0.013 mm" }}
[decide]
machine = "{machine}"
accuracy = {accuracy!r}
speed = {speed!r}
amplitude = {amplitude!r}
power = {power!r}
probability = {probability!r}
spread = {spread!r}
draws = 12
fresh_draws = 100
hold_duration = "1 s"
rpm = [0, 25]
plain = ["p", "p_feedforward"]
"""


@dataclass(frozen=True)
class Checked:
    """A specification: what the answer says of the candidate that it names, and its share of further machines."""

    words: str
    candidate: str
    probability: float
    low: float
    high: float
    later: float

    @property
    def inside(self) -> bool:
        """Whether that share is in the printed interval."""
        return self.low <= self.later <= self.high


def planned(folder: Path, **values: object) -> Plan:
    """The plan of a specification."""
    path = folder / "study.toml"
    path.write_text(STUDY.format(**values), encoding="utf-8")
    return plan_decision(read_study(path))


def specification(folder: Path, seed: int) -> Plan:
    """The specification of a seed; its accuracy is about what the best keeps to on one machine."""
    draw = np.random.default_rng(seed)
    values: dict[str, object] = {
        "seed": seed,
        "machine": MACHINES[seed % len(MACHINES)],
        "speed": float(np.exp(draw.uniform(np.log(15e-3), np.log(80e-3)))),
        "amplitude": float(draw.uniform(1e-3, 6e-3)),
        "power": float(np.exp(draw.uniform(np.log(30.0), np.log(2000.0)))),
        "probability": float(draw.uniform(0.6, 0.95)),
        "spread": float(draw.uniform(0.3, 2.0)),
    }
    trial = planned(folder, accuracy=1.0, **values)
    wanted = [(candidate, trial.table.speed, trial.table.spread) for candidate in trial.candidates]
    number = 10**6 + int(draw.integers(1000))
    least = float(run_batches(trial, batches("search", wanted, [number]), 1)["error_m"].min())
    error = least * float(draw.uniform(*BEYOND))
    return planned(folder, accuracy=error, **values)


def check(plan: Plan, machines: int, jobs: int) -> Checked | None:
    """Decide, then run what the answer names on so many further machines; None where it names nothing measured."""
    decision = decide(plan, jobs)
    named = decision.asked.answer().best
    if named.stage != "fresh":
        return None
    numbers = range(plan.fresh_draws, plan.fresh_draws + machines)
    wanted = [(named.candidate, named.speed, named.spread)]
    (later,) = candidate_results(run_batches(plan, batches("fresh", wanted, numbers), jobs), plan.table)
    table = plan.table
    words = (
        f"{table.accuracy * 1e3:.4f} mm, {table.speed * 1e3:.1f} mm/s, {table.amplitude * 1e3:.1f} mm, "
        f"{table.power:.0f} W, {table.probability:.2f}, {table.spread:.2f} std, {table.machine}"
    )
    candidate = f"{named.controller} at {named.rpm:g} rpm ({named.standing(table)})"
    return Checked(words, candidate, named.probability, named.low, named.high, later.probability)


def checked(count: int, machines: int, jobs: int) -> Iterator[Checked]:
    """So many specifications of which the answer names a candidate that it has measured."""
    seed = 0
    with tempfile.TemporaryDirectory() as folder:
        while count:
            seed += 1
            each = check(specification(Path(folder), seed), machines, jobs)
            if each is not None:
                count -= 1
                yield each


def main() -> None:
    """Print a line a specification, then how many are inside."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--specifications", type=int, default=20)
    options.add_argument("--machines", type=int, default=1000)
    options.add_argument("--jobs", type=int, default=1)
    given = options.parse_args()
    inside = 0
    for each in checked(given.specifications, given.machines, given.jobs):
        inside += each.inside
        print(
            f"{each.words}: {each.candidate}, {each.probability:.3f} ({each.low:.3f} to {each.high:.3f}), "
            f"later {each.later:.3f}: {'inside' if each.inside else 'OUTSIDE'}",
            flush=True,
        )
    print(f"{inside} of {given.specifications} inside")


if __name__ == "__main__":
    main()

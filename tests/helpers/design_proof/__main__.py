"""Show whether designed motions decide what a first record left open.

    PYTHONPATH=tests/helpers python -m design_proof --out DIR [--cases 10]

Takes the first cases of the generator of which a record leaves a pair open, by its likelihood too, designs a motion of
the same length, records it on the generator's machine, and chooses by the likelihood of both records; and the same with
the first motion repeated. Then, of some designs, the share of repeated records that tell the pair is held against what
the design predicts. What is done is kept in DIR and not done again.
"""

import argparse
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from family.cases import Case
from family.limits import with_all
from family.records import FIT, record
from scipy.stats import ncx2, norm

from design_proof.cases import NONE, Pair, cases, pair_of, steered, write
from design_proof.choice import difference, expected
from design_proof.repetitions import share_found
from workbench.design.design import design
from workbench.design.result import Design
from workbench.design.search import ODDS
from workbench.errors import UserError

POWERS = 5
"""Designs of which repetitions are made: those that are least sure come first."""

RESULT = "result.json"
"""Of a case in its folder: null of one that its first record decides."""

CHOICES = "designed", "repeat"
"""Second records."""

Result = dict[str, Any]


def told(gained: float) -> str:
    """What twice the logarithm of the odds for the truth says."""
    return "right" if gained > ODDS else "wrong" if gained < -ODDS else "open"


def run_case(case: Case, pair: Pair, folder: Path) -> Result:
    """Design a motion for a pair, and choose by it and by the first motion repeated."""
    made = pair.made
    write(pair, folder)
    about = {
        "case": case.name,
        "machine": f"{case.machine}, {case.motion}, {case.noise}",
        "true": pair.true,
        "rival": pair.rival,
        "first": pair.apart,
        "duration_s": made.rig.duration,
    }
    rig, first = made.rig, made.records[FIT]
    began = time.perf_counter(), time.process_time()
    try:
        found = design(folder, between=(pair.true, pair.rival), duration=rig.duration)
    except UserError as error:
        return {**about, "refused": str(error), "designed": "open", "repeat": "open"}
    seconds = time.perf_counter() - began[0], time.process_time() - began[1]
    machine = with_all(rig.machine, made.effects.values())
    asked = np.pad(found.legs[0].reference, (0, rig.samples), mode="edge")[: rig.samples]
    designed = record(steered(rig), machine, "designed", asked)
    repeat = record(rig, machine, FIT, scattered="repeat")
    share = share_found(found)
    both = {"designed": [first, designed], "repeat": [first, repeat]}
    gains = {name: difference(pair, records) for name, records in both.items()}
    one = found.told[0]
    return {
        **about,
        "pieces": pieces_of(found),
        "distance": float(np.sqrt(one.distance)),
        "power": [one.power, one.low, one.high],
        "share": share,
        "design_s": seconds,
        **{f"{name}_gain": gain for name, gain in gains.items()},
        **{f"{name}_expected": expected(pair, records) for name, records in both.items()},
        **{name: told(gain) for name, gain in gains.items()},
    }


def pieces_of(found: Design) -> str:
    """The pieces, in words."""
    kinds = [piece.kind for piece in found.pieces]
    return ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))


def results_of(out: Path, count: int) -> Iterator[Result]:
    """Of the first cases that leave a pair open; what is done is kept."""
    found = 0
    for case in cases():
        folder = out / case.name
        kept = folder / RESULT
        if not kept.exists():
            folder.mkdir(parents=True, exist_ok=True)
            pair = pair_of(case)
            is_open = pair is not None and told(difference(pair, [pair.made.records[FIT]])) == "open"
            result = run_case(case, pair, folder) if pair is not None and is_open else None
            kept.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
        result = json.loads(kept.read_text(encoding="utf-8"))
        if result is not None:
            found += 1
            yield result
        if found == count:
            break


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m design_proof", description=__doc__.split("\n\n")[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cases", type=int, default=10)
    given = parser.parse_args()
    results = []
    for result in results_of(given.out, given.cases):
        results.append(result)
        print(line(result), flush=True)
    print(summary(results))


def line(result: Result) -> str:
    """A case in a line."""
    if "refused" in result:
        return f"{result['case']} ({result['machine']}): {result['true']} or {result['rival']}: {result['refused']}"
    power, low, high = result["power"]
    return (
        f"{result['case']} ({result['machine']}): {result['true']} or {result['rival']}, {result['first']:.1f} apart "
        f"first; {result['distance']:.1f} in the design ({result['pieces']}); power {power:.2f} ({low:.2f} to "
        f"{high:.2f}), found {result['share']:.2f}; {'; '.join(_chosen(result, name) for name in CHOICES)}; "
        f"{result['design_s'][0]:.0f} s, {result['design_s'][1]:.0f} s of a processor"
    )


def _chosen(result: Result, name: str) -> str:
    """What one of the second records says, and what is to be expected of it."""
    return f"{name} {result[name]} ({result[f'{name}_gain']:.1f}, on the average {result[f'{name}_expected']:.1f})"


def _share_right(result: Result, name: str) -> float:
    """How often a second record of that kind is right, whatever its noise: of an effect beside none the difference is
    chi-squared about what is expected of it, with a degree of freedom at least, else nearly normal.
    """
    left = result.get(f"{name}_expected", 0.0)
    if result["rival"] == NONE:
        return float(ncx2.sf(ODDS, 1, left))
    return float(norm.sf((ODDS - left) / (2.0 * max(np.sqrt(left), 1e-12))))


def summary(results: list[Result]) -> str:
    """The figures."""
    right = {name: sum(one[name] == "right" for one in results) for name in CHOICES}
    average = {name: sum(_share_right(one, name) for one in results) for name in CHOICES}
    unsure = sorted((one for one in results if "power" in one), key=lambda one: one["power"][0])[:POWERS]
    inside = sum(one["power"][1] <= one["share"] <= one["power"][2] for one in unsure)
    return (
        f"told apart rightly, of {len(results)}: {right['designed']} with the designed record, {right['repeat']} with "
        f"the first repeated; on the average over the sensors' noise, to first order, {average['designed']:.1f} and "
        f"{average['repeat']:.1f}\n"
        f"predicted power holds the share found in {inside} of the {len(unsure)} least sure designs"
    )


if __name__ == "__main__":
    main()

"""One loop in Python: what its simulation costs, and its error estimate, over its duration and its stiffness."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

import workbench as wb
from suite.part import Part, Ratio, Size
from suite.studies import KP
from workbench.publish.style import COLOURS, MARKERS, plain_numbers
from workbench.simulation.simulate import LANES, simulate, simulate_together, solver_error

OWN_DAMPING = 2.28e4
"""N s/m. Bristle damping of the parameter set, which the ratio of stiffness is over."""


SOME = 20
"""Cases of which a mean is taken."""

AT_ONCE = (1, 2, 4, 8)
"""Runs that are simulated together."""


def loop(seconds: float, damping: float | None = None, kp: float = 500.0) -> Any:
    """The loop of the studies here, of another duration, bristle damping (N s/m) or gain (V/m)."""
    return wb.setup(
        "non_rotating",
        "owen2001_simulation",
        controller=wb.pid(kp=kp),
        reference=wb.sine("5 mm", "2 Hz"),
        duration=seconds,
        plant={} if damping is None else {"set": {"bristle_damping": f"{damping:g} N s/m"}},
    )


def least(calls: Sequence[Callable[[], object]], turns: int) -> list[float]:
    """The least processor time (s) of each; they take turns, so that a busy machine hits all alike."""
    best = [float("inf")] * len(calls)
    for call in calls:
        call()
    for _ in range(turns):
        for i, call in enumerate(calls):
            begin = time.process_time()
            call()
            best[i] = min(best[i], time.process_time() - begin)
    return best


def of_a_case(seconds: float, turns: int) -> tuple[float, float]:
    """Processor time (s) of the simulation of a case and of its error estimate: means of some cases of such a study,
    whose gains lie as evenly between the same as those of all.
    """
    setups = [loop(seconds, kp=kp).simulation for kp in np.linspace(*KP, SOME)]
    runs = [simulate(setup) for setup in setups]
    simulation, estimate = least(
        [
            lambda: [simulate(setup) for setup in setups],
            lambda: [solver_error(setup, run) for setup, run in zip(setups, runs, strict=True)],
        ],
        turns,
    )
    return simulation / SOME, estimate / SOME


def seconds(size: Size, folder: Path) -> Part:
    """Time of a run over the seconds that it simulates."""
    cases = [loop(each) for each in size.seconds]
    rounds = [least([lambda case=case: wb.simulate(case) for case in cases], size.turns) for _ in range(size.rounds)]
    times = [min(each) for each in zip(*rounds, strict=True)]

    def draw(axes: Axes) -> None:
        axes.plot(size.seconds, times, marker=MARKERS[0], color=COLOURS[0], label="simulation")
        axes.plot(
            size.seconds,
            [times[-1] * each / size.seconds[-1] for each in size.seconds],
            color="#999999",
            linestyle=":",
            label="in proportion to the longest",
        )
        axes.set_xlabel("simulated time, s")
        axes.set_ylabel("processor time, s")
        _logarithmic(axes)
        axes.legend()

    longest = size.seconds[-1] / size.seconds[0]
    return Part(
        "seconds",
        "Time over simulated seconds",
        "One call of `wb.simulate`: sensors, controller and plant at 1 kHz, default tolerance.",
        ("simulated, s", "ms", "ms for each simulated second"),
        [(f"{s:g}", f"{1e3 * t:.3g}", f"{1e3 * t / s:.3g}") for s, t in zip(size.seconds, times, strict=True)],
        draw,
        ratios={
            "a simulated second of the longest run over one of the shortest": Ratio(
                tuple(each[-1] / each[0] / longest for each in rounds)
            )
        },
    )


def together(size: Size, folder: Path) -> Part:
    """Time of a run over how many of them are simulated at once."""
    setups = [loop(3.0, kp=kp).simulation for kp in np.linspace(*KP, AT_ONCE[-1])]
    setups = [replace(each, reference=setups[0].reference) for each in setups]

    def calls() -> list[Callable[[], object]]:
        return [lambda some=setups[:count]: simulate_together(some) for count in AT_ONCE]

    rounds = [
        [each / count for each, count in zip(least(calls(), size.turns), AT_ONCE, strict=True)]
        for _ in range(size.rounds)
    ]
    times = [min(each) for each in zip(*rounds, strict=True)]

    def draw(axes: Axes) -> None:
        axes.plot(AT_ONCE, [1e3 * t for t in times], marker=MARKERS[0], color=COLOURS[0], label="simulation")
        axes.set_xlabel("runs at once")
        axes.set_ylabel("3 s of closed loop, ms for each run")
        axes.set_xticks(AT_ONCE)
        axes.set_ylim(bottom=0.0)
        axes.legend()

    return Part(
        "together",
        "Time of a run among several",
        f"`simulate_together`: setups that differ in their gains, of which {LANES} are solved at once, to the same "
        "bits as one by one. A diagnosis asks for most of its simulations so.",
        ("runs at once", "ms for each", "over one alone"),
        [(f"{n}", f"{1e3 * t:.3g}", f"{t / times[0]:.3g}") for n, t in zip(AT_ONCE, times, strict=True)],
        draw,
        ratios={
            f"a run of {LANES} at once over one alone": Ratio(
                tuple(each[AT_ONCE.index(LANES)] / each[0] for each in rounds)
            )
        },
    )


def stiffness(size: Size, folder: Path) -> Part:
    """Time of a run over the damping of the bristles, which makes the equations stiff."""
    cases = [loop(3.0), *(loop(3.0, damping) for damping in size.damping)]
    rounds = [least([lambda case=case: wb.simulate(case) for case in cases], size.turns) for _ in range(size.rounds)]
    own, *times = [min(each) for each in zip(*rounds, strict=True)]

    def draw(axes: Axes) -> None:
        axes.plot(size.damping, [1e3 * t for t in times], marker=MARKERS[0], color=COLOURS[0], label="simulation")
        axes.plot([OWN_DAMPING], [1e3 * own], marker=MARKERS[1], color=COLOURS[1], linestyle="", label="the set's own")
        axes.set_xlabel("bristle damping, N s/m")
        axes.set_ylabel("3 s of closed loop, ms")
        axes.set_xscale("log")
        axes.set_ylim(bottom=0.0)
        axes.legend()

    stiffest = f"{size.damping[-1]:g} N s/m"
    return Part(
        "stiffness",
        "Time over stiffness",
        "3 s of the loop with other dampings of the bristles: the larger, the shorter the steps that an explicit "
        "scheme can take where the contact sticks.",
        ("bristle damping, N s/m", "ms", "over the set's own"),
        [(f"{d:g}", f"{1e3 * t:.3g}", f"{t / own:.3g}") for d, t in zip(size.damping, times, strict=True)],
        draw,
        ratios={f"bristle damping {stiffest} over the set's own": Ratio(tuple(each[-1] / each[0] for each in rounds))},
    )


def _logarithmic(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)

"""Studies of one case to many, as the command line runs them: processor time of a case, jobs, memory."""

from pathlib import Path

from matplotlib.axes import Axes

from suite.command import Usage, workbench
from suite.loops import of_a_case
from suite.part import Part, Ratio, Size, shown
from suite.studies import write_cases
from workbench.publish.style import COLOURS, MARKERS, plain_numbers

SECONDS = 1.0
"""Simulated time of a case, s."""

MEGABYTE = 1e6


def run(cases: int, jobs: int, folder: Path) -> Usage:
    """What a study of so many cases takes, its folder of results written to the end."""
    study = write_cases(folder / f"cases_{cases}.toml", cases, SECONDS)
    out = folder / f"cases_{cases}_{jobs}"
    return workbench("run", study, "--out", out, "--jobs", str(jobs), "--overwrite", folder=folder)


def cases(size: Size, folder: Path) -> list[Part]:
    """Time and memory over the number of cases, and one job beside two."""
    run(2, 2, folder)  # compiled code and bytecode are there from here on
    used = [run(each, 1, folder) for each in size.cases]
    few, many = size.cases[0], size.both_jobs
    rounds = [
        (run(few, 1, folder), run(many, 1, folder), run(many, 2, folder), of_a_case(SECONDS, size.turns))
        for _ in range(size.rounds)
    ]
    simulation, estimate = (min(each[3][i] for each in rounds) for i in (0, 1))
    rest = [(one.processor - least.processor) / (many - few) / sum(parts) - 1.0 for least, one, _, parts in rounds]
    return [
        Part(
            "cases",
            "Time over cases",
            f"`workbench run STUDY --jobs 1` on studies of cases of {SECONDS:g} s, error estimates included, to the "
            "finished folder. Start-up is in it: of few cases it is nearly all. The lines are what the simulation "
            "alone takes, and with its error estimate; between them and the curve is all the rest.",
            ("cases", "wall time, s", "processor time, s", "processor time of a case, ms"),
            [
                (f"{n}", shown(u.wall), shown(u.processor), shown(1e3 * u.processor / n))
                for n, u in zip(size.cases, used, strict=True)
            ],
            lambda axes: _draw_time(axes, size, used, simulation, estimate),
            ratios={
                "error estimate over simulation": Ratio(tuple(parts[1] / parts[0] for *_, parts in rounds)),
                "all the rest over simulation and error estimate": Ratio(tuple(rest)),
                f"{many} cases, one job over two, wall time": Ratio(
                    tuple(one.wall / two.wall for _, one, two, _ in rounds)
                ),
            },
        ),
        Part(
            "memory",
            "Memory over cases",
            "Largest resident memory of any process of the same runs.",
            ("cases", "MB"),
            [(f"{n}", f"{u.memory / MEGABYTE:.0f}") for n, u in zip(size.cases, used, strict=True)],
            lambda axes: _draw_memory(axes, size, used),
            ratios={
                f"memory of {many} cases over that of {few}": Ratio(
                    tuple(one.memory / least.memory for least, one, *_ in rounds)
                )
            },
        ),
    ]


def _draw_time(axes: Axes, size: Size, used: list[Usage], simulation: float, estimate: float) -> None:
    each = [1e3 * u.processor / n for n, u in zip(size.cases, used, strict=True)]
    axes.plot(size.cases, each, marker=MARKERS[0], color=COLOURS[0], label="the whole command")
    both = 1e3 * (simulation + estimate)
    axes.axhline(both, color=COLOURS[1], linestyle="--", label=f"simulation and error estimate, {both:.2g} ms")
    axes.axhline(
        1e3 * simulation, color=COLOURS[2], linestyle="-.", label=f"simulation alone, {1e3 * simulation:.2g} ms"
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    axes.set_xlabel("cases in the study")
    axes.set_ylabel("processor time of a case, ms")
    axes.legend()


def _draw_memory(axes: Axes, size: Size, used: list[Usage]) -> None:
    axes.plot(size.cases, [u.memory / MEGABYTE for u in used], marker=MARKERS[0], color=COLOURS[0])
    axes.set_xscale("log")
    plain_numbers(axes.xaxis)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("cases in the study")
    axes.set_ylabel("largest resident memory, MB")

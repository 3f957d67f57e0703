"""How long commands take before they are useful, in processor time, and the first result of a small study."""

import sys
from pathlib import Path

from matplotlib.axes import Axes

from suite.command import NUMPY, WORKBENCH, usage
from suite.part import Part, Ratio, Size
from suite.studies import write_small

FLOOR = "libraries alone"
OTHERS = ("import numpy", FLOOR)
"""What is not the program's."""


def startup(size: Size, folder: Path) -> Part:
    """The least of `size.starts` starts of each; they take turns."""
    study = write_small(folder / "small.toml")
    commands = {
        "import numpy": NUMPY,
        "workbench --help": (*WORKBENCH, "--help"),
        "workbench list": (*WORKBENCH, "list"),
        "workbench check STUDY": (*WORKBENCH, "check", study),
        FLOOR: (sys.executable, Path(__file__).with_name("floor.py"), folder),
        "workbench run STUDY": (*WORKBENCH, "run", study, "--out", folder / "small", "--jobs", "1", "--overwrite"),
    }
    for command in commands.values():
        usage(command, folder)
    rounds = []
    for _ in range(size.rounds):
        starts = [[usage(command, folder).processor for command in commands.values()] for _ in range(size.starts)]
        rounds.append([min(each) for each in zip(*starts, strict=True)])
    best = dict(zip(commands, (min(each) for each in zip(*rounds, strict=True)), strict=True))

    def draw(axes: Axes) -> None:
        names = list(best)[::-1]
        colours = ["#bbbbbb" if name in OTHERS else "#0072B2" for name in names]
        bars = axes.barh(names, [best[name] for name in names], color=colours)
        axes.bar_label(bars, [f" {best[name]:.2f} s" for name in names], fontsize="small")
        axes.margins(x=0.12)
        axes.set_xlabel("processor time, s")
        axes.grid(axis="y", visible=False)

    numpy = best["import numpy"]
    return Part(
        "startup",
        "Start-up",
        "Processor time of whole commands, the least of many starts, code compiled before: help, all lists, a check, "
        "and a study of one case of 3 s with a table and a figure, its folder finished. Grey: a Python that imports "
        "NumPy and ends, which all but help pay too; and one that loads a function that numba has compiled before and "
        "draws a figure as PNG, SVG and PDF, which a study with a figure pays.",
        ("command", "processor time, s", "over import numpy"),
        [
            (name if name == FLOOR else f"`{name}`", f"{value:.2f}", f"{value / numpy:.1f}")
            for name, value in best.items()
        ],
        draw,
        height=2.8,
        ratios={
            f"{name} over import numpy": Ratio(tuple(each[i] / each[0] for each in rounds))
            for i, name in enumerate(commands)
            if i
        }
        | {f"workbench run STUDY over {FLOOR}": Ratio(tuple(each[-1] / each[-2] for each in rounds))},
    )

"""What a record asks of `identify` and `diagnose`, over its length."""

from pathlib import Path

from matplotlib.axes import Axes

from suite.command import workbench
from suite.part import Part, Ratio, Size
from suite.studies import write_experiment, write_rig
from workbench.publish.style import MARKERS, line_style, plain_numbers

QUESTIONS = ("identify", "diagnose")


def record(seconds: float, folder: Path) -> Path:
    """An experiment of one record of so many seconds at 1 kHz, made by a study."""
    rig = folder / f"rig_{seconds:g}"
    workbench("run", write_rig(folder / "rig.toml", seconds), "--out", rig, "--overwrite", folder=folder)
    (made,) = (rig / "records").glob("*.parquet")
    return write_experiment(folder / f"experiment_{seconds:g}.toml", seconds, made)


def records(size: Size, folder: Path) -> Part:
    """Both questions, once for each length: they take seconds to minutes."""
    files = {seconds: record(seconds, folder) for seconds in size.records}
    times = {
        question: [
            workbench(question, file, "--out", folder / question, "--overwrite", folder=folder).processor
            for file in files.values()
        ]
        for question in QUESTIONS
    }

    def draw(axes: Axes) -> None:
        for number, (question, spent) in enumerate(times.items()):
            axes.plot(size.records, spent, marker=MARKERS[number], label=f"workbench {question}", **line_style(number))
        axes.set_xlabel("length of the record, s (at 1 kHz)")
        axes.set_ylabel("processor time, s")
        axes.set_yscale("log")
        axes.set_xticks(size.records)
        plain_numbers(axes.yaxis)
        axes.legend()

    return Part(
        "records",
        "Time over the length of a record",
        "One record of position, two pressures and voltage at 1 kHz with noise. `identify` fits two friction "
        "parameters by simulation, `diagnose` asks which of all effects the plant lacks.",
        ("record, s", *(f"{question}, s" for question in QUESTIONS)),
        [
            (f"{seconds:g}", *(f"{times[question][i]:.3g}" for question in QUESTIONS))
            for i, seconds in enumerate(size.records)
        ],
        draw,
        ratios={
            f"{question} of {size.records[-1]:g} s over {size.records[0]:g} s": Ratio((spent[-1] / spent[0],))
            for question, spent in times.items()
        },
    )

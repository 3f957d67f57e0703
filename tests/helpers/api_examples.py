"""The examples of the public names' docstrings, and what they take as given."""

import doctest
from collections.abc import Iterator
from pathlib import Path

import nbformat
from command import write
from experiments import experiment_text, make_record

import workbench as wb
from workbench import api

EXPERIMENT, _, _ = experiment_text({"coulomb": 0.8, "viscous": 1.2}, ["coulomb", "viscous"]).partition("[truth]")

FACES = (
    *("run", "results", "diagnosis", "identification", "tuning", "decision"),
    "run.plot('axial_friction', against='velocity')",
)
"""What the last cells of the notebook show: what earlier ones have made, and at the end a figure."""


def given_experiment(folder: Path) -> Path:
    """An experiment with its record, in `folder`."""
    make_record(folder)
    return write(folder, EXPERIMENT, "experiment.toml")


def given(folder: Path, experiment: Path) -> dict[str, object]:
    """What examples take as given: an empty folder, an experiment with its record, and the module's small study."""
    names: dict[str, object] = {"wb": wb, "folder": folder, "experiment": experiment}
    for example in doctest.DocTestParser().get_examples(api.__doc__ or ""):
        if example.source.startswith("small_study"):
            exec(example.source, names)
    return names


def documented() -> Iterator[tuple[str, str]]:
    """Every public name with its documentation; of a class also those of its methods."""
    yield "workbench", api.__doc__ or ""
    for name in api.__all__:
        thing = getattr(api, name)
        yield name, thing.__doc__ or ""
        if isinstance(thing, type):
            for method, value in vars(thing).items():
                documentation = getattr(value, "__doc__", None)
                if not method.startswith("_") and documentation:
                    yield f"{name}.{method}", documentation


def examples() -> dict[str, str]:
    """The documentation of every public name that has an example, by name."""
    return {name: text for name, text in documented() if ">>>" in text}


def notebook(folder: Path, experiment: Path) -> nbformat.NotebookNode:
    """A notebook of all examples, a cell each, those that end in an error left out; then the faces of results.

    They take the `experiment` as given. Each example has a folder of its own in `folder`.
    """
    begin = "from pathlib import Path\nimport workbench as wb\n"
    cells = [begin + f"experiment = Path({str(experiment)!r})"]
    for number, text in enumerate(examples().values()):
        parsed = [item for item in doctest.DocTestParser().get_examples(text) if item.exc_msg is None]
        cells.append(f"folder = Path({str(folder / str(number))!r})\n" + "".join(item.source for item in parsed))
    setup = (
        "results = wb.Study(small_study).run(folder / 'faces')\nrun = wb.simulate(wb.Study(small_study).setup(rpm=120))"
    )
    sources = [*cells, setup, *FACES]
    return nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source) for source in sources])

"""workbench check: any file, checked to the last key, and what it would do."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from workbench.cli.options import print_warnings, say

if TYPE_CHECKING:
    from workbench.study.layers import Layer


def command(
    file: Annotated[Path, typer.Argument(help="A study, machine, scenario, experiment or parameters.", metavar="FILE")],
) -> None:
    """Check a file to the last key and say what it would do. Nothing is run or written."""
    from workbench.records.experiment import is_experiment
    from workbench.study.layers import layer_of
    from workbench.toml.gain_file import is_gain_file
    from workbench.toml.reading import read_toml

    data, _ = read_toml(file)
    if "parameters" in data:
        _check_parameters(file)
    elif is_gain_file(data):
        _check_gains(file)
    elif is_experiment(data):
        from workbench.cli.check_experiment import check_experiment

        check_experiment(file)
    elif (layer := layer_of(file)) is not None:
        _check_layer(layer, file)
    else:
        _check_study(file)


def _check_parameters(file: Path) -> None:
    """Say which plants a parameter set serves."""
    from workbench.parameters.sets import read_parameters, serves

    values = read_parameters(file)
    say(f"{file}: a parameter set of {len(values)} values, all in order")
    for line in serves(values):
        say(f"  {line}")


def _check_gains(file: Path) -> None:
    """Say what a gain file holds."""
    from workbench.toml.gain_file import read_gain_file

    found = read_gain_file(file)
    say(f"{file}: tuned gains of {found.type}, in order")
    for entry in found.at:
        settings = ", ".join(f"{name} {value}" for name, value in entry.settings.items())
        say(f"  {'any speed' if entry.rpm is None else f'{entry.rpm:g} rpm'}: {settings}")
    if found.source:
        say(found.source)


def _check_layer(layer: "Layer", file: Path) -> None:
    """Say what a machine or scenario changes."""
    from workbench.study.plan import plan
    from workbench.study.reading import layer_trial

    trial = plan(layer_trial(layer, file)).study
    tables = ", ".join(f"[{name}]" for name in getattr(trial.file, layer.section)[file.stem]) or "nothing"
    say(f"{file}: a {layer.axis}, in order; it changes {tables}")


def _check_study(file: Path) -> None:
    """Say what a study would run, and what other commands would do with it."""
    from workbench.study.description import description
    from workbench.study.plan import plan
    from workbench.study.reading import read_study
    from workbench.study.sections import other_command, sections_of

    study = read_study(file)
    planned = None if other_command(study) is not None else plan(study)
    lines = [] if planned is None else description(planned)
    for section, table in sections_of(study):
        lines += section.describe(table, study)
    say("\n".join([f"{file}: a study, in order", *lines]))
    if planned is not None:
        print_warnings(planned.warnings)

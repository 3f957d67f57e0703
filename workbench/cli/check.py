"""What a file would do, in words, once it is known to be in order."""

from pathlib import Path

from workbench.cli.check_experiment import check_experiment
from workbench.cli.plan import say_decision, say_plan, say_tuning_plan
from workbench.decide.plan import plan_decision
from workbench.files import read_toml
from workbench.identify.experiment import is_experiment
from workbench.parameters import read_parameters, serves
from workbench.study.document import layer_trial, only_decides, read_study
from workbench.study.gain_file import is_gain_file, read_gain_file
from workbench.study.layers import layer_of
from workbench.study.runner import plan
from workbench.tune.study import tasks_of


def check_file(file: Path) -> None:
    """Check a study, machine, scenario, experiment or parameter set to the last key, and print what it would do.

    Raises:
        UserError: a mistake in it.
    """
    data, _ = read_toml(file)
    if "parameters" in data:
        values = read_parameters(file)
        print(f"{file}: a parameter set of {len(values)} values, all in order")
        for line in serves(values):
            print(f"  {line}")
        return
    if is_gain_file(data):
        _check_gains(file)
        return
    if is_experiment(data):
        check_experiment(file)
        return
    if (layer := layer_of(file)) is not None:
        trial = plan(layer_trial(layer, file)).study
        tables = ", ".join(f"[{name}]" for name in getattr(trial.file, layer.section)[file.stem]) or "nothing"
        print(f"{file}: a {layer.axis}, in order; it changes {tables}")
        return
    study = read_study(file)
    planned = None if only_decides(study) else plan(study)
    decision = None if study.file.decide is None else plan_decision(study)
    tasks = tasks_of(study) if study.file.tune is not None else []
    print(f"{file}: a study, in order")
    if planned is not None:
        say_plan(planned)
    if decision is not None:
        say_decision(decision)
    if tasks:
        say_tuning_plan(tasks)


def _check_gains(file: Path) -> None:
    """Say what a gain file holds."""
    found = read_gain_file(file)
    print(f"{file}: tuned gains of {found.type}, in order")
    for entry in found.at:
        settings = ", ".join(f"{name} {value}" for name, value in entry.settings.items())
        print(f"  {'any speed' if entry.rpm is None else f'{entry.rpm:g} rpm'}: {settings}")
    print(found.source)

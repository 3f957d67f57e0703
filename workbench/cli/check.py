"""What a file would do, in words, once it is known to be in order."""

from pathlib import Path

from workbench.cli.check_experiment import check_experiment
from workbench.cli.plan import say_plan
from workbench.files import read_toml
from workbench.identify.experiment import is_experiment
from workbench.parameters import read_parameters, serves
from workbench.study.document import read_study, scenario_trial
from workbench.study.runner import plan
from workbench.study.scenarios import is_scenario


def check_file(file: Path) -> None:
    """Check a study, scenario, experiment or parameter set to the last key, and print what it would do.

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
    if is_experiment(data):
        check_experiment(file)
        return
    if is_scenario(file):
        trial = plan(scenario_trial(file)).study
        tables = ", ".join(f"[{name}]" for name in trial.file.scenarios[file.stem]) or "nothing"
        print(f"{file}: a scenario, in order; it changes {tables}")
        return
    planned = plan(read_study(file))
    print(f"{file}: a study, in order")
    say_plan(planned)

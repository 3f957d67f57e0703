"""What a file would do, in words, once it is known to be in order."""

from pathlib import Path

from workbench.cli.plan import say_decision, say_plan, say_tuning_plan
from workbench.decide.plan import plan_decision
from workbench.files import read_toml
from workbench.identify.experiment import is_experiment, read_experiment
from workbench.identify.readiness import check_experiment, check_pattern, check_records
from workbench.identify.records import read_record
from workbench.parameters import read_parameters, serves
from workbench.study.document import only_decides, read_study, scenario_trial
from workbench.study.gain_file import is_gain_file, read_gain_file
from workbench.study.runner import plan
from workbench.study.scenarios import is_scenario
from workbench.tune.study import tasks_of


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
    if is_gain_file(data):
        _check_gains(file)
        return
    if is_experiment(data):
        _check_experiment(file)
        return
    if is_scenario(file):
        trial = plan(scenario_trial(file)).study
        tables = ", ".join(f"[{name}]" for name in trial.file.scenarios[file.stem]) or "nothing"
        print(f"{file}: a scenario, in order; it changes {tables}")
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
    settings = ", ".join(f"{name} {value}" for name, value in found.settings.items())
    print(f"{file}: tuned gains of {found.type}, in order: {settings}")
    print(found.source)


def _check_experiment(file: Path) -> None:
    """Say what an experiment would do, once it is known to be in order; its records are read where they are there."""
    content = read_experiment(file)
    check_experiment(content, content.method)
    check_pattern(content)
    records = [read_record(spec, content) if spec.path.exists() else None for spec in content.records]
    there = [record for record in records if record is not None]
    whole = len(there) == len(records)
    if whole:
        check_records(content, [record for record in there if record.use == "fit"], content.method)
    absent = "its records are not there yet" if not there else "some of its records are not there yet"
    print(f"{file}: an experiment, in order" if whole else f"{file}: an experiment; {absent}")
    print(content.title + (f" ({content.source})" if content.source else ""))
    print(f"  plant {content.plant.name}, {content.declared}; channels: {', '.join(content.channels)}")
    print(f"  free: {', '.join(content.free) if content.free else 'friction in the directions of the records'}")
    for spec, record in zip(content.records, records, strict=True):
        if record is None:
            print(f"  {spec.path}: is not there yet")
            continue
        said = "".join(f"; {note}" for note in record.notes)
        print(f"  {spec.path}: {spec.use}, {record.time[-1]:g} s at {1.0 / record.sample_time:.6g} Hz{said}")

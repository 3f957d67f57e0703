"""An edit between a stopped command and its --resume: of a gain file, a parameter file, a machine, what is drawn, the
program. Rows of before and after would stand in one table.
"""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from command import ROOT, STUDIES, fails, workbench, write

from workbench.decide.kept import identity_of
from workbench.decide.plan import plan_decision
from workbench.study.plan import plan
from workbench.study.reading import read_study
from workbench.study.resolve import parse_case
from workbench.study.unfold import unfold
from workbench.tune.prepare import cases_for, prepared, tasks_for
from workbench.tune.trials import kept_identity

STUDY = """\
title = "a study of files"
[plant]
model = "non_rotating"
parameters = "rig.toml"
[axes]
machine = ["mine"]
controller = ["p", "tuned"]
[controllers]
p = { type = "pid", kp = "500 V/m" }
tuned = { gains = "tuned/p.toml" }
[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"
[simulation]
duration = "0.2 s"
transient = "0.1 s"
[uncertainty]
draws = 2
scale.mass = { min = 0.8, max = 1.5 }
noise.position = { max = "2 um" }
[tune]
trials = 2
seeds = 1
draws = 2
objective.rms_error = 1
[decide]
machine = "mine"
accuracy = "1 mm"
speed = "20 mm/s"
amplitude = "1 mm"
power = "2 kW"
draws = 2
rpm = [0]
plain = ["p"]
fresh_draws = 2
hold_duration = "0.1 s"
"""

GAINS = (STUDIES / "tuned" / "differential_cylinder" / "p.toml").read_text(encoding="utf-8")

KP = ('kp = "2000 V/m"', 'kp = "2001 V/m"')

MACHINE = 'title = "t"\nsource = "s"\n[plant.set]\nbulk_modulus = "900 MPa"\n'

PARAMETERS = (ROOT / "plants" / "parameters" / "owen2001_experiment.toml").read_text(encoding="utf-8")


def files(folder: Path, name: str = "", old: str = "", new: str = "") -> Path:
    """The study with its files in a new folder, one place of one file edited."""
    contents = {
        "study.toml": STUDY,
        "tuned/p.toml": GAINS,
        "machines/mine.toml": MACHINE,
        "rig.toml": PARAMETERS,
    }
    if name:
        contents[name], count = re.subn(old, new, contents[name], count=1)
        assert count, (name, old)
    for each in ("tuned", "machines"):
        (folder / each).mkdir(parents=True)
    for each, text in contents.items():
        write(folder, text, each)
    return folder / "study.toml"


def of_run(path: Path) -> Mapping[str, object]:
    return plan(read_study(path)).identity


def of_tune(path: Path) -> Mapping[str, object]:
    study, names = prepared(read_study(path), ["tuned"], None)
    reference = [parse_case(study, case) for case in cases_for(study, unfold(study), "p", {})]
    (task,) = tasks_for(study, names)
    return kept_identity(task, reference)


def of_decide(path: Path) -> Mapping[str, object]:
    return identity_of(plan_decision(read_study(path)))


IDENTITIES: Mapping[str, Callable[[Path], Mapping[str, object]]] = {"run": of_run, "tune": of_tune, "decide": of_decide}

EDITS = {
    "gain file": ("tuned/p.toml", *KP),
    "parameter": ("rig.toml", r'(?<=\[parameters.mass\]\nvalue = ")[\d.]+', "15.5"),
    "deviation of a parameter": ("rig.toml", r'(\[parameters.coulomb\]\n(?:.*\n)*?std = ")[\d.]+', r"\g<1>1.23"),
    "machine file": ("machines/mine.toml", "900 MPa", "901 MPa"),
    "noise that is drawn": ("study.toml", "2 um", "3 um"),
    "calibration that is drawn": ("study.toml", r"\[uncertainty\]\n", "[uncertainty]\ncalibration = false\n"),
    "seed of the draws": ("study.toml", r"\[uncertainty\]\n", "[uncertainty]\nseed = 2\n"),
}


EDITED = [(command, edited) for command in IDENTITIES for edited in EDITS]


Unedited = Mapping[str, Mapping[str, object]]


@pytest.fixture(scope="module")
def unedited(tmp_path_factory: pytest.TempPathFactory) -> Unedited:
    """By command what its rows are of, before any edit."""
    path = files(tmp_path_factory.mktemp("unedited") / "before")
    return {command: identity(path) for command, identity in IDENTITIES.items()}


@pytest.mark.parametrize(("command", "edited"), EDITED)
def test_an_edit_is_noticed(tmp_path: Path, unedited: Unedited, command: str, edited: str) -> None:
    assert IDENTITIES[command](files(tmp_path / "after", *EDITS[edited])) != unedited[command]


@pytest.mark.parametrize("command", IDENTITIES)
def test_the_same_elsewhere_is_the_same(tmp_path: Path, unedited: Unedited, command: str) -> None:
    assert IDENTITIES[command](files(tmp_path / "same")) == unedited[command]


@pytest.mark.parametrize("command", IDENTITIES)
def test_another_program_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unedited: Unedited, command: str
) -> None:
    for module in ("study.plan", "tune.trials", "decide.kept"):
        monkeypatch.setattr(f"workbench.{module}.source_hash", lambda folders: "edited")
    assert IDENTITIES[command](files(tmp_path / "after")) != unedited[command]


def test_trials_of_a_tuned_controller_do_not_hang_on_the_others(tmp_path: Path, unedited: Unedited) -> None:
    other = files(tmp_path / "after", "study.toml", r"(?=\[references)", 'other = { type = "pid", kp = "1 V/m" }\n')
    assert of_tune(other) == unedited["tune"]


def test_more_draws_go_on_with_the_runs_of_a_decision(tmp_path: Path, unedited: Unedited) -> None:
    more = files(tmp_path / "after", "study.toml", "fresh_draws = 2", "fresh_draws = 9\nprobability = 0.8")
    assert of_decide(more) == unedited["decide"]


OTHER_TRIALS = "its trials of tuned, seed 1 are of another study or version of the program (parameters)"


@pytest.mark.parametrize(
    ("command", "stop", "said"),
    [
        (("decide",), "decide.run.confirm", "its results are of other parameters or draws"),
        (("tune", "--controller", "tuned"), "tune.search.Search._along", OTHER_TRIALS),
    ],
    ids=["decide", "tune"],
)
def test_what_differs_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], stop: str, said: str
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    path, out = files(tmp_path / "before"), tmp_path / "out"
    name, *options = command
    with monkeypatch.context() as patch:
        patch.setattr(f"workbench.{stop}", stopped)
        assert workbench(name, path, "--out", out, *options).code == 130
    write(path.parent, GAINS.replace(*KP), "tuned/p.toml")
    refused = workbench(name, path, "--out", out, *options, "--resume")
    fails(refused, f"error: {out}: {said}; start anew with --overwrite, or choose another --out")


def test_of_more_cases_than_are_looked_at_every_gain_file_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An entry for one speed of many: no case that stands for all need have it."""
    monkeypatch.setattr("workbench.study.plan.MOST_CHECKED", 100)
    path = files(tmp_path)
    speeds = ", ".join(map(str, range(1, 60)))
    text = path.read_text(encoding="utf-8").replace("[axes]", f'[axes]\n"simulation.seed" = [{speeds}]', 1)
    path.write_text(re.sub(r"(?s)\[uncertainty\].*?\[tune\]", "[tune]", text), encoding="utf-8")
    before = plan(read_study(path))
    known = before.identity
    assert len(before.checked) < len(before.cases)
    gains = tmp_path / "tuned" / "p.toml"
    gains.write_text(gains.read_text(encoding="utf-8") + "\n# an entry that nobody has looked at\n", encoding="utf-8")
    after = plan(read_study(path)).identity
    differing = {key for key, value in after.items() if value != known[key]}
    assert differing == {"content of its gain files"}

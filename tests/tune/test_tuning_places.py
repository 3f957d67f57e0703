"""Gains tuned where they are used: for each speed of rotation and machine, along the bounds of constraints."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from command import workbench, write
from scipy.optimize import brentq
from tuned_study import STUDY, ready, tuned

from workbench.errors import UserError
from workbench.study.reading import read_study
from workbench.study.resolve import resolve
from workbench.study.unfold import unfold
from workbench.toml.gain_file import entry_at, gain_file_text, read_gain_file
from workbench.tune.objective import margins_of
from workbench.tune.prepare import task_for, tasks_for
from workbench.tune.refine import descend
from workbench.tune.report.gain_files import gain_files
from workbench.tune.report.places import place_lines, seeds_line
from workbench.tune.report.tables import number
from workbench.tune.schema import tune_table
from workbench.tune.trials import key_of

pytestmark = pytest.mark.usefixtures("dots_alone")

PLACES = (
    STUDY.replace('model = "non_rotating"', 'model = "by_rpm"\nbristle = "isotropic"')
    .replace("[axes]\n", '[axes]\nmachine = ["light", "heavy"]\nrpm = [0, "60 rpm"]\n')
    .replace("seeds = 1", 'seeds = 1\nper = ["machine", "rpm"]')
) + '[machines.light.plant.set]\nmass = "20 kg"\n[machines.heavy.plant.set]\nmass = "60 kg"\n'


# --- along the bound of a constraint ---


def test_a_descent_ends_on_the_bound_of_a_constraint() -> None:
    """(x - 0.8)^2 + (y - 0.9)^2 under x + y <= 1 is least at (0.45, 0.55): the foot of the perpendicular."""
    met: list[tuple[float, float, np.ndarray]] = []

    def tried(at: np.ndarray) -> tuple[float, Mapping[str, float]]:
        beyond = float(at[0] + at[1] - 1.0)
        value = math.exp((at[0] - 0.8) ** 2 + (at[1] - 0.9) ** 2)
        met.append((value, beyond, at))
        return value, {"phase margin": beyond, "gain margin": -1.0, "saturation": -1.0, "limit cycle": -1.0}

    descend(tried, np.array([0.1, 0.2]), 0.1, 40)
    assert len(met) <= 40
    value, _, at = min((each for each in met if each[1] <= 0.0), key=lambda each: each[0])
    assert at == pytest.approx([0.45, 0.55], abs=0.01)
    assert value == pytest.approx(math.exp(0.245), rel=2e-3)


def test_a_descent_does_without_what_lies_behind_a_wall() -> None:
    """(x - 0.8)^2 with all above 0.6 hunting is least at 0.6."""
    best = []

    def tried(at: np.ndarray) -> tuple[float, Mapping[str, float]]:
        hunts = 1.0 if at[0] > 0.6 else -1.0
        if hunts < 0.0:
            best.append(float(at[0]))
        beyond = {"phase margin": -1.0, "gain margin": -1.0, "saturation": -1.0, "limit cycle": hunts}
        return math.exp((at[0] - 0.8) ** 2), beyond

    descend(tried, np.array([0.2]), 0.1, 40)
    assert max(best) == pytest.approx(0.6, abs=0.02)


def test_the_gain_of_a_p_is_that_at_which_its_phase_margin_is_45_degrees(tmp_path: Path) -> None:
    """Its error falls with K_p all the way: the root of phase margin - 45 is the optimum, found here by brentq."""
    study, _ = ready(tmp_path, STUDY, "p")
    task = task_for(study, "p")

    def lacking(kp: float) -> float:
        return margins_of(task.declared({"kp": kp}), tune_table(study).constraints).phase_deg - 45.0

    result = tuned(tmp_path, STUDY.replace("seeds = 1", "seeds = 3"), "p", trials=24).tuned[0]
    assert result.best is not None
    assert result.best["kp"] == pytest.approx(brentq(lacking, 500.0, 4000.0), rel=5e-3)
    assert result.seeds_differ is not None
    assert result.seeds_differ < 0.02


# --- where they are used ---


def test_each_place_has_a_tuning_of_its_own(tmp_path: Path) -> None:
    """The same controller on the same belief has other gains on another machine; a file has an entry a speed."""
    tuning = tuned(tmp_path, PLACES, "p", trials=8)
    assert [each.task.label for each in tuning.tuned] == [
        f"p, machine {machine}, rpm {rpm}" for machine in ("light", "heavy") for rpm in ("0", "60 rpm")
    ]
    assert len({repr(each.best) for each in tuning.tuned}) > 1
    texts = {name: gain_file_text(content) for name, content in gain_files(tuning.tuned).items()}
    assert list(texts) == ["light/p.toml", "heavy/p.toml"]
    assert max(map(len, texts.values())) < 4000
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir()
        kept = read_gain_file(write(tmp_path, text, name))
        assert [entry.rpm for entry in kept.at] == [0.0, 60.0]
    using = PLACES.replace('p = { type = "pid", kp = "500 V/m" }', 'p = { gains = "{machine}/p.toml" }')
    study = read_study(write(tmp_path, using, "using.toml"))
    cases = [case for case in unfold(study) if case.axes["controller"] == "p"]
    for case, each in zip(cases, tuning.tuned, strict=True):
        assert each.best is not None
        assert resolve(study, case).settings.kp == pytest.approx(each.best["kp"], rel=1e-9)


def test_gains_for_another_speed_are_refused_in_words(tmp_path: Path) -> None:
    tuning = tuned(tmp_path, PLACES.replace('"light", "heavy"', '"light"'), "p", trials=6)
    (tmp_path / "light").mkdir()
    path = write(tmp_path, gain_file_text(gain_files(tuning.tuned)["light/p.toml"]), "light/p.toml")
    using = PLACES.replace('p = { type = "pid", kp = "500 V/m" }', 'p = { gains = "light/p.toml" }')
    using = using.replace('rpm = [0, "60 rpm"]', "rpm = [0, 25]").replace('"light", "heavy"', '"light"')
    answer = workbench("check", write(tmp_path, using, "using.toml"))
    assert answer.code == 2
    assert "was not tuned at 25 rpm, only at 0, 60 rpm; tune it there too, or take one of these speeds" in answer.err
    result = read_gain_file(path)
    assert entry_at(replace_rpm(result, None), 25.0).rpm is None
    lost = using.replace("light/p.toml", "{machine}/p.toml").replace('machine = ["light"]\n', "")
    answer = workbench("check", write(tmp_path, lost, "lost.toml"))
    assert "goes by machine, and this case has none; give the study an axis machine" in answer.err


def replace_rpm(result, rpm):
    """A gain file with its first entry alone, for this speed."""
    return result.model_copy(update={"at": [result.at[0].model_copy(update={"rpm": rpm})]})


def test_entries_for_the_same_speed_are_refused(tmp_path: Path) -> None:
    light = PLACES.replace('"light", "heavy"', '"light"')
    text = gain_file_text(gain_files(tuned(tmp_path, light, "p", trials=4).tuned)["light/p.toml"])
    with pytest.raises(UserError, match="entries: expected each to have an rpm of its own"):
        read_gain_file(write(tmp_path, text.replace("rpm = 60.0", "rpm = 0.0"), "twice.toml"))


def test_every_controller_that_is_named_is_tuned(tmp_path: Path) -> None:
    options = ("--controller", "p", "--controller", "lugre", "--trials", "4")
    answer = workbench(
        "tune", write(tmp_path, PLACES.replace('rpm = [0, "60 rpm"]', "rpm = [0]")), *options, "--out", tmp_path / "out"
    )
    assert (answer.code, answer.err) == (0, "")
    names = {str(path.relative_to(tmp_path / "out/tuned")) for path in (tmp_path / "out/tuned").rglob("*.toml")}
    assert names == {f"{machine}/{name}.toml" for machine in ("light", "heavy") for name in ("p", "lugre")}


def test_an_axis_that_there_is_not_is_told(tmp_path: Path) -> None:
    answer = workbench("check", write(tmp_path, STUDY.replace("seeds = 1", 'per = ["rpm"]')))
    assert 'tune.per: the study has no axis "rpm"; give it one under [axes]' in answer.err


def test_each_place_is_told_for_itself(tmp_path: Path) -> None:
    tuning = tuned(tmp_path, PLACES.replace("seeds = 1", "seeds = 2"), ("p", "pd"), trials=4)
    lines = place_lines(tuning, "declared")
    assert len(lines) == 4
    for line, each in zip(lines, tuning.tuned, strict=False):
        assert each.score is not None
        assert line.startswith(each.task.label.removeprefix("p, ") + ": objective of ")
        assert f"p {number(each.score.nominal)}" in line
    assert seeds_line(tuning)[0].startswith(("Searches from other seeds differ by ", "A seed found no gains"))


@pytest.mark.parametrize("rpm", [10, 25])
def test_a_servo_is_taken_to_hold_its_speed(tmp_path: Path, rpm: int) -> None:
    """Margins on the falling slope, where a voltage that is held would run away, are those with an imposed speed."""
    result = []
    for rotation in ("servo", "ideal"):
        text = PLACES.replace('"isotropic"', f'"isotropic"\nrotation = "{rotation}"').replace(
            '[0, "60 rpm"]', f"[{rpm}]"
        )
        study, _ = ready(tmp_path, text, "p")
        task = task_for(study, "p")
        result.append(margins_of(task.declared(task.start), tune_table(study).constraints))
    servo, ideal = result
    assert servo.stable
    assert (servo.gain_dB, servo.phase_deg) == pytest.approx((ideal.gain_dB, ideal.phase_deg), rel=0.005)


# --- the same way again ---


def test_a_point_is_known_by_how_thoroughly_it_was_run() -> None:
    keys = {key_of({"kp": 1.0}, draws, level) for draws, level in ((0, "screened"), (0, "declared"), (8, "draws"))}
    assert len(keys) == 3


def test_tasks_of_a_place_believe_its_machine(tmp_path: Path) -> None:
    study, names = ready(tmp_path, PLACES, "lugre")
    masses = {task.at["machine"]: task.declared(task.start)[0].belief.body.mass for task in tasks_for(study, names)}
    assert masses == {"light": 20.0, "heavy": 60.0}


def test_a_controller_is_tuned_where_the_study_has_it(tmp_path: Path) -> None:
    text = PLACES.replace('controller = ["p", "pd", "lugre"]', 'controller = ["p"]').replace(
        "[axes]", "[cases.every.axes]"
    )
    text += '[cases.heavy.axes]\nmachine = ["heavy"]\nrpm = [0]\ncontroller = ["lugre"]\n'
    study, names = ready(tmp_path, text, ["p", "lugre", "pd"])
    labels = [task.label for task in tasks_for(study, names)]
    assert [label for label in labels if label.startswith("lugre")] == ["lugre, machine heavy, rpm 0"]
    assert [sum(label.startswith(f"{name},") for label in labels) for name in ("p", "pd")] == [4, 4]

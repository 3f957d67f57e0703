"""A loop on the bench is a study of one case: the same numbers, changes that are the truth's, a file that says them."""

import base64
import json
import zlib
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from benches import of_name, short
from command import STUDIES, workbench
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from plants.equation import to_array
from workbench.bench.groups import chosen
from workbench.bench.link import decoded, encoded
from workbench.bench.loop import BenchLoop, loop_of
from workbench.bench.opened import opened
from workbench.bench.outcome import outcome_of
from workbench.bench.saved import save, study_text
from workbench.errors import UserError


@pytest.mark.parametrize(
    ("name", "where"),
    [
        ("comparison", {"case": "steps_hoses", "rpm": 125, "controller": "lugre_adaptive"}),
        ("comparison", {"case": "slow_sine", "machine": "thesis_rig", "scenario": "friction_up"}),
        ("rotary_drive", {"scenario": "friction_up", "controller": "lugre"}),
        ("pneumatic_cylinder", {"scenario": "industrial_sensors", "rpm": 100}),
        ("thesis_chapter5", {"case": "stability_corrected"}),
        ("observers", {}),
    ],
)
def test_a_case_on_the_bench_has_the_numbers_of_its_study(name: str, where: dict[str, object]) -> None:
    loop = opened(STUDIES / f"{name}.toml", where)
    study = wb.Study(STUDIES / f"{name}.toml").content
    from workbench.study.resolve import resolve
    from workbench.study.unfold import unfold

    case = next(one for one in unfold(study) if all(one.columns[key] == value for key, value in where.items()))
    expected, found = resolve(study, case), loop.resolved
    for one, other in (
        (expected.setup.parameters, found.setup.parameters),
        (expected.belief, found.belief),
        (expected.setup.loop.gains, found.setup.loop.gains),
        (expected.setup.state, found.setup.state),
    ):
        assert to_array(one).tolist() == to_array(other).tolist()
    assert expected.setup.sensors == found.setup.sensors


def test_a_change_of_the_machine_is_none_of_what_controllers_believe() -> None:
    loop = short()
    changed = loop.changed({"plant.set.coulomb": 500.0})
    assert of_name(changed.resolved.setup.parameters, "coulomb") == 500.0
    assert to_array(changed.resolved.belief).tolist() == to_array(loop.resolved.belief).tolist()
    believed = loop.changed({"belief.set.coulomb": 500.0})
    assert of_name(believed.resolved.belief, "coulomb") == 500.0
    assert to_array(believed.resolved.setup.parameters).tolist() == to_array(loop.resolved.setup.parameters).tolist()
    assert changed.changed({"plant.set.coulomb": None}) == loop


def test_a_setup_of_python_comes_to_the_bench_as_it_is() -> None:
    setup = wb.setup(
        "rotating",
        "owen2001_simulation",
        rpm=120,
        controller=wb.pid(kp=500),
        reference=wb.sine("30 mm", "0.9 Hz"),
        duration="1.2 s",
        sensors={"position": {"noise": "5 um"}},
    )
    loop = loop_of(setup.study, setup.case)
    expected = wb.evaluate(wb.simulate(setup), solver_error=False)
    assert dict(outcome_of(loop).figures) == expected.to_dict()


def test_a_saved_study_gives_the_same_figures_to_the_last_digit(tmp_path: Path) -> None:
    loop = short(rpm=120).changed(
        {"controllers.p.kp": 712.3, "plant.set.coulomb": 412.7, "sensors.position.noise": 3e-6}
    )
    loop = loop.changed({"plant.set.friction_gradient": 0.31})
    outcome = outcome_of(loop)
    path = save(outcome, "mine.toml", tmp_path)
    assert workbench("run", path, "--out", tmp_path / "out").code == 0
    row = wb.Study(path).run(tmp_path / "again").frame.iloc[0]
    for name, value in outcome.figures.items():
        if value is not None:
            assert row[name] == value, name


def test_a_saved_study_finds_its_files_from_where_it_stands(tmp_path: Path) -> None:
    rig, elsewhere = tmp_path / "rig", tmp_path / "other" / "place"
    rig.mkdir()
    elsewhere.mkdir(parents=True)
    parameters = Path(wb.__file__).parent.parent / "plants/parameters/owen2001_experiment.toml"
    (rig / "mine.toml").write_bytes(parameters.read_bytes())
    outcome = outcome_of(opened(rig / "mine.toml").changed({"simulation.duration": 2.5}))
    saved = save(outcome, "place/there.toml", elsewhere.parent)
    again = outcome_of(opened(saved))
    assert dict(again.figures) == dict(outcome.figures)
    assert str(tmp_path) not in saved.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("../out.toml", "leads out of the folder"),
        ("/etc/out.toml", "leads out of the folder"),
        ("out.txt", "ends in .toml"),
        ("none/out.toml", "no such folder"),
        ("there.toml", "there is a file of this name"),
        ("a\0b.toml", "is no name of a file"),
        ("a\ud800.toml", "is no name of a file"),
    ],
)
def test_a_name_under_which_nothing_is_saved(name: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "there.toml").write_text("kept", encoding="utf-8")
    with pytest.raises(UserError, match=told):
        save(outcome_of(short()), name, tmp_path)
    assert (tmp_path / "there.toml").read_text(encoding="utf-8") == "kept"
    assert [path.name for path in tmp_path.iterdir()] == ["there.toml"]


def test_another_controller_begins_with_what_it_has_in_common() -> None:
    loop = short().changed({"controllers.p.kp": 620.0})
    other = chosen(loop, "controller", "tafazoli")
    assert other is not None
    assert other.resolved.settings.kp == 620.0
    back = chosen(other, "controller", "p")
    assert back is not None
    assert back.resolved.settings.kp == 620.0
    assert set(other.as_study["controllers"]) == {"tafazoli"}
    assert chosen(short("rotary_drive", controller="lugre"), "controller", "ekf") is None  # it needs pressures


CHANGES = st.dictionaries(
    st.sampled_from(["controllers.p.kp", "plant.set.mass", "plant.set.coulomb", "simulation.tolerance"]),
    st.floats(1e-3, 1e-2),
)


@settings(max_examples=15, deadline=None)
@given(CHANGES)
def test_an_address_brings_a_loop_back(changes: dict[str, float]) -> None:
    first = LOOP
    loop = chosen(first.changed({**changes}), "controller", "dither")
    assert loop is not None
    found = decoded(encoded(loop, first), first)
    assert found.as_study == loop.as_study


LOOP: BenchLoop = short()


def test_the_loop_as_it_was_opened_needs_no_address() -> None:
    first = opened(None)
    assert encoded(first, first) == ""


@pytest.mark.parametrize("text", ["", "x", "AAAA", "eJyrVkrLSM0sVrKqVkrOSMxLTy1WslKqrQUAYbQIZA", "ä", "%00"])
def test_an_address_that_holds_no_state_is_told(text: str) -> None:
    with pytest.raises(UserError, match=r"no state of this bench|unknown|expected"):
        decoded(text, LOOP)


@pytest.mark.parametrize(("axis", "folder"), [("machine", "machines"), ("scenario", "scenarios")])
def test_a_saved_study_takes_its_machine_and_scenario_along(axis: str, folder: str, tmp_path: Path) -> None:
    """Those beside the study come before the shipped ones of their name, which another folder would find."""
    rig, there = tmp_path / "rig", tmp_path / "there"
    (rig / folder).mkdir(parents=True)
    there.mkdir()
    name = {"machine": "thesis_simulation", "scenario": "payload"}[axis]
    layer = 'title = "own"\nsource = "test"\n[plant]\nset = { mass = "50 kg" }\n'
    (rig / folder / f"{name}.toml").write_text(layer, encoding="utf-8")
    outcome = outcome_of(short())
    study = {**outcome.loop.as_study, "axes": {"rpm": [0], axis: [name]}}
    (rig / "study.toml").write_text(tomli_w.dumps(study), encoding="utf-8")
    found = outcome_of(opened(rig / "study.toml"))
    assert of_name(found.loop.resolved.setup.parameters, "mass") == 50.0
    again = outcome_of(opened(save(found, "saved.toml", there)))
    assert dict(again.figures) == dict(found.figures)


def test_a_saved_study_finds_a_recorded_reference(tmp_path: Path) -> None:
    (tmp_path / "rig").mkdir()
    time = np.linspace(0.0, 1.0, 50)
    rows = "".join(f"{t},{0.005 * np.sin(6.0 * t)}\n" for t in time)
    (tmp_path / "rig" / "canudas1995").write_text(f"t,x\n{rows}", encoding="utf-8")
    study = {
        **short().as_study,
        "references": {"r": {"kind": "recorded", "file": "other.csv", "time": "t", "value": "x"}},
        "axes": {"rpm": [0], "references.r.file": ["canudas1995"]},
    }
    (tmp_path / "rig" / "study.toml").write_text(tomli_w.dumps(study), encoding="utf-8")
    found = outcome_of(opened(tmp_path / "rig" / "study.toml"))
    again = outcome_of(opened(save(found, "saved.toml", tmp_path)))
    assert dict(again.figures) == dict(found.figures)


def test_names_with_a_dot_can_be_turned(tmp_path: Path) -> None:
    study = short().as_study
    study["controllers"] = {"a.b": study["controllers"]["p"]}
    (tmp_path / "study.toml").write_text(tomli_w.dumps(study), encoding="utf-8")
    loop = opened(tmp_path / "study.toml")
    assert loop.controller_name == "a_b"
    assert loop.changed({"controllers.a_b.kp": 777.0}).resolved.settings.kp == 777.0


HOSTILE: list[dict[str, object]] = [
    {"changes": {"plant.parameters": "\0.toml"}},
    {"changes": {"sensors.delay": 1e300}},
    {"changes": {"simulation.step": 1e-300, "simulation.method": "rk4"}},
    {"changes": {"references.sine.file": "/dev/zero"}},
    {"references": {"r": {"kind": "recorded", "file": "/dev/zero", "time": "t", "value": "x"}}},
    {"controllers": {"x": {"gains": "/dev/zero"}}, "changes": {"controller": "x"}},
    {"changes": {"simulation.duration": 1e300, "simulation.sample_time": 1e299}},
    {"changes": 3},
    {"controllers": [1]},
]


@pytest.mark.parametrize("state", HOSTILE)
def test_a_hostile_address_is_told(state: dict[str, object]) -> None:
    packed = base64.urlsafe_b64decode(encoded(LOOP.changed({"rpm": 1.0}), LOOP) + "==")
    of = json.loads(zlib.decompress(packed))["of"]
    text = base64.urlsafe_b64encode(zlib.compress(json.dumps({"of": of, **state}).encode())).decode().rstrip("=")
    with pytest.raises(UserError):
        outcome_of(decoded(text, LOOP))


def test_an_address_of_another_loop_is_told() -> None:
    other = opened(None)
    with pytest.raises(UserError, match=r"that of another loop"):
        decoded(encoded(other.changed({"rpm": 50.0}), other), LOOP)


def test_deep_nesting_in_an_address_is_told() -> None:
    text = base64.urlsafe_b64encode(zlib.compress(b"[" * 150_000)).decode()
    with pytest.raises(UserError, match=r"no state of this bench"):
        decoded(text, LOOP)


def test_what_is_opened(tmp_path: Path) -> None:
    assert opened(None).case.rpm == 120.0
    assert np.isfinite(outcome_of(opened(STUDIES / "scenarios" / "payload.toml")).figures["rms_error_m"])
    with pytest.raises(UserError, match=r"holds neither study.toml nor plant.toml"):
        opened(tmp_path)
    with pytest.raises(UserError, match=r"no case with rpm 7; the axes are rpm"):
        opened(STUDIES / "thesis_chapter3.toml", {"rpm": 7})
    (tmp_path / "study.toml").write_text(study_text(outcome_of(short()), tmp_path), encoding="utf-8")
    assert opened(tmp_path).as_study["controllers"] == short().as_study["controllers"]


@pytest.mark.parametrize(
    "name", ["owen2001_simulation", "canudas1995", "differential_cylinder", "guenther2006", "walkman_joint"]
)
def test_a_parameter_file_is_opened_in_a_loop_that_is_stable(name: str) -> None:
    folder = Path(wb.__file__).parent.parent / "plants" / "parameters"
    outcome = outcome_of(opened(folder / f"{name}.toml"))
    assert not outcome.run.diverged
    assert not isinstance(outcome.loop_gain, str)
    assert outcome.loop_gain.margins.stable

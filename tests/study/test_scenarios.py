"""Scenarios: what each of them does to the truth; that the belief stays; the files that come along."""

from pathlib import Path

import pytest
from command import workbench
from scenario_study import FILE_HEAD, FOLDER, resolved, row_of, study_file
from support import registered

from plants.equation import to_array
from workbench.errors import UserError
from workbench.study.plan import plan
from workbench.study.reading import read_study

FILES = sorted(FOLDER.glob("*.toml"))


def test_the_files_of_the_issue_are_there() -> None:
    assert {path.stem for path in FILES} == {
        *("nominal", "measured_rig", "friction_up", "friction_down", "friction_spread", "valve_overlap"),
        *("hose_fed_30", "hose_fed_100", "hose_fed_170", "internal_leakage", "payload"),
        *("industrial_sensors", "stiff_contact"),
    }


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_check_of_a_scenario(path: Path) -> None:
    code, out, err = workbench("check", path)
    assert (code, err) == (0, "")
    assert out.startswith(f"{path}: a scenario, in order; it changes ")


def test_every_scenario_runs_and_changes_the_truth_alone(tmp_path: Path) -> None:
    names = [path.stem for path in FILES]
    path = study_file(tmp_path, names, **{item.stem: item.read_text(encoding="utf-8") for item in FILES})
    planned = plan(read_study(path))
    gains = {case.axes["controller"]: set() for case in planned.cases}
    rows = {}
    for case, item in zip(planned.cases, planned.resolved, strict=True):
        gains[case.axes["controller"]].add(to_array(item.setup.loop.gains).tobytes())
        rows[tuple(case.axes.values())] = row_of(planned.study, case)
    assert [len(seen) for seen in gains.values()] == [1, 1]
    assert {row["outcome"] for row in rows.values()} == {"completed"}
    nominal = rows[("nominal", "p")]
    for name in names:
        differs = rows[(name, "p")]["rms_error_m"] != nominal["rms_error_m"]
        assert differs == (name != "nominal"), name


def test_truth_of_each_scenario(tmp_path: Path) -> None:
    names = [path.stem for path in FILES]
    path = study_file(tmp_path, names, **{item.stem: item.read_text(encoding="utf-8") for item in FILES})
    truth = dict(zip(names, [item.setup for item in resolved(path)][::2], strict=True))
    nominal = registered("non_rotating", duration=1.0).parameters
    assert truth["nominal"].parameters == truth["measured_rig"].parameters == nominal
    assert truth["friction_up"].parameters.friction.negative[:3] == pytest.approx((481.0, 282.1, 2318.0))
    assert truth["friction_down"].parameters.friction.positive[:3] == pytest.approx((259.0, 151.9, 2318.0))
    assert [truth[f"hose_fed_{n}"].parameters.hydraulics.bulk_modulus for n in (30, 100, 170)] == [30e6, 100e6, 170e6]
    assert truth["valve_overlap"].parameters.hydraulics.valve_overlap == pytest.approx(6e-6)
    assert truth["internal_leakage"].parameters.hydraulics.leakage_coefficient == pytest.approx(5e-12)
    assert truth["payload"].parameters.body[:2] == (68.0, 334.0)
    sensors = truth["measured_rig"].sensors
    assert sensors.resolution()[:3] == pytest.approx([0.2 / 4096, 17.2369e6 / 4096, 17.2369e6 / 4096], rel=1e-5)
    accuracy = 0.01 * 17.2369e6
    worst = [abs(c.offset) + abs(c.gain_error) * 4.91e6 for n, c in sensors.channels.items() if "pressure" in n]
    assert all(accuracy / 2.0 < value < accuracy for value in worst)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('title = "t"\n[plant.scale]\ncoulomb = 1.3\n', "", "source: is missing"),
        (FILE_HEAD + "[belief]\n", ":3", "belief: unknown key"),
        (FILE_HEAD + "[sensor]\n", ":3", 'sensor: unknown key; did you mean "sensors"?'),
        (FILE_HEAD + "[plant.scale]\ncolomb = 1.3\n", ":4", 'did you mean "coulomb"?'),
        (FILE_HEAD + '[plant.set]\nmass = "2 m"\n', ":4", "plant.set.mass"),
        (FILE_HEAD + "[plant.set]\nvalve_overlap = -1e-6\n", ":4", "expected a value that is not negative"),
        (FILE_HEAD + "[plant.spread]\nmass = 1\n", ":4", '"owen2001_simulation" gives no std for it'),
        (FILE_HEAD + "[plant.spread]\ncoulomb = -1\n", ":4", "expected a factor that is not negative"),
        (FILE_HEAD + '[sensors.position]\nnoise = "1 Pa"\n', ":", "sensors.position"),
        (FILE_HEAD + '[sensors.position]\ncalibration_error = "1 mm"\n', ":3", "together with calibration_travel"),
        (FILE_HEAD + "[sensors.position]\ngain_error = -1\n", ":4", "gain_error"),
    ],
)
def test_mistake_in_a_scenario_file_is_told_with_that_file_and_line(
    tmp_path: Path, text: str, line: str, message: str
) -> None:
    """By the check of the scenario and by that of a study that names it, alike."""
    study = study_file(tmp_path, ["mine"], mine=text)
    scenario = tmp_path / "scenarios" / "mine.toml"
    for file in (scenario, study):
        code, out, err = workbench("check", file)
        assert (code, out) == (2, "")
        assert err.startswith(f"error: {scenario}{line}")
        assert message in err
        assert err.count("\n") == 1


def test_unknown_scenario_gets_the_nearest_of_tables_and_files(tmp_path: Path) -> None:
    inline = "[scenarios.stiff.plant.set]\nbulk_modulus = 2e9\n"
    for wrong, right in (("stif", "stiff"), ("hose_fedd", "hose_fed")):
        with pytest.raises(UserError, match=f'unknown scenario "{wrong}"; did you mean "{right}"'):
            resolved(study_file(tmp_path, [wrong], inline, hose_fed=FILE_HEAD))


def test_table_of_the_study_comes_before_a_file_of_that_name(tmp_path: Path) -> None:
    inline = "[scenarios.soft.plant.set]\nbulk_modulus = 5e7\n"
    path = study_file(
        tmp_path, ["soft", "hard"], inline, soft="no TOML", hard=FILE_HEAD + "plant.set.bulk_modulus = 2e9\n"
    )
    moduli = [item.setup.parameters.hydraulics.bulk_modulus for item in resolved(path)]
    assert moduli == [5e7, 5e7, 2e9, 2e9]


def test_results_know_what_the_scenario_file_held(tmp_path: Path) -> None:
    """A run cannot be resumed with another scenario: the identity of a study covers the scenario files it names."""
    soft = FILE_HEAD + "plant.set.bulk_modulus = 5e7\n"
    seen = set()
    for text in (soft, soft + "# a remark\n", soft.replace("5e7", "6e7"), soft + "simulation.seed = 9\n"):
        seen.add(read_study(study_file(tmp_path, ["soft"], soft=text)).fingerprint)
    assert len(seen) == 3

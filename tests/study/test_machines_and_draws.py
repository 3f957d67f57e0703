"""Machines, which change what is declared, and draws of them, which are the same for whoever is compared."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import workbench
from scenario_study import INVERSE

from plants.equation import to_array
from workbench.errors import UserError
from workbench.study.plan import again, plan
from workbench.study.reading import read_study

HEAD = """\
title = "a study for tests"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[machines.heavy.plant.set]
mass = "68 kg"
[machines.humble]
plant.parameters = "owen2001_experiment"
belief.parameters = "owen2001_simulation"
[scenarios.worn.plant.scale]
coulomb = 2
[scenarios.rig.sensors.position]
noise = "1 um"
offset = "1 mm"
gain_error = 0.01
calibration_error = "0.1 mm"
calibration_travel = "200 mm"
[axes]
machine = ["heavy", "humble", "thesis_rig"]
scenario = ["nominal", "worn", "rig"]
controller = ["p", "inverse"]
[controllers.p]
type = "pid"
kp = "500 V/m"
"""

STUDY = f"{HEAD}{INVERSE}[uncertainty]\nscale.mass = {{ min = 0.5, max = 2 }}\n"


def study_file(folder: Path, text: str = STUDY, draws: int = 0) -> Path:
    path = folder / "study.toml"
    path.write_text(text + f"draws = {draws}\n", encoding="utf-8")
    return path


def test_machine_changes_truth_and_belief_and_a_scenario_the_truth_alone(tmp_path: Path) -> None:
    planned = plan(read_study(study_file(tmp_path)))
    found = {tuple(case.axes.values()): item for case, item in zip(planned.cases, planned.resolved, strict=True)}
    friction = {machine: 370.0 if machine == "heavy" else 330.0 for machine in ("heavy", "humble", "thesis_rig")}
    for (machine, scenario, _), item in found.items():
        worn = 2.0 if scenario == "worn" else 1.0
        assert item.setup.parameters.friction.positive.coulomb == pytest.approx(worn * friction[machine])
        assert item.belief.friction.positive.coulomb == (330.0 if machine == "thesis_rig" else 370.0)
    assert {found[machine, "worn", "p"].belief.body.mass for machine in friction} == {68.0, 34.0, 15.0}


def test_a_machine_of_a_file_beside_the_study_is_checked_and_kept_with_results(tmp_path: Path) -> None:
    (tmp_path / "machines").mkdir()
    file = tmp_path / "machines" / "mine.toml"
    file.write_text('title = "t"\nsource = "s"\nplant.set.mass = "5 kg"\nbelief.set.mass = "6 kg"\n', encoding="utf-8")
    assert workbench("check", file) == (0, f"{file}: a machine, in order; it changes [plant], [belief]\n", "")
    study = study_file(tmp_path, STUDY.replace('"humble", "thesis_rig"', '"mine"').replace('"worn", "rig"', '"worn"'))
    code, _, err = workbench("run", study, "--out", tmp_path / "out")
    assert (code, err) == (0, "")
    kept = plan(read_study(tmp_path / "out" / "study.toml"))
    assert kept.resolved[-1].setup.parameters.body.mass == 5.0
    assert kept.resolved[-1].belief.body.mass == 6.0


def test_an_unknown_machine_gets_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(UserError, match='unknown machine "thesis_rigg"; did you mean "thesis_rig"'):
        plan(read_study(study_file(tmp_path, STUDY.replace('"thesis_rig"', '"thesis_rigg"'))))


def test_each_draw_is_one_machine_for_every_controller(tmp_path: Path) -> None:
    planned = plan(read_study(study_file(tmp_path, draws=5)))
    machines: dict[tuple[object, ...], set[bytes]] = {}
    for case, item in zip(planned.cases, planned.resolved, strict=True):
        setup = item.setup
        drawn = (to_array(setup.parameters), setup.sensors.errors(), np.array([setup.seed]))
        key = (case.axes["machine"], case.axes["scenario"], case.axes["draw"])
        machines.setdefault(key, set()).add(b"".join(part.tobytes() for part in drawn))
    assert len(machines) == 3 * 3 * 5
    assert {len(seen) for seen in machines.values()} == {1}
    assert len(set.union(*machines.values())) == 2 * 3 * 5  # humble and thesis_rig are one machine, believed otherwise


def test_a_draw_has_a_share_of_the_calibration_that_a_scenario_bounds(tmp_path: Path) -> None:
    planned = plan(read_study(study_file(tmp_path, draws=40)))
    channels = [
        item.setup.sensors.channels["position"]
        for case, item in zip(planned.cases, planned.resolved, strict=True)
        if (case.axes["machine"], case.axes["scenario"], case.axes["controller"]) == ("heavy", "rig", "p")
    ]
    for values, bound in (([c.offset for c in channels], 1e-3), ([c.gain_error for c in channels], 1e-2)):
        assert max(np.abs(values)) <= bound
        assert min(values) < -0.7 * bound
        assert max(values) > 0.7 * bound
    assert len({channel.calibration_seed for channel in channels}) == 40
    fixed = plan(read_study(study_file(tmp_path, STUDY + "calibration = false\n", draws=2)))
    assert {item.setup.sensors.channels["position"].offset for item in fixed.resolved} == {0.0, 1e-3}


def test_cases_are_run_again_on_machines_not_drawn_before(tmp_path: Path) -> None:
    planned = plan(read_study(study_file(tmp_path, draws=3)))
    wanted = [{"machine": "heavy", "scenario": "worn", "controller": "p"}, {"machine": "humble", "scenario": "rig"}]
    fresh = again(planned, wanted, 4)
    assert len(fresh.cases) == 4 * (1 + 2)
    assert [case.index for case in fresh.cases] == list(range(12))
    assert {case.axes["draw"] for case in fresh.cases} == {4, 5, 6, 7}
    seeds = [{item.setup.seed for item in one.resolved} for one in (planned, fresh)]
    assert not seeds[0] & seeds[1]


def test_results_have_a_row_a_draw_and_the_same_bytes_whatever_the_jobs(tmp_path: Path) -> None:
    study = study_file(tmp_path, draws=2)
    texts = []
    for jobs in (1, 2):
        out = tmp_path / str(jobs)
        assert workbench("run", study, "--out", out, "--jobs", jobs)[0] == 0
        texts.append((out / "results.csv").read_bytes())
    assert texts[0] == texts[1]
    frame = pd.read_csv(tmp_path / "1" / "results.csv")
    assert list(frame.columns[:4]) == ["machine", "scenario", "controller", "draw"]
    assert list(frame["draw"]) == [1, 2] * 18
    assert list(frame["solver_error_m"].notna()) == [True, False] * 18  # the first draw tells for all

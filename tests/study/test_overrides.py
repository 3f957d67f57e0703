"""What goes before the tables of a case is as if the study said so."""

from pathlib import Path

import pytest
from command import write

from plants.equation import to_array
from workbench.errors import UserError
from workbench.study.overrides import Overrides, PlantSample, SensorSample
from workbench.study.reading import read_study
from workbench.study.resolve import Resolved, parse_case, resolve
from workbench.study.uncertainty import plant_sample
from workbench.study.uncertainty_schema import UncertaintyTable
from workbench.study.unfold import unfold

STUDY = """\
title = "a study for tests"
[plant]
model = "by_rpm"
parameters = "owen2001_simulation"
motor_limits = false
scale = { mass = 1.5 }
[controllers.lugre]
type = "lugre"
law = "valve_inversion"
lead = 0.5
[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"
[sensors.position]
offset = "1 mm"
gain_error = 0.01
calibration_error = "0.1 mm"
calibration_travel = "200 mm"
[simulation]
duration = "1 s"
[axes]
rpm = [25]
"""


def case_of(folder: Path, text: str, overrides: Overrides | None = None) -> Resolved:
    study = read_study(write(folder, text))
    return resolve(study, unfold(study)[0], overrides)


def numbers(resolved: Resolved) -> list[bytes]:
    """Every number that a run depends on."""
    setup = resolved.setup
    assert setup.rotary is not None
    parts = (setup.parameters, setup.state, setup.inputs, setup.loop.gains, setup.rotary.gains)
    return [to_array(part).tobytes() for part in parts]


def test_settings_and_rpm_are_as_if_the_study_gave_them(tmp_path: Path) -> None:
    text = STUDY.replace("lead = 0.5", "lead = 0.7").replace("rpm = [25]", "rpm = [60]")
    written, overridden = case_of(tmp_path, text), case_of(tmp_path, STUDY, Overrides({"lead": 0.7}, rpm=60.0))
    assert numbers(written) == numbers(overridden)
    assert written.settings == overridden.settings
    assert written.setup.rotation_speed == overridden.setup.rotation_speed


def test_a_sample_is_as_if_the_study_gave_it_and_leaves_the_belief(tmp_path: Path) -> None:
    sample = PlantSample(7, 0.0, {"mass": 2.0}, {"position": 1e-6}, {"position": SensorSample(-0.5, 0.25, 9)})
    written = case_of(
        tmp_path,
        STUDY.replace("mass = 1.5", "mass = 3.0")
        .replace('offset = "1 mm"\ngain_error = 0.01', 'offset = -0.0005\ngain_error = 0.0025\nnoise = "1 um"')
        .replace('"200 mm"', '"200 mm"\ncalibration_seed = 9')
        .replace('duration = "1 s"', 'duration = "1 s"\nseed = 7'),
    )
    sampled, declared = case_of(tmp_path, STUDY, Overrides(sample=sample)), case_of(tmp_path, STUDY)
    assert numbers(written) == numbers(sampled)
    assert written.setup.sensors == sampled.setup.sensors
    assert (written.setup.seed, written.band) == (sampled.setup.seed, sampled.band)
    assert sampled.setup.parameters != declared.setup.parameters
    assert sampled.belief == declared.belief


def test_a_sample_is_the_same_whatever_the_case_bounds(tmp_path: Path) -> None:
    """Sensors without bounds take as many random numbers, so that the curves of the others stay."""
    table = UncertaintyTable.model_validate({"scale": {"mass": {"min": 0.8, "max": 1.5}}, "seed": 3})
    first, again, other = (plant_sample(table, number) for number in (1, 1, 2))
    assert first == again
    assert first != other
    assert 0.8 <= first.factors["mass"] <= 1.5
    ideal = case_of(tmp_path, STUDY[: STUDY.index("[sensors")] + STUDY[STUDY.index("[simulation]") :])
    assert (
        ideal.setup.sensors
        == case_of(
            tmp_path,
            STUDY[: STUDY.index("[sensors")] + STUDY[STUDY.index("[simulation]") :],
            Overrides(sample=first),
        ).setup.sensors
    )


def test_the_tables_of_a_case_are_read_once_for_all_overrides(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, STUDY))
    parsed = parse_case(study, unfold(study)[0])
    assert parsed.resolve(Overrides({"lead": 0.7})).settings.lead == 0.7
    assert parsed.resolve().settings.lead == 0.5


def test_a_helical_speed_belongs_to_a_scheduled_rotation(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r'plant\.rotation: minimum_helical_speed belongs to rotation = "scheduled"'):
        case_of(tmp_path, STUDY, Overrides(minimum_helical_speed=0.01))

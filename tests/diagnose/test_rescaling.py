"""The same record on a machine of another size: other units of mass, length and time change no verdict."""

from pathlib import Path

import pytest
from driven import driven_experiment
from rescaled import rescaled

from workbench.diagnose.diagnose import diagnose
from workbench.diagnose.result import Diagnosis

STIFFNESS = 2e4
"""N/m: of a spring that nobody declared."""

NOISE, DURATION, SHORT = 5e-6, 4.0, 2.5
"""m, s, s."""


def found(diagnosis: Diagnosis) -> tuple[str, list[str]]:
    return diagnosis.verdict, [effect.name for effect in diagnosis.effects]


LARGE = {"mass": 1e3, "length": 20.0}
SLOW = {"time": 3.0}
SMALL = {"mass": 1e-3, "length": 0.05}


@pytest.mark.parametrize(
    ("scale", "duration"),
    [
        pytest.param({**LARGE, **SLOW}, DURATION, id="large and slow", marks=pytest.mark.thorough),
        pytest.param(SMALL, SHORT, id="small"),
    ],
)
def test_a_spring_is_found_on_a_machine_of_any_size(scale: dict[str, float], duration: float, tmp_path: Path) -> None:
    record = driven_experiment(tmp_path, STIFFNESS, NOISE, duration)
    diagnosis = diagnose(rescaled(record, tmp_path / "rescaled", **scale))
    assert found(diagnosis) == ("effect_found", ["spring_load"])
    stiffness = STIFFNESS * scale.get("mass", 1.0) / scale.get("time", 1.0) ** 2
    estimate = diagnosis.effects[0].parameters["spring_stiffness"]
    assert estimate.value == pytest.approx(stiffness, rel=1e-4)
    assert abs(estimate.value - stiffness) < 3.0 * estimate.std


def test_nothing_is_found_on_a_complete_machine_of_another_size(tmp_path: Path) -> None:
    path = rescaled(driven_experiment(tmp_path, 0.0, NOISE, SHORT), tmp_path / "rescaled", **SMALL, **SLOW)
    assert found(diagnose(path)) == ("none_missing", [])

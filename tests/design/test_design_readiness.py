"""`workbench check` of an experiment looks at its table [design]."""

from pathlib import Path

import pytest
from command import STUDIES, workbench, write

EXPERIMENT = (STUDIES / "closed_loop" / "experiment.toml").read_text(encoding="utf-8")


def checked(folder: Path, table: str) -> tuple[int, str, str]:
    """Exit code and what is said of an experiment with this table."""
    path = write(folder, f"{EXPERIMENT}\n[design]\n{table}\n", "experiment.toml")
    return workbench("check", path)


def test_what_is_asked_for_is_said(tmp_path: Path) -> None:
    controller = 'controller = { type = "pid", kp = "200 V/m" }'
    answer = checked(tmp_path, f'between = ["valve_deadband", "none"]\nidentify = ["viscous"]\n{controller}')
    assert (answer[0], answer[2]) == (0, "")
    assert "design: a motion of 60 s that tells valve deadband or nothing missing and shows viscous" in answer[1]


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ('betwen = ["none"]', 'design.betwen: unknown key; did you mean "between"?'),
        ('between = ["valve_dedband"]', 'has no effect "valve_dedband"; did you mean "valve_deadband"?'),
        ('identify = ["viscus"]', '"viscus": unknown parameter; did you mean "viscous"?'),
        ('controller = { type = "pidd" }', 'unknown controller "pidd"; did you mean "pid"?'),
        ('limits = { low = "3 V" }', "limits.low"),
        ('loads = ["0 N", "10 N", "0 N"]', "design.loads: a value stands there more than once"),
    ],
)
def test_a_mistake_is_told_with_its_place(table: str, said: str, tmp_path: Path) -> None:
    code, _, err = checked(tmp_path, table)
    assert code == 2
    assert said in err
    assert len(err.splitlines()) <= 3


def test_what_is_missing_before_there_is_a_record_is_said(tmp_path: Path) -> None:
    noise = 'noise = { position = "5 um" }'
    assert (
        "once its records are there: no record is there to tell the sensors' noise"
        in checked(tmp_path, 'loads = ["0 N"]')[1]
    )
    assert "nothing tells how fast the mass may move; give [design.limits] speed" in checked(tmp_path, noise)[1]
    assert "once its records" not in checked(tmp_path, f'{noise}\nlimits = {{ speed = "0.1 m/s" }}')[1]

"""Study files with a mistake in their references, and records that cannot be used."""

from pathlib import Path

import pytest
from command import DRIVE, changed, write
from mistakes import expect, said

MISTAKES = {
    "unknown kind": (
        changed('"sine"', '"sin"'),
        '@:14: references.sine.kind: unknown kind "sin"; did you mean "sine"?',
    ),
    "unit of a reference": (
        changed("5 mm", "5 kg"),
        '@:15: references.sine.amplitude: got "5 kg", expected a quantity in m, such as "1 m"',
    ),
    "unit of a level": (
        changed('["1 m"]', '["1 m", "2 s"]', DRIVE),
        '@:12: references.step.levels.1: got "2 s", expected a quantity in m, such as "1 m"',
    ),
    "reference without frequency": (
        changed('frequency = "2 Hz"\n', ""),
        "@:13: references.sine.frequency: is missing; this key is needed here",
    ),
    "triangle without height": (
        changed('kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"', 'kind = "triangle"\namplitude = 0\nspeed = 1'),
        "@:15: references.sine.amplitude: got 0.0, expected a value above 0",
    ),
    "infinite amplitude": (
        changed("5 mm", "1e400 mm"),
        "@:15: references.sine.amplitude: got inf, expected a finite value",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(tmp_path: Path, mistake: str) -> None:
    expect(tmp_path, *MISTAKES[mistake])


RECORDED = changed(
    'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"',
    'kind = "recorded"\nfile = "rig.csv"\ntime = "t"\nvalue = "x"\nunit = "mm"',
)
ROWS = "t,x\n0,0\n0.1,1\n0.2,2\n0.3,3\n"


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        (None, "no such file"),
        ("t,y\n0,0\n1,1\n", 'no column "x"; expected one of t, y'),
        ("t,x_\n0,0\n1,1\n", 'no column "x"; did you mean "x_"?'),
        (ROWS + "0.4,four\n", "row 6 holds no finite number"),
        (ROWS + "0.4,inf\n", "row 6 holds no finite number"),
        (ROWS + f"0.4,1{400 * '0'}\n", "row 6 holds no finite number"),
        (ROWS + "0.3,4\n", "row 6: expected a time after that of the row before"),
        ("t,x\n0,0\n1,1\n", "holds 2 rows, expected at least 4"),
        ("", "cannot be read as a table with a header ("),
    ],
)
def test_a_record_that_cannot_be_used(tmp_path: Path, rows: str | None, expected: str) -> None:
    if rows is not None:
        write(tmp_path, rows, "rig.csv")
    assert said(tmp_path, RECORDED).startswith(f"@:13: references.sine: {tmp_path / 'rig.csv'}: {expected}")


def test_a_record_with_a_wrong_unit(tmp_path: Path) -> None:
    write(tmp_path, ROWS, "rig.csv")
    expected = '@:18: references.sine.unit: got "bar", expected a unit such as "m"'
    assert said(tmp_path, RECORDED.replace('"mm"', '"bar"')) == expected

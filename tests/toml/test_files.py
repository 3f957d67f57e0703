"""TOML files: where keys stand, and what is said about each kind of mistake."""

from pathlib import Path
from typing import Literal

import pytest
from pydantic import Field, field_validator

from workbench.errors import UserError, nearest
from workbench.toml.reading import Key, Strict, line_of, read_toml, validate

TEXT = """\
title = "several shapes"
simulation.duration = "5 s"

[plant]   # a comment
model = "by_rpm"
set.coulomb = "310 N"
"quoted key" = 1

[axes]
rpm = [0,
       120]

[[records]]
file = "a.csv"

[records.channels]
time = { column = "t", unit = "s" }

[[records]]
file = "b.csv"
use = "fit"
[records.channels]
position = "x"
[[records.parts]]
begin = 1
[[records.parts]]
begin = 2

[ controllers . p ]
type = "pid"

[belief.set.more]
a = 1
[belief.set]
b = 2
"""


@pytest.mark.parametrize(
    ("key", "line"),
    [
        (("title",), 1),
        (("simulation", "duration"), 2),
        (("plant",), 4),
        (("plant", "model"), 5),
        (("plant", "set", "coulomb"), 6),
        (("plant", "quoted key"), 7),
        (("axes", "rpm"), 10),
        (("axes", "rpm", 1), 10),
        (("records", 0, "file"), 14),
        (("records", 0, "channels", "time"), 17),
        (("records", 0, "channels", "time", "unit"), 17),
        (("records", 1), 19),
        (("records", 1, "file"), 20),
        (("records", 1, "use"), 21),
        (("records", 1, "channels", "position"), 23),
        (("records", 1, "parts", 0, "begin"), 25),
        (("records", 1, "parts", 1, "begin"), 27),
        (("controllers", "p", "type"), 30),
        (("plant", "no_such_key"), 4),
        (("records", 1, "no_such_key"), 19),
        (("simulation",), 2),
        (("plant", "set"), 6),
        (("controllers",), 29),
        (("belief", "parameters"), 32),
        (("belief", "set"), 34),
        (("no_such_table",), None),
    ],
)
def test_line_of_a_key(key: Key, line: int | None) -> None:
    """A key that is missing is said to be missing where its table begins."""
    assert line_of(TEXT, key) == line


class Sensor(Strict):
    noise: float = Field(ge=0.0)
    kind: Literal["white", "none"] = "white"


class Study(Strict):
    title: str
    sensors: dict[str, Sensor] = Field(default_factory=dict)
    records: list[Sensor] = Field(default_factory=list)

    @field_validator("title")
    @classmethod
    def _speaks(cls, title: str) -> str:
        if not title:
            raise ValueError('got "", expected a title')
        return title


def mistake(folder: Path, text: str) -> str:
    """What is said about a file, without the folder."""
    path = folder / "study.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError) as caught:
        validate(Study, *_read(path))
    said = str(caught.value)
    assert "\n" not in said
    return said.replace(str(folder), "")


def _read(path: Path) -> tuple[dict[str, object], Path, str]:
    data, text = read_toml(path)
    return data, path, text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('titel = "a"', '/study.toml:1: titel: unknown key; did you mean "title"?'),
        (
            'title = "a"\n[sensors.x]\nnoise = 1\nnois = 1',
            '/study.toml:4: sensors.x.nois: unknown key; did you mean "noise"?',
        ),
        (
            'title = "a"\n[[records]]\nnoise = 1\n[[records]]\nnoise = 1\nzzz = 2',
            "/study.toml:6: records.1.zzz: unknown key; expected one of noise, kind",
        ),
        ('title = "a"\n[sensors.x]', "/study.toml:2: sensors.x.noise: is missing; this key is needed here"),
        ("[sensors]", "/study.toml: title: is missing; this key is needed here"),
        (
            'title = "a"\nsensors.x.noise = -1.0',
            "/study.toml:2: sensors.x.noise: got -1.0: input should be greater than or equal to 0",
        ),
        (
            'title = "a"\n[sensors.x]\nnoise = 1\nkind = "pink"',
            "/study.toml:4: sensors.x.kind: got \"pink\", expected 'white' or 'none'",
        ),
        ('\ntitle = ""', '/study.toml:2: title: got "", expected a title'),
        ("title = 3", "/study.toml:1: title: got 3: input should be a valid string"),
    ],
)
def test_one_line_with_place_and_fix(tmp_path: Path, text: str, said: str) -> None:
    found = mistake(tmp_path, text)
    expected = [said]
    if said.startswith("/study.toml:1: titel"):  # which of two mistakes comes first is pydantic's choice
        expected.append("/study.toml: title: is missing; this key is needed here")
    assert found in expected


def test_a_valid_file(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text('title = "a"\n[sensors.x]\nnoise = 0.5\n', encoding="utf-8")
    assert validate(Study, *_read(path)) == Study(title="a", sensors={"x": Sensor(noise=0.5)})


def test_syntax_error_names_the_line(tmp_path: Path) -> None:
    said = mistake(tmp_path, 'title = "a"\nrpm = [0, 120\n[plant]\n')
    assert said.startswith("/study.toml: not a TOML file: ")
    assert "line 3" in said


def test_missing_file_names_a_neighbour(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text("", encoding="utf-8")
    with pytest.raises(UserError, match=r'stdy\.toml: no such file; did you mean "study\.toml"\?'):
        read_toml(tmp_path / "stdy.toml")
    with pytest.raises(UserError, match="no such file; check the path"):
        read_toml(tmp_path / "nowhere" / "study.toml")


def test_what_is_no_text_file(tmp_path: Path) -> None:
    (tmp_path / "image.toml").write_bytes(b"\xff\xfe\x00\x81")
    for name in ("image.toml", "."):
        with pytest.raises(UserError, match="cannot be read as text"):
            read_toml(tmp_path / name)


def test_nearest_name() -> None:
    names = ["non_rotating", "rotating_helical", "drive_force"]
    assert nearest("rotating_helix", names) == 'did you mean "rotating_helical"?'
    assert nearest("xyz", names) == "expected one of non_rotating, rotating_helical, drive_force"
    assert nearest("xyz", []) == "none is expected here"

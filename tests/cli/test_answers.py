"""What a command says of whatever it met: three lines at most, none long, and nothing that steers a terminal."""

from pathlib import Path
from unicodedata import category

import pytest
from command import STUDY, changed, workbench, write
from hypothesis import given
from hypothesis import strategies as st

from workbench.errors import (
    LONGEST_LINE,
    MOST_LINES,
    UNSEEN,
    UserError,
    few_of,
    in_one_line,
    nearest,
    shortened,
    spelled,
    visible,
)


@given(st.text(max_size=3000))
def test_a_message_has_few_short_visible_lines(text: str) -> None:
    lines = str(UserError(text)).split("\n")
    assert len(lines) <= MOST_LINES
    assert not any(category(letter) in UNSEEN for line in lines for letter in line)
    assert all(len(line) <= 2 * LONGEST_LINE + 2 for line in lines)


def test_a_message_that_is_short_stays_as_it_is() -> None:
    text = 'study.toml:3: plant.model: got "é \' $x_1$", expected one of these\nand a second line'
    assert str(UserError(text)) == text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[31mred\x1b[0m", r"\x1b[31mred\x1b[0m"),
        ("a\0b\r\x07", r"a\x00b\r\x07"),
        ("\u202eabc\u2028\ufeff", r"\u202eabc\u2028\ufeff"),
        ("摩擦 é\nsecond", "摩擦 é\nsecond"),
    ],
)
def test_what_steers_a_terminal_is_shown(text: str, shown: str) -> None:
    assert visible(text) == shown


def test_values_and_lists_are_shortened() -> None:
    assert shortened("x" * 12345) == "x" * 60 + "... (12 345 characters)"
    assert spelled(["x" * 100]) == "['" + "x" * 58 + "... (104 characters)"
    assert spelled(10**5000) == "a whole number of very many digits"
    assert few_of(["name"] * 100) == ", ".join(["name"] * 33) + " and 67 more"
    assert nearest("x" * 10**6, ["abc"]) == "expected one of abc"
    assert len(in_one_line("place: " + "word " * 1000)) == LONGEST_LINE + len("place: ")


def test_of_many_mistakes_the_first_are_told(tmp_path: Path) -> None:
    path = write(tmp_path, changed("[plant]", "".join(f"key_{i} = 1\n" for i in range(400)) + "[plant]"))
    lines = workbench("check", path).err.replace(str(path), "@").splitlines()
    assert [line.partition(": unknown key; expected one of title, source, ")[0] for line in lines] == [
        "error: @:2: key_0",
        "@:3: key_1",
        "... and 398 more",
    ]


def test_a_title_cannot_steer_the_terminal(tmp_path: Path) -> None:
    path = write(tmp_path, changed('"a study for tests"', '"right \u202e left"'))
    assert r"right \u202e left" in workbench("check", path).out
    assert "\u202e" not in workbench("check", path).out


def test_a_long_name_is_no_long_answer(tmp_path: Path) -> None:
    path = write(tmp_path, STUDY.replace("by_rpm", "x" * 12345))
    said = workbench("check", path).err
    assert 'unknown plant "' + "x" * 60 + '... (12 345 characters)"; expected one of ' in said
    assert len(said) < 500

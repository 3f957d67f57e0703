"""Names of files: whatever a name is, its file lies in its folder, and no other name has the same."""

from pathlib import PurePosixPath, PureWindowsPath
from unicodedata import category

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.errors import UNSEEN
from workbench.toml.file_names import LONGEST, file_name, is_file_name

ODD = st.text(st.sampled_from("ab./\\:%~ \0\x1b\u202eé摩C0N"), max_size=12) | st.text(max_size=400)


@given(ODD)
def test_a_name_stays_in_its_folder(name: str) -> None:
    made = file_name(name)
    assert made == PurePosixPath("folder", made).name == PureWindowsPath("folder", made).name
    assert not any(category(letter) in UNSEEN for letter in made)
    assert not made.startswith(".")
    assert not PureWindowsPath(made).is_reserved()
    assert len(made.encode()) <= LONGEST


@given(st.sets(ODD, min_size=2, max_size=30))
def test_different_names_have_different_files(names: set[str]) -> None:
    assert len(set(map(file_name, names))) == len(names)


@pytest.mark.parametrize(
    "name", ["plain", "slow sine", "460_rpm", "a.b", "über-1", "摩擦", "x" * LONGEST, "a,b (c) + d=e"]
)
def test_an_ordinary_name_stays_as_it_is(name: str) -> None:
    assert file_name(name) == name


@pytest.mark.parametrize(
    ("name", "made"),
    [
        ("../evil", "%2E.%2Fevil"),
        ("/etc/passwd", "%2Fetc%2Fpasswd"),
        ("..", "%2E%2E"),
        ("", "%"),
        ("%2F", "%252F"),
        ("a\0b", "a%00b"),
        ("con", "%63on"),
        ("NUL.txt", "%4EUL.txt"),
        ("a. ", "a.%20"),
    ],
)
def test_what_leads_elsewhere_is_escaped(name: str, made: str) -> None:
    assert file_name(name) == made


def test_long_names_differ_by_their_ends() -> None:
    one, other = file_name("x" * 5000), file_name("x" * 4999 + "y")
    assert one[:100] == other[:100] == "x" * 100
    assert one != other


@pytest.mark.parametrize("name", ["..", ".", "", "a/b", "a\\b", "a\0", 3, None, ["a"]])
def test_what_is_read_back_is_a_name_and_nothing_else(name: object) -> None:
    assert not is_file_name(name)
    assert is_file_name(file_name("../evil"))

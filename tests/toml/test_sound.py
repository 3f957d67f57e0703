"""What no file holds: it is refused in a line that says what and where, before anything is made of it."""

from pathlib import Path

import pytest
from command import STUDY, workbench, write

from workbench.toml import reading

DEEP = "lists or tables in each other are too deep, expected at most 30"
DIGITS = "a whole number has too many digits, expected at most 19; write it with a point or an exponent, such as 1e30"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("x = " + "9" * 4301, f"@: {DIGITS}"),
        ("x = -" + "9" * 20, f"@:1: x: {DIGITS}"),
        ("x = 0x" + "f" * 5000, f"@:1: x: {DIGITS}"),
        ("x = " + "[" * 2000 + "]" * 2000, f"@: {DEEP}"),
        ("x = " + "[" * 40 + "]" * 40, f"@:1: x.0.0: {DEEP}"),
        ("[" + "a." * 3000 + "a]", f"@:1: a.a.a: {DEEP}"),
        ("x = 1979-05-27", "@:1: x: got the date or time 1979-05-27, expected text in quotes, or a number"),
        ("x = [07:32:00]", "@:1: x.0: got the date or time 07:32:00, expected text in quotes, or a number"),
        (r'x = "a\u0000b"', r"@:1: x: got text with the character '\x00', which nobody sees; leave it out"),
        (r'x = "\u001b[2J"', r"@:1: x: got text with the character '\x1b', which nobody sees; leave it out"),
        (r'"a\u0000b" = 1', r"@: a\x00b: got a key with the character '\x00', which nobody sees; leave it out"),
    ],
)
def test_it_is_refused(tmp_path: Path, line: str, said: str) -> None:
    path = write(tmp_path, f"{line}\n")
    answer = workbench("check", path)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.replace(str(path), "@") == f"error: {said}\n"


def test_a_file_of_many_megabytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "MOST_BYTES", 100.0)
    answer = workbench("check", write(tmp_path, STUDY))
    assert answer.err == f"error: {tmp_path / 'study.toml'}: has 0 MB, expected at most 0.0001 MB of text\n"

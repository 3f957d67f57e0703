"""What the `workbench` command says of a study with a mistake in it."""

from pathlib import Path

from command import workbench


def said(folder: Path, text: str | bytes) -> str:
    """What `workbench run` says of a study, without its folder; nothing is left behind, and `check` says the same."""
    path = folder / "study.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    answer, checked = workbench("run", path, "--out", folder / "out"), workbench("check", path)
    assert (answer.code, answer.out) == (checked.code, checked.out) == (2, "")
    assert answer.err == checked.err
    assert not (folder / "out").exists()
    assert answer.err.startswith("error: ")
    assert answer.err.count("\n") == 1
    return answer.err.removeprefix("error: ").rstrip("\n").replace(str(folder / "study.toml"), "@")


def expect(folder: Path, text: str | bytes, expected: str) -> None:
    """This is said, to the letter; where `expected` ends in a space or a bracket, what is said goes on."""
    found = said(folder, text)
    if expected.endswith((" ", "(")):
        found = found[: len(expected)]
    assert found == expected

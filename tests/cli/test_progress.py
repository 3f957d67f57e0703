"""How far work is, as those tell it who do it."""

import pytest

from workbench.cli.progress import Lines
from workbench.progress import of_unknown_length, part_of


class Told:
    """Progress that keeps what it was told."""

    def __init__(self) -> None:
        self.told = list[tuple[str, float | None]]()

    def __call__(self, doing: str, done: float | None = None, /) -> None:
        self.told.append((doing, done))


def test_a_part_is_told_as_a_share_of_the_whole() -> None:
    whole = Told()
    part = part_of(whole, 0.5, 0.25)
    part("begins", 0.0)
    part("ends", 1.0)
    part("goes on")
    assert whole.told == [("begins", 0.5), ("ends", 0.75), ("goes on", None)]


def test_work_of_unknown_length_tells_what_it_does_alone() -> None:
    whole = Told()
    of_unknown_length(whole)("searches", 0.6)
    assert whole.told == [("searches", None)]


def test_a_line_tells_the_time_left_where_the_share_is_known(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [0.0]
    monkeypatch.setattr("workbench.cli.progress.INTERVAL", 15.0)
    monkeypatch.setattr("workbench.cli.progress.time.monotonic", lambda: now[0])
    lines = Lines()
    for at, doing, done in ((10.0, "too soon", 0.1), (20.0, "half", 0.5), (40.0, "nobody knows", None)):
        now[0] = at
        lines.say(doing, done)
    assert capsys.readouterr().err == "half, about 20 s left\nnobody knows\n"

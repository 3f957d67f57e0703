"""The harness that kills commands, on a stand-in that starts at once: it passes what is sound, and sees what is not."""

import json
import signal
from pathlib import Path

import kills
import pytest
from command import write
from kill_studies import Command

SOUND = """\
import signal, sys
for each, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
    signal.signal(each, lambda *_, code=code: sys.exit(code))
import pathlib, sqlite3, time
out = pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
out.mkdir(exist_ok=True)
rows = sqlite3.connect(out / "rows.sqlite")
rows.execute("CREATE TABLE IF NOT EXISTS rows (row INTEGER)")
for row in range(rows.execute("SELECT COUNT(*) FROM rows").fetchone()[0], 8):
    time.sleep(0.2)
    rows.execute("INSERT INTO rows VALUES (?)", (row,))
    rows.commit()
    print(f"row {row}", file=sys.stderr, flush=True)
(out / "page.html").write_text("8 rows")
"""

HARMS = {
    "rows are kept in the end alone": ("    rows.commit()\n", "", "0 pieces of work are kept, "),
    "it goes another way when it goes on": ('"8 rows"', 'str(sys.argv[-1] == "--resume")', "page.html differs"),
    "half a file is left": ('(out / "page', '(out / ".page.part").touch()\n(out / "page', ".page.part is left behind"),
    "something is left beside": ("rows = ", '(out.parent / ".out.part").touch()\nrows = ', ".out.part is left beside"),
    "a traceback": ("sys.exit(code)", "1 / 0", "traceback: Traceback"),
    "another exit code": ("sys.exit(code)", "sys.exit(3)", "exit code 3, expected 130"),
}


def played(home: Path, code: str, stop: signal.Signals) -> kills.Tally:
    command = Command(("stand_in", "study"), lambda folder: None, ["--resume"], "rows.sqlite", "rows", "row", code=code)
    return kills.play(command, home, stop, [1.2, 0.1], {"page.html": b"8 rows"}, jobs=1)


@pytest.mark.parametrize("stop", kills.CODES)
def test_what_is_sound_passes(tmp_path: Path, stop: signal.Signals) -> None:
    tally = played(tmp_path, SOUND, stop)
    assert tally.wrong == []
    assert tally.signals[stop.name] + tally.ended_before == 2


@pytest.mark.parametrize("harm", HARMS)
def test_what_is_not_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, harm: str) -> None:
    monkeypatch.setattr(kills, "AT_STAKE", 0.1)
    old, new, said = HARMS[harm]
    assert SOUND.count(old) == 1
    wrong = played(tmp_path, SOUND.replace(old, new), signal.SIGINT).wrong
    assert any(said in line for line in wrong), wrong


def test_times_alone_do_not_count(tmp_path: Path) -> None:
    for name, seconds in (("one", 1.0), ("two", 2.0)):
        (tmp_path / name).mkdir()
        write(tmp_path / name, json.dumps({"run": {"wall_seconds": seconds, "seed": 1}}), "run.json")
    assert kills.contents(tmp_path / "one") == kills.contents(tmp_path / "two")
    write(tmp_path / "two", json.dumps({"run": {"seed": 2}}), "run.json")
    assert kills.contents(tmp_path / "one") != kills.contents(tmp_path / "two")

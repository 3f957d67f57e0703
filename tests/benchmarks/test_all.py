"""The machinery of `make benchmark`: its page, its ratios, its reading of the peers' table. No time is asserted."""

import importlib
import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from command import ROOT, workbench

PRINTED = """\
3 s of closed loop at 1 kHz                             ms  error, m  over ours
ours, tolerance 1e-5                                 1.64    1.9e-09       1.00
the same scheme in C, gcc -O2, tolerance 1e-5        1.35    1.9e-09       0.82
CasADi with CVODES, sample by sample               115.00    3.2e-09      70.12
python-control, restarted each sample             1975.00*   4.7e-10    1204.27
ours over the same scheme in C, gcc -O2, tolerance 1e-5: 1.21
* measured over 0.2 s and scaled to 3 s; its error is that of the stretch
"""


@pytest.fixture
def suite(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Imports a module of benchmarks/ by name; none stays imported."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    before = set(sys.modules)

    def of(name: str) -> ModuleType:
        return importlib.import_module(name)

    yield of
    for name in set(sys.modules) - before:
        if name.split(".")[0] in ("suite", "all"):
            del sys.modules[name]


def test_a_page_of_small_sizes_has_its_figures_tables_and_ratios(
    suite: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size = suite("suite.part").Size(2, 1, 1, (1, 3), 3, (0.5, 1.0), (1e4, 1e5), (2.0,))
    everything = suite("all")
    parts = everything.measured(["seconds", "stiffness"], size)
    everything.report(parts, tmp_path, full=False, keep=True)
    page = (tmp_path / "benchmarks.md").read_text(encoding="utf-8")
    for part in parts:
        assert f"## {part.title}" in page
        assert f"(benchmarks/{part.name}.svg)" in page
        assert (tmp_path / "benchmarks" / f"{part.name}.svg").stat().st_size > 0
        assert part.ratios
    assert "no ratios are stored" in capsys.readouterr().out
    kept = suite("suite.ratios").stored(tmp_path / "benchmarks" / "ratios.json")
    assert set(kept) == {name for part in parts for name in part.ratios}
    assert all(len(ratio.values) == size.rounds for ratio in kept.values())


def test_cases_are_run_by_the_command_line(suite: Any, tmp_path: Path) -> None:
    used = suite("suite.cases").run(3, 1, tmp_path)
    lines = (tmp_path / "cases_3_1" / "results.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 4
    assert used.processor > 0.0
    assert used.memory > 1e7
    with pytest.raises(RuntimeError, match="exit code 2: error: "):
        suite("suite.command").workbench("run", "nothing.toml", "--out", "out", folder=tmp_path)


def test_files_of_the_other_parts_are_in_order(suite: Any, tmp_path: Path) -> None:
    experiment = suite("suite.records").record(1.0, tmp_path)
    for file in (suite("suite.studies").write_small(tmp_path / "small.toml"), experiment):
        answer = workbench("check", file)
        assert (answer.code, answer.err) == (0, "")


def test_the_peers_table_is_read_and_compared(suite: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    peers = suite("suite.peers")
    times = peers.times_in(PRINTED)
    assert [time.milliseconds for time in times] == [1.64, 1.35, 115.0, 1975.0]
    assert times[2].name == "CasADi with CVODES, sample by sample"
    monkeypatch.setattr(peers, "measured", lambda turns: times)
    part = peers.peers(suite("suite.part").QUICK, tmp_path)
    assert part.ratios["ours over the same scheme in C"].middle == pytest.approx(1.64 / 1.35)
    assert part.ratios["python-control, restarted each sample over ours"].middle == pytest.approx(1975.0 / 1.64)
    broken = [replace(time, error=math.nan) if "gcc" in time.name else time for time in times]
    monkeypatch.setattr(peers, "measured", lambda turns: broken)
    assert not any("in C" in name for name in peers.peers(suite("suite.part").QUICK, tmp_path).ratios)
    with pytest.raises(ValueError, match="no row of a table"):
        peers.times_in("nothing of the kind\n")


@pytest.mark.parametrize(
    ("before", "now", "moved"),
    [
        ((1.0, 1.1, 1.2), (1.15, 1.3, 1.4), False),  # ranges overlap
        ((1.0, 1.1, 1.2), (1.3, 1.4, 1.5), True),
        ((1.3, 1.4, 1.5), (1.0, 1.1, 1.2), True),
        ((1.0,), (1.04,), False),  # apart, but by less than what counts
        ((1.0,), (1.06,), True),
    ],
)
def test_a_ratio_has_moved_where_all_rounds_are_beyond_the_old_ones(
    suite: Any, before: tuple[float, ...], now: tuple[float, ...], moved: bool
) -> None:
    ratio = suite("suite.part").Ratio
    lines = suite("suite.ratios").changes({"a over b": ratio(before)}, {"a over b": ratio(now), "new": ratio((1.0,))})
    assert len(lines) == moved
    assert all(line.startswith("a over b: ") for line in lines)

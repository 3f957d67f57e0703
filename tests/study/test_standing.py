"""A finished run whose results, tables, figures and page still stand: --resume makes none of them again, and all of
them once anything is not as it was.
"""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from command import FIGURE, Answer, changed, workbench, write

from workbench.study import standing

TABLE = '[[tables]]\nname = "t"\ntitle = "t"\nrows = [{ result = "rms_error_m", label = "error", unit = "mm" }]\n'

SMALL = (
    changed('"1 s"', '"0.2 s"').replace('"0.4 s"', '"0.1 s"').replace("[0, 460]", "[0]")
    + TABLE
    + FIGURE
    + 'curves = [{ y = "position" }]\n'
)
"""One case with a table and a figure."""


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the study, and its results, finished."""
    folder = tmp_path_factory.mktemp("finished")
    assert resumed(folder, SMALL).code == 0
    return folder


@pytest.fixture
def place(finished: Path, tmp_path: Path) -> Path:
    """A copy of it, in which files have the times that they had."""
    return shutil.copytree(finished, tmp_path / "copy")


def resumed(folder: Path, study: str, *options: str) -> Answer:
    return workbench("run", write(folder, study), "--out", folder / "out", "--jobs", "1", "--resume", *options)


def times(folder: Path) -> dict[str, int]:
    """When each file of the results was written."""
    names = ("results.csv", "results.html", "run.json", "tables/t.md", "figures/f.pdf")
    return {name: (folder / "out" / name).stat().st_mtime_ns for name in names if (folder / "out" / name).exists()}


def test_what_stands_is_not_made_again_and_told_all_the_same(place: Path) -> None:
    before, first = times(place), resumed(place, SMALL, "--keep-trajectories")
    assert set(times(place).items()).isdisjoint(set(before.items()) - {("results.csv", before["results.csv"])})
    before, second = times(place), resumed(place, SMALL, "--keep-trajectories")
    assert times(place) == before
    assert len(before) == 5
    assert (first.code, second.code) == (0, 0)
    assert second.out == first.out.replace(f"wrote {place / 'out' / 'results.html'}\n", "")
    assert "| error " in second.out
    assert "results.html" in second.out


def _edited(old: str, new: str) -> Callable[[Path], str]:
    def edit(folder: Path) -> str:
        assert SMALL.count(old) == 1
        return SMALL.replace(old, new)

    return edit


def _removed(name: str) -> Callable[[Path], str]:
    def remove(folder: Path) -> str:
        (folder / "out" / name).unlink()
        return SMALL

    return remove


def _changed_file(folder: Path) -> str:
    path = folder / "out" / "figures" / "f.svg"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("<svg", "<gvs", 1), encoding="utf-8")
    os.utime(path, ns=(0, 1))
    return SMALL


def _drawn_beside(folder: Path) -> str:
    shutil.copy(folder / "out" / "figures" / "f.png", folder / "out" / "figures" / "other.png")
    return SMALL


@pytest.mark.parametrize(
    "edit",
    [
        _edited('label = "error"', 'label = "rms"'),
        _edited('title = "f"', 'title = "g"'),
        _removed("tables/t.md"),
        _removed("figures/f.pdf"),
        _removed("results.html"),
        _changed_file,
        _drawn_beside,
    ],
    ids=["table", "figure", "no table", "no figure", "no page", "other", "beside"],
)
def test_it_is_made_again_once_it_is_not_as_it_was(place: Path, edit: Callable[[Path], str]) -> None:
    before, study = times(place), edit(place)
    assert resumed(place, study).code == 0
    after = times(place)
    assert len(after) == 5
    for name in ("results.html", "run.json", "tables/t.md", "figures/f.pdf"):
        assert after[name] != before[name], name
    assert resumed(place, study).code == 0
    assert times(place) == after


def test_it_is_made_again_by_another_program(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another version of a package that draws, or any other source file: the page's own style."""
    before = times(place)
    monkeypatch.setattr(standing, "versions", lambda packages: {"matplotlib": "0"})
    assert resumed(place, SMALL).code == 0
    drawn = times(place)
    assert drawn["figures/f.pdf"] != before["figures/f.pdf"]
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b" " * (path.name == "page.css"))
    assert resumed(place, SMALL).code == 0
    assert times(place)["results.html"] != drawn["results.html"]


def test_both_options_are_refused_where_all_stands(place: Path) -> None:
    answer = resumed(place, SMALL, "--overwrite")
    assert (answer.code, answer.err.splitlines()[-1]) == (2, "error: --resume and --overwrite: choose one")

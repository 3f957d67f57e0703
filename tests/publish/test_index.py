"""The page over a folder of results says what is there, and touches nothing of others."""

import os
import re
import shutil
from pathlib import Path

import pytest
from command import STUDY, changed, workbench

import workbench as wb
from workbench.errors import UserError
from workbench.publish.page.index import entries_of, write_index


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    for name in ("one", "deeper/two & three"):
        wb.Study(folder / "study.toml").run(folder / name)
    begun = folder / "begun"
    begun.mkdir()
    (begun / "results.sqlite").write_bytes(b"")
    (folder / "notes.html").write_text("<title>mine</title>", encoding="utf-8")
    return folder


def test_every_result_is_listed_with_what_it_says(results: Path) -> None:
    one, two = sorted(entries_of(results), key=lambda entry: entry.folder, reverse=True)
    assert (one.folder, two.folder) == ("one", "deeper/two & three")
    assert two.link == "deeper/two%20%26%20three/results.html"
    assert one.kind == "study"
    assert "Phase lag from" in one.says
    assert one.cases == "2"
    assert re.fullmatch(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d", one.started)


def test_the_command_writes_it_again_and_again(results: Path) -> None:
    texts = []
    for _ in range(2):
        answer = workbench("index", results)
        assert answer.code == 0
        assert answer.out == f"wrote {results / 'index.html'}: 2 results\n"
        texts.append((results / "index.html").read_text(encoding="utf-8"))
    assert texts[0] == texts[1]
    assert "begun: go on with" in texts[0]
    assert "mine" not in texts[0]
    assert "http" not in re.sub(r"http://www.w3.org/2000/svg", "", texts[0])


def test_a_page_of_somebody_else_stays(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("<title>mine</title>", encoding="utf-8")
    with pytest.raises(UserError, match=r"index\.html: is not of this program; move it away"):
        write_index(tmp_path)
    assert (tmp_path / "index.html").read_text(encoding="utf-8") == "<title>mine</title>"
    with pytest.raises(UserError, match="no such folder"):
        write_index(tmp_path / "none")


def test_a_folder_without_results_says_so(tmp_path: Path) -> None:
    path, count = write_index(tmp_path)
    assert count == 0
    assert "No finished results here" in path.read_text(encoding="utf-8")


def test_what_a_title_holds_is_text(tmp_path: Path) -> None:
    text = changed('title = "', 'title = "<script>alert(1)</script> ', STUDY)
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    wb.Study(tmp_path / "study.toml").run(tmp_path / "out")
    page = (tmp_path / "out" / "results.html").read_text(encoding="utf-8")
    assert "<script>alert(1)" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert "<script>alert(1)" not in write_index(tmp_path)[0].read_text(encoding="utf-8")


def test_what_is_broken_or_leads_elsewhere_is_passed_over(results: Path, tmp_path: Path) -> None:
    folder = tmp_path / "all"
    shutil.copytree(results / "one", folder / "one")
    (folder / "loop").symlink_to(folder)
    (folder / "linked").symlink_to(results / "one")
    odd = folder / "odd"
    odd.mkdir()
    (odd / "binary.html").write_bytes(bytes(range(256)))
    (odd / "folder.html").mkdir()
    (odd / "dangling.html").symlink_to(odd / "nowhere")
    (odd / "marked.html").write_text("<![foo[ x ]]>", encoding="utf-8")
    os.mkfifo(odd / "pipe.html")
    page = (results / "one" / "results.html").read_text(encoding="utf-8")
    for name, picture in (("up", "../../secret"), ("far", "/etc/passwd")):
        (folder / name).mkdir()
        text = page.replace('<meta name="picture" content="', f'<meta name="picture" content="{picture}')
        (folder / name / "results.html").write_text(text, encoding="utf-8")
    for name, record in (("up", '{"wall_seconds": ' + "1" * 400 + "}"), ("far", "[" * 100_000)):
        (folder / name / "run.json").write_text(record, encoding="utf-8")
    found = entries_of(folder)
    assert [entry.folder for entry in found] == ["far", "one", "up"]
    assert not any(entry.picture for entry in found)
    assert write_index(folder)[1] == 3


def test_a_folder_of_results_is_not_one_of_folders(results: Path) -> None:
    with pytest.raises(UserError, match=r"one: is a folder of results itself; name the one that holds it"):
        write_index(results / "one")

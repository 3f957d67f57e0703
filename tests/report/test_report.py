"""A report: one LaTeX document of folders of results, which compiles without a warning where there is a LaTeX."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from command import ROOT, STUDY, Answer, fails, ran, workbench
from hypothesis import given, settings
from hypothesis import strategies as some
from latex_reader import mistakes, whole

from workbench.publish.contents import CONTENTS, Contents, write_contents
from workbench.report import compiling
from workbench.report.document import document
from workbench.report.folder import write_report
from workbench.report.part import Part

LATEX = shutil.which("pdflatex") is not None
NO_LATEX = "no pdflatex on this machine: apt-get install texlive-latex-extra texlive-science"

TABLE = """
[[tables]]
name = "lags"
title = "Lags & errors, 100 % of them"
source = "nobody_et_al, µ"
index = "rpm"
columns = [{ result = "phase_lag_deg", label = "lag", unit = "deg", published = { 460 = 1.0 } },
           { result = "rms_error_m", label = "rms", unit = "mm" }]

[[figures]]
name = "lag_over_rpm"
title = "Lag over rpm"
[[figures.panels]]
x = "rpm"
x_label = "rotation"
y_label = "lag"
y_unit = "deg"
curves = [{ y = "phase_lag_deg", label = "p" }]
"""

REMARK = "# Assumptions of a test, 中:\n# - the first_one, about 5 µm;\n# - the second.\n"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of a small study with a table and a figure."""
    return ran(tmp_path_factory.mktemp("report"), REMARK + STUDY + TABLE)


def said_by(folder: Path, answer: Answer) -> str:
    """What the command complains of, with @ for the folder."""
    return answer.err.replace(str(folder), "@")


def test_a_study_is_told_in_order_with_its_file_as_appendix(results: Path, tmp_path: Path) -> None:
    out = tmp_path / "paper"
    assert workbench("report", results, "--out", out) == (0, f"wrote {out / 'report.tex'}\n", "")
    assert sorted(path.relative_to(out).as_posix() for path in out.rglob("*.*")) == [
        *("parts/results/lag-over-rpm.pdf", "parts/results/lags.tex", "report.tex")
    ]
    text = whole(out / "report.tex")
    assert mistakes(out / "report.tex") == []
    headings = ["Answer", "Assumptions and notes", "Tables", "Figures", "Provenance", "The file study.toml"]
    assert re.findall(r"\\section\{([^}]+)\}", text) == headings
    assert "1 of 2 cases: torque-limited (rpm 460)." in text
    assert r"\item the first one, about 5 \textmu{}m;" in text
    assert r"Tables~" not in text
    assert r"Table~\ref{tab:results:lags}." in text
    assert r"\caption{Lag over rpm.}" in text
    assert r"\item[a] nobody et al, \textmu{}." in text
    assert "numba" in text
    assert "# - the first_one, about 5 \\textmu{}m;" in text, "the file stands there as it is"


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        (r"\label{tab:", r"\label{tob:", "no label tab:results:lags"),
        (r"\end{threeparttable}", "", "table is ended that was not begun last"),
        (r"\toprule", r"\toprule}", "a brace is closed that was not opened"),
        ("0 & ", "0 & & ", "7 cells in 6 columns"),
        (r"\caption{", r"\caption{a_b ", "bare '_'"),
        (r"\caption{", r"\caption{µ ", "character 'µ'"),
    ],
)
def test_the_reader_of_these_tests_sees(results: Path, tmp_path: Path, before: str, after: str, said: str) -> None:
    report = write_report([results], tmp_path / "paper")
    table = tmp_path / "paper" / "parts" / "results" / "lags.tex"
    text = table.read_text(encoding="utf-8")
    assert before in text
    table.write_text(text.replace(before, after, 1), encoding="utf-8")
    assert any(said in mistake for mistake in mistakes(report.tex)), mistakes(report.tex)


def test_the_same_results_give_the_same_bytes(results: Path, tmp_path: Path) -> None:
    first, again = (write_report([results, results], tmp_path / name) for name in ("a", "b"))
    files = sorted(path.relative_to(first.tex.parent) for path in first.tex.parent.rglob("*.*"))
    assert len(files) == 5
    for path in files:
        assert (first.tex.parent / path).read_bytes() == (again.tex.parent / path).read_bytes()
    assert mistakes(first.tex) == []
    assert "tab:results-2:lags" in whole(first.tex)


def width_of(pdf: Path) -> float:
    """The width of a picture, in mm."""
    box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+)", pdf.read_bytes())
    assert box is not None
    return float(box[1]) / 72.0 * 25.4


def test_figures_have_the_width_that_is_asked_for(results: Path, tmp_path: Path) -> None:
    before = (results / "figures" / "lag_over_rpm.pdf").read_bytes()
    report = write_report([results], tmp_path / "paper", "ieee")
    drawn = tmp_path / "paper" / "parts" / "results" / "lag-over-rpm.pdf"
    assert width_of(drawn) == pytest.approx(88.9, abs=0.1)
    assert report.remarks == []
    assert r"\includegraphics{parts" in report.tex.read_text(encoding="utf-8"), "it is not scaled"
    assert (results / "figures" / "lag_over_rpm.pdf").read_bytes() == before, "the results are left alone"


@pytest.mark.skipif(not LATEX, reason=NO_LATEX)
def test_it_compiles_without_a_warning_to_the_same_bytes(results: Path, tmp_path: Path) -> None:
    first, again = (write_report([results], tmp_path / name, "84 mm", pdf=True) for name in ("a", "b"))
    assert first.remarks == []
    assert first.pdf is not None
    assert again.pdf is not None
    assert first.pdf.read_bytes().startswith(b"%PDF")
    assert first.pdf.read_bytes() == again.pdf.read_bytes()


@pytest.mark.skipif(not LATEX, reason=NO_LATEX)
def test_what_latex_stops_at_is_told_in_a_line(results: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(results, tmp_path / "results")
    table = copy / "tables" / "lags.tex"
    table.write_text(table.read_text(encoding="utf-8").replace(r"\toprule", r"\tobrule"), encoding="utf-8")
    answer = workbench("report", copy, "--out", tmp_path / "paper", "--pdf")
    fails(answer, "report.tex: pdflatex stops: Undefined control sequence")
    assert not (tmp_path / "paper").exists()


def test_without_a_latex_the_way_to_one_is_told(results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling.shutil, "which", lambda name: None)
    answer = workbench("report", results, "--out", tmp_path / "paper", "--pdf")
    fails(answer, "--pdf: no pdflatex is found; install one (apt-get install texlive-latex-extra")
    assert not (tmp_path / "paper").exists()


def test_folders_that_hold_no_results(results: Path, tmp_path: Path) -> None:
    out, kinds = tmp_path / "paper", "workbench run, tune, decide, identify or diagnose"

    def said(folder: Path) -> str:
        answer = workbench("report", folder, "--out", out)
        fails(answer)
        return said_by(tmp_path, answer)

    empty = tmp_path / "empty"
    assert said(empty) == f"error: @/empty: no such folder, expected one of results of {kinds}\n"
    empty.mkdir()
    assert said(empty) == f"error: @/empty: got nothing; expected the results of {kinds}\n"
    (empty / "a.txt").write_text("a", encoding="utf-8")
    assert said(empty) == f"error: @/empty: got a.txt; expected the results of {kinds}\n"
    assert said(empty / "a.txt") == f"error: @/empty/a.txt: is a file, expected a folder of results of {kinds}\n"
    (empty / "identified.json").write_text("{}", encoding="utf-8")
    assert "was written by an earlier version; run the command again" in said(empty)
    (empty / CONTENTS).write_text('{"a": 1}', encoding="utf-8")
    assert said(empty).startswith(f"error: @/empty/{CONTENTS}: got a, expected answer, command, ")
    (empty / CONTENTS).write_text("{", encoding="utf-8")
    assert f"{CONTENTS}: cannot be read (" in said(empty)
    copy = shutil.copytree(results, tmp_path / "copy")
    table, figure = copy / "tables" / "lags.tex", copy / "figures" / "lag_over_rpm.pdf"
    table.write_text(r"\begin{table}", encoding="utf-8")
    assert said(copy).endswith(
        "make the tables again, of a study with workbench run STUDY.toml --out @/copy --resume\n"
    )
    table.unlink()
    assert said(copy) == "error: @/copy/tables/lags.tex: no such file, expected a table; make the tables again\n"
    shutil.copyfile(results / "tables" / "lags.tex", table)
    figure.write_bytes(b"%PDF")
    assert "got no picture of ours, expected a PDF of a page" in said(copy)
    figure.unlink()
    (copy / "figures" / "lag_over_rpm.png").unlink()
    assert said(copy) == (
        "error: @/copy/figures/lag_over_rpm.pdf: no such file, expected a figure; make the figures again\n"
    )
    (copy / "results.parquet").unlink()
    assert "holds no finished results" in said(copy)
    assert not out.exists()


def test_formats_that_are_none(results: Path, tmp_path: Path) -> None:
    for text, expected in {
        "iee": 'format "iee": did you mean "ieee"?, or a width such as "84 mm" or "84 mm, 9 pt"',
        "84": 'format "84": expected one of ieee, ',
        "5 mm": 'format "5 mm": expected 40 to 400 mm with text of 4 to 24 pt',
        "90 mm, 40 pt": "expected 40 to 400 mm with text of 4 to 24 pt",
    }.items():
        fails(workbench("report", results, "--out", tmp_path / "paper", "--format", text), expected)


def test_what_is_there_is_protected(results: Path, tmp_path: Path) -> None:
    out = tmp_path / "paper"
    assert workbench("report", results, "--out", out).code == 0
    fails(workbench("report", results, "--out", out), "holds a report already; replace it with --overwrite")
    (out / "mine.txt").write_text("mine", encoding="utf-8")
    assert workbench("report", results, "--out", out, "--overwrite").code == 0
    assert (out / "mine.txt").exists()
    (out / "report.tex").write_text("mine", encoding="utf-8")
    answer = workbench("report", results, "--out", out, "--overwrite")
    fails(answer, "holds report.tex, parts that no report wrote; choose another --out")
    assert (out / "report.tex").read_text(encoding="utf-8") == "mine"


def contents(text: str, words: str = "") -> Contents:
    """Contents with that file, and words in all places."""
    said = dict.fromkeys(("title", "question", "command", "file"), words)
    return Contents(**said, answer=[words], notes=[words], tables=[], figures=[], details=[], provenance={}, text=text)


@settings(max_examples=30)
@given(some.text(), some.text())
def test_any_words_and_any_file_make_a_document(text: str, words: str) -> None:
    made = document({"a": Part(contents(text, words), {}, [])}, {"a": {}}, 160.0)
    assert made.isascii()
    listed = made.partition(r"\begin{Verbatim}")[2].partition("\n")[2].partition("\\end{Verbatim}")[0]
    assert all(len(re.sub(r"\\(?:[{}]|\w+\{\})", "x", line)) <= 200 for line in listed.splitlines())


@pytest.mark.skipif(not LATEX, reason=NO_LATEX)
def test_a_file_of_any_characters_compiles(tmp_path: Path) -> None:
    folder = tmp_path / "results"
    folder.mkdir()
    text = (
        "a = '''`\\{}%&#$^~_''' # µ ± ² é ł ß 中 \u202f 😀 -- <<>> ,, ?`\n"
        + "x" * 300
        + "\n"
        + 'b = "word '
        + "word " * 60
    )
    said = "Ångström_and_others ± 5 µm, α ≤ β, “so”, 中 <a> [b] * 50 % of #3 & $4, ~ {x} \\y a/long/path/of_parts.toml"
    write_contents(contents(text, said), folder)
    report = write_report([folder], tmp_path / "paper", pdf=True)
    assert report.remarks == []
    if shutil.which("lualatex"):
        command = ["lualatex", "-interaction=nonstopmode", "-halt-on-error", "report.tex"]
        for _ in range(2):
            subprocess.run(command, cwd=tmp_path / "paper", check=True, capture_output=True, timeout=120.0)
        log = (tmp_path / "paper" / "report.log").read_text(encoding="utf-8", errors="replace")
        assert compiling.warnings_in(log) == []
        assert "Missing character" not in log


def test_contents_are_read_as_they_were_written(tmp_path: Path) -> None:
    from workbench.publish.contents import read_contents

    write_contents(contents("µ", "words"), tmp_path)
    assert read_contents(tmp_path) == contents("µ", "words")
    assert set(json.loads((tmp_path / CONTENTS).read_text(encoding="utf-8"))) == {*Contents.__dataclass_fields__}


def test_the_docs_name_every_format() -> None:
    from workbench.publish.page_format import FORMATS

    told = (ROOT / "docs" / "papers.md").read_text(encoding="utf-8")
    for name, page in FORMATS.items():
        assert f"| `{name}` | {page.width:g} mm | {page.points:g} pt | {page.source} |" in told

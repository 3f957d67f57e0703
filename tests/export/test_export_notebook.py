"""workbench export notebook: cells that run, and figures that are those of the command."""

from pathlib import Path

import nbformat
from command import STUDY, changed, fails, workbench, write

TABLE = """
[[tables]]
name = "errors"
title = "Errors"
rows = [{ result = "rms_error_m", label = "rms error", unit = "mm", where = { rpm = 460 } }]
"""


def test_the_notebook_shows_what_the_command_finds(tmp_path: Path) -> None:
    study = write(tmp_path, STUDY + TABLE)
    out = tmp_path / "books" / "study.ipynb"
    answer = workbench("export", "notebook", study, "--case", "rpm=460", "--out", out)
    assert (answer.code, answer.err) == (0, "")
    book = nbformat.read(out, 4)
    nbformat.validate(book)
    code = [cell for cell in book.cells if cell.cell_type == "code"]
    assert code[0].source == "import workbench as wb\n\nstudy = wb.Study('../study.toml')\nstudy"
    assert "loop = study.setup(rpm=460)" in "\n".join(cell.source for cell in code)
    assert all(cell.outputs for cell in code)
    shown = {cell.source: cell.outputs[0]["data"]["text/plain"] for cell in code}
    assert workbench("run", study, "--out", tmp_path / "own").code == 0
    for name in ("results.csv", "tables/errors.csv"):
        own, other = tmp_path / "own" / name, tmp_path / "books" / "study_results" / name
        assert own.read_bytes() == other.read_bytes()
    for number in (tmp_path / "own" / "tables" / "errors.csv").read_text(encoding="utf-8").split()[-1].split(",")[-2:]:
        assert number in shown["results.table('errors')"]
    assert "image/png" in next(cell for cell in code if "run.plot" in cell.source).outputs[0]["data"]


def test_what_is_refused(tmp_path: Path) -> None:
    study, out = write(tmp_path, STUDY), tmp_path / "study.ipynb"
    fails(workbench("export", "notebook", study, "--out", tmp_path / "study.py"), "a name that ends in .ipynb")
    fails(
        workbench("export", "notebook", study, "--case", "rpm=1", "--out", out), "no case with rpm 1; the axes are rpm"
    )
    write(tmp_path, changed('"pid"', '"pidd"'), "wrong.toml")
    fails(workbench("export", "notebook", tmp_path / "wrong.toml", "--out", out), 'did you mean "pid"')
    out.write_text("mine", encoding="utf-8")
    fails(workbench("export", "notebook", study, "--out", out), "is there already; replace it with --overwrite")
    assert out.read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "study_results").exists()

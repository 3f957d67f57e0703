"""Names from files never lead out of the folder of results, nor do links that lie in it."""

from pathlib import Path

import pytest
from command import FIGURE, STUDY, fails, ran, workbench, write

from workbench.errors import UserError
from workbench.publish.contents import Contents, read_contents, write_contents
from workbench.publish.folders import anew, made


def evil_names(folder: Path) -> list[str]:
    return ["../evil", "../../evil", str(folder / "evil"), "..", "a/b", "a\\b", "x" * 5000, "con", "plain"]


def test_records_of_cases_stay_in_their_folder(tmp_path: Path) -> None:
    names = evil_names(tmp_path)
    cases = "".join(f"[cases.{quoted(name)}]\n" for name in names)
    text = 'records = ["position"]\n' + STUDY.replace("[0, 460]", "[0]").replace('"2 Hz"', '"5 Hz"') + cases
    (tmp_path / "home").mkdir()
    out = ran(tmp_path / "home", text)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["home"]
    assert sorted(path.name for path in (tmp_path / "home").iterdir()) == ["results", "study.toml"]
    records = sorted((out / "records").iterdir())
    assert len(records) == len(names)
    assert "plain_0_rpm_0008.parquet" in {path.name for path in records}
    assert all(path.suffix == ".parquet" and path.is_file() for path in records)


def quoted(name: str) -> str:
    return '"' + name.replace("\\", "\\\\") + '"'


@pytest.mark.parametrize("folder", ["tables", "figures"])
def test_a_link_in_the_results_is_not_followed(tmp_path: Path, folder: str) -> None:
    """What a later command makes anew goes nowhere else."""
    curve = '[[figures.panels.curves]]\ny = "position"\nwhere = { rpm = 0 }\n'
    table = '[[tables]]\nname = "t"\ntitle = "t"\nindex = "rpm"\ncolumns = [{ result = "rms_error_m", label = "e" }]\n'
    out, elsewhere = ran(tmp_path, STUDY + table + FIGURE + curve), tmp_path / "elsewhere"
    elsewhere.mkdir()
    for path in (out / folder).iterdir():
        path.unlink()
    (out / folder).rmdir()
    (out / folder).symlink_to(elsewhere)
    fails(workbench(folder.replace("figures", "plot").removesuffix("s"), out), "is a link that leads elsewhere")
    assert not list(elsewhere.iterdir())
    (out / folder).unlink()
    (out / folder).mkdir()
    victim = tmp_path / "victim"
    victim.write_text("mine")
    for name in ("t.csv", "t.md", "t.tex", "f.png", "f.pdf", "f.svg"):
        (out / folder / name).symlink_to(victim)
    workbench(folder.replace("figures", "plot").removesuffix("s"), out)
    assert victim.read_text() == "mine"


def test_links(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "there")
    with pytest.raises(UserError, match="is a link that leads elsewhere"):
        made(tmp_path / "link")
    assert anew(tmp_path / "there") == tmp_path / "there" == made(tmp_path / "there")
    assert not anew(tmp_path / "link").exists()


CONTENTS = Contents("t", "", [], [], "c", ["a"], [], [], {}, "f", "")


@pytest.mark.parametrize("field", ["tables", "figures", "details"])
@pytest.mark.parametrize("name", ["../../secret", "/etc/passwd", "..", ""])
def test_names_read_back_lead_nowhere(tmp_path: Path, field: str, name: str) -> None:
    write_contents(Contents(**{**vars(CONTENTS), field: [name]}), tmp_path)
    with pytest.raises(UserError, match=rf"contents\.json: {field}: got \['"):
        read_contents(tmp_path)


@pytest.mark.parametrize(
    ("field", "value"), [("title", 3), ("answer", "x"), ("notes", [1]), ("provenance", []), ("tables", 1)]
)
def test_contents_of_another_kind(tmp_path: Path, field: str, value: object) -> None:
    write_contents(Contents(**{**vars(CONTENTS), field: value}), tmp_path)
    with pytest.raises(UserError, match=rf"contents\.json: {field}: got "):
        read_contents(tmp_path)
    write_contents(CONTENTS, tmp_path)
    assert read_contents(tmp_path) == CONTENTS


def test_a_study_of_a_machine_with_a_name_that_leads_elsewhere(tmp_path: Path) -> None:
    """Its gain files are looked for where `workbench tune` writes them."""
    text = STUDY.replace("rpm = [0, 460]", 'rpm = [0]\nmachine = ["../evil"]').replace(
        'type = "pid"\nkp = "500 V/m"', 'gains = "tuned/{machine}/p.toml"'
    )
    answer = workbench("check", write(tmp_path, text + '[machines."../evil"]\n'))
    fails(answer, str(tmp_path / "tuned" / "%2E.%2Fevil" / "p.toml"), "no such file")

"""Archives that are no FMU, or mean harm: a line each, and nothing is unpacked."""

import io
import stat
import zipfile
from pathlib import Path

import pytest
from foreign_fmu import DESCRIPTION

from workbench.errors import UserError
from workbench.fmu import archive
from workbench.fmu.description import read_fmu


def zipped(files: dict[str, bytes]) -> bytes:
    """An archive of these files."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in files.items():
            made.writestr(name, content)
    return buffer.getvalue()


def with_description(text: str | bytes, **more: bytes) -> bytes:
    """An archive with that description."""
    return zipped({"modelDescription.xml": text.encode() if isinstance(text, str) else text, **more})


GROWS = '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><x>&b;</x>'
WHOLE = with_description(DESCRIPTION)

BAD = {
    "nothing": (b"", "no archive that can be read"),
    "text": (b"no archive", "no archive that can be read"),
    "cut": (WHOLE[: len(WHOLE) // 2], "no archive that can be read"),
    "damaged": (WHOLE.replace(WHOLE[60:90], b"\0" * 30), "no archive that can be read"),
    "empty": (zipped({}), "holds no modelDescription.xml"),
    "outside": (with_description(DESCRIPTION, **{"../../evil": b""}), 'file "../../evil" leads out of the archive'),
    "absolute": (with_description(DESCRIPTION, **{"/etc/evil": b""}), "leads out of the archive"),
    "other system": (with_description(DESCRIPTION, **{"a\\..\\evil": b""}), "leads out of the archive"),
    "many": (with_description(DESCRIPTION, **{f"f{i}": b"" for i in range(11)}), "holds 12 files, expected at most 10"),
    "bomb": (with_description(DESCRIPTION, zeros=b"\0" * 200_000), "would unpack to more than 100000 bytes"),
    "long": (with_description(DESCRIPTION + " " * 50_000), "modelDescription.xml is longer than 40000 bytes"),
    "entities": (with_description(GROWS), "has a document type"),
    "no XML": (with_description("<a>"), "is no XML"),
    "an odd encoding": (with_description('<?xml version="1.0" encoding="none"?><a/>'), "is no XML"),
    "other XML": (with_description("<a/>"), 'FMI "", expected 2.0 or 3.0'),
    "FMI 1": (with_description(DESCRIPTION.replace('fmiVersion="2.0"', 'fmiVersion="1.0"')), 'FMI "1.0"'),
    "model exchange alone": (
        with_description(DESCRIPTION.replace("CoSimulation", "Other")),
        "no co-simulation",
    ),
    "no token": (with_description(DESCRIPTION.replace("guid=", "uuid=")), "lacks the attribute 'guid'"),
    "no reference": (
        with_description(DESCRIPTION.replace('valueReference="4"', 'valueReference="x"')),
        "invalid literal",
    ),
    "odd reference": (with_description(DESCRIPTION.replace('valueReference="4"', 'valueReference="-4"')), "-4"),
    "no type": (with_description(DESCRIPTION.replace('<Real unit="deg"/>', "")), 'variable "phi" has no type'),
    "no factor": (with_description(DESCRIPTION.replace('factor="0.017453292519943295"', 'factor="0"')), "the factor 0"),
    "odd factor": (with_description(DESCRIPTION.replace('factor="0.017453292519943295"', 'factor="x"')), "float"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_fmu_is_told_in_a_line(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive, "MOST_FILES", 10)
    monkeypatch.setattr(archive, "MOST_BYTES", 100_000)
    monkeypatch.setattr(archive, "MOST_DESCRIPTION", 40_000)
    content, said = BAD[name]
    path = tmp_path / "machine.fmu"
    path.write_bytes(content)
    with pytest.raises(UserError, match=r"machine\.fmu: ") as told:
        read_fmu(path)
    assert said in str(told.value)
    assert "\n" not in str(told.value)
    assert [*tmp_path.iterdir()] == [path]


def test_a_link_in_an_archive_is_not_followed(tmp_path: Path) -> None:
    path, link = tmp_path / "machine.fmu", zipfile.ZipInfo("resources/link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("modelDescription.xml", DESCRIPTION)
        made.writestr(link, "/etc/passwd")
    with pytest.raises(UserError, match="leads out of the archive"):
        read_fmu(path)


def test_no_more_is_unpacked_than_the_list_of_files_says(tmp_path: Path) -> None:
    content = with_description(DESCRIPTION, resources=b"", **{"resources/a": b"a" * 1000})
    path = tmp_path / "machine.fmu"
    path.write_bytes(content.replace((1000).to_bytes(4, "little"), (10).to_bytes(4, "little")))
    with pytest.raises(UserError):
        archive.unpack(path, tmp_path / "out", ("resources/",))

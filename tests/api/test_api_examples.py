"""Every public name is documented, its examples run, and a notebook made of them executes without a screen."""

import doctest
import inspect
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import control
import nbformat
import pytest
from api_examples import FACES, documented, examples, given, given_experiment, notebook
from command import ROOT
from nbclient import NotebookClient
from snippets.blocks import blocks

from workbench import api
from workbench.design import design, power, search

pytestmark = pytest.mark.usefixtures("png_alone", "little_effort")


@pytest.fixture(scope="module")
def little_effort() -> Iterator[None]:
    """A motion is designed from few pieces and on few machines: how good it is no example shows."""
    with (
        mock.patch.object(search, "STEPS", 0),
        mock.patch.object(design, "COMPARED", 0),
        mock.patch.object(power, "STEPS", 0),
    ):
        yield


@pytest.fixture(scope="module")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The one that examples take as given: they read it and write elsewhere."""
    return given_experiment(tmp_path_factory.mktemp("given"))


EXAMPLES = examples()
"""Names with their documentation."""


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_run(name: str, experiment: Path, tmp_path: Path) -> None:
    test = doctest.DocTestParser().get_doctest(EXAMPLES[name], given(tmp_path, experiment), name, name, 0)
    failures: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    runner.run(test, out=failures.append, clear_globs=False)
    assert not failures, "".join(failures)
    ours = [thing for thing in test.globs.values() if type(thing).__module__.startswith("workbench.")]
    faces = [thing._repr_html_() for thing in ours if hasattr(thing, "_repr_html_")]
    assert all(face.lstrip().startswith("<") for face in faces)


@pytest.mark.parametrize("name", api.__all__)
def test_every_public_name_is_documented_with_its_arguments_and_an_example(name: str) -> None:
    texts = {where: text for where, text in documented() if where.partition(".")[0] == name}
    assert texts[name].strip()
    thing = getattr(api, name)
    if name == "UserError":
        return
    assert any(">>>" in text for text in texts.values())
    if inspect.isfunction(thing):
        assert "Raises:" in texts[name] or name in ("simulate", "evaluate")
        for parameter in inspect.signature(thing).parameters:
            assert f"{parameter}:" in texts[name] or f"{parameter} " in texts[name], parameter


@pytest.mark.thorough
@pytest.mark.filterwarnings("default")
def test_a_notebook_of_the_examples_executes(tmp_path: Path) -> None:
    cells = notebook(tmp_path, given_experiment(tmp_path))
    NotebookClient(cells, timeout=300, resources={"metadata": {"path": ROOT}}).execute()
    nbformat.write(cells, tmp_path / "examples.ipynb")
    shown = [{kind for output in cell.get("outputs", []) for kind in output.get("data", {})} for cell in cells.cells]
    *faces, figure = shown[-len(FACES) :]
    assert all("text/html" in kinds for kinds in faces)
    assert "image/png" in figure


def test_the_readme_and_the_guide_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "studies").symlink_to(ROOT / "studies")
    monkeypatch.chdir(tmp_path)
    pages = (ROOT / "README.md", ROOT / "docs" / "python.md")
    code = "".join(block.text for page in pages for block in blocks(page) if block.language == "python")
    names: dict[str, object] = {"control": control}
    exec(code, names)
    assert str(names["results"]).startswith('StudyResults("Chapter 3: tracking", 9 cases')

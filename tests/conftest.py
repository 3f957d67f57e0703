"""Fixtures that several tests share: every registered plant, and parameters for it."""

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest import mock

import pytest
from browsing import CHROMIUM, FLAGS
from thesis_actuator import OF_OTHERS, along

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy comes in; threads make small matrices slower

from plants.interface import Plant
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytest.register_assert_rewrite("command", "mistakes")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests of the one diagnosis go first, and together: a worker that is free steals the last ones."""
    items.sort(key=lambda item: not (isinstance(item, pytest.Function) and "diagnosed" in item.fixturenames))


@pytest.fixture(autouse=True, scope="session")
def no_progress() -> Iterator[None]:
    """A command says nothing of how far it is, however slow the machine: what it says is compared."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("workbench.cli.progress.INTERVAL", math.inf)
        yield


@contextmanager
def idle_threads(more: int) -> Iterator[None]:
    """So many `more` threads idle, or fewer, of a worker beside others."""
    from workbench.fitting.threads import _team

    if "PYTEST_XDIST_WORKER" not in os.environ:
        yield
        return
    team = _team(os.getpid())
    team._changed(more)
    try:
        yield
    finally:
        team._changed(-more)


@pytest.fixture(autouse=True, scope="session")
def one_thread_a_worker() -> Iterator[None]:
    """Workers have a processor each: threads would only wait for those of another."""
    with idle_threads(-1):
        yield


@pytest.fixture(scope="module")
def both_threads(one_thread_a_worker: None) -> Iterator[None]:
    """What works in threads does so here."""
    with idle_threads(+1):
        yield


@pytest.fixture(scope="module")
def png_alone() -> Iterator[None]:
    """Figures as PNG alone, for tests that look at no other format."""
    with pictures_as_png():
        yield


@pytest.fixture(scope="module")
def dots_alone(png_alone: None) -> Iterator[None]:
    """Figures as PNG of one dot, for tests that look at none and whose figures other tests draw."""
    from matplotlib.figure import Figure
    from matplotlib.image import imsave

    from workbench.publish import pictures

    def dot(_figure: Figure, path: Path, metadata: dict[str, Any]) -> None:
        imsave(path, [[0.0]], metadata=metadata)

    with mock.patch.object(pictures, "_lay_out"), mock.patch.object(Figure, "savefig", dot):
        yield


@contextmanager
def pictures_as_png() -> Iterator[None]:
    """PDF and SVG take long."""
    from workbench.compare.report import figures
    from workbench.publish.pictures import save

    with mock.patch.object(save, "__defaults__", (("png",),)), mock.patch.object(figures, "FORMATS", ("png",)):
        yield


@pytest.fixture(scope="module")
def browser() -> Iterator["Browser"]:
    """A real browser; a machine without one loses its tests and nothing else."""
    if not CHROMIUM:
        pytest.skip("no browser: skipped")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield running
        running.close()


@pytest.fixture(params=plants().values(), ids=lambda plant: plant.name)
def plant(request: pytest.FixtureRequest) -> Plant:
    """Every registered plant in turn."""
    return request.param


@pytest.fixture
def parameters(plant: Plant) -> Any:
    """The thesis's simulation set for `plant`, derived flow."""
    return build(plant.Parameters, along(plant, read_parameters(named_sets()["owen2001_simulation"]) | OF_OTHERS))


@pytest.fixture(scope="session")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The experiment of `deadband`, in a folder of its own."""
    from deadband import make_experiment  # what it takes is rewritten first

    return make_experiment(tmp_path_factory.mktemp("diagnosis"))


@pytest.fixture(scope="session")
def diagnosed(experiment: Path) -> tuple[Any, Any]:
    """What the command answers, run once for all tests, and the diagnosis that it made."""
    from command import workbench

    from workbench.diagnose import diagnose

    made = []

    def kept(*arguments: Any) -> Any:
        made.append(whole(*arguments))
        return made[-1]

    whole = diagnose.diagnose
    with pictures_as_png(), idle_threads(+1), mock.patch.object(diagnose, "diagnose", kept):
        answer = workbench("diagnose", experiment, "--out", experiment.parent / "out")
    return answer, *made


@pytest.fixture(scope="session")
def diagnosis(diagnosed: tuple[Any, Any]) -> Any:
    """What diagnosis finds in the experiment."""
    return diagnosed[1]

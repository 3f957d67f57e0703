"""Simulations of a diagnosis that are asked for together: the same bits as each for itself."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from threading import Barrier

import numpy as np
import pytest
from driven import driven_shooting

from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.simulation import together
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.together import Asked, Push, errors_of
from workbench.fitting.threads import THREADS, side_by_side
from workbench.simulation.simulate import LANES

pytestmark = pytest.mark.usefixtures("both_threads")

Made = tuple[Shooting, list[Motion], dict[str, float]]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return driven_shooting(tmp_path_factory.mktemp("drive"), 5e-6, 4.0)


def asked_of(made: Made) -> list[Asked]:
    """Own parameters, effects, starts and pushes that differ."""
    how, (motion,), values = made
    acting = [{"spring_stiffness": 2e4}, {"drag_coefficient": 50.0, "memory_time": 0.02}, {"backlash_width": 1e-4}]
    own = [{"viscous": factor * values["viscous"]} for factor in (0.5, 1.1, 2.0)]
    moved = np.zeros(len(how.along.names))
    moved[how.along.names.index("velocity")] = 1e-3
    push = Push(False, {motion.record: np.sin(motion.record.time)})
    return [
        *(Asked(how, motion, {**values, **changed}) for changed in [*own, *acting]),
        Asked(how, motion, values, moved),
        Asked(replace(how, push=push), motion, values),
        Asked(replace(how, length=0.5), motion, values),
    ]


@pytest.mark.parametrize("worth", [0, 30_000, 10**9])
def test_together_they_are_the_same_bits(made: Made, worth: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """With what acts in each of them alone, or in several, or with all effects."""
    monkeypatch.setattr(together, "WORTH", worth)
    monkeypatch.setattr(together, "_spent", together._Spent())
    monkeypatch.setattr(together, "_memory", together._Memory())
    several = errors_of(asked_of(made))
    for asked, errors in zip(asked_of(made), several, strict=True):
        monkeypatch.setattr(together, "_memory", together._Memory())
        (alone,) = errors_of([asked])
        for one, other in zip(errors, alone, strict=True):
            np.testing.assert_array_equal(one, other)
    assert len({b"".join(one.tobytes() for one in errors) for errors in several}) == len(several)


def test_what_is_asked_for_twice_is_simulated_once(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(together, "_memory", together._Memory())
    counted = list[int]()

    def counting(chunk: together._Chunk, shown: Mapping[Asked, Sequence[Asked]]) -> dict[Asked, list[np.ndarray]]:
        counted.append(len(chunk.asked))
        return simulated(chunk, shown)

    simulated = together._Chunk.errors
    monkeypatch.setattr(together._Chunk, "errors", counting)
    first, second, *_ = asked_of(made)
    one, other, again = errors_of([first, second, first])
    assert sum(counted) == 2
    assert again is one
    assert errors_of([second]) == [other]
    assert sum(counted) == 2


@pytest.mark.parametrize(
    ("count", "sizes"), [(1, [1]), (2, [1, 1]), (5, [3, 2]), (8, [4, 4]), (9, [4, 4, 1]), (18, [4, 4, 4, 4, 1, 1])]
)
def test_every_thread_has_about_as_much_to_do(made: Made, count: int, sizes: list[int]) -> None:
    assert (LANES, THREADS) == (4, 2)
    how, (motion,), values = made
    asked = [Asked(how, motion, {**values, "viscous": 1.0 + i}) for i in range(count)]
    assert [len(chunk.asked) for chunk in together._chunks(asked)] == sizes


def test_a_thread_that_another_works_beside_splits_nothing(made: Made) -> None:
    how, (motion,), values = made
    asked = [Asked(how, motion, {**values, "viscous": 1.0 + i}) for i in range(6)]
    both = Barrier(THREADS, timeout=60.0)

    def sizes(own: list[Asked]) -> list[int]:
        both.wait()
        found = [len(chunk.asked) for chunk in together._chunks(own)]
        both.wait()
        return found

    assert side_by_side(sizes, [asked, asked[:4]]) == [[4, 2], [4]]


def test_a_plant_is_compiled_for_what_acts_where_that_pays(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    """Three candidates together, or one that is simulated again and again."""
    how, (motion,), values = made
    steps = motion.record.time.size  # of a run, at least

    def chunks(*acting: dict[str, float]) -> list[tuple[int, bool]]:
        asked = [Asked(how, motion, {**values, **own}) for own in acting]
        return [(len(chunk.asked), chunk.alone) for chunk in together._chunks(asked)]

    candidates = [
        {"drag_coefficient": 50.0},
        {"memory_time": 0.02},
        {"backlash_width": 1e-4},
    ]
    for worth, found in ((2 * steps, [(2, True), (1, True)]), (10**9, [(1, False)] * 3)):
        monkeypatch.setattr(together, "WORTH", worth)
        monkeypatch.setattr(together, "_spent", together._Spent())
        assert chunks(*candidates) == found
    monkeypatch.setattr(together, "WORTH", 10 * steps)
    assert chunks(candidates[0]) == [(1, False)]
    for i in range(10):
        errors_of([Asked(how, motion, {**values, "drag_coefficient": 40.0 + i})])
    assert chunks(candidates[0], {"drag_coefficient": 60.0}, candidates[1]) == [(1, True), (1, True), (1, False)]


@pytest.mark.parametrize("acting", [{}, {"viscous_negative": 900.0}, {"backlash_width": 1e-4, "memory_time": 0.02}])
def test_along_a_record_effects_that_do_nothing_leave_the_bits(
    tmp_path: Path, acting: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    how, (motion,), values = driven_shooting(tmp_path, 5e-6, 4.0)
    along = Along(how.along.plant, how.along.flow)
    found = []
    for long in (0, 10**6):
        monkeypatch.setattr("workbench.diagnose.residuals.along.LONG", long)
        found.append(along.residuals(motion, {**values, **acting}, "force"))
    np.testing.assert_array_equal(*found)
    assert np.ptp(found[0]) > 0.0

"""One trial: a mutant is made, given to the commands that read it, and watched."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from unittest import mock

from command import DRIVE, STUDY

from fuzz import records, studies
from fuzz.sandbox import Sandbox
from fuzz.structure import mutated
from fuzz.studies import RICH, Mutant, mutant, originals, written
from fuzz.watch import Finding, watched
from workbench.errors import UserError
from workbench.publish.pictures import save
from workbench.study.plan import plan
from workbench.study.reading import read_study
from workbench.study.sections import other_command

MOST_CASES, MOST_SECONDS, MOST_STEPS, LEAST_TOLERANCE = 12, 4.0, 60_000, 1e-8
"""Of a mutant that is really run, all cases together: others take too long to run thousands of them."""

DRAWN = 200
"""Mutants from which one that can be run is taken, at most: what is refused is looked at in thousands of checks."""

KINDS = ("check", "run", "records")


@dataclass(frozen=True)
class Trial:
    """What became of a mutant: `done` in a word, and what was found."""

    done: str
    findings: list[Finding]


def random_of(kind: str, seed: int, number: int) -> Random:
    """The random numbers of one mutant, whatever came before it."""
    return Random(f"{kind} {seed} {number}")


def trial(sandbox: Sandbox, kind: str, seed: int, number: int) -> Trial:
    """Make a mutant and watch what becomes of it."""
    return TRIALS[kind](sandbox, random_of(kind, seed, number))


def _check(sandbox: Sandbox, random: Random) -> Trial:
    return _checked(sandbox, mutant(random))


def _checked(sandbox: Sandbox, made: Mutant) -> Trial:
    """The file checked for itself, and where it is in order so far through the study that names it."""
    path = sandbox.put(made.place, made.content)
    answer, found = watched(sandbox, "check", path)
    if made.named_by and not found:
        naming = sandbox.put("mutant.toml", made.named_by.encode())
        answer, found = watched(sandbox, "check", naming)
        naming.unlink()
    path.unlink()
    return Trial("in order" if answer is not None and answer.code == 0 else "refused", found)


def _run(sandbox: Sandbox, random: Random) -> Trial:
    text = random.choice((STUDY, DRIVE, RICH, RICH, RICH))
    data = next(original.data for original in originals() if original.text == text)
    for _ in range(DRAWN):
        path = sandbox.put("mutant.toml", written(mutated(data, random, [data])))
        if (fit := _is_fit(path)) is not False:
            break
    if not fit:
        return Trial("refused", watched(sandbox, "check", path)[1])
    with contextlib.nullcontext() if random.random() < 0.1 else _png_alone():
        answer, found = watched(sandbox, "run", path, "--out", sandbox.out, "--jobs", "1")
        if not found and answer is not None and answer.code == 0 and random.random() < 0.3:
            reads = random.choice((("plot",), ("table",), ("index",), ("plot", "--y", "position"), ("report",)))
            report = ("--out", sandbox.out / "report") if reads == ("report",) else ()
            _, found = watched(sandbox, reads[0], sandbox.out, *reads[1:], *report)
    sandbox.empty()
    return Trial("run", found)


def _is_fit(path: Path) -> bool | None:
    """Whether a study is in order and takes a blink to run; None of one that is odd, which a check is to tell."""
    try:
        study = read_study(path)
        if other_command(study) is not None:
            return False
        planned = plan(study)
        setups = [item.setup for item in planned.resolved]
    except UserError:
        return False
    except Exception:  # noqa: BLE001 - the check that follows tells it
        return None
    steps = sum(setup.duration / min(setup.sample_time, setup.integrator.step) for setup in setups)
    seconds = sum(setup.duration for setup in setups)
    exact = min((setup.integrator.tolerance for setup in setups), default=1.0)
    return len(setups) <= MOST_CASES and seconds <= MOST_SECONDS and steps <= MOST_STEPS and exact >= LEAST_TOLERANCE


@contextlib.contextmanager
def _png_alone() -> Iterator[None]:
    with mock.patch.object(save, "__defaults__", (("png",),)):
        yield


def _records(sandbox: Sandbox, random: Random) -> Trial:
    name, content = records.record(random)
    path, experiment = sandbox.put(name, content), sandbox.studies / "experiment.toml"
    if random.random() < 0.5:
        experiment.touch()  # what is replaced is no new file
        answer, found = watched(sandbox, "import", path, "--out", experiment, "--force")
        if not found and answer is not None and answer.code == 0:
            answer, found = watched(sandbox, "check", experiment)
    elif random.random() < 0.5:
        experiment.write_text(records.EXPERIMENT.replace("@", name), encoding="utf-8")
        answer, found = watched(sandbox, "check", experiment)
    else:
        experiment.write_text(_recorded(name), encoding="utf-8")
        answer, found = watched(sandbox, "check", experiment)
    experiment.unlink()
    path.unlink()
    return Trial("in order" if answer is not None and answer.code == 0 else "refused", found)


def _recorded(name: str) -> str:
    """A study whose reference is the record."""
    sine = 'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"'
    assert sine in STUDY
    return STUDY.replace(sine, f'kind = "recorded"\nfile = "{name}"\ntime = "time"\nvalue = "position"\nunit = "mm"')


TRIALS = {"check": _check, "run": _run, "records": _records}
__all__ = ["KINDS", "Trial", "random_of", "studies", "trial"]

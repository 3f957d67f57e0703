"""What each command would do with an experiment, in words: it serves, or why not; and what its records hold."""

from collections.abc import Callable, Sequence
from difflib import get_close_matches
from pathlib import Path

from workbench.cli.options import say
from workbench.diagnose import readiness as diagnosis
from workbench.errors import UserError
from workbench.identify import readiness as identification
from workbench.records.experiment import Experiment, RecordSpec, read_experiment
from workbench.records.reading import Record, read_pieces
from workbench.records.schema import METHODS

UNTESTED = 'no record is held out: what is found is tested on what it was fitted to; use = "held_out" keeps one apart'
"""Of an experiment without any."""

LIKE = 0.6
"""Likeness of a file's name from which it may be the one that was meant."""


def check_experiment(file: Path) -> None:
    """Say what an experiment would do, with the records that are there.

    Raises:
        UserError: a mistake in the file, a record that cannot be read, or one that no command can use.
    """
    content = read_experiment(file)
    identification.check_pattern(content)
    designed = _design(content)
    records = [read_pieces(spec, content) if spec.is_there else [] for spec in content.records]
    there = [piece for pieces in records for piece in pieces]
    serves, lines = _commands(content, there)
    whole = all(records)
    absent = "its records are not there yet" if not there else "some of its records are not there yet"
    order = "an experiment, in order" if whole else f"an experiment; {absent}"
    say(f"{file}: {order}" + ("" if len(serves) > 1 else f"; for {serves[0]} alone"))
    say(content.title + (f" ({content.source})" if content.source else ""))
    names = [channel.called for channel in content.channels.values()]
    say(f"  plant {content.plant.name}, {content.declared}; channels: {', '.join(names)}")
    say(f"  free: {content.freed}")
    say("\n".join(f"  {line}" for line in [*lines, *designed]))
    if all(spec.use == "fit" for spec in content.records):
        say(f"  {UNTESTED}")
    for spec, pieces in zip(content.records, records, strict=True):
        say(f"  {spec.path}: {_present(pieces) if pieces else _absent(spec)}")


def _commands(content: Experiment, there: Sequence[Record]) -> tuple[list[str], list[str]]:
    """The commands that the experiment serves, and a line for each, or for each method of one.

    Raises:
        UserError: it serves none.
    """
    given = METHODS[:2] if content.method in (None, "both") else (content.method,)
    methods = {f"identify --method {method}": _why(content, _identify(content, there, method)) for method in given}
    if len(set(methods.values())) == 1:
        methods = {"identify": next(iter(methods.values()))}
    reasons = {**methods, "diagnose": _why(content, _diagnose(content, there))}
    if all(reasons.values()):
        said = "; ".join(f"{name}: {why}" for name, why in reasons.items())
        alike = len(set(reasons.values())) == 1
        raise UserError(f"{content.path}: {reasons['diagnose'] if alike else f'no command can use it: {said}'}")
    needed = {name: [spec for spec in content.records if name == "diagnose" or spec.use == "fit"] for name in reasons}
    use = {
        name: "can use it" + " as soon as all records are there" * (not all(spec.is_there for spec in specs))
        for name, specs in needed.items()
    }
    lines = [f"{name}: " + (f"not, since {why}" if why else use[name]) for name, why in reasons.items()]
    return list(dict.fromkeys(name.split()[0] for name, why in reasons.items() if not why)), lines


def _design(content: Experiment) -> list[str]:
    """What [design] asks for, if it is there.

    Raises:
        UserError: a mistake in it.
    """
    if not content.design:
        return []
    from workbench.design.readiness import check_design

    return [f"design: {check_design(content)}"]


def _why(content: Experiment, check: Callable[[], None]) -> str:
    """Why a check fails; empty where it does not."""
    try:
        check()
    except UserError as error:
        return str(error).removeprefix(f"{content.path}: ")
    return ""


def _identify(content: Experiment, there: Sequence[Record], method: str) -> Callable[[], None]:
    def check() -> None:
        identification.check_experiment(content, method)
        fitted = [record for record in there if record.use == "fit"]
        if all(spec.is_there for spec in content.records if spec.use == "fit"):
            identification.check_records(content, fitted, method)

    return check


def _diagnose(content: Experiment, there: Sequence[Record]) -> Callable[[], None]:
    def check() -> None:
        diagnosis.check_experiment(content)
        diagnosis.motions_of(content, there)

    return check


def _absent(spec: RecordSpec) -> str:
    """That a record is not there, and which file may have been meant."""
    lost = next((path for path in spec.places.values() if not path.exists()), spec.path)
    folder = lost.parent
    if not folder.is_dir():
        return f"is not there (yet?): there is no folder {folder}"
    close = get_close_matches(lost.name, [item.name for item in folder.iterdir()], n=1, cutoff=LIKE)
    return "is not there (yet?)" + (f'; did you mean "{close[0]}"?' if close else "")


def _present(pieces: Sequence[Record]) -> str:
    first, seconds = pieces[0], sum(float(piece.time[-1]) for piece in pieces)
    said = "".join(f"; {note}" for piece in pieces for note in piece.notes)
    return f"{first.use}, {seconds:g} s at {1.0 / first.sample_time:.6g} Hz{said}"

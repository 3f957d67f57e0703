"""What the position is asked to do, or in open loop what is fed to an input of the plant."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from workbench.api.plain import Quantity


@dataclass(frozen=True)
class ReferenceChoice:
    """A reference by its kind and settings: the table [references.KIND] of a study.

    It is checked where it is used, since only a plant says in which unit its values are.

    Example:
        >>> wb.sine("30 mm", 0.9).table
        {'kind': 'sine', 'amplitude': '30 mm', 'frequency': 0.9}
    """

    kind: str
    settings: Mapping[str, object]

    @property
    def table(self) -> dict[str, object]:
        """As a study file holds it."""
        return {"kind": self.kind, **{name: value for name, value in self.settings.items() if value is not None}}


def reference(kind: str, /, **settings: Quantity) -> ReferenceChoice:
    """Any kind of reference, that of another package included.

    Args:
        kind: as `workbench list references` shows them.
        settings: of that kind; SI floats, or text with a unit.

    Raises:
        UserError: where the reference is used: no such kind or setting, or a wrong unit.

    Example:
        >>> wb.reference("sine", amplitude="30 mm", frequency=0.9).table == wb.sine("30 mm", 0.9).table
        True
    """
    return ReferenceChoice(kind, settings)


def sine(
    amplitude: Quantity, frequency: Quantity, *, offset: Quantity | None = None, phase: Quantity | None = None
) -> ReferenceChoice:
    """r(t) = offset + amplitude sin(2 pi frequency t + phase).

    Args:
        amplitude: m (in open loop the unit of the input).
        frequency: Hz, above 0.
        offset: as the amplitude; default 0.
        phase: rad; default 0.

    Raises:
        UserError: where the reference is used: a wrong unit, or a frequency that is not above 0.

    Example:
        >>> wb.sine("30 mm", "0.9 Hz", offset="5 mm").kind
        'sine'
    """
    return ReferenceChoice("sine", {"amplitude": amplitude, "frequency": frequency, "offset": offset, "phase": phase})


def steps(levels: Sequence[Quantity], dwell: Quantity, *, start: Quantity | None = None) -> ReferenceChoice:
    """r(t) = levels[k] for start + k dwell <= t < start + (k + 1) dwell; 0 before, the last level to the end.

    Args:
        levels: m, at least one.
        dwell: s, above 0.
        start: s; default 0.

    Raises:
        UserError: where the reference is used: a wrong unit, no level, or a dwell that is not above 0.

    Example:
        >>> wb.steps([0.005, "-5 mm"], "1 s").settings["levels"]
        [0.005, '-5 mm']
    """
    return ReferenceChoice("steps", {"levels": list(levels), "dwell": dwell, "start": start})


def ramp(rate: Quantity, *, start: Quantity | None = None, stop: Quantity | None = None) -> ReferenceChoice:
    """r(t) = rate (min(t, stop) - start) from start on, and 0 before.

    Args:
        rate: m/s.
        start: s; default 0.
        stop: s; default never.

    Raises:
        UserError: where the reference is used: a wrong unit.

    Example:
        >>> wb.ramp("8 mm/s", stop="2 s").kind
        'ramp'
    """
    return ReferenceChoice("ramp", {"rate": rate, "start": start, "stop": stop})


def triangle(
    amplitude: Quantity,
    *,
    frequency: Quantity | None = None,
    speed: Quantity | None = None,
    offset: Quantity | None = None,
) -> ReferenceChoice:
    """A triangular wave between offset - amplitude and offset + amplitude; |dr/dt| = speed = 4 amplitude frequency.

    Args:
        amplitude: m.
        frequency: Hz; either this
        speed: or this, in m/s.
        offset: m; default 0.

    Raises:
        UserError: where the reference is used: a wrong unit, both of frequency and speed, or neither.

    Example:
        >>> wb.triangle("10 mm", speed="8 mm/s").kind
        'triangle'
    """
    return ReferenceChoice(
        "triangle", {"amplitude": amplitude, "frequency": frequency, "speed": speed, "offset": offset}
    )


def multisine(amplitude: Quantity, frequency: Quantity, harmonics: Sequence[int]) -> ReferenceChoice:
    """A sum of sines at `harmonics` of `frequency`, scaled so that its largest magnitude is `amplitude`.

    Args:
        amplitude: m.
        frequency: of the fundamental, Hz, above 0.
        harmonics: whole numbers from 1 on, at least one.

    Raises:
        UserError: where the reference is used: a wrong unit or harmonic.

    Example:
        >>> wb.multisine("10 mm", "0.2 Hz", [1, 2, 3, 5]).kind
        'multisine'
    """
    return ReferenceChoice("multisine", {"amplitude": amplitude, "frequency": frequency, "harmonics": list(harmonics)})


def chirp(
    amplitude: Quantity, start_frequency: Quantity, end_frequency: Quantity, *, sweep: Quantity
) -> ReferenceChoice:
    """A sine whose frequency goes from start_frequency to end_frequency within `sweep`.

    Args:
        amplitude: m.
        start_frequency: Hz, above 0.
        end_frequency: Hz, above 0.
        sweep: s, above 0.

    Raises:
        UserError: where the reference is used: a wrong unit, or a value that is not above 0.

    Example:
        >>> wb.chirp("5 mm", "0.5 Hz", "10 Hz", sweep="20 s").kind
        'chirp'
    """
    settings = {"start_frequency": start_frequency, "end_frequency": end_frequency}
    return ReferenceChoice("chirp", {"amplitude": amplitude, **settings, "sweep": sweep})


def recorded(
    file: str | Path, *, time: str, value: str, time_unit: str | None = None, unit: str | None = None
) -> ReferenceChoice:
    """A motion from a table of text (CSV, any separator) with a header: a cubic spline through its rows.

    Args:
        file: its path, from the folder of the study or setup.
        time: the column of times, which must rise; at least four rows.
        value: the column of values.
        time_unit: of the times; default s.
        unit: of the values; default SI.

    Raises:
        UserError: where the reference is used: no such file or column, or rows that are no numbers in order.

    Example:
        >>> wb.recorded("motion.csv", time="t", value="x", unit="mm").table["file"]
        'motion.csv'
    """
    columns = {"file": str(file), "time": time, "value": value}
    return ReferenceChoice("recorded", {**columns, "time_unit": time_unit, "unit": unit})

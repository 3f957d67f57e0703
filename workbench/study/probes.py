"""Figures that a study asks for beside the standard ones."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from workbench.simulation.run import Run
from workbench.study.report.schema import Probe


def crossings(time: np.ndarray, values: np.ndarray, level: float) -> np.ndarray:
    """Instants (s) at which `values` rise through `level`, interpolated between samples."""
    before = np.flatnonzero((values[:-1] < level) & (values[1:] >= level))
    share = (level - values[before]) / (values[before + 1] - values[before])
    return time[before] + share * (time[before + 1] - time[before])


def probe_values(run: Run, probes: Mapping[str, Probe], transient: float, case: str | None) -> dict[str, float | None]:
    """The value (SI) of each probe, or None where it does not apply: another case, a signal that the run lacks."""
    values: dict[str, float | None] = {}
    for name, probe in probes.items():
        needed = {probe.signal, probe.event or probe.signal}
        applies = not run.diverged and (not probe.cases or case in probe.cases) and needed <= {"time", *run.signals}
        values[name] = _value(run, probe, transient) if applies else None
    return values


def _value(run: Run, probe: Probe, transient: float) -> float | None:
    signals = {"time": run.time, **run.signals}
    signal = signals[probe.signal]
    window = run.time >= transient
    if probe.event is not None:
        events = crossings(run.time[window], signals[probe.event][window], probe.event_level)
        if events.size < 2:
            return None
        if probe.take == "interval":
            return float(np.mean(np.diff(events)))
        if probe.take == "change":
            return float(np.mean(np.diff(np.interp(events, run.time, signal))))
        window &= (run.time >= events[0]) & (run.time < events[-1])
    if probe.take == "decay_rate":
        return decay_rate(run.time[window], signal[window])
    return _figure(signal[window], probe)


DECAYED = 0.01
"""Share of the first distance at which a decay is over: what is left says more of the final value's own error."""


def decay_rate(time: np.ndarray, values: np.ndarray) -> float | None:
    """Rate lam (1/s) of values -> final + c exp(-lam t), by regression of the logarithm; None where nothing decays."""
    distance = np.abs(values - values[-1])
    ended = int(np.argmax(distance <= DECAYED * distance[0]))
    if ended < FEWEST_OF_DECAY:
        return None
    return -float(np.polyfit(time[:ended], np.log(distance[:ended]), 1)[0])


FEWEST_OF_DECAY = 5
"""Samples from which a rate is taken."""


_FIGURES: Mapping[str, Callable[[np.ndarray], Any]] = {
    "maximum": np.max,
    "minimum": np.min,
    "peak_to_peak": np.ptp,
    "mean": np.mean,
    "rms": lambda values: np.sqrt(np.mean(values**2)),
    "final": lambda values: values[-1],
}


def _figure(values: np.ndarray, probe: Probe) -> float:
    if probe.level is not None:
        return float(np.mean(np.abs(values) < probe.level))
    return float(_FIGURES[probe.take](values))

"""What a fit by simulation finds, whole when it is made."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np

from workbench.identify.simulation.problem import Problem
from workbench.records.reading import Record

NORMAL_95 = 1.959964
"""Half width of a 95 % interval in standard deviations."""


@dataclass(frozen=True)
class Fitted:
    """One parameter: value, standard deviation and 95 % interval (SI); the value alone where the fit is refuted."""

    value: float
    std: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class SimulationFit:
    """What a fit by simulation finds.

    `unidentified` says of each parameter that the records cannot identify why; it is at its declared value. `bounded`
    are those at a bound of the experiment: value (SI), and which bound, in words; such a number has no deviation.
    `refuted` says how much more than noise is left, where that is so much that no number is identified; else "".
    `measured` and `simulated` are by record and output, in SI, over `times`; `rms` the residuals' by output.
    """

    estimates: Mapping[str, Fitted]
    correlation: np.ndarray
    unidentified: Mapping[str, str]
    sensors: Mapping[str, Fitted]
    rms: Mapping[str, float]
    before: Mapping[str, float]
    times: Mapping[Record, np.ndarray]
    simulated: Mapping[Record, Mapping[str, np.ndarray]]
    measured: Mapping[Record, Mapping[str, np.ndarray]]
    memory: float
    evaluations: int
    noise: Mapping[str, float] = field(default_factory=dict)
    refuted: str = ""
    notes: tuple[str, ...] = ()
    bounded: Mapping[str, tuple[float, str]] = field(default_factory=dict)

    def to_json(self) -> dict[str, object]:
        """As identified.json holds it."""
        return {
            "refuted": self.refuted,
            "unidentified": dict(self.unidentified),
            "notes": list(self.notes),
            "correlation": {"names": list(self.estimates), "matrix": self.correlation.tolist()},
            "sensors": {name: asdict(fitted) for name, fitted in self.sensors.items()},
            "rms": {"before": dict(self.before), "after": dict(self.rms), "noise": dict(self.noise)},
            "residual_memory_s": self.memory,
            "evaluations": self.evaluations,
        }


def result_of(
    problem: Problem,
    theta: np.ndarray,
    cov: np.ndarray,
    length: int,
    unidentified: Mapping[str, str],
    bounded: Mapping[str, tuple[float, str]],
    before: Mapping[str, float],
    rms: Mapping[str, float],
    noise: Mapping[str, float],
    refuted: str,
    notes: tuple[str, ...],
) -> SimulationFit:
    """Everything that a fit has found, in SI; without deviations where it is refuted."""
    count = len(problem.free)
    deviations = np.sqrt(np.diag(cov))
    estimates = {}
    for i, name in enumerate(problem.free):
        ends = [problem.value(name, theta[i] + side * NORMAL_95 * deviations[i]) for side in (-1.0, 1.0)]
        value = problem.value(name, theta[i])
        std = abs(problem.slope(name, theta[i])) * float(deviations[i])
        estimates[name] = Fitted(value, None, None, None) if refuted else Fitted(value, std, ends[0], ends[1])
    left, numbers = problem.left(theta)
    residuals = left / problem.weights
    times, measured, simulated = (dict[Record, dict[str, list[np.ndarray]]]() for _ in range(3))
    for item, name, place in problem.series():
        own = slice(place.start + item.warm, place.stop)
        for table, values in (
            (times, item.time[item.warm :]),
            (measured, problem.measured[own]),
            (simulated, (problem.measured - residuals)[own]),
        ):
            table.setdefault(item.of, {}).setdefault(name, []).append(values)
    scales = np.outer(deviations[:count], deviations[:count])
    sensors = {}
    for name, std in problem.experiment.accuracies.items():
        if name in problem.sensors:
            column = problem.sensors.index(name)
            spread = std * deviations[count + column]
            value = std * float(numbers[column])
            ends = [value - NORMAL_95 * spread, value + NORMAL_95 * spread]
            sensors[name] = Fitted(value, None, None, None) if refuted else Fitted(value, spread, ends[0], ends[1])
    return SimulationFit(
        estimates=estimates,
        correlation=cov[:count, :count] / np.where(scales > 0.0, scales, 1.0),
        unidentified=unidentified,
        sensors=sensors,
        rms=rms,
        before=before,
        times={record: np.concatenate(next(iter(parts.values()))) for record, parts in times.items()},
        simulated={record: _joined(parts) for record, parts in simulated.items()},
        measured={record: _joined(parts) for record, parts in measured.items()},
        memory=length * float(problem.observed[0].count) * problem.observed[0].record.sample_time,
        evaluations=problem.evaluations,
        noise=noise,
        refuted=refuted,
        notes=notes,
        bounded=bounded,
    )


def _joined(parts: Mapping[str, Sequence[np.ndarray]]) -> dict[str, np.ndarray]:
    """The windows of each output one after the other."""
    return {name: np.concatenate(values) for name, values in parts.items()}

"""Measured friction-velocity curves of a study, the laws that predict them, and what the curves say a law lacks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.friction_curves.checks import curves_of
from workbench.friction_curves.measured import DIRECTIONS, Curve
from workbench.friction_curves.predicted import Fitted, Prediction, laws, supported
from workbench.friction_curves.schema import FrictionCurvesTable
from workbench.parameters.sets import parameter_path, parameter_value, read_parameters
from workbench.study.study import Study
from workbench.study.unfold import unfold


@dataclass(frozen=True)
class Comparison:
    """The measured curves, the laws, and the laws with effects fitted; `added` is the one that the fit speeds
    support.
    """

    study: Study
    spec: FrictionCurvesTable
    measured: list[Curve]
    at_rest: list[Curve]
    laws: list[Prediction]
    fitted: list[Fitted]
    added: Fitted

    def curves(self, rpm: Sequence[float]) -> list[Curve]:
        """The measured ones at these speeds of rotation."""
        return [curve for curve in self.measured if curve.rpm in rpm]

    def simulated(self, name: str) -> dict[float, list[str]]:
        """The values (SI) that the study's cases set of a parameter, and which cases, by name."""
        found: dict[float, list[str]] = {}
        for case in unfold(self.study):
            if (value := case.tables["plant"].get("set", {}).get(name)) is not None:
                cases = found.setdefault(parameter_value(name, value), [])
                if case.name and case.name not in cases:
                    cases.append(case.name)
        return found

    @property
    def rpm(self) -> list[float]:
        """All speeds at which curves were measured."""
        return sorted({curve.rpm for curve in self.measured})

    @property
    def predictions(self) -> list[Prediction]:
        """The bare laws, and the one with what was added, if anything was."""
        return [*self.laws, *([self.added.prediction] if self.added.effect else [])]

    @property
    def distinct(self) -> list[Prediction]:
        """The same with one in the place of two that predict the same: helical and isotropic, in the steady state."""
        found: list[Prediction] = []
        for one in self.predictions:
            alike = [i for i, other in enumerate(found) if _same(one, other, self.measured)]
            if alike:
                found[alike[0]] = replace(found[alike[0]], name=f"{found[alike[0]].name} and {one.name}")
            else:
                found.append(one)
        return found


def _same(one: Prediction, other: Prediction, curves: Sequence[Curve]) -> bool:
    return all(np.allclose(one.residual(curve), other.residual(curve), atol=1e-9) for curve in curves)


def compare(study: Study, spec: FrictionCurvesTable) -> Comparison:
    """Predict every measured curve by every law, and fit what the anisotropic one may lack."""
    values = read_parameters(parameter_path(spec.parameters, study.path.parent))
    curves = curves_of(study, spec)
    measured = [curve for curve in curves if curve.rpm]
    known = laws(values)
    added, fitted = supported(known[-1], [curve for curve in measured if curve.rpm in spec.fit_rpm])
    return Comparison(study, spec, measured, [curve for curve in curves if not curve.rpm], known, fitted, added)


def hydraulic_power(frictions: Sequence[float], speed: float) -> float:
    """Friction times velocity (W), thesis (4.16); mean of both directions."""
    return float(np.mean(frictions)) * speed


def predicted_power(law: Prediction, rpm: float, speed: float) -> tuple[float, float]:
    """Hydraulic and rotary power (W) at a speed (m/s) along, mean of both directions."""
    sides = [law.steady(rpm, name, np.array([speed])) for name in DIRECTIONS]
    hydraulic = hydraulic_power([float(along[0]) for along, _ in sides], speed)
    return hydraulic, float(np.mean([around[0] for _, around in sides])) * law.surface_speed(rpm)

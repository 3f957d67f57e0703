"""What a study would run: its cases, checked to the last key. Nothing here simulates."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from controllers.registry import CONTROLLERS
from plants.axis import LINEAR
from plants.equation import EQUATION_FOLDERS, source_hash, to_array
from plants.laws.registry import LAWS
from plants.registry import PLANTS
from workbench.metrics.registry import METRICS, columns
from workbench.simulation.integrators.registry import INTEGRATORS
from workbench.study.checks.checks import Checks
from workbench.study.names import matches
from workbench.study.reference_tables import REFERENCES
from workbench.study.resolve import ParsedCase, Resolved, parse_case
from workbench.study.study import Case, Study, located
from workbench.study.uncertainty import DRAW, on_plant_samples
from workbench.study.unfold import unfold

PROGRAM_FOLDERS = (*EQUATION_FOLDERS, "workbench/metrics", "workbench/study")
"""Folders of the source files on which a row of results depends."""


@dataclass(frozen=True)
class Plan:
    """A study that has been checked to the last key: its cases, each as `parsed`, and what it is on the machine as
    `declared`, not drawn.
    """

    study: Study
    cases: list[Case]
    parsed: list[ParsedCase]
    declared: list[Resolved]
    warnings: Sequence[str] = ()

    @cached_property
    def resolved(self) -> list[Resolved]:
        """What each case runs."""
        return [
            parsed.resolve(case.overrides) if DRAW in case.axes else declared
            for case, parsed, declared in zip(self.cases, self.parsed, self.declared, strict=True)
        ]

    @property
    def axes(self) -> list[str]:
        """Columns that tell the cases apart."""
        return list(dict.fromkeys(name for case in self.cases for name in case.columns))

    @property
    def columns(self) -> list[str]:
        """Columns of results.csv: the axes, the standard figures, the probes."""
        return [*self.axes, *columns(self.axis), *self.study.file.probes]

    @property
    def axis(self) -> str:
        """Unit of the positions of all its plants, "m" or "rad"."""
        return self.declared[0].setup.plant.axis if self.declared else LINEAR

    @property
    def identity(self) -> dict[str, str]:
        """What results must agree in to be of the same study: the file, the numbers it leads to, all code."""
        numbers = hashlib.sha256()
        for item in self.resolved:
            setup = item.setup
            signals = [setup.reference, *(feed.signal for feed in setup.feeds)]
            turned = (setup.rotary.gains,) if setup.rotary else ()
            for values in (setup.parameters, setup.state, setup.inputs, setup.loop.gains, *turned):
                numbers.update(to_array(values).tobytes())
            for signal in signals:
                if signal is not None:
                    numbers.update(signal(np.linspace(0.0, setup.duration, 1001))[0].tobytes())
        return {
            "study": self.study.fingerprint,
            "parameters": numbers.hexdigest(),
            "version of the program": source_hash(PROGRAM_FOLDERS),
            "version of the plug-ins": self._plugins,
        }

    @property
    def _plugins(self) -> str:
        """The plug-ins that the cases name, and all metrics, each with a hash of its source; "" without any."""
        used = {item.setup.plant for item in self.resolved}
        types = {str(table.get("type")) for case in self.cases for table in case.tables["controllers"].values()}
        sources = [(name, PLANTS.source(name)) for name, plant in PLANTS.working().items() if plant in used]
        sources += [(name, CONTROLLERS.source(name)) for name in sorted(types)]
        sources += [(name, METRICS.source(name)) for name in METRICS.working()]
        laws = {str(tables.get("plant", {}).get("friction", "")) for tables in (case.tables for case in self.cases)}
        sources += [(name, LAWS.source(name)) for name in sorted(laws)]
        methods = {item.setup.integrator.method for item in self.resolved}
        sources += [(name, INTEGRATORS.source(name)) for name in sorted(methods)]
        kinds = {str(table.get("kind")) for case in self.cases for table in case.tables["references"].values()}
        sources += [(name, REFERENCES.source(name)) for name in sorted(kinds)]
        return ", ".join(f"{name} {source}" for name, source in sources if source)

    @property
    def simulated_seconds(self) -> float:
        """Duration of all cases together (s)."""
        return sum(item.setup.duration for item in self.declared)


def plan(study: Study) -> Plan:
    """Unfold and check a study.

    Raises:
        UserError: the first mistake in any case, table or figure.
    """
    planned = _drawn(study, unfold(study))
    check_one_axis(study, planned)
    checks = Checks(study, planned.cases, planned.declared, planned.axes, list(columns(planned.axis)))
    checks.all()
    return replace(planned, warnings=checks.warnings())


def check_one_axis(study: Study, planned: Plan) -> None:
    """Raise UserError where some plants go straight and others turn: results have one column for both."""
    for case, item in zip(planned.cases, planned.declared, strict=True):
        if item.setup.plant.axis != planned.axis:
            first, other = planned.declared[0].setup.plant.name, item.setup.plant.name
            message = f"{first} has positions in {planned.axis}, {other} in {item.setup.plant.axis}; make two studies"
            raise located(study, case, ("plant", "model"), message)


def again(planned: Plan, wanted: Sequence[Mapping[str, object]], draws: int) -> Plan:
    """Those cases of a plan that have one of the `wanted` sets of columns, on so many machines not yet drawn."""
    study, table = planned.study, planned.study.file.uncertainty
    chosen = [case for case in unfold(study) if any(matches(case.columns, where) for where in wanted)]
    first = 1 + (table.draws if table is not None else 0)
    return _drawn(study, chosen, range(first, first + draws))


def _drawn(study: Study, cases: list[Case], numbers: range | None = None) -> Plan:
    """The plan of these cases on each plant sample, where the study draws any."""
    parsed = [parse_case(study, case) for case in cases]
    declared = [each.resolve() for each in parsed]
    axis = declared[0].setup.plant.axis if declared else LINEAR
    drawn = on_plant_samples(study, cases, numbers, axis)
    times = range(len(drawn) // len(cases) if cases else 1)
    return Plan(study, drawn, [each for each in parsed for _ in times], [each for each in declared for _ in times])


def needed_trajectories(planned: Plan) -> set[int]:
    """Indices of the cases whose trajectories some figure of the study draws."""
    columns = planned.columns
    wanted = [
        curve.where
        for figure in planned.study.file.figures
        for panel in figure.panels
        if panel.x not in columns
        for curve in panel.curves
    ]
    return {case.index for case in planned.cases if any(matches(case.columns, where) for where in wanted)}

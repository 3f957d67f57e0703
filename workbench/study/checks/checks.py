"""What a study asks of its results, checked before it runs: probes, tables and figures, and settings without use."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property, partial

import numpy as np
from pydantic import BaseModel

from plants.axis import LINEAR
from workbench.errors import nearest, shortened
from workbench.metrics.registry import names_along
from workbench.metrics.window import whole_periods
from workbench.simulation.references import ReferenceSignal, Steps
from workbench.simulation.setup import memory_names
from workbench.study.cases import Cases
from workbench.study.checks.load import unheld
from workbench.study.checks.rotation import rotation_warning
from workbench.study.checks.shown import Shown
from workbench.study.checks.use import check_use
from workbench.study.names import signals_of
from workbench.study.resolve import Resolved, resolve
from workbench.study.sections import Checked, placed, sections_of
from workbench.study.study import INDEX, Case, Study, check_name, located, named
from workbench.toml.quantities import check_along
from workbench.toml.reading import Key, SchemaError

MEMORY = "controller_"
"""What the names of signals of a controller's state begin with."""

CLOSE = 0.85
"""Likeness above which such a name is a slip of the pen: they all begin alike."""


WINDOWED = ("rms_error_m", "max_error_m")
"""Figures of all that comes after the transient."""

REACH_INSTANTS = 10_001
"""At most so many instants tell how far a reference goes."""


@dataclass(frozen=True)
class Checks:
    """A study with those of its cases that stand for all, what these resolve to, and the figures of its results."""

    study: Study
    cases: Sequence[Case]
    resolved: Sequence[Resolved]
    every: Cases
    figures: Sequence[str]

    @cached_property
    def axes(self) -> dict[str, list[object]]:
        """The columns that tell the cases apart, each with its values."""
        return self.every.axes

    @cached_property
    def columns(self) -> list[str]:
        """All columns but those of probes that clash."""
        return [*self.axes, *self.figures, *self.study.file.probes]

    @cached_property
    def _known(self) -> dict[int, Resolved]:
        """What has been resolved, by the case's index."""
        return {case.index: item for case, item in zip(self.cases, self.resolved, strict=True)}

    def _item(self, index: int) -> Resolved:
        """What a case resolves to."""
        if index not in self._known:
            self._known[index] = resolve(self.study, self.every[index])
        return self._known[index]

    @property
    def axis(self) -> str:
        """Unit of the positions of the study's plants."""
        return self.resolved[0].setup.plant.axis if self.resolved else LINEAR

    def all(self) -> None:
        """Raise UserError for the first mistake."""
        self._references()
        self._probes()
        for i, name in enumerate(self.study.file.records):
            self._signal(("records", i), name, [*self._known])
        several = dict.fromkeys(section.name for section, _ in sections_of(self.study) if section.several)
        for kind in ("tables", "figures", *several):
            names = [str(getattr(item, "name", i)) for i, item in enumerate(getattr(self.study.file, kind))]
            for i, name in enumerate(names):
                if name in names[:i]:
                    raise self.study.error((kind, i, "name"), f'"{name}" is taken: expected another name')
        for i, table in enumerate(self.study.file.tables):
            self._shown.table(("tables", i), table)
        for i, figure in enumerate(self.study.file.figures):
            self._shown.figure(("figures", i), figure)
        for section, content, key in placed(self.study):
            self._along(content, key)
            section.check(content, replace(self._checked, key=key))
        if len(self.cases) == self.every.bases:  # what is of use in none of these may be in others
            check_use(self.study, self.cases, self.resolved)

    def _references(self) -> None:
        """Raise UserError where a reference, or what is fed to an input, is more than a number can hold."""
        seen: set[str] = set()
        for case, item in zip(self.cases, self.resolved, strict=True):
            setup, tables = item.setup, case.tables["references"]
            point = repr((tables, setup.duration, setup.plant.axis))
            if point in seen:
                continue
            seen.add(point)
            for signal in (setup.reference, *(feed.signal for feed in setup.feeds)):
                if signal is not None and not _is_finite(signal, setup.duration, setup.sample_time):
                    name = named(case, "reference")
                    key = ("references", name) if signal is setup.reference else ("references",)
                    message = f"grows beyond all numbers within {setup.duration:g} s; expected less, or slower"
                    raise located(self.study, case, key, message)

    def _along(self, content: BaseModel, key: Key) -> None:
        """Quantities of a question along the axis of the study's plants."""
        try:
            check_along(content, self.axis, key)
        except SchemaError as mistake:
            raise self.study.error(mistake.key, mistake.message) from None

    @cached_property
    def _shown(self) -> Shown:
        return Shown(self.study, self.every, self.columns, self.axis, self._signal)

    @property
    def _checked(self) -> Checked:
        """What the sections of other questions are handed."""
        several = partial(self._shown.chosen, one=False)
        return Checked(self.study, self.cases, self.resolved, [*self.axes], self.figures, several)

    def _signal(self, key: Key, name: str, cases: Sequence[int]) -> None:
        """`name` has to be a signal of at least one of the cases of these indices."""
        setups = {i: self._item(i).setup for i in cases}
        known = dict.fromkeys(
            signal
            for setup in setups.values()
            for signal in signals_of(setup.plant, setup.loop.controller, setup.reference is not None)
        )
        if name in known:
            return
        if not name.startswith(MEMORY):
            raise self.study.error(key, f'unknown signal "{shortened(name)}"; {nearest(name, known)}')
        said = {}
        for i, setup in setups.items():
            controller = setup.loop.controller
            own = ", ".join(memory_names(controller)) or "none"
            said[f'"{named(self.every[i], "controller")}" (type {controller.name})'] = own
        owners = "; ".join(f"controller {who} has {own}" for who, own in said.items())
        close = get_close_matches(name, [signal for signal in known if signal.startswith(MEMORY)], n=1, cutoff=CLOSE)
        hint = f'did you mean "{close[0]}"? ' if close else ""
        raise self.study.error(key, f'no signal "{shortened(name)}" here; {hint}{owners}')

    def _probes(self) -> None:
        taken = {name.casefold() for name in (INDEX, *self.axes, *self.figures)}
        for name, probe in self.study.file.probes.items():
            if name.casefold() in taken:
                raise self.study.error(("probes", name), "the results have a column of this name already")
            taken.add(name.casefold())
            for case in probe.cases:
                check_name(self.study, ("probes", name, "cases"), "case", case, self.study.file.cases)
            probed = [case.index for case in self.cases if not probe.cases or case.name in probe.cases]
            self._signal(("probes", name, "signal"), probe.signal, probed)
            if probe.event is not None:
                self._signal(("probes", name, "event"), probe.event, probed)

    def warnings(self) -> list[str]:
        """What may be meant, and seldom is: far references, too little after the transient, rotations not held."""
        found = dict.fromkeys(
            line for section, table in sections_of(self.study) for line in section.warnings(table, self._checked)
        )
        found |= dict.fromkeys(self._shown.joined())
        seen: set[str] = set()
        for case, item in zip(self.cases, self.resolved, strict=True):
            turned = repr((case.tables["plant"], item.setup.rotation_speed, item.belief, item.setup.sample_time))
            if turned not in seen:
                seen.add(turned)
                if message := rotation_warning(case, item):
                    found[str(located(self.study, case, ("plant", "rotation"), message))] = None
                if message := unheld(item.setup.plant, item.setup.parameters):
                    found[str(located(self.study, case, ("plant",), message))] = None
            name, travel = named(case, "reference"), item.setup.plant.travel(item.setup.parameters)
            point = (name, case.tables["references"].get(name), item.setup.duration, item.transient, travel)
            if item.signal is None or repr(point) in seen:
                continue
            seen.add(repr(point))
            if item.setup.reference is not None and (reach := _reach(item)) > 0.5 * travel:
                message = f"reaches {reach:g} {self.axis}, the stroke ends at +-{0.5 * travel:g} {self.axis}"
                found[str(located(self.study, case, ("references", name), message))] = None
            period, left = item.signal.period, item.setup.duration - item.transient
            if item.setup.reference is not None and period is not None and whole_periods(left, period) == 0:
                message = f'"{name}" has a period of {period:g} s, and after the transient only {left:g} s are left'
                found[str(located(self.study, case, ("simulation", "duration"), message))] = None
            if item.setup.reference is not None and period is not None and period < 2.0 * item.setup.sample_time:
                rate = 1.0 / item.setup.sample_time
                message = f'"{name}" has {1.0 / period:g} Hz, and a controller sampled at {rate:g} Hz sees half of that'
                found[str(located(self.study, case, ("references", name), message))] = None
            if self._errors_are_asked_for and (jump := _last_jump(item)) is not None and jump < item.transient:
                message = (
                    f'"{name}" jumps for the last time at {jump:g} s, and the transient of {item.transient:g} s leaves '
                    f"nothing of that to {' and '.join(self._windowed)}; shorten it, or ask for steady-state errors"
                )
                found[str(located(self.study, case, ("simulation", "transient"), message))] = None
        return list(found)

    @property
    def _windowed(self) -> list[str]:
        called = names_along(self.axis)
        return [called[name] for name in WINDOWED]

    @cached_property
    def _errors_are_asked_for(self) -> bool:
        """Whether a table asks for the errors after the transient; without tables any figure may be meant."""
        tables = self.study.file.tables
        asked = {one.result for table in tables for one in table.columns}
        asked |= {one.result for table in tables for one in table.rows}
        return not tables or not asked.isdisjoint(self._windowed)


def _is_finite(signal: ReferenceSignal, duration: float, sample_time: float) -> bool:
    """Whether a signal and its derivatives are numbers from beginning to end."""
    instants = np.linspace(0.0, duration, min(round(duration / sample_time) + 1, REACH_INSTANTS))
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return all(bool(np.all(np.isfinite(values))) for values in signal(instants))
    except FloatingPointError:
        return False


def _reach(item: Resolved) -> float:
    """Largest magnitude (m) of a case's reference."""
    setup = item.setup
    instants = min(round(setup.duration / setup.sample_time) + 1, REACH_INSTANTS)
    return (
        float(np.max(np.abs(setup.reference(np.linspace(0.0, setup.duration, instants))[0])))
        if setup.reference
        else 0.0
    )


def _last_jump(item: Resolved) -> float | None:
    """When steps jump for the last time within a case (s)."""
    reference = item.setup.reference
    dwells = reference.dwells(item.setup.duration) if isinstance(reference, Steps) else []
    return dwells[-1][0] if dwells else None

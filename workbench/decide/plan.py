"""A study's [decide], checked to the last key: candidates, motions, and the plant samples on which they are tried."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from workbench.decide.checks import Candidate, check_candidates, check_motions, check_still
from workbench.decide.schema import DecideTable
from workbench.errors import UserError, nearest
from workbench.simulation.simulate import Loop
from workbench.study.checks.use import check_use
from workbench.study.fmu_plant import refuse_fmu
from workbench.study.layers import MACHINE
from workbench.study.overrides import Overrides
from workbench.study.plan import PROGRAM_FOLDERS
from workbench.study.reading import with_files
from workbench.study.resolve import ParsedCase, Resolved, parse_case, resolve
from workbench.study.schema import SimulationTable
from workbench.study.study import Case, Study
from workbench.study.uncertainty import check_scales, plant_sample
from workbench.study.unfold import unfold
from workbench.toml.reading import SchemaError, conform

Stage = Literal["search", "fresh"]
"""Draws on which candidates are looked for, and draws on which those that may be chosen are measured."""

STREAMS: dict[Stage, int] = {"search": 2, "fresh": 4}
"""The streams of plant samples of decisions: none of those on which gains were tuned or studies run."""

PROGRAM = (*PROGRAM_FOLDERS, "workbench/decide")
"""Folders of the source files on which a run depends."""

MOTION = "decision"
"""The name of the reference that a decision makes."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What is run: each candidate at each speed (m/s), on each plant sample of each spread.

    `cases` holds the declared machine by speed and candidate, `loops` the controller with its gains by candidate: what
    it believes is no matter of draws.
    """

    study: Study
    table: DecideTable
    candidates: Sequence[Candidate]
    speeds: Sequence[float]
    spreads: Sequence[float]
    draws: int
    fresh_draws: int
    cases: Mapping[float, Mapping[Candidate, ParsedCase]]
    loops: Mapping[Candidate, Loop]

    @property
    def several(self) -> bool:
        """Whether machines are drawn; without [uncertainty] there is one, the declared one."""
        return self.draws > 1

    @property
    def plant(self) -> Mapping[str, object]:
        """What is declared of the plant: the study's, under what its machine says."""
        return next(iter(self.cases[self.table.speed].values())).case.declared

    @property
    def runs(self) -> int:
        """How many runs the search takes, those of holds not counted."""
        return len(self.candidates) * len(self.speeds) * len(self.spreads) * self.draws

    @property
    def simulated_seconds(self) -> float:
        """Duration of all runs of the search together, holds included (s)."""
        each = len(self.candidates) * len(self.spreads) * self.draws
        moving = sum(self.table.cycles * self.table.period(speed) for speed in self.speeds)
        return each * (moving + self.table.hold_duration)

    def sampled(self, candidate: Candidate, speed: float, spread: float, number: int, stage: Stage) -> Resolved:
        """A candidate's case on a plant sample, whose friction is spread by `spread` standard deviations."""
        case, uncertainty = self.cases[speed][candidate], self.study.file.uncertainty
        if uncertainty is None:
            return case.resolve()
        sample = replace(plant_sample(uncertainty, number, STREAMS[stage]), friction=spread)
        return case.resolve(Overrides(sample=sample))


def plan_decision(study: Study, machine: str | None = None) -> Plan:
    """Check a study's [decide] and [uncertainty], and build every candidate once; on that `machine`, if it is given.

    Raises:
        UserError: the first mistake.
    """
    table = study.section(DecideTable)
    if table is None:
        raise UserError(
            f"{study.path}: has no [decide]; expected one with accuracy, speed, amplitude, power, rpm, plain"
        )
    refuse_fmu(study, "decide")
    if machine is not None:
        table = table.model_copy(update={"machine": machine})
    if table.machine is not None:
        study = _with_machine(study, table.machine)
    speeds = sorted({*(table.speeds or []), table.speed})
    names = _controllers(study, table)
    _check_uncertainty(study, table)
    sample_time = _sample_time(study)
    check_motions(study, table, speeds, sample_time)
    rotations = [round(speed * 30.0 / math.pi, 6) for speed in table.rpm]
    unfolded = {speed: _cases(study, table, speed, sample_time, names, rotations) for speed in speeds}
    asked = unfolded[table.speed]
    check_still(study, table, resolve(study, _still(asked)))
    cases = {
        speed: {candidate: parse_case(study, case) for candidate, case in own.items()}
        for speed, own in unfolded.items()
    }
    resolved = {candidate: parsed.resolve() for candidate, parsed in cases[table.speed].items()}
    check_candidates(study, table, resolved)
    check_scales(study, asked.values())
    check_use(study, list(asked.values()), list(resolved.values()))
    several = study.file.uncertainty is not None
    planned = Plan(
        study=study,
        table=table,
        candidates=list(resolved),
        speeds=speeds,
        spreads=sorted({*(table.spreads or []), table.spread}),
        draws=table.draws if several else 1,
        fresh_draws=table.fresh_draws if several else 0,
        cases=cases,
        loops={candidate: case.setup.loop for candidate, case in resolved.items()},
    )
    _check_draws(planned)
    return planned


def _with_machine(study: Study, machine: str) -> Study:
    """The study with the machine of that name, whose file is read where the study has no such table."""
    beside = MACHINE.files(study.path.parent)
    known = {**study.file.machines, **beside}
    if machine not in known:
        raise study.error(("decide", "machine"), f'unknown machine "{machine}"; {nearest(machine, sorted(known))}')
    return study if machine in study.file.machines else with_files(study, MACHINE, {machine: beside[machine]})


def _controllers(study: Study, table: DecideTable) -> list[str]:
    known = study.file.controllers
    if not known:
        raise study.error(("controllers",), "is missing: expected a table such as [controllers.p]")
    for key, names in (("controllers", table.controllers or []), ("plain", table.plain)):
        for name in names:
            if name not in known:
                raise study.error(("decide", key), f'unknown controller "{name}"; {nearest(name, known)}')
    return table.controllers or list(known)


def _check_uncertainty(study: Study, table: DecideTable) -> None:
    if "spread" in study.file.plant:
        raise study.error(("plant", "spread"), "[decide] spreads friction by its own spread: leave this out")
    if study.file.uncertainty is None:
        for key, values in (("spread", [table.spread]), ("spreads", table.spreads or [])):
            if any(values):
                message = "the study has no [uncertainty]: expected 0, or a table [uncertainty] that says what varies"
                raise study.error(("decide", key), message)


def _sample_time(study: Study) -> float:
    """The sample time (s) of a study whose durations are not its own to say."""
    try:
        return conform(SimulationTable, {**study.file.simulation, "duration": 1.0, "transient": 0.0}).sample_time
    except SchemaError as mistake:
        raise study.error(("simulation", *mistake.key), mistake.message) from None


def _cases(
    study: Study,
    table: DecideTable,
    speed: float,
    sample_time: float,
    controllers: Sequence[str],
    rotations: Sequence[float],
) -> dict[Candidate, Case]:
    """The candidates' cases at a speed: the study with its machine and this motion alone, over controllers and rpm."""
    period = table.period(speed)
    # One sample more than the periods, so that rounding to samples takes none of them away.
    span = {"duration": table.cycles * period + sample_time, "transient": (table.cycles - 1) * period}
    on = {MACHINE.axis: table.machine} if table.machine is not None else {}
    machine = {axis: [name] for axis, name in on.items()}
    file = study.file.model_copy(
        update={
            "cases": {},
            "axes": {**machine, "controller": list(controllers), "rpm": list(rotations)},
            "references": {MOTION: {"kind": "sine", "amplitude": table.amplitude, "frequency": 1.0 / period}},
            "simulation": {**study.file.simulation, **span},
        }
    )
    cases = unfold(replace(study, file=file))
    return {(case.tables["controller"], case.rpm): replace(case, axes=on) for case in cases}


def _still(cases: Mapping[Candidate, Case]) -> Case:
    """The first candidate without rotation."""
    first = next(iter(cases.values()))
    return replace(first, tables={**first.tables, "rpm": 0})


def _check_draws(planned: Plan) -> None:
    """A draw of each spread can be built."""
    for candidate in planned.candidates[: len(planned.table.rpm)]:
        for spread in planned.spreads:
            try:
                planned.sampled(candidate, planned.table.speed, spread, 0, "search")
            except SchemaError as mistake:
                raise planned.study.error(mistake.key, mistake.message) from None

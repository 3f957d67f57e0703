"""The residual stage: flow, then force; each balance with the effects that its residual supports."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from workbench.diagnose.residuals.balances import balances_of, diagnosed_plant
from workbench.diagnose.residuals.fit import Fit, fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.null import floored
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.result import IDENTIFIED, FoundEffect
from workbench.diagnose.selection.selection import BalanceResult, Step, is_circular, select
from workbench.diagnose.selection.unexplained import Dependence, dependence
from workbench.diagnose.simulation.setup import behind_backlash
from workbench.diagnose.simulation.stage import SimulationStage, SimulationStart
from workbench.parameters.sets import EITHER_SIGN
from workbench.progress import Progress
from workbench.records.experiment import Experiment

LEFT_OVER = 1.5
"""Floors above which a residual is not explained by the effects that were added."""

TAKEN = 0.3
"""Share of the residual that effects may leave, however much that is over the floor, and still be named."""

FAR = 10.0
"""Floors above which what effects leave is none of them, on whatever signals it depends or not: a play in the valve
depends on where it was before."""

PLACES, PLACED = ("position", "time", "rotation_angle"), 0.3
"""Signals that no force makes, and the share of a residual's variance from which it is theirs."""

RUNAWAY = 5.0
"""Times the declared value, or a part of it, beyond which no fit of a balance is a place to begin a simulation."""


@dataclass(frozen=True, eq=False)
class ResidualStage:
    """The balances with their effects, and all parameters that fit them: without effects and with these."""

    results: Sequence[BalanceResult]
    declared: Values
    baseline: Values
    corrected: Values

    @property
    def dependences(self) -> list[Dependence | None]:
        """On which signals depends what is left of each balance; None of one on which nothing was fitted, whose
        residual has in it what others leave open.
        """
        return [_depends(result.after) if result.after.names else None for result in self.results]

    def simulation_start(self, effects: Sequence[FoundEffect]) -> SimulationStart:
        """What the simulation stage begins with, with the effects that were found so far."""
        return SimulationStart(
            [name for result in self.results for name in result.balance.free],
            self.declared,
            _starts(self.declared, self.baseline, [result.before for result in self.results]),
            _starts(self.declared, self.corrected, [result.after for result in self.results]),
            {effect.name: tuple(effect.parameters) for effect in effects},
        )


def residual_stage(
    experiment: Experiment,
    motions: Sequence[Motion],
    declared: Values,
    offset: FoundEffect | None,
    progress: Progress,
) -> ResidualStage:
    """Let effects compete on each balance; `offset` is that of a sensor, if one was found."""
    baseline, values = dict(declared), dict(declared)
    if offset is not None:
        values |= {name: number.value for name, number in offset.parameters.items()}
    balances = balances_of(experiment.plant, experiment.flow, motions, values, experiment.free)
    progress("noise floors", 0.02)
    first = dict(values)
    for balance in balances:
        first |= fit(balance, first, balance.free, experiment.bounds).values
    results = list[BalanceResult]()
    whole = diagnosed_plant(experiment.plant, experiment.flow, motions[0].channels)
    for balance in floored(whole, balances, first):
        progress(f"effects on the {balance.name} balance", 0.1 + 0.1 * len(results))
        after, steps = select(balance, values, experiment.bounds)
        if _leaves_too_much(steps[0].before, after, steps):
            after, steps = steps[0].before, [replace(steps[0], added=None, alternatives=[])]
        results.append(BalanceResult(balance, steps[0].before, after, steps))
        baseline |= {name: steps[0].before.values[name] for name in balance.free}
        values |= {name: after.values[name] for name in after.names}
    return ResidualStage(results, declared, baseline, values)


def with_effects_of(
    stage: ResidualStage, experiment: Experiment, effects: Sequence[FoundEffect], simulation: SimulationStage
) -> ResidualStage:
    """The balances with the effects that the simulated plant has, and the values that fit them.

    As they are where these are the same effects; else their own parameters are fitted anew around the effects' numbers.
    """
    if {effect.name for effect in effects} == set(simulation.effects):
        return stage
    names = [name for own in simulation.effects.values() for name in own]
    values = {**stage.declared, **{name: simulation.after.values[name] for name in names}}
    again = []
    for result in stage.results:
        balance = replace(
            result.balance, motions=behind_backlash(simulation.how, result.balance.motions, simulation.after.values)
        )
        after = fit(balance, values, balance.free, experiment.bounds)
        values |= {name: after.values[name] for name in after.names}
        again.append(replace(result, after=after))
    return replace(stage, results=again, corrected=values)


def _starts(declared: Values, values: Values, fits: Sequence[Fit]) -> dict[str, float]:
    """Where a simulation begins: `values`, but the plant's own parameters as declared where a balance says little of
    them, or lets one run away.
    """
    starts = dict(values)
    for fitted in fits:
        for name in fitted.balance.free:
            value, start = fitted.values[name], declared[name]
            if name in EITHER_SIGN or start <= 0.0:
                continue
            known = name not in fitted.bounded and fitted.deviations[name] < IDENTIFIED * value
            starts[name] = value if known and 1.0 / RUNAWAY < value / start < RUNAWAY else start
    return starts


def _depends(after: Fit) -> Dependence | None:
    return dependence(after.balance, after.values)


def _leaves_too_much(before: Fit, after: Fit, steps: Sequence[Step]) -> bool:
    """Whether effects take a part of a residual that goes on to depend on a signal, or to be far above its floor: then
    they stand in for another.

    A circular one takes its part of any residual: it is not believed where the residual depends on place or time.
    """
    if after is before or not after.balance.simulated:  # without such a floor nobody knows what is too much
        return False
    if any(step.added is not None and is_circular(step.added.effect, after.balance) for step in steps):
        first = _depends(before)
        if first is not None and any(first.shares.get(name, 0.0) > PLACED for name in PLACES):
            return True
    if after.rms < LEFT_OVER or after.rms < TAKEN * before.rms:
        return False
    return bool(after.rms > FAR) or _depends(after) is not None

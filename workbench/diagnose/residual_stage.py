"""The residual stage: flow, then force; each balance with the effects that its residual supports."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.balances import balances_of, diagnosed_plant
from workbench.diagnose.residuals.baseline import baseline
from workbench.diagnose.residuals.fit import Fit, fit, over, weighed_fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.null import floored, null_motion, surrogate, with_fitted_floor
from workbench.diagnose.residuals.unknowns import Bounds, Values
from workbench.diagnose.result import IDENTIFIED, FoundEffect
from workbench.diagnose.selection.balance_curves import CurveFit, curve_of
from workbench.diagnose.selection.search import search
from workbench.diagnose.selection.selection import BalanceResult, Step, is_circular
from workbench.diagnose.selection.sets import Asked
from workbench.diagnose.selection.trials import Shape, Shapes
from workbench.diagnose.selection.unexplained import PLACES, Dependence, dependence
from workbench.diagnose.simulation.fits import begun
from workbench.diagnose.simulation.reached import SimulationStart
from workbench.diagnose.simulation.setup import behind_backlash
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.parameters.sets import EITHER_SIGN
from workbench.progress import Progress
from workbench.records.experiment import Experiment

LEAST_SHARE, CIRCULAR_SHARE = 0.04, 0.15
"""Shares of a residual's rms that an effect has to take away: what smoothing leaves is no noise, and effects take some
of it; and that one has to take that is made of what it is to explain."""

LEFT_OVER = 1.5
"""Floors above which a residual is not explained by the effects that were added."""

TAKEN = 0.3
"""Share of the residual that effects may leave, however much that is over the floor, and still be named."""

PARTLY = 0.7
"""Share of the residual that effects have to lower at least to be named where what they leave is not explained: half of
its square is then another's."""

FAR = 10.0
"""Floors above which what effects leave is none of them, on whatever signals it depends or not: a play in the valve
depends on where it was before."""

PLACED = 0.3
"""Share of a residual's variance from which it is that of a signal that no force makes."""

TOO_LITTLE = 0.7
"""Floors below which records leave so much less than a plant that lacks nothing that it is not theirs."""

DRAWS, FEWEST, DRAWN = 8, 2, 160_000
"""Of noise by which a balance's floor is found, at most and at least, and samples that all of them have together: one
alone of a short record is off by up to a tenth.
"""

RUNAWAY = 5.0
"""Times the declared value, or a part of it, beyond which no fit of a balance is a place to begin a simulation."""


@dataclass(frozen=True, eq=False)
class ResidualStage:
    """The balances with their effects, all parameters that fit them, without effects and with these, the values by
    which effects would be shaped best, and curves for what no effect explains.
    """

    results: Sequence[BalanceResult]
    declared: Values
    baseline: Values
    corrected: Values
    shapes: Shapes
    curves: Sequence[CurveFit] = ()

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
            self.shapes,
        )


def baselines(
    experiment: Experiment,
    motions: Sequence[Motion],
    declared: Values,
    offset: FoundEffect | None,
    progress: Progress,
) -> ResidualStage:
    """The declared plant fitted to each balance, with the balance's floor; `offset` is that of a sensor, if one was
    found.
    """
    bounds, values = experiment.bounds, dict(declared)
    if offset is not None:
        values |= {name: number.value for name, number in offset.parameters.items()}
    balances = balances_of(experiment, motions, values)
    progress("fitting the declared plant", 0.02)
    fits = list[Fit]()
    for balance in balances:
        fits.append(baseline(balance, values, bounds))
        values |= {name: fits[-1].values[name] for name in balance.free}
    results = [BalanceResult(each.balance, each, each, [Step(each, [])], {}, {}, {}) for each in fits]
    return ResidualStage(results, declared, values, values, {})


def with_floors(stage: ResidualStage, experiment: Experiment, progress: Progress) -> ResidualStage:
    """The balances over what they leave of a plant that lacks nothing and is kept beside the records.

    Parameters that make up for what is missing may make a plant that hunts, and leaves far more than the records do: no
    noise does. Then the plant as it is declared says it, too, and what leaves less counts.
    """
    progress("noise floors", 0.25)
    balances = [result.balance for result in stage.results]
    whole = diagnosed_plant(experiment.plant, experiment.flow, balances[0].motions[0].channels)
    floors = floored(whole, balances, stage.baseline)
    results = [_over(result, floor) for result, floor in zip(stage.results, floors, strict=True)]
    if min(result.after.rms for result in results) < TOO_LITTLE:
        declared = floored(
            whole, balances, {**stage.baseline, **{n: stage.declared[n] for b in balances for n in b.free}}
        )
        lower = [min(pair, key=lambda one: one.floor) for pair in zip(floors, declared, strict=True)]
        results = [_over(result, floor) for result, floor in zip(stage.results, lower, strict=True)]
    return replace(stage, results=results)


def with_simulated_floors(stage: ResidualStage, simulation: SimulationStage, bounds: Bounds) -> ResidualStage:
    """The balances over what they leave of the plant that follows the records from end to end."""
    samples = sum(motion.record.time.size for motion in simulation.after.balance.motions)
    count = min(max(DRAWN // samples, FEWEST), DRAWS)
    draws = _beside(simulation, count) if simulation.is_beside else _freely(simulation, count)
    known = {**stage.corrected, **simulation.after.moved}
    if not draws:
        return stage
    floors = [
        with_fitted_floor(result.balance, draws, {**known, **result.after.moved}, bounds) for result in stage.results
    ]
    return replace(stage, results=[_over(result, floor) for result, floor in zip(stage.results, floors, strict=True)])


def _freely(simulation: SimulationStage, count: int) -> list[list[Motion]]:
    """Records of the plant that follows, with noise of the spectrum that it leaves."""
    motions, values = simulation.after.balance.motions, simulation.after.values
    how = begun(simulation.how, motions, values)
    simulated = [how.simulated(motion, values) for motion in motions]
    return [
        [
            surrogate(motion, seen, DRAWS * i + k)
            for i, (motion, seen) in enumerate(zip(motions, simulated, strict=True))
        ]
        for k in range(count)
    ]


def _beside(simulation: SimulationStage, count: int) -> list[list[Motion]]:
    """Records of a plant that a force alone keeps beside them, with its sensors' noise; none if it does not stay."""
    along, motions, values = simulation.how.along, simulation.after.balance.motions, simulation.after.values
    draws = list[list[Motion]]()
    for k in range(count):
        null = [null_motion(along, motion, values, DRAWS * i + k) for i, motion in enumerate(motions)]
        draws.append([motion for motion in null if motion is not None])
    return draws if all(len(draw) == len(motions) for draw in draws) else []


def _over(result: BalanceResult, balance: Balance) -> BalanceResult:
    before, after = over(result.before, balance), over(result.after, balance)
    steps = [replace(step, before=over(step.before, balance)) for step in result.steps]
    return replace(result, balance=balance, before=before, after=after, steps=steps)


def with_effects(stage: ResidualStage, experiment: Experiment, progress: Progress) -> ResidualStage:
    """The balances with the effects that their residuals support: flow, then force. Effects of a balance that still
    depends on a signal stand in for another where a curve over it is likelier.
    """
    results, shapes, values = list[BalanceResult](), dict[str, Sequence[Shape]](), dict(stage.baseline)
    curves = list[CurveFit]()
    for result in stage.results:
        progress(f"effects on the {result.balance.name} balance", 0.3 + 0.1 * len(results))
        balance = result.balance
        before = result.before if not results else baseline(balance, values, experiment.bounds)
        ask = Asked(stage.declared, experiment.bounds, len(balance.effects), {}, LEAST_SHARE)
        found = search(before, {}, ask)
        shapes |= found.shapes
        after = replace(
            result,
            before=before,
            after=found.fit,
            steps=found.steps,
            effects=found.effects,
            gains=found.gains,
            alternatives=found.alternatives,
            otherwise=found.otherwise,
        )
        after = after.withdrawn() if _leaves_too_much(after) else after
        curve = curve_of(experiment, after, values, stage.declared)
        if curve is not None and curve.is_likelier(after, ask):
            curves.append(curve)
            after = after.withdrawn()
        results.append(after)
        values |= {name: after.after.values[name] for name in after.after.names}
    return replace(stage, results=results, corrected=values, shapes=shapes, curves=curves)


def with_most(stage: ResidualStage) -> ResidualStage:
    """The balances without effects beside which more is left than they take, over the floor: they may stand in for what
    is left, where no simulated plant tells better. The same if there are none.
    """
    partly = [one for one in stage.results if one.effects and 2.0 * one.after.rms**2 > one.before.rms**2 + 1.0]
    if not partly:
        return stage
    results = [one.withdrawn() if one in partly else one for one in stage.results]
    fitted = {name: one.after.values[name] for one in results for name in one.after.names}
    return replace(stage, results=results, corrected={**stage.corrected, **fitted})


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
        values |= after.moved
        own = {effect: names for effect, names in simulation.effects.items() if effect in balance.effects}
        again.append(replace(result, after=after, effects=own))
    return replace(stage, results=again, corrected=values)


def with_declared_of(stage: ResidualStage, experiment: Experiment, simulation: SimulationStage) -> ResidualStage:
    """The balances around what the simulated plant says of parameters that are declared with a deviation: each moves
    on one balance alone, and the others would hold it as it is declared.
    """
    told = {name for result in stage.results for name in result.balance.priors} & set(simulation.after.names)
    if not told:
        return stage

    def around(one: Fit, simulated: Fit) -> Fit:
        values = {**one.values, **{name: simulated.values[name] for name in told}}
        names = [name for name in one.names if name not in told]
        return weighed_fit(one.balance, values, names, experiment.bounds)

    results = []
    first, last = ({name: one.values[name] for name in told} for one in (simulation.before, simulation.after))
    declared, baseline, corrected = {**stage.declared, **last}, {**stage.baseline, **first}, {**stage.corrected, **last}
    for result in stage.results:
        before = around(result.before, simulation.before)
        alike = result.after is result.before and simulation.after is simulation.before
        after = before if alike else around(result.after, simulation.after)
        results.append(replace(result, before=before, after=after))
        baseline |= before.moved
        corrected |= after.moved
    return replace(stage, results=results, declared=declared, baseline=baseline, corrected=corrected)


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


def _leaves_too_much(result: BalanceResult) -> bool:
    """Whether effects take a part of a residual that goes on to depend on a signal, or to be far above its floor: then
    they stand in for another.

    A circular one takes its part of any residual: it has to take more, and is not believed where the residual depends
    on place or time.
    """
    before, after = result.before, result.after
    if not result.effects or not after.balance.simulated:  # without such a floor nobody knows what is too much
        return False
    if any(is_circular(effect, after.balance) for effect in result.effects):
        first = _depends(before)
        if after.rms > (1.0 - CIRCULAR_SHARE) * before.rms:
            return True
        if first is not None and any(first.shares.get(name, 0.0) > PLACED for name in PLACES):
            return True
    if after.rms < LEFT_OVER or after.rms < TAKEN * before.rms:
        return False
    return bool(after.rms > min(FAR, PARTLY * before.rms)) or _depends(after) is not None

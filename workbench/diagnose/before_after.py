"""Errors before and after: residuals of the balances, and free runs of the simulated plant."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals import pump
from workbench.diagnose.residuals.fit import Fit, fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.result import BeforeAfter, Errors, ErrorsByUse
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.simulation.fits import Fitting, Simulated, begun
from workbench.diagnose.simulation.free_run import FreeRunErrors, free_run
from workbench.diagnose.simulation.setup import as_simulated, behind_backlash, shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.records.experiment import Experiment

DRIFTS = 2.0
"""Times the error on the fit records beyond which a free run of held-out ones is looked at closer."""


def errors_of(
    experiment: Experiment,
    results: Sequence[BalanceResult],
    simulation: SimulationStage | None,
    baseline: Values,
    corrected: Values,
    held_out: Sequence[Motion],
) -> ErrorsByUse:
    """Errors of the baseline and of what was found, each with the parameters that were fitted to that kind of error."""

    free = (None, None) if simulation is None else _free(experiment, simulation, results[0].balance.motions)

    def on(motions: Sequence[Motion]) -> BeforeAfter:
        if not motions:
            return BeforeAfter(Errors({}), Errors({}))
        whole = None if simulation is None else shooting_of(experiment, motions, held=simulation.how.held)
        before, after = free
        first = _errors(results, motions, baseline, whole, before)
        if after is before and corrected == baseline:
            return BeforeAfter(first, first)
        return BeforeAfter(first, _errors(results, motions, corrected, whole, after))

    fitted, tested = on(results[0].balance.motions), on(held_out)
    own = None
    if simulation is not None and not simulation.is_trusted and _drifts(fitted.after, tested.after):
        own = _own_fits(experiment, simulation, held_out)
    found = ErrorsByUse(fitted, tested, own)
    if simulation is not None and simulation.effects and found.runs_worse:
        return replace(found, gained=_gained(experiment, simulation, held_out))
    return found


def _errors(
    results: Sequence[BalanceResult],
    motions: Sequence[Motion],
    values: Values,
    whole: Shooting | None,
    simulated: Fit | None,
) -> Errors:
    """Errors of one model: `values` in the balances, those of the fit `simulated` in a free run; that of a balance is
    infinite where the plant runs away.
    """
    balances = {}
    for result in results:
        over = replace(result.balance, motions=behind_backlash(whole, motions, values))
        rms = float(np.sqrt(np.mean(over.stacked(values) ** 2)))
        balances[over.name] = float(np.nan_to_num(rms, nan=np.inf)) * over.floor
    run = FreeRunErrors() if whole is None or simulated is None else free_run(whole, motions, simulated.values)
    units = {result.balance.name: result.balance.unit for result in results}
    speed, axis = _of_pump(results, motions, values), results[0].balance.axis
    return Errors(balances, speed, run.position, run.load_pressure, axis, units)


def _of_pump(results: Sequence[BalanceResult], motions: Sequence[Motion], values: Values) -> float | None:
    """Rms over plateaus of the pump's speed (rad/s); None without a pump."""
    flow = next((result.balance for result in results if result.balance.name == "flow"), None)
    if flow is None or not all(motion.has(pump.SPEED) for motion in motions) or motions[0].has("valve_voltage"):
        return None
    displacement = values["pump_displacement"]
    return pump.rms_of(
        [pump.plateau_means(motion.thinned, flow.residuals(motion, values)[0], displacement) for motion in motions]
    )


def _drifts(fitted: Errors, tested: Errors) -> bool:
    """Whether a free run of the held-out records is off by far more than one of the records that were fitted."""
    if fitted.position is None or tested.position is None:
        return False
    return tested.position > DRIFTS * fitted.position


def _free(experiment: Experiment, simulation: SimulationStage, motions: Sequence[Motion]) -> tuple[Fit, Fit]:
    """The fits before and after by whose values the plant runs freely: those of the simulation, or of a plant that is
    far from noise those of free runs themselves.
    """
    fits = simulation.before, simulation.after
    if not all(Simulated(simulation.how, one).is_astray for one in fits):
        return fits
    before, after = (_freely(experiment, simulation, one, motions)[1] for one in fits)
    return before, before if fits[0] is fits[1] else after


def _freely(
    experiment: Experiment, simulation: SimulationStage, fitted: Fit, motions: Sequence[Motion]
) -> tuple[Shooting, Fit]:
    """A plant from end to end of records, and a fit of it to them from its first samples on."""
    motions = as_simulated(experiment, motions)
    whole = shooting_of(experiment, motions, held=simulation.how.held)
    assert whole is not None  # free runs of it are among the errors
    return whole, Fitting(motions, fitted.names, experiment.bounds).freely(whole, fitted.values)


def _own_fits(experiment: Experiment, simulation: SimulationStage, held_out: Sequence[Motion]) -> BeforeAfter:
    """Free-run errors of held-out records with parameters fitted to these: the least that the plant can leave."""

    def left(one: Fit) -> Errors:
        whole, own = _freely(experiment, simulation, one, held_out)
        run = free_run(whole, held_out, own.values)
        return Errors({}, position=run.position, load_pressure=run.load_pressure, axis=experiment.plant.axis)

    return BeforeAfter(left(simulation.before), left(simulation.after))


def _gained(experiment: Experiment, simulation: SimulationStage, held_out: Sequence[Motion]) -> float:
    """By how much the logarithm of the likelihood of held-out records rises with what was found, by the noise that it
    leaves of them: an error that goes up with slow noise alone says nothing.
    """
    held_out = as_simulated(experiment, held_out)
    whole = shooting_of(experiment, held_out, held=simulation.how.held)
    assert whole is not None  # free runs of it are among the errors
    before, after = (
        fit(begun(whole, held_out, one.values).balance(held_out, ()), one.values, ())
        for one in (simulation.before, simulation.after)
    )
    noise = weighing_at(after)
    return 0.5 * (before.seen_by(noise) - after.seen_by(noise))

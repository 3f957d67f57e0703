"""Errors before and after: residuals of the balances, and free runs of the simulated plant."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals import pump
from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.result import BeforeAfter, Errors, ErrorsByUse
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.simulation.by_curve import Curved
from workbench.diagnose.simulation.fits import Fitting, Simulated
from workbench.diagnose.simulation.free_run import FreeRunErrors, free_run
from workbench.diagnose.simulation.held_out import HeldOut, likelier
from workbench.diagnose.simulation.nearer import freely
from workbench.diagnose.simulation.setup import as_simulated, behind_backlash
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.fitting.threads import side_by_side
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
    runs = None if simulation is None else _free(experiment, simulation)
    before, after = (None, None) if runs is None else runs
    models = [(baseline, before), (corrected, after)]
    if after is before and corrected == baseline:
        models.pop()

    def of(motions: Sequence[Motion]) -> BeforeAfter:
        if not motions:
            return BeforeAfter(Errors({}), Errors({}))
        whole = simulation.along(experiment, motions) if simulation else None
        errors = side_by_side(lambda model: _errors(results, motions, whole, *model), models)
        return BeforeAfter(errors[0], errors[-1])

    fitted, tested = side_by_side(of, [results[0].balance.motions, held_out])
    own = None
    if simulation is not None and not simulation.is_trusted and _drifts(fitted.after, tested.after):
        own = _own_fits(experiment, simulation, held_out)
    found = ErrorsByUse(fitted, tested, own)
    if simulation is not None and _is_far(simulation):
        found = replace(found, written=_as_written(experiment, simulation, (baseline, corrected), held_out))
    if simulation is not None and simulation.curved is not None:
        found = replace(found, with_curve=_with_curve(experiment, simulation.curved, held_out))
    if simulation is not None and simulation.effects and found.runs_worse:
        return replace(found, gained=_gained(HeldOut.of(experiment, simulation, held_out), simulation))
    return found


def _gained(records: HeldOut, simulation: SimulationStage) -> float | None:
    """By how much the logarithm of the likelihood of held-out records rises with what was found; None where that leaves
    far more of them than noise, whose likelihood it would be.
    """
    after = records.left_by(simulation.after)
    return likelier(after, records.left_by(simulation.before)) if after.excess < NEAR_NOISE else None


def _errors(
    results: Sequence[BalanceResult],
    motions: Sequence[Motion],
    whole: Shooting | None,
    values: Values,
    simulated: Values | None,
) -> Errors:
    """Errors of one model: `values` in the balances, `simulated` in a free run; that of a balance is infinite where the
    plant runs away.
    """
    balances = {}
    for result in results:
        over = replace(result.balance, motions=behind_backlash(whole, motions, values))
        rms = float(np.sqrt(np.mean(over.stacked(values) ** 2)))
        balances[over.name] = float(np.nan_to_num(rms, nan=np.inf)) * over.floor
    run = FreeRunErrors() if whole is None or simulated is None else free_run(whole, motions, simulated)
    units = {result.balance.name: result.balance.unit for result in results}
    speed, axis = _of_pump(results, motions, values), results[0].balance.axis
    return Errors(balances, speed, run.position, run.load_pressure, axis, units, run.shown)


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


def _free(experiment: Experiment, simulation: SimulationStage) -> tuple[Values, Values]:
    """The parameters before and after by which the plant runs freely: those of the simulation, or of a plant that is
    far from noise those of fits to free runs themselves.
    """
    if not _is_far(simulation):
        return simulation.before.values, simulation.after.values
    return _freely(experiment, simulation, simulation.after.balance.motions)


def _is_far(simulation: SimulationStage) -> bool:
    """Whether the plant is so far from noise that free runs have parameters of their own: one that a curve brings near
    has those of the curve.
    """
    fits = (simulation.before, simulation.after)
    return simulation.curved is None and all(Simulated(simulation.how, one).is_astray for one in fits)


def _as_written(
    experiment: Experiment, simulation: SimulationStage, models: tuple[Values, Values], held_out: Sequence[Motion]
) -> tuple[BeforeAfter, BeforeAfter]:
    """Free-run errors of the fit and of the held-out records with the parameters of the balances, before and after."""

    def of(motions: Sequence[Motion]) -> BeforeAfter:
        if not motions:
            return BeforeAfter(Errors({}), Errors({}))
        whole = simulation.along(experiment, motions)
        return BeforeAfter(*(_run(experiment, free_run(whole, motions, values)) for values in models))

    fitted, tested = side_by_side(of, (simulation.after.balance.motions, as_simulated(experiment, held_out)))
    return fitted, tested


def _with_curve(experiment: Experiment, by_curve: Curved, held_out: Sequence[Motion]) -> tuple[Errors, Errors]:
    """Free-run errors of the fit and of the held-out records with a curve that is switched on."""

    def of(motions: Sequence[Motion]) -> Errors:
        if not motions:
            return Errors({})
        whole, values = by_curve.along(experiment, motions), by_curve.simulated.fit.values
        return _run(experiment, free_run(whole, motions, values))

    fitted, tested = side_by_side(of, (by_curve.simulated.fit.balance.motions, as_simulated(experiment, held_out)))
    return fitted, tested


def _run(experiment: Experiment, run: FreeRunErrors) -> Errors:
    axis = experiment.plant.axis
    return Errors({}, position=run.position, load_pressure=run.load_pressure, axis=axis, shown=run.shown)


def _freely(experiment: Experiment, simulation: SimulationStage, motions: Sequence[Motion]) -> tuple[Values, Values]:
    """The plant before and after fitted to free runs of records, as `as_simulated` has them."""
    whole = simulation.along(experiment, motions)

    def fitted(one: Fit) -> Values:
        return freely(Fitting(motions, one.names, experiment.bounds), whole, one.values).values

    before, *after = side_by_side(fitted, dict.fromkeys((simulation.before, simulation.after)))
    return before, after[0] if after else before


def _own_fits(experiment: Experiment, simulation: SimulationStage, held_out: Sequence[Motion]) -> BeforeAfter:
    """Free-run errors of held-out records with parameters fitted to these: the least that the plant can leave."""
    held_out = as_simulated(experiment, held_out)
    whole = simulation.along(experiment, held_out)
    runs = side_by_side(lambda values: free_run(whole, held_out, values), _freely(experiment, simulation, held_out))
    return BeforeAfter(*(_run(experiment, run) for run in runs))

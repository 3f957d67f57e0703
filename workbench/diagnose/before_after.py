"""Errors before and after: residuals of the balances, and free runs of the simulated plant."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from workbench.diagnose.residuals.fitting import fit
from workbench.diagnose.residuals.flow import pump_speed_errors
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.simulation.shooting import Shooting, free_run, set_up, simulation_balance
from workbench.diagnose.simulation.simulated import SEARCH, Simulated
from workbench.records.experiment import Experiment

DRIFTS = 2.0
"""Times the error on the fit records beyond which a free run of held-out ones is looked at closer."""

KEYS = {"force": "force_rms_N", "flow": "flow_rms_m3_per_s"}
"""What the error of each balance is called."""


def errors_of(
    experiment: Experiment,
    results: Sequence[BalanceResult],
    simulated: Simulated | None,
    baseline: Values,
    corrected: Values,
    held_out: Sequence[Motion],
) -> dict[str, Any]:
    """Rms of each balance's residual and of free-run simulation, with the baseline and with what was found.

    Each with the parameters that were fitted to that kind of error.
    """
    errors: dict[str, Any] = {}
    for use, motions in (("fit", results[0].balance.motions), ("held_out", held_out)):
        sides: dict[str, dict[str, float]] = {"before": {}, "after": {}}
        whole = set_up(experiment, motions, held=simulated.how.held) if simulated is not None and motions else None
        for side, values in (("before", baseline), ("after", corrected)) if motions else ():
            for result in results:
                over = replace(result.balance, motions=behind_backlash(whole, motions, values))
                rms = float(np.sqrt(np.mean(over.stacked(values) ** 2))) * over.floor
                sides[side][KEYS[over.name]] = rms
            if all(motion.has("pump_speed") and not motion.has("valve_voltage") for motion in motions):
                sides[side] |= _of_pump(motions, values)
            if simulated is not None:
                sides[side] |= free_run(whole, motions, getattr(simulated, side).values)
        errors[use] = sides
    if simulated is not None and not simulated.is_trusted and _drifts(errors):
        errors["held_out"]["own_parameters"] = _own_fit(experiment, simulated, held_out)
    return errors


def _of_pump(motions: Sequence[Motion], values: Values) -> dict[str, float]:
    """Rms over plateaus of the pump's speed; empty where there are none, or no displacement."""
    if "pump_displacement" not in values:
        return {}
    errors = np.concatenate([pump_speed_errors(motion, values) for motion in motions])
    return {"pump_speed_rms_rad_per_s": float(np.sqrt(np.mean(errors**2)))} if errors.size else {}


def _drifts(errors: Mapping[str, Any]) -> bool:
    """Whether a free run of the held-out records is off by far more than one of the records that were fitted."""
    fitted, tested = (errors[use]["after"].get("position_rms_m") for use in ("fit", "held_out"))
    return fitted is not None and tested is not None and tested > DRIFTS * fitted


def _own_fit(experiment: Experiment, simulated: Simulated, held_out: Sequence[Motion]) -> dict[str, float]:
    """Free-run errors of held-out records with the plant's parameters fitted to them: the least that it can leave."""
    whole = set_up(experiment, held_out, held=simulated.how.held)
    assert whole is not None  # free runs of it are among the errors
    after = simulated.after
    balance = simulation_balance(whole, held_out, after.names)
    return free_run(whole, held_out, fit(balance, after.values, after.names, experiment.bounds, SEARCH).values)


def behind_backlash(whole: Shooting | None, motions: Sequence[Motion], values: Values) -> list[Motion]:
    """Motions with the rod on the side of a backlash where the simulated one is."""
    return list(motions) if whole is None else [whole.with_backlash_of(motion, values) for motion in motions]

"""Results of a comparison that nobody simulated: errors, powers and limit cycles of given size over draws."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import Verdict, verdicts

SPEC = ComparisonTable(
    plain=["p", "pi"], pressure=["load_pressure"], steps=["steps"], negligible=1e-6, fresh_draws=10, left_out=["Ramps."]
)

COUNTS = SPEC.model_copy(update={"negligible": 1e-6})

Errors = Mapping[tuple[str, float], float]
"""Mean error (m) by controller and rpm."""


def case(controller: str, rpm: float, error: float, **other: Any) -> dict[str, Any]:
    """One row of the results; `other` sets its columns."""
    turning = rpm > 0
    moving = other.get("reference", "sine") != "steps"
    motor = 4.0 * rpm if turning else None
    return {
        "machine": "rig",
        "scenario": "nominal",
        "reference": "sine",
        "rpm": rpm,
        "controller": controller,
        "draw": 1,
        "outcome": "completed",
        "phase_lag_deg": 1.0 if moving else None,
        "rms_error_m": error,
        "max_error_m": 2.0 * error,
        "steady_state_max_error_m": None if moving else error,
        "limit_cycle": None if moving else "none",
        "limit_cycle_amplitude_m": None,
        "supply_power_W": 200.0,
        "rotation_power_W": rpm if turning else None,
        "motor_electric_power_W": motor,
        "motor_loss_W": 3.0 * rpm if turning else None,
        "paid_power_W": 200.0 + (motor or 0.0),
        "rotation_speed_mean_rpm": rpm if turning else None,
        "below_stribeck_fraction": 0.25 if turning else None,
        "motor_torque_rms_N_m": 0.05 * rpm if turning else None,
        "solver_error_m": 1e-12,
        "solver_rms_error_m": 1e-12,
        **other,
    }


def cell(
    errors: Errors, draws: Sequence[int] = range(1, 11), noise: float = 0.05, seed: int = 1, **other: Any
) -> pd.DataFrame:
    """One cell: each candidate with a spread of its own around what all share on a draw."""
    random = np.random.default_rng(seed)
    shared = np.exp(0.4 * random.standard_normal(len(draws)))
    rows = [
        case(controller, rpm, error * shared[i] * float(np.exp(noise * random.standard_normal())), draw=draw, **other)
        for (controller, rpm), error in errors.items()
        for i, draw in enumerate(draws)
    ]
    return pd.DataFrame(rows)


CONTROLLERS = ("p", "pi", "load_pressure", "lugre", "tafazoli")
SPEEDS = (0.0, 10.0, 50.0)


def whole(seed: int = 1, draws: Sequence[int] = range(1, 11), noise: float = 0.1) -> pd.DataFrame:
    """Two machines, two scenarios, a sine and steps; who wins differs from cell to cell. In one scenario PI hunts, and
    P at rest: on one machine often, on the other on a single draw.

    What is true of a cell does not depend on `seed`: that is of the draws alone.
    """
    truth, frames = np.random.default_rng(99), []
    for machine in ("simulated", "rig"):
        for scenario in ("nominal", "soft"):
            for reference in ("sine", "steps"):
                errors: dict[tuple[str, float], float] = {
                    (name, rpm): 1e-4 * float(np.exp(truth.normal())) * (3.0 if (name, rpm) == ("p", 0.0) else 1.0)
                    for name in CONTROLLERS
                    for rpm in SPEEDS
                }
                seed += 1000
                other = {"machine": machine, "scenario": scenario, "reference": reference}
                part = cell(errors, draws, noise, seed, **other)
                if machine == "simulated":
                    part["rotation_power_W"] *= 100.0
                    part["rotation_speed_mean_rpm"] *= 1.1
                    part["motor_torque_rms_N_m"] *= 10.0
                if scenario == "soft" and reference == "steps":
                    hunts = (part["controller"] == "pi") & (part["rpm"] < 50.0) & (part["draw"] % 2 == 0)
                    hunts |= (
                        (part["controller"] == "p")
                        & (part["rpm"] == 0.0)
                        & ((part["draw"] % 2 == 0) if machine == "simulated" else (part["draw"] == 15))
                    )
                    part.loc[hunts, ["limit_cycle", "limit_cycle_amplitude_m"]] = ["sustained", 1.4e-3]
                frames.append(part)
    return pd.concat(frames, ignore_index=True)


def verdict(frame: pd.DataFrame, spec: ComparisonTable = COUNTS, fresh: pd.DataFrame | None = None) -> Verdict:
    """The verdict of a study of one cell."""
    (found,) = verdicts(spec, frame, fresh).values()
    return found

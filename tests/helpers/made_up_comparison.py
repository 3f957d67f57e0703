"""Results of a comparison that nobody simulated: errors, powers and limit cycles of given size over draws."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from workbench.compare.comparison import compare
from workbench.compare.result import Comparison, Verdict
from workbench.compare.schema import ComparisonTable
from workbench.study.schema import StudyFile
from workbench.study.study import Study

SPEC = ComparisonTable(
    plain=["p", "pi"], pressure=["load_pressure"], steps=["steps"], negligible=1e-6, fresh_draws=10, left_out=["Ramps."]
)

Errors = Mapping[tuple[str, float], float]
"""Mean error (m) by controller and rpm."""


@dataclass(frozen=True)
class Place:
    """The cell in which a case is run."""

    machine: str = "rig"
    scenario: str = "nominal"
    reference: str = "sine"


HERE = Place()
STEPS = Place(reference="steps")


@dataclass(frozen=True)
class ResultRow:
    """One row of the results, by its columns."""

    machine: str
    scenario: str
    reference: str
    rpm: float
    controller: str
    draw: int
    outcome: str
    phase_lag_deg: float | None
    rms_error_m: float
    max_error_m: float
    steady_state_max_error_m: float | None
    limit_cycle: str | None
    limit_cycle_amplitude_m: float | None
    supply_power_W: float  # noqa: N815 - the unit's own letters
    rotation_power_W: float | None  # noqa: N815
    motor_electric_power_W: float | None  # noqa: N815
    motor_loss_W: float | None  # noqa: N815
    paid_power_W: float  # noqa: N815
    rotation_speed_mean_rpm: float | None
    below_stribeck_fraction: float | None
    motor_torque_rms_N_m: float | None  # noqa: N815
    solver_error_m: float = 1e-12
    solver_rms_error_m: float = 1e-12


def case(controller: str, rpm: float, error: float, draw: int = 1, place: Place = HERE) -> ResultRow:
    """A case with an error (m), whose powers go with rpm."""
    moving = place.reference != "steps"

    def turning(value: float) -> float | None:
        return value if rpm > 0 else None

    return ResultRow(
        machine=place.machine,
        scenario=place.scenario,
        reference=place.reference,
        rpm=rpm,
        controller=controller,
        draw=draw,
        outcome="completed",
        phase_lag_deg=1.0 if moving else None,
        rms_error_m=error,
        max_error_m=2.0 * error,
        steady_state_max_error_m=None if moving else error,
        limit_cycle=None if moving else "none",
        limit_cycle_amplitude_m=None,
        supply_power_W=200.0,
        rotation_power_W=turning(rpm),
        motor_electric_power_W=turning(4.0 * rpm),
        motor_loss_W=turning(3.0 * rpm),
        paid_power_W=200.0 + 4.0 * rpm,
        rotation_speed_mean_rpm=turning(rpm),
        below_stribeck_fraction=turning(0.25),
        motor_torque_rms_N_m=turning(0.05 * rpm),
    )


def cell(
    errors: Errors,
    draws: Sequence[int] = range(1, 11),
    noise: float = 0.05,
    seed: int = 1,
    place: Place = HERE,
) -> pd.DataFrame:
    """One cell: each candidate with a spread of its own around what all share on a plant sample."""
    random = np.random.default_rng(seed)
    shared = np.exp(0.4 * random.standard_normal(len(draws)))
    rows = [
        case(controller, rpm, error * shared[i] * float(np.exp(noise * random.standard_normal())), draw, place)
        for (controller, rpm), error in errors.items()
        for i, draw in enumerate(draws)
    ]
    return pd.DataFrame([vars(row) for row in rows])  # of dataclasses pandas makes copies all the way down


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
                part = cell(errors, draws, noise, seed, Place(machine, scenario, reference))
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


def made_up_study(title: str = "made up", question: str = "") -> Study:
    """A study that holds nothing but its title and question."""
    return Study(Path("made_up.toml"), "", StudyFile(title=title, question=question))


def compared(frame: pd.DataFrame, table: ComparisonTable = SPEC, fresh: pd.DataFrame | None = None) -> Comparison:
    """The comparison of made-up results."""
    return compare(made_up_study(), table, frame, fresh)


def verdict(frame: pd.DataFrame, table: ComparisonTable = SPEC, fresh: pd.DataFrame | None = None) -> Verdict:
    """The verdict of a study of one cell."""
    (only,) = compared(frame, table, fresh).verdicts.values()
    return only

"""What a balance's residual would be if nothing were missing: the fitted plant simulated along the record, its
sensors' noise added, and judged as the record is.

Smoothing, a bristle that follows a noisy velocity, contacts that break away between samples: all of it leaves a
residual on records without any effect, and more of it than the sensors' noise alone.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from controllers import pid
from controllers.pid import PID
from plants.two_chamber import TWO_CHAMBER
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.diagnose.residuals.unknowns import Values
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build
from workbench.simulation.simulate import Feed, Loop, Setup, simulate

TRACKING = 20.0
"""rad/s. Crossover of the loop that keeps the simulation beside the record: its own valve voltage drifts away."""

SEED = 20
"""Of the generator of the noise that is added: the same experiment gives the same floors."""


def null_motion(motion: Motion, values: Values, flow: str, seed: int) -> Motion | None:
    """The motion of the plant with `values` in the place of the recorded one; None where the plant diverges."""
    record = motion.record
    parameters = build(TWO_CHAMBER.Parameters, values, flow)
    h = parameters.hydraulics
    if motion.voltage is None:
        return None
    state, inputs = TWO_CHAMBER.equilibrium(parameters, 0.0)
    known = np.isfinite(record.channels["position"])
    position = Sampled(record.time[known], motion.position[known])
    voltage = Sampled(record.time, motion.voltage)
    speed_gain = h.valve_flow_gain * h.valve_position_gain * np.sqrt(0.5 * h.supply_pressure) / h.piston_area_1
    gains = PID.design(pid.Settings(kp=TRACKING / speed_gain), parameters, record.sample_time)
    run = simulate(
        Setup(
            plant=TWO_CHAMBER,
            parameters=parameters,
            state=state._replace(position=float(motion.position[0])),
            inputs=inputs,
            duration=float(record.time[-1]),
            loop=Loop(PID, gains),
            reference=position,
            feeds=(Feed("valve_voltage", voltage, linear=False),),
            sample_time=record.sample_time,
        )
    )
    if run.diverged or run.time.size != record.time.size:
        return None
    noise = np.random.default_rng([SEED, seed])
    shown = {
        "position": run.measurements[:, 0],
        "pressure_1": run.measurements[:, 1],
        "pressure_2": run.measurements[:, 2],
    }
    channels = {
        name: values_of + motion.noise[name] * noise.standard_normal(values_of.size)
        for name, values_of in shown.items()
    }
    channels["valve_voltage"] = run.command
    for name, values_of in record.channels.items():
        channels.setdefault(name, values_of)
    return motion_of(replace(record, channels=channels))


SPOILT = 1.3
"""Sensor floors beyond which a floor without a contact in it is not believed: the simulation then broke away where
the record did not."""


def with_floor(balance: Balance, motions: Sequence[Motion], values: Values) -> Balance:
    """The balance with the residual of motions on which nothing is missing as its floor, where that is larger."""
    null = replace(balance, motions=motions)
    floors = float(np.sqrt(np.mean(null.stacked(values) ** 2)))
    floor = balance.floor * max(floors if balance.sharp else min(floors, SPOILT), 1.0)
    return replace(balance, floor=floor, simulated=True)


def floored(balances: Sequence[Balance], values: Values, flow: str) -> list[Balance]:
    """All balances with such floors, of a valve-driven actuator whose `values` serve it; others as they are."""
    motions = balances[0].motions
    if not motions[0].has("valve_voltage", "position", "pressure_1", "pressure_2"):
        return list(balances)
    null = [null_motion(motion, values, flow, i) for i, motion in enumerate(motions)]
    complete = [motion for motion in null if motion is not None]
    return [with_floor(balance, complete, values) if complete else balance for balance in balances]

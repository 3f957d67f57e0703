"""What turning the rod takes, by the rows of results: power at rod and terminals, the pump's, real speed, torque."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from workbench.compare.candidates import TOLD_SPEED
from workbench.compare.cells import hunting_counts
from workbench.simulation.run import COMPLETED

POWER = "rotation_power_W"
TERMINALS = "motor_electric_power_W"
PUMP = "supply_power_W"
TORQUE = "motor_torque_rms_N_m"

ALIKE_POWER = 0.1
"""Share by which the power of turning differs at most where the friction around the rod is the same."""

CASE = ["scenario", "reference", "controller", "rpm", "draw"]


@dataclass(frozen=True)
class TurningPrice:
    """Mean power (W) of turning at `rpm` on each of two machines, at the rod and at the motor's terminals."""

    rpm: float
    rod: tuple[float, float]
    terminals: tuple[float, float]


def prices_of_turning(frame: pd.DataFrame, first: str, second: str) -> list[TurningPrice]:
    """By rpm what turning takes on two machines, over the cases that both have."""
    turning = frame[(frame["rpm"] > 0) & frame[POWER].notna() & frame["outcome"].eq(COMPLETED)]
    ours, theirs = (turning[turning["machine"] == name].set_index(CASE) for name in (first, second))
    common = ours.index.intersection(theirs.index)
    ours, theirs = ours.loc[common], theirs.loc[common]
    prices = []
    for rpm in sorted(common.unique("rpm")):
        here = common.get_level_values("rpm") == rpm
        rod, terminals = (
            (float(ours.loc[here, name].mean()), float(theirs.loc[here, name].mean())) for name in (POWER, TERMINALS)
        )
        prices.append(TurningPrice(rpm, rod, terminals))
    return prices


def turn_alike(frame: pd.DataFrame, first: str, second: str) -> bool:
    """Whether turning takes the same power on both machines, as with the same friction around the rod."""
    prices = prices_of_turning(frame, first, second)
    return bool(prices) and all(abs(price.rod[0] / price.rod[1] - 1.0) <= ALIKE_POWER for price in prices)


def pump_changes(frame: pd.DataFrame) -> dict[str, float]:
    """By reference the share by which rotating changes what the pump pays: the same controller, motion and plant sample
    at rest and turning.

    What a loop that hunts takes is no price of rotation.
    """
    places = frame[["machine", "scenario", "controller", "rpm"]].itertuples(index=False, name=None)
    hunting = {place for place, counted in hunting_counts(frame).items() if counted.hunts}
    frame = frame[[place not in hunting for place in places]]
    key = ["machine", "scenario", "reference", "controller", "draw"]
    rest = frame[frame["rpm"] == 0].set_index(key)[PUMP].rename("rest")
    pairs = frame[frame["rpm"] > 0].join(rest, on=key).dropna(subset=[PUMP, "rest"])
    pairs = pairs[pairs["outcome"].eq(COMPLETED) & (pairs["rest"] > 0.0)]
    if pairs.empty:
        return {}
    means = pairs.groupby(["reference"], sort=False)[[PUMP, "rest"]].mean()
    return {str(name): row[PUMP] / row["rest"] - 1.0 for name, row in means.iterrows()}


@dataclass(frozen=True)
class RealSpeed:
    """Whether the rod turns as fast as it is told to: in how many of the turning `cases` it is `off`, by which share it
    is so at most, and for which share of the time the contact is below the Stribeck speed (None: not known).
    """

    cases: int
    off: int
    furthest: float
    below_stribeck: float | None


def real_speed(frame: pd.DataFrame) -> RealSpeed | None:
    """That of these rows; None where nothing turns."""
    turning = frame[(frame["rpm"] > 0) & frame["rotation_speed_mean_rpm"].notna()]
    if turning.empty:
        return None
    shares = turning["rotation_speed_mean_rpm"] / turning["rpm"] - 1.0
    below = float(pd.to_numeric(turning["below_stribeck_fraction"]).mean())
    return RealSpeed(
        cases=len(turning),
        off=int((shares.abs() > TOLD_SPEED).sum()),
        furthest=max(shares, key=abs),
        below_stribeck=None if math.isnan(below) else below,
    )


@dataclass(frozen=True)
class MotorLoad:
    """What the motor has to deliver: the largest rms torque (N m) by commanded rpm, over so many turning `cases`, of
    which `limited` are at a limit of it.
    """

    torques: Mapping[float, float]
    cases: int
    limited: int

    def above(self, torque: float) -> Sequence[float]:
        """The speeds (rpm) at which it is more than that `torque` (N m)."""
        return [rpm for rpm, most in self.torques.items() if most > torque]


def motor_load(frame: pd.DataFrame) -> MotorLoad | None:
    """That of these rows; None where nothing turns."""
    turning = frame[(frame["rpm"] > 0) & frame[TORQUE].notna()]
    if turning.empty:
        return None
    most = turning.groupby("rpm")[TORQUE].max()
    torques = {float(str(rpm)): float(torque) for rpm, torque in most.items()}
    return MotorLoad(torques, len(turning), int((frame["outcome"] == "torque-limited").sum()))

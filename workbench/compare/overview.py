"""What the verdicts say together: the answer by machine, between machines, and what follows for power, pump, motor and
hunting.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from workbench.compare.candidates import MM, TOLD_SPEED, Cell, hunting_draws, with_all_axes
from workbench.compare.finalists import related
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import Verdict, within
from workbench.compare.words import ALIKE, families
from workbench.metrics.limit_cycle import HUNTING
from workbench.publish.tables import shown_number
from workbench.publish.words import plain_name, watts
from workbench.simulation.run import COMPLETED

POWER = "rotation_power_W"
TERMINALS = "motor_electric_power_W"
PUMP = "supply_power_W"
ALIKE_POWER = 0.1
"""Share by which the power of turning differs at most where the friction around the rod is the same."""

MOST_NAMED = 5
"""Cases named in one sentence."""

CASE = ["scenario", "reference", "controller", "rpm", "draw"]


def answer(spec: ComparisonTable, found: Mapping[Cell, Verdict]) -> list[str]:
    """The verdicts of each machine in a sentence: what stands above everything."""
    return [by_machine(spec, machine, found) for machine in dict.fromkeys(cell.machine for cell in found)]


def overview(
    spec: ComparisonTable, frame: pd.DataFrame, whole: pd.DataFrame, found: Mapping[Cell, Verdict]
) -> list[str]:
    """What follows from the verdicts. Of several machines each other is held against the first, prices told once.

    `frame` has the draws that all candidates have met, `whole` the fresh ones too.
    """
    frame, whole = with_all_axes(frame), with_all_axes(whole)
    machines = list(dict.fromkeys(cell.machine for cell in found))
    lines = []
    for i, other in enumerate(machines[1:], start=1):
        lines.append(between(machines[0], other, found))
        if not any(turn_alike(known, other, frame) for known in machines[:i]):
            lines += around_the_rod(machines[0], other, frame)
    lines += friction_model(spec, found)
    lines += pump(frame)
    for machine in machines:
        part = whole[whole["machine"] == machine]
        lines += [*real_speed(machine, part), *motor(spec, machine, part)]
    return lines


def cell_name(cell: Cell, machine: bool = False) -> str:
    """A cell in words."""
    words = f"{plain_name(cell.scenario)} {plain_name(cell.reference)}"
    return f"{plain_name(cell.machine)} {words}" if machine and cell.machine else words


def on(machine: str) -> str:
    """The words in front of a sentence about one machine."""
    return f"On {plain_name(machine)}" if machine else "Here"


def by_machine(spec: ComparisonTable, machine: str, found: Mapping[Cell, Verdict]) -> str:
    """How many cells of a machine have which verdict, and which; those that ask for more than plain control first.

    Where nothing beats plain control at rest it may still err by more than counts: that is told.
    """
    cells = [cell for cell in found if cell.machine == machine]
    kinds: dict[str, list[str]] = {}
    for cell in sorted(cells, key=lambda cell: found[cell].kind == "nothing needed"):
        kinds.setdefault(found[cell].kind, []).append(cell_name(cell))
    told = "; ".join(f"{kind} in {len(names)} ({', '.join(names)})" for kind, names in kinds.items())
    first = f"{on(machine)}, of {len(cells)} cells: {told}."
    if len(kinds) == 1:
        first = f"{on(machine)}: {next(iter(kinds))} in all {len(cells)} cells."
    needed = [cell for cell in cells if found[cell].kind == "nothing needed"]
    open_ = [cell_name(cell) for cell in needed if not within(spec, found[cell].best["nothing"])]
    if not open_:
        return first
    return f"{first} Not within {spec.negligible * MM:g} mm, and nothing helps: {', '.join(open_)}."


def between(one: str, other: str, found: Mapping[Cell, Verdict]) -> str:
    """In which cells two machines have another verdict."""
    pairs = [(cell, cell._replace(machine=other)) for cell in found if cell.machine == one]
    both = [(first, second) for first, second in pairs if second in found]
    apart = [(first, second) for first, second in both if found[first].kind != found[second].kind]
    names = f"{plain_name(one)} and {plain_name(other)}"
    if not apart:
        return f"Between {names} no verdict of {len(both)} differs."
    told = "; ".join(f"{cell_name(first)} ({found[first].kind}, {found[second].kind})" for first, second in apart)
    return f"Between {names} {len(apart)} of {len(both)} verdicts differ: {told}."


def around_the_rod(one: str, other: str, frame: pd.DataFrame) -> list[str]:
    """What the friction around the rod makes of the price: power at equal speed, on the same cases."""
    prices = prices_of_turning(one, other, frame)
    parts = [
        f"{rpm:g} rpm: {watts(rod[0])} and {watts(rod[1])} at the rod (ratio {shown_number(rod[0] / rod[1], 2)}), "
        f"{watts(terminals[0])} and {watts(terminals[1])} at the terminals"
        for rpm, (rod, terminals) in prices.items()
    ]
    if not parts:
        return []
    return [
        f"What the friction around the rod makes of the price of turning it (means over the motions, where the rod "
        f"turns as told), on {plain_name(one)} and on {plain_name(other)}: {'; '.join(parts)}."
    ]


def prices_of_turning(one: str, other: str, frame: pd.DataFrame) -> dict[float, list[tuple[float, float]]]:
    """By rpm the mean power (W) of either machine at the rod and at the terminals, over the cases that both have."""
    turning = frame[(frame["rpm"] > 0) & frame[POWER].notna() & frame["outcome"].eq(COMPLETED)]
    first, second = (turning[turning["machine"] == name].set_index(CASE) for name in (one, other))
    common = first.index.intersection(second.index)
    first, second = first.loc[common], second.loc[common]
    found = {}
    for rpm in sorted(common.unique("rpm")):
        here = common.get_level_values("rpm") == rpm
        found[rpm] = [
            (float(first.loc[here, name].mean()), float(second.loc[here, name].mean())) for name in (POWER, TERMINALS)
        ]
    return found


def turn_alike(one: str, other: str, frame: pd.DataFrame) -> bool:
    """Whether turning takes the same power on both, as with the same friction around the rod."""
    rods = [rod for rod, _ in prices_of_turning(one, other, frame).values()]
    return bool(rods) and all(abs(first / second - 1.0) <= ALIKE_POWER for first, second in rods)


def friction_model(spec: ComparisonTable, found: Mapping[Cell, Verdict]) -> list[str]:
    """In how many cells measured load pressure does as well as a friction model, at rest."""
    words = [related(spec, *pair).word for verdict in found.values() if (pair := families(verdict)) is not None]
    if not words:
        return []
    counts = {word: words.count(word) for word in ("beats", "is level with", "loses to", "cannot be told from")}
    return [
        f"What a friction model is worth at rest: inverting the valve by measured load pressure, without one, beats "
        f"the best with one in {counts['beats']} of {len(words)} cells that have both, is level in "
        f"{counts['is level with']}, loses in {counts['loses to']}, cannot be told in {counts['cannot be told from']}."
    ]


def pump(frame: pd.DataFrame) -> list[str]:
    """How rotating changes what the pump pays: the same controller, motion and draw at rest and turning.

    What a loop that hunts takes is no price of rotation.
    """
    places = frame[["machine", "scenario", "controller", "rpm"]].itertuples(index=False, name=None)
    hunting = {key for key, (draws, _) in hunting_draws(frame).items() if draws}
    frame = frame[[place not in hunting for place in places]]
    key = ["machine", "scenario", "reference", "controller", "draw"]
    rest = frame[frame["rpm"] == 0].set_index(key)[PUMP].rename("rest")
    pairs = frame[frame["rpm"] > 0].join(rest, on=key).dropna(subset=[PUMP, "rest"])
    pairs = pairs[pairs["outcome"].eq("completed") & (pairs["rest"] > 0.0)]
    if pairs.empty:
        return []
    ratios = pairs.groupby(["reference"], sort=False)[[PUMP, "rest"]].mean()
    change = {str(name): row[PUMP] / row["rest"] - 1.0 for name, row in ratios.iterrows()}
    told = ", ".join(f"{plain_name(name)} {_percent(value)}" for name, value in change.items())
    still = all(abs(value) <= ALIKE for value in change.values())
    verb = "does not change" if still else "changes"
    return [
        f"Rotating {verb} what the pump pays (change by motion, same controllers and draws, none that hunts: {told})."
    ]


def _percent(share: float) -> str:
    return f"{round(100.0 * share, 1) + 0.0:+.1f} %"  # no negative zero


def real_speed(machine: str, frame: pd.DataFrame) -> list[str]:
    """Whether the rod turns as fast as it is told to."""
    turning = frame[(frame["rpm"] > 0) & frame["rotation_speed_mean_rpm"].notna()]
    if turning.empty:
        return []
    off = turning["rotation_speed_mean_rpm"] / turning["rpm"] - 1.0
    wrong = off.abs() > TOLD_SPEED
    furthest = max(off, key=abs)
    slow = turning["below_stribeck_fraction"]
    sentence = (
        f"{on(machine)} the mean real speed is more than {100 * TOLD_SPEED:g} % off the command in {wrong.sum()} of "
        f"{len(turning)} turning cases (furthest {_percent(furthest)})"
    )
    if slow.notna().any():
        sentence += f"; the contact is below the Stribeck speed for {_percent(slow.mean())[1:]} of their time"
    return [f"{sentence}."]


def motor(spec: ComparisonTable, machine: str, frame: pd.DataFrame) -> list[str]:
    """What the motor has to deliver, speed by speed, and whether it is at a limit."""
    turning = frame[(frame["rpm"] > 0) & frame["motor_torque_rms_N_m"].notna()]
    if turning.empty:
        return []
    most = turning.groupby("rpm")["motor_torque_rms_N_m"].max()
    told = ", ".join(f"{torque:.2g} at {rpm:g}" for rpm, torque in most.items())
    above = [f"{rpm:g}" for rpm, torque in most.items() if torque > spec.nominal_torque]
    nominal = f"its nominal {spec.nominal_torque:g} N m"
    said = f"above {nominal} at {', '.join(above)} rpm" if above else f"not above {nominal}"
    limited = int((frame["outcome"] == "torque-limited").sum())
    return [
        f"{on(machine)} the motor needs up to (N m rms at rpm) {told}: {said}; {limited} of {len(turning)} turning "
        "cases are torque-limited."
    ]


def hunting(frame: pd.DataFrame) -> list[str]:
    """Who hunts in which scenario, in how many draws and how far; and where nobody does."""
    frame = with_all_axes(frame)
    judged = frame.dropna(subset=["limit_cycle"])
    if judged.empty:
        return ["Hunting was not judged: no reference holds still."]
    lines = []
    for (machine, scenario), rows in judged.groupby(["machine", "scenario"], sort=False):
        name = cell_name(Cell(str(machine), str(scenario), ""), machine=True).strip()
        bad = rows[rows["limit_cycle"].isin(HUNTING)]
        if bad.empty:
            lines.append(f"Hunting, {name}: none of {len(rows)} cases that hold still.")
            continue
        parts = [_who(str(controller), group, rows) for controller, group in bad.groupby("controller", sort=False)]
        lines.append(f"Hunting, {name}: {len(bad)} of {len(rows)} cases that hold still. {' '.join(parts)}")
    return lines


def _who(controller: str, bad: pd.DataFrame, rows: pd.DataFrame) -> str:
    """At which speeds a controller hunts, how far at most, and at which it does not."""
    own = rows.loc[rows["controller"] == controller, "rpm"]
    speeds = sorted(bad["rpm"].unique())
    quiet = sorted(set(own) - set(speeds))
    amplitude = bad["limit_cycle_amplitude_m"].max() * MM
    size = "" if pd.isna(amplitude) else f", up to {amplitude:.3g} mm peak to peak"
    rest = f"; not at {_speeds(quiet)}" if quiet else ""
    return f"{plain_name(controller)} hunts at {_speeds(speeds)} rpm{size}{rest}."


def _speeds(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def exactness(spec: ComparisonTable, frame: pd.DataFrame) -> str:
    """In words, of how many cases the error is hardly larger than that of their integration, where that is told."""
    frame = frame[frame["solver_error_m"].notna()]
    steps = frame["reference"].isin(spec.steps)
    error = np.where(steps, frame["steady_state_max_error_m"], frame["rms_error_m"])
    doubtful = np.where(steps, frame["solver_error_m"], frame["solver_rms_error_m"]) > 0.1 * error
    told = doubtful & (error > spec.negligible)
    words = (
        f"Of {len(frame)} cases whose solver error was found, {doubtful.sum()} have one above 10 % of their error; in "
        f"{told.sum()} of these the error is above {spec.negligible * MM:g} mm"
    )
    rows = frame[told].assign(error=error[told]).sort_values("error", ascending=False)
    names = [
        f"{plain_name(str(row.controller))} at {row.rpm:g} rpm, "
        f"{cell_name(Cell(str(row.machine), str(row.scenario), str(row.reference)), machine=True)}"
        for row in rows.head(MOST_NAMED).itertuples()
    ]
    more = f", and {len(rows) - MOST_NAMED} more" if len(rows) > MOST_NAMED else ""
    return f"{words}{': ' if names else ''}{'; '.join(names)}{more}."

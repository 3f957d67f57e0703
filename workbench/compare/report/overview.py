"""What the verdicts say together: the answer by machine, between machines, and what follows for power, pump, motor and
hunting.
"""

import math
from collections.abc import Mapping, Sequence

from workbench.compare.agreement import agreement
from workbench.compare.candidates import MM, TOLD_SPEED, Cell
from workbench.compare.exactness import DOUBTFUL, exactness
from workbench.compare.finalists import related
from workbench.compare.hunting import Hunter, hunting_places
from workbench.compare.report.words import ALIKE, families
from workbench.compare.result import Change, Comparison, Verdict
from workbench.compare.schema import ComparisonTable
from workbench.compare.turning import (
    MotorLoad,
    RealSpeed,
    TurningPrice,
    motor_load,
    prices_of_turning,
    pump_changes,
    real_speed,
    turn_alike,
)
from workbench.compare.verdicts import within
from workbench.publish.tables import shown_number
from workbench.publish.words import plain_name, watts

MOST_NAMED = 5
"""Cases named in one sentence."""


def answer(comparison: Comparison) -> list[str]:
    """The verdicts of each machine in a sentence: what stands above everything."""
    return [by_machine(comparison.table, machine, comparison.of(machine)) for machine in comparison.machines]


def overview(comparison: Comparison) -> list[str]:
    """What follows from the verdicts. Of several machines each other is held against the first, prices told once."""
    machines, tuned = comparison.machines, comparison.tuned
    lines = []
    for i, other in enumerate(machines[1:], start=1):
        lines.append(between(comparison, machines[0], other))
        if not any(turn_alike(tuned, known, other) for known in machines[:i]):
            lines += around_the_rod(machines[0], other, prices_of_turning(tuned, machines[0], other))
    lines += friction_model(comparison)
    lines += pump(pump_changes(tuned))
    for machine in machines:
        rows = comparison.every_run[comparison.every_run["machine"] == machine]
        speed, load = real_speed(rows), motor_load(rows)
        lines += [] if speed is None else [speed_sentence(machine, speed)]
        lines += [] if load is None else [motor_sentence(comparison.table, machine, load)]
    return lines


def on(machine: str) -> str:
    """The words in front of a sentence about one machine."""
    return f"On {plain_name(machine)}" if machine else "Here"


def by_machine(table: ComparisonTable, machine: str, verdicts: Mapping[Cell, Verdict]) -> str:
    """How many cells of a machine have which verdict, and which; those that ask for more than plain control first.

    Where nothing beats plain control at rest it may still err by more than counts: that is told.
    """
    kinds: dict[str, list[str]] = {}
    for cell in sorted(verdicts, key=lambda cell: verdicts[cell].kind == "nothing needed"):
        kinds.setdefault(verdicts[cell].kind, []).append(cell.words)
    told = "; ".join(f"{kind} in {len(names)} ({', '.join(names)})" for kind, names in kinds.items())
    first = f"{on(machine)}, of {len(verdicts)} cells: {told}."
    if len(kinds) == 1:
        first = f"{on(machine)}: {next(iter(kinds))} in all {len(verdicts)} cells."
    needed = {cell: verdict for cell, verdict in verdicts.items() if verdict.kind == "nothing needed"}
    open_ = [cell.words for cell, verdict in needed.items() if not within(table, verdict.best["nothing"])]
    if not open_:
        return first
    return f"{first} Not within {table.negligible * MM:g} mm, and nothing helps: {', '.join(open_)}."


def between(comparison: Comparison, first: str, second: str) -> str:
    """In which cells two machines have another verdict."""
    moved = {cell._replace(machine=first): verdict for cell, verdict in comparison.of(second).items()}
    held = agreement(comparison.of(first), moved)
    names = f"{plain_name(first)} and {plain_name(second)}"
    if not held.moved:
        return f"Between {names} no verdict of {held.cells} differs."
    told = "; ".join(f"{cell.words} ({here}, {there})" for cell, (here, there) in held.moved.items())
    return f"Between {names} {len(held.moved)} of {held.cells} verdicts differ: {told}."


def around_the_rod(first: str, second: str, prices: Sequence[TurningPrice]) -> list[str]:
    """What the friction around the rod makes of the price: power at equal speed, on the same cases."""
    parts = [
        f"{price.rpm:g} rpm: {watts(price.rod[0])} and {watts(price.rod[1])} at the rod "
        f"(ratio {shown_number(price.rod[0] / price.rod[1], 2)}), "
        f"{watts(price.terminals[0])} and {watts(price.terminals[1])} at the terminals"
        for price in prices
    ]
    if not parts:
        return []
    return [
        f"What the friction around the rod makes of the price of turning it (means over the motions, where the rod "
        f"turns as told), on {plain_name(first)} and on {plain_name(second)}: {'; '.join(parts)}."
    ]


def friction_model(comparison: Comparison) -> list[str]:
    """In how many cells measured load pressure does as well as a friction model, at rest."""
    pairs = [pair for verdict in comparison.verdicts.values() if (pair := families(verdict)) is not None]
    words = [related(comparison.table, *pair).word for pair in pairs]
    if not words:
        return []
    return [
        f"What a friction model is worth at rest: inverting the valve by measured load pressure, without one, beats "
        f"the best with one in {words.count('beats')} of {len(words)} cells that have both, is level in "
        f"{words.count('is level with')}, loses in {words.count('loses to')}, cannot be told in "
        f"{words.count('cannot be told from')}."
    ]


def pump(changes: Mapping[str, float]) -> list[str]:
    """How rotating changes what the pump pays, by reference; nothing where nothing turns."""
    if not changes:
        return []
    told = ", ".join(f"{plain_name(name)} {_percent(share)}" for name, share in changes.items())
    still = all(abs(share) <= ALIKE for share in changes.values())
    verb = "does not change" if still else "changes"
    return [
        f"Rotating {verb} what the pump pays (change by motion, same controllers and draws, none that hunts: {told})."
    ]


def _percent(share: float) -> str:
    return f"{round(100.0 * share, 1) + 0.0:+.1f} %"  # no negative zero


def speed_sentence(machine: str, speed: RealSpeed) -> str:
    """Whether the rod turns as fast as it is told to."""
    sentence = (
        f"{on(machine)} the mean real speed is more than {100 * TOLD_SPEED:g} % off the command in {speed.off} of "
        f"{speed.cases} turning cases (furthest {_percent(speed.furthest)})"
    )
    if speed.below_stribeck is not None:
        sentence += f"; the contact is below the Stribeck speed for {_percent(speed.below_stribeck)[1:]} of their time"
    return f"{sentence}."


def motor_sentence(table: ComparisonTable, machine: str, load: MotorLoad) -> str:
    """What the motor has to deliver, speed by speed, and whether it is at a limit."""
    told = ", ".join(f"{torque:.2g} at {rpm:g}" for rpm, torque in load.torques.items())
    above = load.above(table.nominal_torque)
    nominal = f"its nominal {table.nominal_torque:g} N m"
    limit = f"above {nominal} at {_speeds(above)} rpm" if above else f"not above {nominal}"
    return (
        f"{on(machine)} the motor needs up to (N m rms at rpm) {told}: {limit}; {load.limited} of {load.cases} turning "
        "cases are torque-limited."
    )


def hunting_sentences(comparison: Comparison, scenario: str) -> list[str]:
    """Who hunts in a scenario, in how many cases and how far; and where nobody does."""
    runs = comparison.every_run
    places = hunting_places(runs[runs["scenario"] == scenario])
    if not places:
        return ["Hunting was not judged: no reference holds still."]
    lines = []
    for place in places:
        if not place.hunters:
            lines.append(f"Hunting, {place.words}: none of {place.cases} cases that hold still.")
            continue
        who = " ".join(_who(hunter) for hunter in place.hunters)
        lines.append(f"Hunting, {place.words}: {place.hunting} of {place.cases} cases that hold still. {who}")
    return lines


def _who(hunter: Hunter) -> str:
    """At which speeds a controller hunts, how far at most, and at which it does not."""
    size = "" if math.isnan(hunter.amplitude) else f", up to {hunter.amplitude * MM:.3g} mm peak to peak"
    rest = f"; not at {_speeds(hunter.quiet)}" if hunter.quiet else ""
    return f"{plain_name(hunter.controller)} hunts at {_speeds(hunter.speeds)} rpm{size}{rest}."


def _speeds(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def exactness_sentence(comparison: Comparison) -> str:
    """Of how many cases the error is hardly larger than that of their integration, where that is told."""
    table = comparison.table
    exact = exactness(table, comparison.tuned)
    words = (
        f"Of {exact.cases} cases whose solver error was found, {exact.doubtful} have one above {100 * DOUBTFUL:g} % of "
        f"their error; in {len(exact.counting)} of these the error is above {table.negligible * MM:g} mm"
    )
    names = [
        f"{plain_name(case.controller)} at {case.rpm:g} rpm, {case.cell.whole_words}"
        for case in exact.counting[:MOST_NAMED]
    ]
    more = f", and {len(exact.counting) - MOST_NAMED} more" if len(exact.counting) > MOST_NAMED else ""
    return f"{words}{': ' if names else ''}{'; '.join(names)}{more}."


def change_sentence(change: Change) -> str:
    """Which verdicts another condition would change."""
    held = change.agreement
    if not held.moved:
        return f"{change.condition}, 0 of {held.cells} verdicts would be others."
    told = "; ".join(f"{cell.whole_words} ({other} in place of {now})" for cell, (now, other) in held.moved.items())
    return f"{change.condition}, {len(held.moved)} of {held.cells} verdicts would be others: {told}."

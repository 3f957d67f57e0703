"""A decision in words: what was asked, what rotating costs, what was assumed."""

import pandas as pd

from workbench.decide.order import ALIKE
from workbench.decide.report.names import (
    ERRORS,
    MM,
    POWERS,
    confidence,
    deviations,
    speed_of,
    watts,
)
from workbench.decide.result import Decision
from workbench.decide.run import enough
from workbench.decide.schema import MOTOR, PUMP
from workbench.publish.words import plain_name
from workbench.simulation.simulate import COMPLETED
from workbench.study.uncertainty_schema import drawn_from
from workbench.toml.gain_file import KEY


def question(decision: Decision) -> str:
    """What was asked."""
    table = decision.table
    whom = f" of the {plain_name(table.machine)}" if table.machine else ""
    motion = f"a sine of {table.amplitude * MM:g} mm, {1.0 / table.period(table.speed):.3g} Hz"
    drawn = (
        f", with a probability of at least {table.probability:g} over machines whose friction is spread by "
        + deviations(table.spread)
    )
    return (
        f"Asked{whom}: {'an' if table.figure == 'rms_error' else 'a'} {ERRORS[table.figure]} of at most "
        f"{table.accuracy * MM:g} mm at {speed_of(table.speed)} ({motion}) with at most {table.power:g} W "
        f"({POWERS[table.power_figure]}){drawn if decision.plan.several else ', on the declared machine'}."
    )


def price(decision: Decision) -> str:
    """What rotating adds where it was asked, and whether it changes what the pump pays; empty if nothing rotates."""
    pairs = _turning_and_still(decision)
    if pairs.empty:
        return ""
    by_rpm = pairs.groupby("rpm")[[PUMP, f"{PUMP}_still", MOTOR]].mean()
    pump, still = float(pairs[PUMP].mean()), float(pairs[f"{PUMP}_still"].mean())
    most = float((by_rpm[PUMP] / by_rpm[f"{PUMP}_still"] - 1.0).abs().max())
    added = ", ".join(f"{watts(row[MOTOR])} at {rpm:g} rpm" for rpm, row in by_rpm.iterrows())
    kept = (
        f"rotating does not change what the pump pays (by {100.0 * most:.2g} % at most)"
        if most < ALIKE
        else f"rotating changes what the pump pays, by up to {100.0 * most:.2g} %"
    )
    return (
        f"Rotating adds {added} at the motor's terminals. On the same machines with the same controllers the pump pays "
        f"{watts(pump)} while the rod rotates and {watts(still)} while it does not: {kept}."
    )


def _turning_and_still(decision: Decision) -> pd.DataFrame:
    """Runs of the search that rotate where it was asked, each beside the one at rest of its controller and machine."""
    table, rows = decision.table, decision.draws
    asked = rows[
        (rows["stage"] == "search")
        & (rows["speed_m_per_s"] == table.speed)
        & (rows["spread"] == table.spread)
        & (rows["outcome"] == COMPLETED)
    ].dropna(subset=[PUMP])
    still = asked.loc[asked["rpm"] == 0, ["controller", "draw", PUMP]]
    turning = asked[asked["rpm"] != 0].dropna(subset=[MOTOR])
    return turning.merge(still, on=["controller", "draw"], suffixes=("", "_still"))


def assumptions(decision: Decision) -> list[str]:
    """What was assumed: what the draws are, how a run is judged, whose gains these are; then the study's own lines."""
    table, study = decision.table, decision.plan.study
    gains = study.file.controllers
    tuned = [plain_name(name) for name, _ in decision.plan.candidates if KEY in gains[name]]
    tuned = list(dict.fromkeys(tuned))
    return [
        _machines(decision),
        *([_procedure(decision)] if decision.plan.several else []),
        f"Each run: {table.cycles} periods of the sine, of which the first is left out. A run that does not simply "
        "complete (diverged, stuck, end stop, saturated throughout, torque-limited) does not meet the accuracy. A "
        f"loop that hunts while a step is held for {table.hold_duration:g} s on one of its machines is out, however "
        "accurate it is in motion.",
        "Controllers believe the plant as declared, whatever is drawn. "
        + (f"Tuned gains: {', '.join(tuned)}; all others as the study gives them." if tuned else "No gains are tuned."),
        "Plain: " + ", ".join(map(plain_name, table.plain)) + ". What suffices is the simplest that does: plain "
        "control before compensation before rotation before both; within a kind the least power, and of powers within "
        f"{100.0 * ALIKE:g} % of each other the least error.",
        *table.assumptions,
    ]


def _procedure(decision: Decision) -> str:
    """How a choice is made of draws, in words."""
    plan, table = decision.plan, decision.table
    return (
        f"The {plan.draws} draws of the search only say what is out (its 95 % interval is below what is asked, or it "
        "hunts) and in which order the others are measured again, at most "
        f"{table.contenders} of each kind; probabilities of "
        f"those come from {plan.fresh_draws} fresh draws alone, so that having been picked flatters none. All their "
        f"intervals together hold with {confidence()} (exact binomial intervals, the i-th measured at 1 - 0.05/(i (i + "
        f"1))). For the first that is measured, {enough(table.probability, plan.fresh_draws)}."
    )


def _machines(decision: Decision) -> str:
    """What is drawn, in words."""
    uncertainty, plant = decision.plan.study.file.uncertainty, decision.plan.plant
    if uncertainty is None:
        return "One machine, the declared one: the study has no [uncertainty]."
    friction = f'friction by the standard deviations of "{plant.get("parameters")}" times the spread'
    parts = [friction, *drawn_from(uncertainty)]
    return (
        f"Machines are drawn (seed {uncertainty.seed}), the same for every candidate, speed and spread: "
        f"{'; '.join(parts)}."
    )

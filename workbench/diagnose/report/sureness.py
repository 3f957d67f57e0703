"""How sure a diagnosis is, a line each: what speaks for an effect, what stopped the others, what is left over the
floor, what simulation says, which parameters the records do not identify, and what was done to
the records.
"""

from collections.abc import Mapping, Sequence

from plants.effects.registry import effects
from workbench.diagnose.report.names import listed_names, percent
from workbench.diagnose.report.parameters import Row, not_held, parameter_rows, plant_of
from workbench.diagnose.report.series import words_of
from workbench.diagnose.report.verdict import NOISE, dependence_words, follows_held_out, held_out_floors, worse
from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.result import FAR, BeforeAfter, Diagnosis, Errors, FittedParameter, FoundEffect
from workbench.diagnose.selection.selection import BalanceResult, Candidate
from workbench.diagnose.selection.sets import AT_FLOOR
from workbench.diagnose.selection.unexplained import LEAST, OfferedTerm, curve_over
from workbench.diagnose.simulation.by_curve import Curved
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.publish.along import SHOWN
from workbench.publish.tables import shown_number
from workbench.publish.words import listed, plain_name
from workbench.toml.units import factor

QUIET = 100.0
"""Floors that only the floor's smallness makes, where the simulated plant fits."""

AWAY = 1e6
"""Floors that nothing measured leaves: what is carried along the motion, as a load that swings, has gone beyond all
bounds.
"""


def sureness(diagnosis: Diagnosis) -> list[str]:
    """How sure the verdict is, a line each: evidence, what remains over the floor, what the records do not show."""
    unexplained = diagnosis.unexplained
    names = [effect.name for effect in diagnosis.effects]
    lines = [_of_effect(diagnosis, effect) for effect in diagnosis.effects]
    lines += [_of_floor(diagnosis, result) for result in diagnosis.results]
    for result in diagnosis.rounds:
        best = result.steps[0].candidates[0].effect if result.steps[0].candidates else None
        if best not in [None, *names] and not result.steps[0].added:
            lines.append(why_none(result))
    lines += _of_simulation(diagnosis)
    lines += _of_worse(diagnosis)
    if unexplained is not None and diagnosis.verdict != "unexplained":
        depends = dependence_words(unexplained.dependence, diagnosis.axis)
        lines.append(f"What remains is not explained: {depends}; no known effect explains it.")
    if unexplained is not None:
        is_curve = diagnosis.simulation is not None and diagnosis.simulation.curved is not None
        lines.append(of_term(unexplained.term, is_curve=is_curve))
        plant, over = plant_of(diagnosis), unexplained.dependence.signals
        if curve_over(plant, unexplained.balance, unexplained.term.signal) is None:
            balance = SHOWN[diagnosis.axis].said(unexplained.balance)
            lines.append(
                f"plant.toml offers no curve for it: {plant.name} can have none of the {balance} balance over "
                f"{listed_names(over, 'or')}."
            )
    elif far := _far(diagnosis):
        lines.append(
            f"What is left of the {listed(far)} balance is not called unexplained, since it depends on no measured "
            f"signal by more than {percent(LEAST)} of its variance: nothing measured says what is missing."
        )
    lines += _of_parameters(diagnosis)
    lines.append(_of_held(diagnosis))
    if (lost := not_held(diagnosis)) and not diagnosis.is_rejected:
        lines.append(
            f"plant.toml does not have {listed_names(lost)}, which {plant_of(diagnosis).name} cannot "
            "hold: it is not the corrected plant, but the declared one with its own parameters fitted without effects."
        )
    if not diagnosis.errors.held_out.before.by_key:
        lines.append("There is no held-out record: nothing tests what was found on data that it has not seen whole.")
    every = [*diagnosis.results[0].balance.motions, *diagnosis.held_out]
    lines += [f"{motion.record.label}: {note}." for motion in every for note in motion.record.notes]
    return lines


def _of_effect(diagnosis: Diagnosis, effect: FoundEffect) -> str:
    """What an effect is, and what speaks for it."""
    evidence = effect.evidence
    text = f"{plain_name(effect.name).capitalize()}: {effects(diagnosis.axis)[effect.name].words} "
    text += f"({effects()[effect.name].source})."
    if evidence.left_out_gain is not None:
        text += f" It lowers the residual by {percent(evidence.left_out_gain, 1)}"
        text += (
            f" and stands out of its noise by {shown_number(evidence.standard_errors or 0.0, 3)} standard deviations."
        )
    elif evidence.sum_rms is not None and evidence.left_rms is not None:
        before, after = (f"{1e-3 * rms:.3g}" for rms in (evidence.sum_rms, evidence.left_rms))
        text += f" The sum of both pressures is off by {before} kPa rms; one constant leaves {after} kPa of it."
    if effect.alternatives:
        text += f" As good within its scatter: {listed_names(effect.alternatives)}."
    return text + "".join(f" But {remark}." for remark in effect.remarks)


def _of_floor(diagnosis: Diagnosis, result: BalanceResult) -> str:
    """What is left of a balance in floors, on the records that were fitted and on those that were not."""
    fitted, tested = result.after.rms, held_out_floors(diagnosis, result)
    if not fitted < AWAY:
        return f"The {words_of(result.balance)} balance runs away along the measured motion, and tells nothing."
    times = f"{shown_number(fitted, 3)} times its noise floor"
    if result.balance.spread is not None:
        times += f" (from draw to draw of that noise ± {shown_number(100.0 * result.balance.spread, 2)} %)"
    times += f", and {shown_number(tested, 3)} times on held-out records" if tested else ""
    if fitted > QUIET and diagnosis.simulation is not None and diagnosis.simulation.is_trusted:
        reason = "of sensors so quiet, smoothing and sampling leave most of it"
    elif fitted >= NOISE > tested > 0.0:
        reason = "the sensors' noise explains all of it on the held-out records, but not on those that were fitted"
    elif fitted >= NOISE:
        reason = "not all of it is the sensors' noise"
    elif tested >= NOISE and follows_held_out(diagnosis):
        reason = (
            "the sensors' noise explains all of it on the records that were fitted; the held-out ones move otherwise, "
            "where that is no floor, and the simulated plant follows them within their noise"
        )
    elif tested >= NOISE:
        reason = "the sensors' noise explains all of it on the records that were fitted, but not on the held-out ones"
    else:
        reason = "the sensors' noise explains all of it"
    return f"What is left of the {words_of(result.balance)} balance is {times}: {reason}."


def why_none(result: BalanceResult) -> str:
    """Why no effect was added to a balance: what stopped the best one."""
    best = result.steps[0].candidates[0]
    where = "simulated plant" if result.balance.name == SIMULATION else f"{words_of(result.balance)} balance"
    return (
        f"No {'further ' * bool(result.effects)}effect was added to the {where}{_beside(result)}: the best, "
        f"{plain_name(best.effect)}, stands "
        f"out by {best.deviations:.1f} standard deviations of the noise, {_stopped(best, result.steps[0].before)}."
    )


def _beside(result: BalanceResult) -> str:
    """What a balance had from the beginning."""
    return f", which has {listed_names(result.effects)}" if result.effects else ""


def _stopped(best: Candidate, before: Fit) -> str:
    """The rule that stopped a candidate for a balance, which is as `before` without it."""
    if before.rms <= AT_FLOOR:
        return "but the balance is at its noise floor without any"
    if best.gain <= best.asked:
        return f"where {best.asked_deviations:.1f} are asked of one among so many"
    if best.fit is not None and (ended := sorted(best.fit.bounded - set(best.fit.balance.free))):
        return f"but {listed(ended)} ran to the end of its range, and so is no estimate"
    return (
        "but it was not taken: it takes too little of the residual, or not on parts that were left out of its fit, or "
        "by its own deviation it may as well do nothing, or a plant that lacks nothing would gain as much, or what it "
        "leaves depends on a signal, so that it stands in for something else"
    )


def _of_simulation(diagnosis: Diagnosis) -> list[str]:
    """What the simulated plant says, and how far a free run of a held-out record can be believed."""
    simulation, lines = diagnosis.simulation, list[str]()
    if simulation is None:
        return lines
    pieces = simulation.starts_anew_every
    along = "from end to end" if pieces is None else f"in pieces of {pieces:g} s, since it runs away before the end"
    if simulation.is_beside:
        along = "beside its records, whose force has the noise of a sensor, as it foresees the next position,"
    if simulation.loop is not None:
        along = (
            f"from end to end, led by a loop of {shown_number(simulation.loop, 2)} rad/s that it does not do without,"
        )
    without = f", {shown_number(simulation.before.rms, 3)} without what was found" if diagnosis.effects else ""
    error = (
        f"is off by {shown_number(simulation.after.rms, 3)} standard deviations of the sensors' noise{without}; "
        "the parameters are of this fit"
    )
    if simulation.loop is not None:
        error += ", whose deviations take the loop's force for known and may be several times too small"
    if simulation.curved is not None:
        error = _with_curve(simulation, simulation.curved, diagnosis.axis)
    elif not simulation.is_trusted:
        error = "is off by far more than the sensors' noise; the parameters are those that fit the balances"
    lines.append(f"Simulated {along} and fitted to the fit records, the plant {error}.")
    if dropped := [effect for effect in simulation.dropped if effect not in simulation.refuted]:
        lines.append(_of_dropped(dropped, simulation))
    if simulation.refuted:
        lines.append(
            f"The search found {listed_names(simulation.refuted)}, not named here: without, the plant follows the "
            "held-out records within noise, and they are likelier."
        )
    if simulation.stood_in:
        lines.append(
            f"The search found {listed_names(simulation.stood_in)}, not named here: one curve over a signal does in "
            "their place, or what is left beside them says more than they do."
        )
    if diagnosis.errors.written is not None:
        lines += _of_written(diagnosis, *diagnosis.errors.written)
    if diagnosis.errors.with_curve is not None:
        lines += _of_curve(diagnosis, *diagnosis.errors.with_curve)
    own, after = diagnosis.errors.own_parameters, diagnosis.errors.held_out.after
    if own is not None and own.after.position is not None and after.position is not None:
        off, left, plain = (
            SHOWN[diagnosis.axis].length(errors.position or 0.0, 2) for errors in (after, own.after, own.before)
        )
        without = f", {plain} without what was found" if diagnosis.effects and own.before.position is not None else ""
        lines.append(
            f"A free run of the held-out records is off by {off} in position. "
            f"With the same parameters fitted to these records themselves {left} "
            f"would be left{without}: so much of it is the model's, and the rest is drift, as small forces that differ "
            "between records add up."
        )
    return lines


def _with_curve(simulation: SimulationStage, by_curve: Curved, axis: str) -> str:
    """What a plant is off by that a curve brings near its records."""
    balance, curve = SHOWN[axis].said(by_curve.dependence.balance), by_curve.fitted
    return (
        f"is off by {shown_number(simulation.after.rms, 3)} standard deviations of the sensors' noise; with a curve "
        f"over {plain_name(curve.signal)} for what the {balance} balance lacks, fitted beside its parameters, by "
        f"{shown_number(by_curve.simulated.fit.rms, 3)}. The parameters are of that fit, and go with the curve"
    )


def _of_curve(diagnosis: Diagnosis, fitted: Errors, tested: Errors) -> list[str]:
    """What a free run does with a curve that is switched on, and without."""
    shown, told = SHOWN[diagnosis.axis], list[str]()
    without = diagnosis.errors.fit.after, diagnosis.errors.held_out.after
    for one, before, records in zip((fitted, tested), without, ("fit", "held-out"), strict=True):
        if one.position is not None:
            plain = f" ({shown.length(before.position, 2)} at best without)" if before.position is not None else ""
            told.append(f"{shown.length(one.position, 2)}{plain} on the {records} records")
    return [f"With that curve switched on a free run is off in position by {listed(told)}."] if told else []


def _of_written(diagnosis: Diagnosis, fitted: BeforeAfter, tested: BeforeAfter) -> list[str]:
    """What the parameters of plant.toml do in a free run, where the table has those of fits to free runs."""
    shown, told = SHOWN[diagnosis.axis], list[str]()
    for one, records in ((fitted, "fit"), (tested, "held-out")):
        before, after = one.before.position, one.after.position
        if after is not None:
            without = f" ({shown.length(before, 2)} without what was found)" if diagnosis.effects and before else ""
            told.append(f"{shown.length(after, 2)}{without} on the {records} records")
    if not told:
        return []
    return [
        f"Free runs in the table have parameters of their own; with those of plant.toml one is off by {listed(told)}."
    ]


def _of_dropped(dropped: Sequence[str], simulation: SimulationStage) -> str:
    """Why effects that were added to balances are not named."""
    added = f"Added to the balances, and not named here: {listed_names(dropped)}. Simulated along the records"
    if simulation.is_near:
        return f"{added}, the plant does as well without."
    return (
        f"{added}, the plant comes no nearer to them with what was added; but without it comes near them neither, so "
        "that the balances may be right: look at what is declared and held."
    )


def _of_worse(diagnosis: Diagnosis) -> list[str]:
    """Figures of held-out records that get worse with what was found, and yet do not reject it."""
    if diagnosis.is_rejected or not diagnosis.effects or not (figures := worse(diagnosis)):
        return []
    trusted = diagnosis.simulation is not None and diagnosis.simulation.is_trusted
    judge = "balances that have effects"
    if trusted:
        likelier = diagnosis.errors.gained is not None and diagnosis.errors.gained > 0.0
        judge = "likelihood of the free run, which rises" if likelier else "free run"
    return [
        f"Not all gets better on held-out records: worse is {listed(figures)}. It does not reject what was found, "
        f"which is judged by the {judge}; but a study that simulates the corrected plant should not rest on it."
    ]


def of_term(term: OfferedTerm, *, is_curve: bool = False) -> str:
    """What a data-driven term would do, the curve of a plant that follows or else a mean of what is left, and that it
    is no more than that.
    """
    use, errors = ("held-out", term.held_out) if term.held_out is not None else ("fit", term.fit)
    assert errors is not None  # a residual depends on a signal only where something moves
    shown = {"m^3/s": "cm^3/s"}.get(term.unit, term.unit)
    before, after = (shown_number(factor(term.unit, shown) * rms, 3) for rms in (errors.before, errors.after))
    signal, lowers = plain_name(term.signal), "would lower" if errors.after < errors.before else "would not lower"
    words = f"A data-driven term, the mean of that residual over {signal}, {lowers} it"
    if is_curve:
        words = f"That curve is a data-driven term over {signal}: it {lowers} the balance's residual"
    return (
        f"{words} on the {use} records: "
        f"{before} {shown} without it, {after} {shown} with it, where something moves (report.json has its nodes). It "
        "describes the records and names no cause."
    )


def _far(diagnosis: Diagnosis) -> list[str]:
    """The balances that are far from their floors, whatever the verdict."""
    if diagnosis.simulation is not None and diagnosis.simulation.is_trusted:
        return []
    return [words_of(result.balance) for result in diagnosis.results if result.after.rms > FAR]


def _of_parameters(diagnosis: Diagnosis) -> list[str]:
    """Which parameters the records do not identify: without effects, and with those that were found."""
    rows = parameter_rows(diagnosis)
    final = [name for name, row in rows.items() if row.final.doubt]
    if not diagnosis.effects:
        return [f"The records do not identify {listed(final)}: {_doubts(final, rows)}."] if final else []
    first = [name for name, row in rows.items() if row.baseline is not None and row.baseline.doubt]
    lines = []
    if first:
        why = _reasons([row.baseline for row in rows.values() if row.baseline is not None])
        lines.append(f"Without effects (baseline) the records do not identify {listed(first)}: {why}.")
    if final:
        lines.append(f"With what was found the records do not identify {listed(final)}: {_doubts(final, rows)}.")
    elif first:
        lines.append("With what was found they identify every parameter that was fitted.")
    return lines


def _of_held(diagnosis: Diagnosis) -> str:
    """What deviations rest on: values that are held, exactly or by what is declared of them."""
    priors = list(dict.fromkeys(name for result in diagnosis.results for name in result.balance.priors))
    if priors:
        of_them = "it" if len(priors) == 1 else "them"
        return (
            f"{listed(priors)} moved within what is declared of {of_them}, and deviations count that; all else that is "
            "held they take for exact."
        )
    return (
        "Deviations take what is held for exact, mass and areas too: a std beside a value in the parameter file lets "
        "it be off by that much, and widens them."
    )


def _doubts(names: list[str], rows: Mapping[str, Row]) -> str:
    """Why parameters are not identified, and what plant.toml has of them."""
    return f"{_reasons([rows[name].final for name in names])}. In plant.toml such a value stands without a deviation"


def _reasons(parameters: Sequence[FittedParameter]) -> str:
    """Why any of these is not identified."""
    return listed(list(dict.fromkeys(one.doubt for one in parameters if one.doubt)), "or")

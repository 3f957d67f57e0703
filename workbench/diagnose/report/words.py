"""A diagnosis in words: one sentence of what was found, and how sure that is."""

from collections.abc import Mapping

from plants.effects import EFFECTS
from workbench.diagnose.before_after import KEYS
from workbench.diagnose.diagnose import WORSE, Diagnosis
from workbench.diagnose.report.names import ERRORS, PLAIN, REJECTED, listed, percent, plain, quantity
from workbench.diagnose.report.parameters import not_held, plant_of
from workbench.diagnose.report.reasons import of_parameters, of_simulation, of_term, why_none
from workbench.diagnose.result import Found
from workbench.diagnose.selection.promising import EXPLAINS
from workbench.diagnose.selection.selection import SURE, BalanceResult, least_gain
from workbench.diagnose.selection.unexplained import LEAST
from workbench.publish.tables import shown_number
from workbench.toml.units import factor

NOISE = 1.2
"""Floors up to which a residual is the sensors' noise."""

FAR = 3.0
"""Floors beyond which a residual is not called explained, whatever the verdict."""

QUIET = 100.0
"""Floors that only the floor's smallness makes, where the simulated plant fits."""


def verdict_sentence(found: Diagnosis) -> str:
    """What was found, in one sentence."""
    verdict = found.report["verdict"]
    effects = [f"{plain(one.name)} ({_numbers(one.numbers)})" for one in found.found]
    if verdict == REJECTED:
        return (
            f"Rejected on held-out records: {listed(effects)} would lower the error of the records that were fitted, "
            "but raises it on records that were not; the plant stays as declared."
        )
    if verdict == "ambiguous":
        pairs = [
            f"the data cannot tell {plain(one.name)} from {listed([plain(name) for name in one.alternatives], 'or')}"
            for one in found.found
            if one.alternatives
        ]
        sure = [text for text, one in zip(effects, found.found, strict=True) if not one.alternatives]
        return f"Ambiguous: {listed(pairs)}." + (f" Found beside: {listed(sure)}." if sure else "")
    if verdict == "effect_found":
        return f"Found: {listed(effects)}."
    if verdict == "unexplained":
        return f"Unexplained: {_dependence(found)}; no known effect explains it."
    if found.simulated is not None and found.simulated.after.rms < FAR:
        return (
            "None missing: the declared plant, with its own parameters fitted and simulated along the records, is off "
            f"by {found.simulated.after.rms:.1f} standard deviations of the sensors' noise, and no known effect lowers "
            "that on data left out."
        )
    most = max(one["after"] for one in found.report["floor"].values())
    if most > FAR:
        return (
            "None missing that is known: no effect lowers the residual on data left out, and it depends on no "
            f"measured signal; but it is {shown_number(most, 2)} times the noise floor: the plant is not complete, "
            "the record moves faster than the smoothing follows, or it holds no noise (as a simulated one may)."
        )
    tested = max((ratio for result in found.results if (ratio := _held_out_floors(found, result))), default=0.0)
    which = "the records that were fitted, but not the held-out ones" if tested >= max(NOISE, most) else "the records"
    beside = f" ({tested:.1f} times on held-out records)" if tested else ""
    return (
        f"None missing: the declared plant, with its own parameters fitted, explains {which}; what is left is "
        f"{most:.1f} times the noise floor{beside}, and no known effect lowers it on data left out."
    )


def _numbers(numbers: Mapping[str, tuple[float, float]]) -> str:
    return ", ".join(f"{name} = {quantity(name, *number)}" for name, number in numbers.items())


def _dependence(found: Diagnosis) -> str:
    one = found.unexplained
    assert one is not None
    shares = [f"{plain(name)} ({percent(one.shares[name])} of its variance)" for name in one.signals]
    return f"the {one.balance} balance's residual depends on {listed(shares)}"


def _of_worse(found: Diagnosis) -> list[str]:
    """Figures of held-out records that get worse with what was found, and yet do not reject it: free runs."""
    errors = found.report["error"]["held_out"]
    if found.report["verdict"] == REJECTED or not found.found or not errors["before"]:
        return []
    worse = [
        f"{words} (from {shown_number(factor(unit, shown) * errors['before'][key], 3)} to "
        f"{shown_number(factor(unit, shown) * errors['after'][key], 3)} {shown})"
        for key, (words, unit, shown) in ERRORS.items()
        if key in errors["before"] and key in errors["after"] and errors["after"][key] > WORSE * errors["before"][key]
    ]
    if not worse:
        return []
    return [
        f"Not all gets better on held-out records: worse is {listed(worse)}. It does not reject what was found, which "
        "is judged by the balances; but a study that simulates the corrected plant should not rest on it."
    ]


def sureness(found: Diagnosis) -> list[str]:
    """How sure the verdict is, a line each: evidence, what remains over the floor, what the records do not show."""
    lines = [_of_effect(found, one) for one in found.found]
    for result in found.results:
        lines.append(_of_floor(found, result))
        best = result.steps[0].candidates[0].effect if result.steps[0].candidates else None
        if best not in [None, *(one.name for one in found.found)] and result.steps[0].added is None:
            lines.append(why_none(result))
    lines += of_simulation(found)
    lines += _of_worse(found)
    if found.unexplained is not None and found.report["verdict"] != "unexplained":
        lines.append(f"What remains is not explained: {_dependence(found)}; no known effect explains it.")
    if found.unexplained is not None and "data_driven_term" in found.report["unexplained"]:
        lines.append(of_term(found.report["unexplained"]))
    if found.unexplained is None and (far := _far(found)):
        lines.append(
            f"What is left of the {listed(far)} balance is not called unexplained, since it depends on no measured "
            f"signal by more than {percent(LEAST)} of its variance: nothing measured says what is missing."
        )
    lines += of_parameters(found)
    if (lost := not_held(found)) and found.report["verdict"] != REJECTED:
        lines.append(
            f"plant.toml does not have {listed([plain(name) for name in lost])}, which {plant_of(found)} cannot hold: "
            "it is not the corrected plant, but the declared one with its own parameters fitted without effects."
        )
    if not found.report["error"]["held_out"]["before"]:
        lines.append("There is no held-out record: nothing tests what was found on data that it has not seen whole.")
    return lines


def _of_effect(found: Diagnosis, one: Found) -> str:
    """What an effect is, and what speaks for it."""
    text = f"{plain(one.name).capitalize()}: {PLAIN.get(one.name, 'see its source')} ({EFFECTS[one.name].source})."
    if "left_out_gain" in one.evidence:
        least = max(least_gain(one.name, len(one.numbers), result.balance) for result in found.results)
        share, sure = one.evidence["left_out_gain"], one.evidence["standard_errors"]
        text += (
            f" It lowers the residual on data that its fit has not seen by {percent(share)}"
            f" ({sure:.1f} standard errors; {percent(least)} and more, and {SURE:g} are asked for)."
        )
        if "explained" in one.evidence:
            share = one.evidence["explained"]
            text += f" Of what the simulated plant was off by beyond noise it explains {percent(share)}; "
            text += f"more than {percent(EXPLAINS)} is asked for."
    elif "sum_rms_Pa" in one.evidence:
        before, after = (f"{1e-3 * one.evidence[key]:.3g}" for key in ("sum_rms_Pa", "left_rms_Pa"))
        text += f" The sum of both pressures is off by {before} kPa rms; one constant leaves {after} kPa of it."
    if one.alternatives:
        text += f" As good within its scatter: {listed([plain(name) for name in one.alternatives])}."
    return text + "".join(f" But {remark}." for remark in one.remarks)


def _of_floor(found: Diagnosis, result: BalanceResult) -> str:
    """What is left of a balance in floors, on the records that were fitted and on those that were not."""
    name, fitted = result.balance.name, found.report["floor"][result.balance.name]["after"]
    tested = _held_out_floors(found, result)
    times = f"{shown_number(fitted, 3)} times its noise floor"
    times += f", and {shown_number(tested, 3)} times on held-out records" if tested else ""
    if fitted > QUIET and found.simulated is not None and found.simulated.is_trusted:
        said = "of sensors so quiet, smoothing and sampling leave most of it"
    elif fitted >= NOISE:
        said = "not all of it is the sensors' noise"
    elif tested >= NOISE:
        said = "the sensors' noise explains all of it on the records that were fitted, but not on the held-out ones"
    else:
        said = "the sensors' noise explains all of it"
    return f"What is left of the {name} balance is {times}: {said}."


def _held_out_floors(found: Diagnosis, result: BalanceResult) -> float:
    """What is left of a balance on held-out records, in floors; 0 without any."""
    left = found.report["error"]["held_out"]["after"].get(KEYS[result.balance.name], 0.0)
    return float(left / result.balance.floor)


def _far(found: Diagnosis) -> list[str]:
    """The balances that are far from their floors, whatever the verdict."""
    if found.simulated is not None and found.simulated.is_trusted:
        return []
    return [name for name, one in found.report["floor"].items() if one["after"] > FAR]

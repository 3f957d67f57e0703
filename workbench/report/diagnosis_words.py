"""A diagnosis in words: one sentence of what was found, how sure that is, and in which units numbers are shown."""

from collections.abc import Mapping
from typing import Any

from plants.effects import EFFECTS
from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.selection import CIRCULAR_GAIN, LEAST_GAIN, PRICE, SURE, is_circular
from workbench.parameters import known_units
from workbench.report.tables import shown_number
from workbench.units import factor

REJECTED = "rejected_on_held_out"

PLAIN = {
    "direction_asymmetry": "friction differs between the two directions",
    "position_dependent_friction": "friction changes along the stroke",
    "pressure_dependent_friction": "friction grows with the load pressure, as of a seal that is pressed by it",
    "frictional_memory": "friction follows the velocity late",
    "rising_static_friction": "break-away friction grows with the time at rest",
    "quadratic_drag": "a resistance grows with the square of the velocity",
    "viscous_drift": "viscous friction changes along the record, as of oil that warms up",
    "constant_load": "a constant force acts on the rod",
    "spring_load": "a force grows with the position, as of a hose or cable that bends",
    "rotation_periodic_force": "a force repeats with every turn of the rod",
    "valve_deadband": "the spool has to move by its overlap before oil flows",
    "internal_leakage": "oil leaks from one chamber into the other",
    "supply_droop": "the supply pressure falls when much oil is taken",
    "entrained_air": "air makes the oil soft at low pressure",
    "unequal_areas": "the second chamber's piston area is not the declared one",
    "command_delay": "the valve gets its command late",
    "backlash": "the position sensor is coupled loosely to the rod",
    "pressure_sensor_offset": "the first pressure sensor is off by a constant",
}
"""What each effect is, for a reader who does not know its name."""

ERRORS = {
    "force_rms_N": ("residual of the force balance", "N", "N"),
    "flow_rms_m3_per_s": ("residual of the flow balance", "m^3/s", "cm^3/s"),
    "position_rms_m": ("position, simulated against measured", "m", "mm"),
    "load_pressure_rms_Pa": ("load pressure, simulated against measured", "Pa", "kPa"),
}
"""Figures of the error: in words, the unit that they have, the unit that is shown."""

FAR = 3.0
"""Floors beyond which a residual is not called explained, whatever the verdict."""

QUIET = 100.0
"""Floors that only the floor's smallness makes, where the simulated plant fits."""

_COARSE = {"m": 1e-4, "Pa": 1e6, "s": 0.1}


def plain(name: str) -> str:
    """A name without its underscores."""
    return name.replace("_", " ")


def shown_unit(unit: str, value: float) -> str:
    """The unit in which a parameter of this size is read most easily."""
    large = abs(value) >= _COARSE.get(unit, 0.0)
    units = {
        "m": "mm" if large else "µm",
        "Pa": "MPa" if large else "kPa",
        "s": "s" if large else "ms",
        "m/s": "mm/s",
        "m^3/s": "cm^3/s",
    }
    return units.get(unit, unit)


def quantity(name: str, value: float, std: float | None = None) -> str:
    """A parameter's value with its unit, and its standard deviation in the same unit."""
    unit = known_units().get(name, "1")
    shown = shown_unit(unit, value)
    scale = factor(unit, shown)
    text = shown_number(scale * value, 4)
    if std is not None:
        text += f" ± {shown_number(scale * std, 2)}"
    return text if shown == "1" else f"{text} {shown}"


def listed(names: list[str], last: str = "and") -> str:
    """Words in a row: a, b and c."""
    return f" {last} ".join(part for part in (", ".join(names[:-1]), names[-1]) if part) if names else ""


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
    return (
        "None missing: the declared plant, with its own parameters fitted, explains the records; what is left is "
        f"{most:.1f} times the noise floor, and no known effect lowers it on data left out."
    )


def _numbers(numbers: Mapping[str, tuple[float, float]]) -> str:
    return ", ".join(f"{name} = {quantity(name, *number)}" for name, number in numbers.items())


def _dependence(found: Diagnosis) -> str:
    one = found.unexplained
    assert one is not None
    shares = [f"{plain(name)} ({100.0 * one.shares[name]:.0f} % of its variance)" for name in one.signals]
    return f"the {one.balance} balance's residual depends on {listed(shares)}"


def sureness(found: Diagnosis) -> list[str]:
    """How sure the verdict is, a line each: evidence, what remains over the floor, what the records do not show."""
    lines = []
    for one in found.found:
        text = f"{plain(one.name).capitalize()}: {PLAIN.get(one.name, 'see its source')} ({EFFECTS[one.name].source})."
        if "left_out_gain" in one.evidence:
            circular = any(is_circular(one.name, result.balance) for result in found.results)
            asked = CIRCULAR_GAIN if circular else LEAST_GAIN
            least = asked + PRICE * len(one.numbers)
            share, sure = one.evidence["left_out_gain"], one.evidence["standard_errors"]
            text += (
                f" It lowers the residual on data that its fit has not seen by {100 * share:.0f} %"
                f" ({sure:.1f} standard errors; {100 * least:.0f} % and more, and "
                f"{SURE:g} are asked for)."
            )
        elif "sum_rms_Pa" in one.evidence:
            before, after = (f"{1e-3 * one.evidence[key]:.3g}" for key in ("sum_rms_Pa", "left_rms_Pa"))
            text += f" The sum of both pressures is off by {before} kPa rms; one constant leaves {after} kPa of it."
        if one.alternatives:
            text += f" As good within its scatter: {listed([plain(name) for name in one.alternatives])}."
        lines.append(text)
    for result in found.results:
        ratio = found.report["floor"][result.balance.name]["after"]
        said = "the sensors' noise explains all of it" if ratio < 1.2 else "not all of it is the sensors' noise"
        if ratio > QUIET and found.simulated is not None and found.simulated.is_trusted:
            said = "of sensors so quiet, smoothing and sampling leave most of it"
        name, times = result.balance.name, shown_number(ratio, 3)
        lines.append(f"What is left of the {name} balance is {times} times its noise floor: {said}.")
        best = result.steps[0].candidates[0].effect if result.steps[0].candidates else None
        if best not in [None, *(one.name for one in found.found)] and result.steps[0].added is None:
            lines.append(f"{_nearest(result.steps[0])}")
    lines += _of_simulation(found)
    if found.unexplained is not None and found.report["verdict"] != "unexplained":
        lines.append(f"What remains is not explained: {_dependence(found)}; no known effect explains it.")
    if found.unexplained is not None and "data_driven_term" in found.report["unexplained"]:
        lines.append(_of_term(found.report["unexplained"]))
    lost = [name for name, one in found.report["baseline"].items() if not one["identified"]]
    if lost:
        lines.append(
            f"The records do not identify {listed(lost)}: a standard deviation exceeds half the value, or the fit ran "
            "to the end of its range."
        )
    if not found.report["error"]["held_out"]["before"]:
        lines.append("There is no held-out record: nothing tests what was found on data that it has not seen whole.")
    return lines


def _of_term(unexplained: Mapping[str, Any]) -> str:
    """What a data-driven term would do, and that it is no more than that."""
    term = unexplained["data_driven_term"]
    use = "held_out" if "held_out" in term else "fit"
    shown = {"m^3/s": "cm^3/s"}.get(term["unit"], term["unit"])
    before, after = (shown_number(factor(term["unit"], shown) * term[use][side], 3) for side in ("before", "after"))
    return (
        f"A data-driven term, the mean of that residual over {plain(term['signal'])}, would lower it on the "
        f"{use.replace('_', '-')} records from {before} to {after} {shown} where something moves (report.json has its "
        "nodes). It describes the records and names no cause."
    )


def _of_simulation(found: Diagnosis) -> list[str]:
    """What the simulated plant says, and how far a free run of a held-out record can be believed."""
    if found.simulated is None:
        return []
    data, lines = found.report["simulation"], []
    pieces = data["starts_anew_every_s"]
    along = "from end to end" if pieces is None else f"in pieces of {pieces:g} s, since it runs away before the end"
    change = "" if not found.found else f", {shown_number(data['before'], 3)} without what was found"
    said = (
        f"is off by {shown_number(data['after'], 3)} standard deviations of the sensors' noise{change}; "
        "the parameters are of this fit"
    )
    if not data["parameters_from_it"]:
        said = "is off by far more than the sensors' noise; the parameters are those that fit the balances"
    lines.append(f"Simulated {along} and fitted to the fit records, the plant {said}.")
    if data["dropped"]:
        lines.append(f"The simulated plant does without {listed([plain(name) for name in data['dropped']])}: dropped.")
    own = found.report["error"]["held_out"].get("own_parameters")
    if own is not None:
        after = found.report["error"]["held_out"]["after"]["position_rms_m"]
        best = own["position_rms_m"]
        lines.append(
            f"A free run of the held-out records is off by {shown_number(1e3 * after, 2)} mm in position. With the "
            f"same parameters fitted to these records themselves {shown_number(1e3 * best, 2)} mm would be left: so "
            "much of it is the model's, and the rest is drift, as small forces that differ between records add up."
        )
    return lines


def _nearest(step: Any) -> str:
    best = step.candidates[0]
    change = 100.0 * (1.0 - best.fit.validated_rms / step.before.validated_rms)
    name = step.before.balance.name
    return (
        f"No effect was added to the {name} balance: the best, {plain(best.effect)}, would lower it by {change:.1f} %."
    )

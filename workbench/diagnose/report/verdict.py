"""The verdict of a diagnosis in one sentence."""

from collections.abc import Mapping, Sequence

from workbench.diagnose.report.names import ERRORS, listed_names, percent, quantity
from workbench.diagnose.report.offered import offered_entries
from workbench.diagnose.report.parameters import plant_of
from workbench.diagnose.result import WORSE, Diagnosis, Estimate
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.selection.unexplained import Dependence
from workbench.publish.along import SHOWN
from workbench.publish.tables import shown_number
from workbench.publish.words import listed, plain_name
from workbench.toml.units import factor

NOISE = 1.2
"""Floors up to which a residual is the sensors' noise."""

FEW = 3
"""Signals that a sentence names."""


def worse(diagnosis: Diagnosis) -> list[str]:
    """The errors of held-out records that get worse with what was found, each in words with both numbers."""
    errors = diagnosis.errors.held_out
    before, after = errors.before.by_key, errors.after.by_key
    return [
        f"{words} (from {shown_number(factor(unit, shown) * before[key], 3)} to "
        f"{shown_number(factor(unit, shown) * after[key], 3)} {shown})"
        for key, (words, unit, shown) in ERRORS.items()
        if key in before and key in after and after[key] > WORSE * before[key]
    ]


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """What was found, in one sentence."""
    effects = [
        f"{plain_name(effect.name)} ({_numbers(effect.parameters, diagnosis.axis)})" for effect in diagnosis.effects
    ]
    match diagnosis.verdict:
        case "rejected_on_held_out":
            return (
                f"Rejected on held-out records: {listed(effects)} would lower the error of the records that were "
                f"fitted, but on those that were not worse is {listed(worse(diagnosis)) or 'an error'}; the plant "
                "stays as declared."
            )
        case "ambiguous":
            pairs = [
                f"the data cannot tell {plain_name(effect.name)} from {listed_names(effect.alternatives, 'or')}"
                for effect in diagnosis.effects
                if effect.alternatives
            ]
            sure = [text for text, effect in zip(effects, diagnosis.effects, strict=True) if not effect.alternatives]
            return f"Ambiguous: {listed(pairs)}." + (f" Found beside: {listed(sure)}." if sure else "")
        case "effect_found":
            return f"Found: {listed(effects)}."
        case "unexplained":
            assert diagnosis.unexplained is not None
            depends = dependence_words(diagnosis.unexplained.dependence, diagnosis.axis)
            return f"Unexplained: {depends}; no known effect explains it."
        case "undecided":
            return _undecided(diagnosis)
        case "none_missing":
            return _none_missing(diagnosis)


def next_words(diagnosis: Diagnosis, folder: str) -> str:
    """What to do next where effects could not be told apart: the command that finds out; where something is not
    explained, how a plant is simulated with a curve for it; empty otherwise.
    """
    if diagnosis.verdict == "ambiguous" and diagnosis.simulation is not None:
        return f"What to record to tell them apart: workbench design {folder} --out {folder}_next"
    left = diagnosis.unexplained
    goes_with_it = diagnosis.simulation is not None and diagnosis.simulation.curved is not None
    if left is None or not (diagnosis.verdict == "unexplained" or (goes_with_it and not diagnosis.is_rejected)):
        return ""
    entries = offered_entries(left, plant_of(diagnosis), diagnosis.experiment.values, "")
    if not entries:
        return ""
    return (
        f"To simulate the plant with a curve over {plain_name(left.term.signal)} for what is not explained: "
        f"{entries[0].name} = 1 in {folder}/plant.toml"
    )


def _undecided(diagnosis: Diagnosis) -> str:
    simulation, most = diagnosis.simulation, max(result.after.rms for result in diagnosis.results)
    if simulation is not None:
        off = f"simulated along the records the plant is off by {shown_number(simulation.after.rms, 2)} standard "
        off += f"deviations of the sensors' noise, and its balances leave {shown_number(most, 2)} times their floor"
    else:
        off = f"it is {shown_number(most, 2)} times the noise floor"
    return (
        "Undecided: no known effect lowers what is left on data left out, and that depends on no measured signal; but "
        f"{off}: the plant is not complete, its parameters were not found, the record moves faster than the smoothing "
        "follows, or it holds no noise (as a simulated one may)."
    )


def _none_missing(diagnosis: Diagnosis) -> str:
    simulation = diagnosis.simulation
    if simulation is not None:
        off = simulation.after.rms
        more = ", more than noise from sample to sample: the rest is slow or hums, and goes with no signal; "
        return (
            "None missing: the declared plant, with its own parameters fitted and simulated along the records, is off "
            f"by {off:.1f} standard deviations of the sensors' noise{', and ' if off < NOISE else more}"
            "no known effect lowers that on data left out."
        )
    most = max(result.after.rms for result in diagnosis.results)
    tested = max((ratio for result in diagnosis.results if (ratio := held_out_floors(diagnosis, result))), default=0.0)
    which = "the records that were fitted, but not the held-out ones" if tested >= max(NOISE, most) else "the records"
    beside = f" ({tested:.1f} times on held-out records)" if tested else ""
    return (
        f"None missing: the declared plant, with its own parameters fitted, explains {which}; what is left is "
        f"{most:.1f} times the noise floor{beside}, and no known effect lowers it on data left out."
    )


def _numbers(parameters: Mapping[str, Estimate], axis: str) -> str:
    return ", ".join(f"{name} = {quantity(name, *number, axis)}" for name, number in parameters.items())


def dependence_words(dependence: Dependence, axis: str) -> str:
    """On which signals a balance's residual depends, or over which a simulated plant lacks something."""
    told = SHOWN[axis].said(dependence.balance)
    if dependence.gain is not None:
        gains = [f"{plain_name(name)} ({dependence.shares[name] * dependence.gain:.0f})" for name in dependence.signals]
        return (
            f"the simulated plant lacks something in the {told} balance over {_few(gains)}: by so much a curve there "
            "raises the logarithm of its likelihood"
        )
    shares = [f"{plain_name(name)} ({percent(dependence.shares[name])} of its variance)" for name in dependence.signals]
    return f"the {told} balance's residual depends on {_few(shares)}"


def _few(signals: Sequence[str]) -> str:
    """The strongest of some signals: those that move together all show what is missing over one."""
    more = len(signals) - FEW
    return listed([*signals[:FEW], f"{more} more"] if more > 1 else signals)


def held_out_floors(diagnosis: Diagnosis, result: BalanceResult) -> float:
    """What is left of a balance on held-out records, in floors; 0 without any."""
    return diagnosis.errors.held_out.after.balances.get(result.balance.name, 0.0) / result.balance.floor


def follows_held_out(diagnosis: Diagnosis) -> bool:
    """Whether the simulated plant follows the held-out records near to the noise of their position."""
    off, simulation = diagnosis.errors.held_out.after.position, diagnosis.simulation
    if off is None or simulation is None or not simulation.is_trusted:
        return False
    return all(off < NOISE * motion.sensed["position"] for motion in diagnosis.held_out)

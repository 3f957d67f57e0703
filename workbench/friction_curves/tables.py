"""Tables of measured friction-velocity curves against what the bristle laws predict."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from workbench.friction_curves.comparison import Comparison
from workbench.friction_curves.measured import DIRECTIONS, FASTEST, Curve
from workbench.friction_curves.power import MM, fall, framed, in_text
from workbench.friction_curves.predicted import Fitted, affordable, rms, share, unchanged
from workbench.parameters.sets import known_units
from workbench.publish.tables import Table, shown_number
from workbench.records.friction import SLIDING
from workbench.toml.units import factor

SAME = 0.1
"""Share of its standard deviation by which a simulated number may differ from the fitted one."""

NOUGHT = 1e-3
"""A number is shown as 0 below this share of its standard deviation."""

LEVEL = 1e8
"""N s/m. More at v = 0 is no slope: friction has a level there."""

SPEED_RANGE = f"{MM * SLIDING:g} to {MM * FASTEST:g} mm/s"


def error_table(found: Comparison) -> Table:
    """Root mean square error of each law, and of each candidate effect, on the fit and on the check speeds."""
    fit, check = found.curves(found.spec.fit_rpm), found.curves(found.spec.check_rpm)
    bare = [unchanged(law, fit) for law in found.laws]
    best = min(rms(law, check) for law in found.laws)
    others = [rpm for rpm in found.rpm if rpm not in (*found.spec.fit_rpm, *found.spec.check_rpm)]
    lines = []
    for one in [*bare, *found.fitted]:
        line = {"law": one.prediction.name, "fitted numbers": str(len(one.numbers))}
        for label, rpm in (("fit", found.spec.fit_rpm), ("check", found.spec.check_rpm), ("other", others)):
            if rpm:
                curves, heading = found.curves(rpm), f"{label}: {in_text(rpm)} rpm"
                line[f"{heading} (N)"] = shown_number(rms(one.prediction, curves), 3)
                line[f"{label} (%)"] = shown_number(100.0 * share(one.prediction, curves), 3)
        line["check / best bare law"] = f"{rms(one.prediction, check) / best:.2f}"
        line["price"] = shown_number(one.price, 4)
        lines.append(line)
    notes = [
        f"Root mean square of measured less predicted axial friction over {SPEED_RANGE} in both directions, and as "
        "a share of the measured friction's. The laws know the axial set without rotation and the set of pure "
        "rotation; no number is fitted to a curve, but for the effects: on the fit speeds only. Check / best bare law: "
        "error on the check speeds over that of the law without effects that is best there; below 1 is better.",
        "Price: n ln(rms^2) + k ln(n) on the fit speeds with four independent numbers a curve and k fitted ones.",
        verdict(found),
    ]
    return Table("Measured against predicted axial friction of the rotating rod", framed(lines), notes)


def verdict(found: Comparison) -> str:
    """What the numbers support, in a sentence."""
    added, check = found.added, found.curves(found.spec.check_rpm)
    best = min(rms(law, check) for law in found.laws)
    if added.effect is None:
        return f"The fit speeds support none of the effects. {_not_chosen(found)}"
    after = rms(added.prediction, check)
    said = (
        f"The fit speeds support {added.effect.name}, the lowest price. On the check speeds the error "
        f"{'falls' if after < best else 'rises'} from {shown_number(best, 3)} N, that of the best bare law, to "
        f"{shown_number(after, 3)} N. "
    )
    fewer = [one for one in found.fitted if len(one.numbers) < len(added.numbers)]
    cheaper = [*found.laws, *(one.prediction for one in fewer)]
    better = min(cheaper, key=lambda law: rms(law, check))
    if rms(better, check) < after:
        error = shown_number(rms(better, check), 3)
        said += f"With fewer numbers {better.name} does better on the check speeds, {error} N: the choice is doubtful. "
    return said + _not_chosen(found)


def _not_chosen(found: Comparison) -> str:
    """Why the other effects are not supported, in a sentence or two."""
    fit = found.curves(found.spec.fit_rpm)
    chosen = found.added.effect.name if found.added.effect else ""
    names = {one.effect.name: one for one in found.fitted if one.effect and one.effect.name != chosen}
    unknown = [name for name, one in names.items() if not one.identified]
    many = [name for name, one in names.items() if one.identified and not affordable(one, fit)]
    dear = [name for name in names if name not in (*unknown, *many)]
    reasons = {
        "their numbers are not all identified (friction_curve_effects)": unknown,
        "as many numbers as half the independent ones of the curves, or more": many,
        "a higher price": dear,
    }
    return "Not supported: " + "; ".join(f"{', '.join(who)}: {why}" for why, who in reasons.items() if who) + "."


def effect_table(found: Comparison) -> Table:
    """The fitted numbers of every candidate."""
    units = known_units()
    lines = []
    for one in found.fitted:
        for name, (value, std) in one.numbers.items():
            unit = {"m/s": "mm/s"}.get(units.get(name, "1"), units.get(name, "1"))
            scale = factor(units.get(name, "1"), unit)
            lines.append(
                {
                    "law": one.prediction.name,
                    "parameter": name,
                    "unit": {"width": "rpm"}.get(name, unit.replace("1", "")),
                    "value": _fitted_value(scale * value, scale * std),
                    "std": shown_number(scale * std, 2) if np.isfinite(std) else "",
                    "remark": _remark(one, name),
                }
            )
    notes = [
        f"Fitted at {in_text(found.spec.fit_rpm)} rpm. The film's speed stays at the Stribeck velocity of pure "
        "rotation: at these speeds of rotation the film is there whole, and the curves cannot tell how it came.",
        "film: the axial level falls to film_share of itself with the helical speed. guide: a contact that slides "
        "and does not turn takes guide_coulomb of the axial level. resonance: takes the share dip off axial "
        "friction around 100 rpm. Without a value or deviation: the curves do not depend on it, or on others as well.",
        *_simulated(found),
    ]
    return Table("What the anisotropic law may lack, fitted", framed(lines), notes)


def _fitted_value(value: float, std: float) -> str:
    if np.isinf(std):
        return ""
    return shown_number(value, 3) if abs(value) > NOUGHT * std else "0"


def _remark(one: Fitted, name: str) -> str:
    if one.is_identified(name):
        return ""
    return "not identified, at its bound" if name in one.at_bound else "not identified"


def _simulated(found: Comparison) -> list[str]:
    """Where the study simulates other numbers than those of the effect that the fit supports."""
    units, lines = known_units(), []
    for name, (value, std) in found.added.numbers.items():
        unit = units.get(name, "1").replace("1", "")
        for declared, cases in found.simulated(name).items() if name in units else ():
            if abs(declared - value) > SAME * std:
                where = f" in {', '.join(cases)}" if cases else ""
                lines.append(
                    f"The study simulates {name} {declared:g} {unit}".rstrip()
                    + f"{where}; the fit gives {shown_number(value, 3)} {unit}".rstrip()
                    + f" (std {shown_number(std, 2)}): set it in the study."
                )
    return lines


def slope_table(found: Comparison) -> Table:
    """What rotation adds to the slope of friction over velocity."""
    spec, lines = found.spec, []
    alone = {curve.direction: curve for curve in found.at_rest}
    for rpm in found.rpm:
        line = {"rpm": f"{rpm:g}"}
        for law in found.distinct:
            at_rest, regression = law.added_slope(rpm)
            line[f"{law.name}, at v = 0"] = shown_number(at_rest, 4) if at_rest < LEVEL else "a level"
            line[f"{law.name}, regression"] = shown_number(regression, 4)
        curve = next(curve for curve in found.curves([rpm]) if curve.direction == "forward")
        upper = curve.speed > 0.5 * FASTEST
        rise = np.polyfit(curve.speed[upper], curve.friction[upper] - alone["forward"].friction[upper], 1)[0]
        line["measured, upper half"] = shown_number(float(rise), 4)
        if reference := {float(name): slopes for name, slopes in spec.reference_slope.items()}.get(rpm):
            line["reference, at v = 0"] = shown_number(reference[0], 4)
            line["reference, regression"] = shown_number(reference[1], 4)
        lines.append(line)
    notes = [
        f"With the forward set in both directions. Regression: a line over 0 to {MM * FASTEST:g} mm/s. "
        "Measured: the rise of the forward curve's slope over that without rotation, over the upper half of the "
        "speeds, where static friction has decayed; within a fraction of a percent that is the rise of the "
        "thesis's viscous friction.",
        *(
            ["A level: friction is left at v = 0, as a guide leaves it, and no slope."]
            if _any(lines, "a level")
            else []
        ),
        *(
            ["Reference: another computation of the bare anisotropic law, as the study gives it."]
            * bool(spec.reference_slope)
        ),
    ]
    return Table("Slope that rotation adds to axial friction (N s/m)", framed(lines), notes)


def _any(lines: Sequence[dict[str, str]], cell: str) -> bool:
    return any(cell in line.values() for line in lines)


def static_table(found: Comparison) -> Table:
    """Static friction against rpm: how far it falls."""
    first, cells = _falls(found, lambda curve: curve.static)
    notes = [
        f"Mean of both directions; fall in percent from {shown_number(first, 3)} N without rotation. Predicted: what "
        "is left as the velocity goes to 0.",
        static_words(found),
    ]
    return Table("Fall of static friction with speed of rotation", cells, notes)


def slowest_table(found: Comparison) -> Table:
    """The same of friction at the slowest measured speed."""
    first, cells = _falls(found, lambda curve: curve.at(SLIDING))
    notes = [f"Mean of both directions; fall in percent from {shown_number(first, 3)} N without rotation."]
    return Table(f"Fall of friction at {MM * SLIDING:g} mm/s with speed of rotation", cells, notes)


def _falls(found: Comparison, of: Callable[[Curve], float]) -> tuple[float, pd.DataFrame]:
    """A friction (N) without rotation, and by how many percent it falls, measured and by each law."""
    first, lines = sum(of(curve) for curve in found.at_rest), []
    for rpm in found.rpm:
        measured = sum(of(curve) for curve in found.curves([rpm]))
        line = {"rpm": f"{rpm:g}", "measured (N)": shown_number(0.5 * measured, 3)}
        line["measured (%)"] = fall(measured, first)
        for law in found.distinct:
            line[f"{law.name} (%)"] = fall(sum(of(law.curve(rpm, name)) for name in DIRECTIONS), first)
        lines.append(line)
    return 0.5 * first, framed(lines)


def static_words(found: Comparison) -> str:
    """Which law predicts the fall of static friction."""
    first = sum(curve.static for curve in found.at_rest)
    fast = [rpm for rpm in found.rpm if rpm >= min(found.spec.fit_rpm)]
    falls = [100.0 * (1.0 - sum(c.static for c in found.curves([rpm])) / first) for rpm in fast]
    said = (
        f"Measured static friction falls by {min(falls):.0f} to {max(falls):.0f} % from {min(fast):g} rpm on and "
        "no further. "
    )
    bare = (
        "Every law that lets the whole contact turn predicts its fall to nothing, at any speed of rotation: the "
        "fall, but not "
    )
    bare += "what remains. "
    if "guide_coulomb" not in found.added.numbers:
        return said + bare
    left = sum(found.added.prediction.curve(fast[0], name).static for name in DIRECTIONS)
    return (
        f"{said}{bare}With a guide that does not turn, fitted to the curves and not to this, the law predicts "
        f"{fall(left, first)} %."
    )

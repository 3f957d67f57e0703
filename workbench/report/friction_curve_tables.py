"""Tables of measured friction-velocity curves against what the bristle laws predict."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from workbench.identify.friction_curves import DIRECTIONS, FASTEST, SLIDING, rms, share, unchanged
from workbench.parameters import known_units
from workbench.report.friction_curve_comparison import Comparison, hydraulic_power, predicted_power
from workbench.report.tables import shown_number
from workbench.units import factor

MM = 1e3
IDENTIFIED = 1.0
"""A fitted number with a standard deviation above this share of it is not identified."""

NOUGHT = 1e-3
"""A number is shown as 0 below this share of its standard deviation."""

LEVEL = 1e8
"""N s/m. More at v = 0 is no slope: friction has a level there."""

SPEED_RANGE = f"{MM * SLIDING:g} to {MM * FASTEST:g} mm/s"

Table = tuple[str, str, pd.DataFrame, list[str]]
"""Name, title, cells and notes."""


def _rpm(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


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
                curves, heading = found.curves(rpm), f"{label}: {_rpm(rpm)} rpm"
                line[f"{heading} (N)"] = shown_number(rms(one.prediction, curves), 3)
                line[f"{label} (%)"] = shown_number(100.0 * share(one.prediction, curves), 3)
        line["check, of the best bare law"] = f"{rms(one.prediction, check) / best:.2f}"
        line["price"] = shown_number(one.price, 4)
        lines.append(line)
    notes = [
        f"Root mean square of measured less predicted axial friction over {SPEED_RANGE} in both directions, and as "
        "a share of the measured friction's. The laws know the axial set without rotation and the set of pure "
        "rotation; no number is fitted to a curve, but for the effects: on the fit speeds only.",
        "Price: n ln(rms^2) + k ln(n) on the fit speeds with four independent numbers a curve and k fitted ones.",
        verdict(found),
    ]
    return "friction_curve_error", "Measured against predicted axial friction of the rotating rod", _frame(lines), notes


def verdict(found: Comparison) -> str:
    """What the numbers support, in a sentence."""
    added, check = found.added, found.curves(found.spec.check_rpm)
    best = min(rms(law, check) for law in found.laws)
    if added.effect is None:
        return "None of the effects is worth its numbers: the fit speeds do not support any."
    before, after = shown_number(best, 3), shown_number(rms(added.prediction, check), 3)
    return (
        f"The fit speeds support {added.effect.name}, the lowest price. On the check speeds the error falls from "
        f"{before} N, that of the best bare law, to {after} N. The others are not supported: what they add does "
        "not pay for their numbers."
    )


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
                    "value": shown_number(scale * value, 3) if abs(value) > NOUGHT * std else "0",
                    "std": shown_number(scale * std, 2) if np.isfinite(std) else "",
                    "remark": "" if std < IDENTIFIED * abs(value) else "not identified",
                }
            )
    notes = [
        f"Fitted at {_rpm(found.spec.fit_rpm)} rpm. The film's speed stays at the Stribeck velocity of pure "
        "rotation: at these speeds of rotation the film is there whole, and the curves cannot tell how it came.",
        "film: the axial level falls to film_share of itself with the helical speed. guide: a contact that slides "
        "and does not turn takes guide_coulomb of the axial level. resonance: takes the share dip off axial "
        "friction around 100 rpm.",
    ]
    return "friction_curve_effects", "What the anisotropic law may lack, fitted", _frame(lines), notes


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
        if reference := spec.reference_slope.get(f"{rpm:g}"):
            line["reference, at v = 0"] = shown_number(reference[0], 4)
            line["reference, regression"] = shown_number(reference[1], 4)
        lines.append(line)
    notes = [
        f"N s/m, with the forward set in both directions. Regression: a line over 0 to {MM * FASTEST:g} mm/s. "
        "Measured: the rise of the forward curve's slope over that without rotation, over the upper half of the "
        "speeds, where static friction has decayed; within a fraction of a percent that is the rise of the "
        "thesis's viscous friction.",
    ]
    return "added_slope", "Slope that rotation adds to axial friction", _frame(lines), notes


def static_table(found: Comparison) -> Table:
    """Static friction, and friction at the slowest measured speed, against rpm: how far they fall."""
    first = sum(curve.static for curve in found.at_rest)
    slow = sum(curve.at(SLIDING) for curve in found.at_rest)
    lines = []
    for rpm in found.rpm:
        curves = found.curves([rpm])
        measured, near = sum(curve.static for curve in curves), sum(curve.at(SLIDING) for curve in curves)
        line = {"rpm": f"{rpm:g}", "measured static (N)": shown_number(0.5 * measured, 3)}
        line["its fall (%)"] = _fall(measured, first)
        for law in found.distinct:
            predicted = sum(law.curve(rpm, name).static for name in DIRECTIONS)
            line[f"{law.name}, v to 0 (%)"] = _fall(predicted, first)
        line[f"measured at {MM * SLIDING:g} mm/s (%)"] = _fall(near, slow)
        for law in found.distinct:
            predicted = sum(law.curve(rpm, name).at(SLIDING) for name in DIRECTIONS)
            line[f"{law.name}, at {MM * SLIDING:g} mm/s (%)"] = _fall(predicted, slow)
        lines.append(line)
    notes = [
        f"Mean of both directions; percent by which it falls from {shown_number(0.5 * first, 3)} N (static) and "
        f"{shown_number(0.5 * slow, 3)} N (at {MM * SLIDING:g} mm/s) without rotation.",
        static_words(found),
    ]
    return "static_friction", "Static friction against speed of rotation", _frame(lines), notes


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
        f"{_fall(left, first)} %."
    )


def _fall(now: float, before: float) -> str:
    return f"{100.0 * (1.0 - now / before):.1f}"


def power_table(found: Comparison) -> Table:
    """Hydraulic power at one speed along, measured and predicted, and with rotary power, against rpm."""
    speed, lines = found.spec.speed, []
    before = hydraulic_power([curve.at(speed) for curve in found.at_rest], speed)
    lines.append({"rpm": "0", "measured hydraulic (W)": shown_number(before, 3)})
    for rpm in found.rpm:
        measured = hydraulic_power([curve.at(speed) for curve in found.curves([rpm])], speed)
        line = {"rpm": f"{rpm:g}", "measured hydraulic (W)": shown_number(measured, 3)}
        line["reduced by (%)"] = _fall(measured, before)
        for law in found.distinct:
            line[f"{law.name}, reduced by (%)"] = _fall(predicted_power(law, rpm, speed)[0], before)
        rotary = predicted_power(found.predictions[-1], rpm, speed)[1]
        line["rotary (W)"] = shown_number(rotary, 3)
        line["measured hydraulic and rotary (W)"] = shown_number(measured + rotary, 3)
        lines.append(line)
    totals = {line["rpm"]: float(line.get("measured hydraulic and rotary (W)", np.inf)) for line in lines}
    paying = [rpm for rpm, total in totals.items() if total < before]
    words = f"at {', '.join(paying)} rpm" if paying else "at none of these speeds"
    notes = [
        f"At {MM * speed:g} mm/s along, mean of both directions. Hydraulic: friction times velocity (4.16). "
        f"Rotary: friction times surface speed (4.18), by {found.predictions[-1].name}, since none was measured "
        "while the rod slid.",
        f"By this account rotating pays {words}.",
    ]
    return "power_at_speed", "Power against speed of rotation at a constant velocity", _frame(lines), notes


def _frame(lines: list[dict[str, str]]) -> pd.DataFrame:
    return pd.DataFrame(lines).fillna("")

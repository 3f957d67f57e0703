"""Power of the rotating rod by measured and by predicted friction, and what all tables of friction curves share."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from workbench.friction_curves.comparison import Comparison, hydraulic_power, predicted_power
from workbench.publish.tables import Table, shown_number

MM = 1e3


def in_text(values: Sequence[float]) -> str:
    """Speeds of rotation in text."""
    return ", ".join(f"{value:g}" for value in values)


def fall(now: float, before: float) -> str:
    """By how many percent, in text."""
    return f"{100.0 * (1.0 - now / before):.1f}"


def framed(lines: list[dict[str, str]]) -> pd.DataFrame:
    """Cells, empty where a line has none."""
    return pd.DataFrame(lines).fillna("")


def power_table(found: Comparison) -> Table:
    """Hydraulic power at one speed along, measured and predicted, and with rotary power, against rpm."""
    speed, lines = found.spec.speed, []
    before = hydraulic_power([curve.at(speed) for curve in found.at_rest], speed)
    lines.append({"rpm": "0", "measured hydraulic (W)": shown_number(before, 3)})
    for rpm in found.rpm:
        measured = hydraulic_power([curve.at(speed) for curve in found.curves([rpm])], speed)
        line = {"rpm": f"{rpm:g}", "measured hydraulic (W)": shown_number(measured, 3)}
        line["reduced by (%)"] = fall(measured, before)
        for law in found.distinct:
            line[f"{law.name}, reduced by (%)"] = fall(predicted_power(law, rpm, speed)[0], before)
        rotary = predicted_power(found.predictions[-1], rpm, speed)[1]
        line["rotary (W)"] = shown_number(rotary, 3)
        line["measured hydraulic and rotary (W)"] = shown_number(measured + rotary, 3)
        lines.append(line)
        own = sum(predicted_power(found.predictions[-1], rpm, speed))
        line["predicted hydraulic and rotary (W)"] = shown_number(own, 3)
    totals = {line["rpm"]: float(line.get("measured hydraulic and rotary (W)", np.inf)) for line in lines}
    paying = [rpm for rpm, total in totals.items() if total < before]
    words = f"at {', '.join(paying)} rpm" if paying else "at none of these speeds"
    notes = [
        f"At {MM * speed:g} mm/s along, mean of both directions. Hydraulic: friction times velocity (4.16). "
        f"Rotary: friction times surface speed (4.18), by {found.predictions[-1].name}, since none was measured "
        "while the rod slid.",
        f"By this account, measured hydraulic and rotary, rotating pays {words}.",
        *_by_the_law(found, {float(rpm) for rpm in paying}),
    ]
    return Table("Power against speed of rotation at a constant velocity", framed(lines), notes)


def _by_the_law(found: Comparison, paying: set[float]) -> list[str]:
    """Where predicted hydraulic power comes to another answer than measured, and why."""
    law, speed = found.predictions[-1], found.spec.speed
    before = sum(predicted_power(law, 0.0, speed))
    own = {rpm for rpm in found.rpm if sum(predicted_power(law, rpm, speed)) < before}
    said = f"By predicted power alone, of {law.name}, it pays "
    said += f"at {in_text(sorted(own))} rpm" if own else "at none of these speeds"
    said += f" ({shown_number(before, 3)} W without rotation)."
    for rpm in sorted(paying ^ own):
        measured = hydraulic_power([curve.at(speed) for curve in found.curves([rpm])], speed)
        off = 100.0 * (predicted_power(law, rpm, speed)[0] / measured - 1.0)
        way = "above" if off > 0.0 else "below"
        said += (
            f" The answers differ at {rpm:g} rpm: there predicted hydraulic power is {abs(off):.0f} % {way} measured."
        )
    if names := ", ".join(even.name for even in getattr(found.study.file, "break_even", None) or ()):
        said += f" The tables {names} count simulated power, which follows the prediction."
    return [said]

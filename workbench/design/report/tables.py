"""Tables of a design: pairs, pieces, hypotheses."""

import math

import pandas as pd

from workbench.design.pieces import shaped
from workbench.design.result import Design
from workbench.parameters.sets import known_units
from workbench.publish.along import SHOWN
from workbench.publish.tables import Table, shown_number


def tables_of(design: Design) -> dict[str, Table]:
    """By name; none that is empty."""
    found = {
        "pairs": Table("How surely the motion tells each hypothesis from a rival", _pairs(design)),
        "parameters": Table("Parameters before and after the motion", _parameters(design)),
        "pieces": Table("Pieces of the motion", _pieces(design)),
        "hypotheses": Table("Hypotheses", _hypotheses(design)),
    }
    return {name: table for name, table in found.items() if not table.cells.empty}


def _pairs(design: Design) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {
                "if it is": design.name_of(one.true),
                "the rival is": design.name_of(one.rival),
                "records": "do not claim the rival" if design.is_nested(one) else "tell it",
                "distance (std of noise)": "far"
                if math.isinf(one.distance)
                else shown_number(math.sqrt(one.distance), 3),
                "share of records": f"{one.power:.2f}",
                "90 % interval": f"{one.low:.2f} to {one.high:.2f}",
            }
            for one in design.told
        ]
    )


def _parameters(design: Design) -> pd.DataFrame:
    units = known_units(design.rig.axis)
    return pd.DataFrame(
        [
            {
                "parameter": one.name,
                "unit": units.get(one.name, "1"),
                "value": shown_number(one.value, 4),
                "std before": shown_number(one.before, 2),
                "std after": shown_number(one.after, 2),
            }
            for one in design.known
        ]
    )


def _pieces(design: Design) -> pd.DataFrame:
    shown, closed = SHOWN[design.rig.axis], design.rig.steering is not None
    unit, factor = (shown.unit, shown.factor) if closed else (design.rig.along.plant.command_unit, 1.0)
    rows = []
    for piece in design.pieces:
        of = shaped(piece, design.rig.reach)
        numbers = dict(of.numbers)
        size = numbers.pop("amplitude")
        rows.append(
            {
                "piece": piece.kind,
                "duration (s)": f"{piece.duration:g}",
                "rpm": f"{piece.condition.rotation * 30.0 / math.pi:.0f}",
                f"load ({shown.force_unit})": f"{piece.condition.load:g}",
                f"about ({unit})": shown_number(factor * of.place, 3),
                f"size ({unit})": shown_number(factor * size, 3),
                "further": ", ".join(_said(key, value, unit, factor) for key, value in numbers.items()),
            }
        )
    return pd.DataFrame(rows)


def _said(key: str, value: float, unit: str, factor: float) -> str:
    if key == "speed":
        return f"{key} {shown_number(factor * value, 3)} {unit}/s"
    return f"{key} {shown_number(value, 3)} {'s' if key == 'hold' else 'Hz'}"


def _hypotheses(design: Design) -> pd.DataFrame:
    units = known_units(design.rig.axis)
    names = list(dict.fromkeys(u.name for one in design.hypotheses for u in one.unknowns))
    rows = []
    for name in names:
        row = {"parameter": name, "unit": units.get(name, "1")}
        for number, one in enumerate(design.hypotheses):
            has = any(u.name == name for u in one.unknowns)
            row[design.name_of(number)] = shown_number(one.values[name], 4) if has else ""
        rows.append(row)
    return pd.DataFrame(rows)

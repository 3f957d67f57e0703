"""Text, units and numbers for LaTeX: whatever a table holds, siunitx can align it, and a reader sees no identifier."""

import re

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as some

from controllers.registry import controllers
from controllers.settings import settings_of
from plants.axis import AXES
from plants.equation import fields
from plants.registry import plants
from workbench.metrics.registry import columns as metrics
from workbench.parameters.sets import known_units
from workbench.publish.along import SHOWN
from workbench.publish.latex.columns import column_of
from workbench.publish.latex.table import latex_table
from workbench.publish.latex.text import display_name, escaped, shown_text
from workbench.publish.latex.units import latex_unit
from workbench.publish.tables import shown_number
from workbench.records.schema import CHANNELS, NUISANCES
from workbench.study.names import BASE_UNITS, signal_units
from workbench.tune.report.tables import METRIC_WORDS


@pytest.mark.parametrize(
    ("unit", "shown"),
    {
        "N s/m": r"\unit{\newton\second\per\metre}",
        "V/(rad/s)": r"\unit{\volt\per\radian\second}",
        "V s/(m/s N)": r"\unit{\volt\second\per\metre\second\per\newton}",
        "V/(m s)": r"\unit{\volt\per\metre\per\second}",
        "1/s": r"\unit{\per\second}",
        "m^2/(s Pa^0.5)": r"\unit{\metre\squared\per\second\per\pascal\tothe{0.5}}",
        "rad/s s/m": r"\unit{\radian\per\second\second\per\metre}",
        "rad/s/(m s)": r"\unit{\radian\per\second\per\metre\per\second}",
        "deg/s": r"\unit{\degree\per\second}",
        "mdeg": r"\unit{\milli\degree}",
        "µm": r"\unit{\micro\metre}",
        "kPa": r"\unit{\kilo\pascal}",
        "m^3": r"\unit{\metre\cubed}",
        "min": r"\unit{\minute}",
        "%": r"\unit{\percent}",
        "rpm": r"\unit{rpm}",
        "95 %": None,
        "std": None,
        "1": None,
        "m (": None,
    }.items(),
)
def test_units(unit: str, shown: str | None) -> None:
    assert latex_unit(unit) == shown


def test_every_unit_that_the_program_shows_is_one_for_siunitx() -> None:
    units = {
        *BASE_UNITS.values(),
        *CHANNELS.values(),
        *NUISANCES.values(),
        *(unit for _, unit in METRIC_WORDS.values()),
    }
    for axis in AXES:
        shown = SHOWN[axis]
        units |= {
            shown.unit,
            shown.small_unit,
            shown.speed_unit,
            shown.force_unit,
            "kPa",
            "MPa",
            "mm/s",
            "rpm",
            "%",
            "dB",
        }
        units |= {item.unit for item in metrics(axis).values()} | {*signal_units(axis).values()}
        units |= {*known_units(axis).values()}
    for plant in plants().values():
        units |= {item.unit for item in (*fields(plant.Signals), *fields(plant.Inputs), *fields(plant.Parameters))}
        units |= {
            plant.unit_for(item.unit) for each in controllers().values() for item in settings_of(each.Settings).values()
        }
    assert [unit for unit in units - {"1", ""} if latex_unit(unit) is None] == []


@pytest.mark.parametrize(
    ("text", "shown"),
    {
        "K_p = 500 V/m": r"K\textsubscript{p} = 500 V/m",
        "R^2 of friction": r"R\textsuperscript{2} of friction",
        "valve_flow_gain of run_1.csv": r"valve flow gain of run\_1.csv",
        "0.3 ± 0.1 µm": r"0.3 \textpm{} 0.1 \textmu{}m",
        "Åström & Müller, 100 %": r"\r{A}str\"{o}m \& M\"{u}ller, 100 \%",
        "+-30 mm": r"\textpm{}30 mm",
        "[a] * --resume": r"{[}a] {*} -{}-resume",
        "中": "{[}U+4E2D]",
    }.items(),
)
def test_text(text: str, shown: str) -> None:
    assert shown_text(text) == shown


@given(some.text())
def test_text_of_any_kind_is_ascii_with_its_braces_closed(text: str) -> None:
    for shown in (escaped(text), shown_text(text)):
        assert shown.isascii()
        assert shown.isprintable()
        bare = re.sub(r"\\.", "", shown)
        depth = [0]
        for character in bare:
            depth.append(depth[-1] + {"{": 1, "}": -1}.get(character, 0))
        assert min(depth) == 0
        assert depth[-1] == 0
        assert not re.search(r"[%&#$_^]", bare)


def test_names_are_shown_without_underscores() -> None:
    assert display_name("static_map and lugre_adaptive") == "static map and lugre adaptive"
    assert display_name("results/run_1/a_b.csv") == "results/run_1/a_b.csv"


def shown_by(format_: str) -> re.Match[str]:
    """What a table-format has room for."""
    found = re.fullmatch(
        r"(?P<said><?)(?P<sign>\+?)(?P<whole>\d)\.(?P<part>\d+)(?:e(?P<minus>-?)(?P<power>\d))?", format_
    )
    assert found is not None, format_
    return found


@given(some.lists(some.floats(-1e9, 1e9), min_size=1), some.integers(2, 6))
def test_there_is_room_for_every_number(numbers: list[float], digits: int) -> None:
    cells = [shown_number(number, digits) for number in numbers]
    column = column_of("force (N)", cells, "", words=False)
    room = shown_by(column.table_format)
    assert list(column.cells) == cells
    for cell in cells:
        mantissa, _, power = cell.partition("e")
        whole, _, part = mantissa.lstrip("-").partition(".")
        assert len(whole) <= int(room["whole"])
        assert len(part) <= int(room["part"])
        assert not mantissa.startswith("-") or room["sign"]
        assert len(power.lstrip("+-")) <= int(room["power"] or 0)
        assert not power.startswith("-") or room["minus"]


def test_what_is_no_number_stands_in_braces_beside_numbers() -> None:
    cells = ["1.5", "< 0.1", "+12.25", "0.31 (2)", "", "diverged", "3 to 4", "-", "7 %"]
    column = column_of("error (mm)", cells, "", words=False)
    assert list(column.cells) == [
        *("1.5", "<0.1", "+12.25", "0.31 {~(2)}", "", "{diverged}", "{3 to 4}", "{-}", r"7 {\,\%}"),
    ]
    assert column.table_format == "<+2.2{~(2)}"
    assert not column_of("outcome", ["diverged", "completed", "3"], "", words=False).table_format


def made(cells: pd.DataFrame, *notes: str) -> str:
    columns = {str(name): column.tolist() for name, column in cells.items()}
    return latex_table("t", "a title", columns, notes, {}, ())


def test_a_table_takes_the_form_that_fits_its_page() -> None:
    words = "a remark of many words that has to be broken over lines"
    narrow = pd.DataFrame({"controller": ["p"], "error (mm)": ["1.5"]})
    assert r"\begin{table}[htbp]" in made(narrow)
    assert r"\small" in made(narrow)
    broken = made(narrow.assign(remark=2 * words, other=words))
    assert r"p{" in broken
    assert r"\begin{table}" in broken
    turned = made(pd.DataFrame({f"error {i} (mm)": ["123456.789"] for i in range(10)}))
    assert r"\begin{sidewaystable}" in turned
    assert "needs array, booktabs, siunitx, threeparttable, rotating\n" in turned
    parted = made(pd.DataFrame({"rpm": ["0"], **{f"error {i} (mm)": ["123456.789"] for i in range(40)}}))
    assert parted.count(r"\begin{table}") == parted.count("{rpm}") > 1
    assert "(part 2 of " in parted
    assert parted.count(r"\label{") == 1
    long = made(pd.DataFrame({"rpm": [str(i) for i in range(100)]}), "A note.")
    assert r"\begin{longtable}" in long
    assert r"\insertTableNotes" in long


def test_a_long_word_may_be_broken() -> None:
    assert escaped("x" * 40).count(r"\allowbreak{}") == 4
    assert escaped("a plain sentence with valve_flow_gain in it").count("allowbreak") == 0
    assert escaped(f"see {'/deadbeef' * 5} there").replace(r"\allowbreak{}", "") == f"see {'/deadbeef' * 5} there"

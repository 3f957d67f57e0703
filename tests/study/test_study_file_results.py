"""Study files with a mistake in what they ask of the results: probes, tables and figures."""

from pathlib import Path

import pytest
from command import FIGURE, STUDY, workbench
from mistakes import expect

TABLE = '[[tables]]\nname = "t"\ntitle = "t"\n'
PANEL = FIGURE + 'y_unit = "mm"\n'

MISTAKES = {
    "unknown signal": (
        STUDY + '[probes.top]\nsignal = "positon"\ntake = "maximum"\n',
        '@:22: probes.top.signal: unknown signal "positon"; did you mean "position"?',
    ),
    "case of a probe": (
        STUDY + '[probes.top]\nsignal = "position"\ntake = "maximum"\ncases = ["a"]\n',
        '@:24: probes.top.cases: unknown case "a"; none is expected here',
    ),
    "probe of a taken name": (
        STUDY + '[probes.Rms_error_m]\nsignal = "position"\ntake = "maximum"\n',
        "@:21: probes.Rms_error_m: the results have a column of this name already",
    ),
    "unknown column": (
        STUDY + TABLE + 'index = "rpm"\ncolumns = [{ result = "phase_lag", label = "lag" }]\n',
        '@:25: tables.0.columns.0.result: unknown figure "phase_lag"; did you mean "phase_lag_deg"?',
    ),
    "unit of a column": (
        STUDY + TABLE + 'index = "rpm"\ncolumns = [{ result = "phase_lag_deg", label = "lag", unit = "kg" }]\n',
        '@:25: tables.0.columns.0.unit: "kg" is not a unit of what is in deg',
    ),
    "columns alike": (
        STUDY
        + TABLE
        + 'index = "rpm"\ncolumns = [{ result = "gain_ratio", label = "a" }, { result = "outcome", label = "a" }]\n',
        "@:21: tables.0: two columns have the same label: expected different ones",
    ),
    "two tables of one name": (
        STUDY + 2 * (TABLE + 'index = "rpm"\ncolumns = [{ result = "outcome", label = "a" }]\n'),
        '@:27: tables.1.name: "t" is taken: expected another name',
    ),
    "index": (
        STUDY + TABLE + 'index = "rmp"\ncolumns = [{ result = "phase_lag_deg", label = "lag" }]\n',
        '@:24: tables.0.index: unknown axis "rmp"; did you mean "rpm"?',
    ),
    "row of no case": (
        STUDY + TABLE + '[[tables.rows]]\nresult = "phase_lag_deg"\nlabel = "lag"\nwhere = { rpm = 461 }\n',
        "@:27: tables.0.rows.0.where: no case has rpm 461, expected one",
    ),
    "row of two cases": (
        STUDY + TABLE + '[[tables.rows]]\nresult = "phase_lag_deg"\nlabel = "lag"\n',
        "@:24: tables.0.rows.0.where: 2 cases to choose from, expected one",
    ),
    "a reference that the table has not": (
        STUDY + TABLE + 'index = "rpm"\nreferences = { thesis = "Owen" }\n'
        'columns = [{ result = "gain_ratio", label = "a", against = { thsis = { 0 = 1.0 } } }]\n',
        '@:26: tables.0.columns.0.against: unknown reference of the table "thsis"; did you mean "thesis"?',
    ),
    "a reference's value where no number is": (
        STUDY + TABLE + 'index = "rpm"\nreferences = { thesis = "Owen" }\n'
        'columns = [{ result = "gain_ratio", label = "a", against = { thesis = { x = 1.0 } } }]\n',
        '@:26: tables.0.columns.0.against.thesis: got "x", expected a number as rpm has them',
    ),
    "a reference of the name of published": (
        STUDY + TABLE + 'index = "rpm"\nreferences = { published = "Owen" }\n'
        'columns = [{ result = "gain_ratio", label = "a" }]\n',
        '@:21: tables.0: references: "published" is that of `published`, with its source in `source`',
    ),
    "published where no number is": (
        STUDY + TABLE + 'index = "rpm"\ncolumns = [{ result = "gain_ratio", label = "a", published = { x = 1.0 } }]\n',
        '@:25: tables.0.columns.0.published: got "x", expected a number as rpm has them',
    ),
    "curve of no signal": (
        STUDY + PANEL + 'curves = [{ y = "motor_current", where = { rpm = 0 } }]\n',
        '@:28: figures.0.panels.0.curves.0.y: unknown signal "motor_current"; ',
    ),
    "curve of two cases": (
        STUDY + PANEL + 'curves = [{ y = "position" }]\n',
        "@:28: figures.0.panels.0.curves.0.where: 2 cases to choose from, expected one",
    ),
    "condition on no axis": (
        STUDY + PANEL + 'curves = [{ y = "position", where = { rmp = 0 } }]\n',
        '@:28: figures.0.panels.0.curves.0.where.rmp: unknown axis "rmp"; did you mean "rpm"?',
    ),
    "unit of a panel": (
        STUDY + PANEL.replace('"mm"', '"bar"') + 'curves = [{ y = "position", where = { rpm = 0 } }]\n',
        '@:27: figures.0.panels.0.y_unit: "bar" is not a unit of what is in m',
    ),
    "curve of another controller's signal": (
        STUDY + PANEL + 'curves = [{ y = "controller_friction", where = { rpm = 0 } }]\n',
        '@:28: figures.0.panels.0.curves.0.y: no signal "controller_friction" here; controller "p" (type pid) has '
        "controller_integral, controller_command, controller_error, controller_first, controller_second, "
        "controller_third",
    ),
    "misspelled signal of a controller": (
        STUDY + '[probes.top]\nsignal = "controller_integra"\ntake = "maximum"\n',
        '@:22: probes.top.signal: no signal "controller_integra" here; did you mean "controller_integral"? controller ',
    ),
    "probe of a signal that none of its cases has": (
        STUDY
        + '[probes.top]\nsignal = "controller_theta"\ntake = "final"\ncases = ["a"]\n'
        + '[cases.a]\n[cases.b.controllers]\np = { type = "lugre", kp = 500 }\n',
        '@:22: probes.top.signal: no signal "controller_theta" here; controller "p" (type pid) has ',
    ),
    "legend": (
        STUDY + PANEL + 'legend = "top"\ncurves = [{ y = "position", where = { rpm = 0 } }]\n',
        "@:28: figures.0.panels.0.legend: got \"top\", expected 'best', ",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(tmp_path: Path, mistake: str) -> None:
    expect(tmp_path, *MISTAKES[mistake])


def test_mathematics_that_cannot_be_set_is_a_mistake(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    figure = FIGURE.replace('title = "f"', "title = 'y $\\foo$ and $x_1$'")
    path.write_text(STUDY + figure + 'x = "rpm"\ncurves = [{ y = "phase_lag_deg" }]\n', encoding="utf-8")
    answer = workbench("check", path)
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert "whose mathematics between $ cannot be set" in answer.err
    assert r"write \$ for a dollar" in answer.err

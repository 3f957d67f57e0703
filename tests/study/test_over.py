"""Tables and figures over the draws of a machine, or over other axes: what is taken of the cases, and of how many."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from command import STUDY, fails, ran, workbench, write
from pydantic import ValidationError

import workbench as wb
from workbench.errors import UserError
from workbench.study.reading import read_study
from workbench.study.report.figures import draw
from workbench.study.report.folder import shown_columns, write_figures, write_pages, write_tables
from workbench.study.report.schema import FigureSpec, Summary, TableSpec
from workbench.study.report.summary import taken
from workbench.study.report.tables import make_table, write_table
from workbench.study.store import read_results
from workbench.study.unfold import unfold

DRAWS = 21
ERRORS = {0: np.arange(1.0, DRAWS + 1.0), 460: np.arange(DRAWS, 0.0, -1.0) / 2.0}
"""rms errors in mm of the draws, by rpm."""

FRAME = pd.DataFrame(
    [
        {
            "rpm": rpm,
            "draw": draw + 1,
            "outcome": "completed" if error < 20.0 else "end stop",
            "rms_error_m": 1e-3 * error if draw else None,
            "limit_cycle": "sustained" if error > 15.5 else "none",
            "solver_error_m": None if draw else 1e-9,
        }
        for rpm, errors in ERRORS.items()
        for draw, error in enumerate(errors)
    ]
)
"""Twenty-one draws at two speeds of rotation; the first of each has no rms error."""

RMS: dict[str, Any] = {"result": "rms_error_m", "label": "rms", "unit": "mm", "digits": 4}


def over_draws(**content: Any) -> TableSpec:
    """A table over the draws."""
    return TableSpec(name="t", title="a title", over=["draw"], **content)


@pytest.mark.parametrize(
    ("take", "expected"),
    [
        ({"take": "mean"}, [np.mean(ERRORS[0][1:]), np.mean(ERRORS[460][1:])]),
        ({"take": "median"}, [np.median(ERRORS[0][1:]), np.median(ERRORS[460][1:])]),
        ({"take": "minimum"}, [2.0, 0.5]),
        ({"take": "maximum"}, [21.0, 10.0]),
        ({"take": "standard_deviation"}, [np.std(ERRORS[0][1:], ddof=1), np.std(ERRORS[460][1:], ddof=1)]),
        ({"take": "quantile", "level": 0.9}, [np.quantile(ERRORS[0][1:], 0.9), np.quantile(ERRORS[460][1:], 0.9)]),
        ({"take": "share_below", "level": "5.1 mm", "unit": "%"}, [100.0 * 4 / 21, 100.0 * 10 / 21]),
        ({"take": "share_below", "level": 5.1e-3, "unit": "1"}, [4 / 21, 10 / 21]),
    ],
)
def test_a_figure_of_all_draws(take: dict[str, Any], expected: list[float]) -> None:
    """Cases without the figure, as the first draw of each speed here, are left out, which the cell says; of shares they
    are part.
    """
    column = {**RMS, **take}
    table = make_table(over_draws(index="rpm", columns=[column]), FRAME)
    assert table["rpm"].tolist() == ["0", "460"]
    shown = [cell.removesuffix(" [20 of 21]") for cell in table.iloc[:, 1]]
    assert (shown == table.iloc[:, 1].tolist()) == take["take"].startswith("share")
    assert [float(cell) for cell in shown] == pytest.approx(expected, rel=1e-3)
    rows = [{**column, "where": {"rpm": rpm}} for rpm in ERRORS]
    single = make_table(over_draws(rows=rows), FRAME)
    assert single["this program"].tolist() == table.iloc[:, 1].tolist()


def test_a_level_in_a_unit_that_is_not_si() -> None:
    """Lags are stored in degrees, speeds of rotation in rpm."""
    lags = FRAME.assign(phase_lag_deg=30.0 + FRAME["rms_error_m"].to_numpy() * 1e3, rotation_speed_mean_rpm=100.0)
    for column, level, expected in (
        ("phase_lag_deg", "60 deg", 20 / 21),
        ("phase_lag_deg", 35.5, 4 / 21),
        ("rotation_speed_mean_rpm", "90 rpm", 0.0),
        ("rotation_speed_mean_rpm", "110 rpm", 1.0),
    ):
        share = {"result": column, "label": "s", "digits": 9, "take": "share_below", "level": level}
        table = make_table(over_draws(index="rpm", where={"rpm": 0}, columns=[share]), lags)
        assert float(table["s"].iloc[0]) == pytest.approx(expected)


def test_a_column_may_pick_other_cases_than_its_table() -> None:
    """Its where is laid over the table's."""
    spec = over_draws(
        index="rpm",
        where={"rpm": 0},
        columns=[{**RMS, "take": "maximum"}, {**RMS, "label": "turned", "take": "maximum", "where": {"rpm": 460}}],
    )
    table = make_table(spec, FRAME)
    assert table["turned (mm)"].tolist() == ["", "10.00 [20 of 21]"]


def test_a_row_of_no_case_is_empty() -> None:
    row = {**RMS, "take": "mean", "where": {"rpm": 0, "outcome": "diverged"}}
    assert make_table(over_draws(rows=[row, {**row, "where": {"rpm": 0}}]), FRAME)["this program"][0] == ""


def test_words_are_counted_and_a_note_says_what_is_taken_of_how_many(tmp_path: Path) -> None:
    hunts = {"result": "limit_cycle", "label": "hunts", "unit": "%", "digits": 3, "take": "share", "of": ["sustained"]}
    spec = over_draws(index="rpm", columns=[{**RMS, "take": "median"}, hunts])
    assert make_table(spec, FRAME)["hunts (%)"].tolist() == [f"{100.0 * 6 / 21:.1f}", "0"]
    _, markdown, _ = write_table(spec, FRAME, tmp_path)
    said = 'Over draw: "rms" is the median of 20 of 21 cases; "hunts" is the share of sustained of 21 cases.'
    assert said in markdown.read_text(encoding="utf-8")
    assert "In square brackets how many of the cases have the figure" in markdown.read_text(encoding="utf-8")


def test_side_by_side_and_below_what_the_solver_tells() -> None:
    """The solver's error is known of the first draw and stands for all; a magnitude below it says nothing."""
    errors = [0.0, *[1e-12] * (DRAWS - 1), 0.0, *[2e-3] * (DRAWS - 1)]
    tiny = FRAME.assign(rms_error_m=errors, solver_rms_error_m=FRAME["solver_error_m"], controller="p")
    tiny = tiny[["controller", *(name for name in tiny.columns if name != "controller")]]
    table = make_table(over_draws(index="controller", across="rpm", columns=[{**RMS, "take": "maximum"}]), tiny)
    assert table.to_numpy().tolist() == [["p", "< 1e-06 (1)", "2.000 (1)"]]


def test_axes_that_are_neither_shown_nor_summarised_stay_lines() -> None:
    twice = pd.concat([FRAME.assign(controller=name) for name in ("p", "pd")])[["controller", *FRAME.columns]]
    column = {**RMS, "take": "maximum"}
    table = make_table(over_draws(index="rpm", columns=[column]), twice)
    assert table[["rpm", "controller"]].to_numpy().tolist() == [["0", "p"], ["460", "p"], ["0", "pd"], ["460", "pd"]]
    of_both = TableSpec(name="t", title="t", over=["draw", "controller"], index="rpm", columns=[column])
    assert len(make_table(of_both, twice)) == 2
    with pytest.raises(UserError, match='row "rms": 42 cases for rpm 0, expected those of one controller'):
        make_table(over_draws(rows=[{**column, "where": {"rpm": 0}}]), twice)


def test_without_over_each_draw_is_a_line() -> None:
    assert len(make_table(TableSpec(name="t", title="t", index="rpm", columns=[RMS]), FRAME)) == 2 * DRAWS


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"over": ["draw"]}, '"rms": expected a take such as "median" for its cases over draw'),
        ({"take": "mean"}, '"rms": take = "mean" needs over, such as over = \\["draw"\\]'),
        ({"over": ["rpm"], "take": "mean"}, 'over: "rpm" is an axis of the table'),
        ({"over": ["draw"], "take": "quantile"}, "level belongs to take"),
        ({"over": ["draw"], "take": "quantile", "level": 1.5}, "expected a share from 0 to 1"),
        ({"over": ["draw"], "take": "mean", "level": 0.5}, "level belongs to take"),
        ({"over": ["draw"], "take": "share"}, "of belongs to take"),
        ({"over": ["draw"], "take": "mean", "of": ["none"]}, "of belongs to take"),
    ],
)
def test_what_cannot_be_taken_is_said(content: dict[str, Any], said: str) -> None:
    over = content.get("over", [])
    column = RMS | {name: value for name, value in content.items() if name != "over"}
    with pytest.raises(ValidationError, match=said):
        TableSpec(name="t", title="t", index="rpm", over=over, columns=[column])


def test_nothing_is_taken_of_no_case_and_no_deviation_of_one() -> None:
    assert taken([None, float("nan")], Summary(take="mean"), "rms_error_m") is None
    assert taken([1.0], Summary(take="standard_deviation"), "rms_error_m") is None
    with pytest.raises(ValueError, match="whose values are words"):
        taken(["none"], Summary(take="mean"), "limit_cycle")


def panel(curve: dict[str, Any], **settings: Any) -> FigureSpec:
    """A figure with one curve of the rms error over rpm."""
    of_results = {"x": "rpm", "x_label": "rotation", "y_label": "error", "y_unit": "mm", **settings}
    return FigureSpec(name="f", title="f", panels=[{**of_results, "curves": [{"y": "rms_error_m", **curve}]}])


def test_a_curve_of_medians_with_a_band_between_quantiles(tmp_path: Path) -> None:
    spec = panel({"label": "P", "take": "median", "band": [0.05, 0.95]}, over=["draw"])
    (axes,) = draw(spec, FRAME, tmp_path).axes
    line, hollow = axes.lines
    assert list(line.get_ydata()) == pytest.approx([np.median(ERRORS[rpm][1:]) for rpm in ERRORS])
    assert (list(hollow.get_xdata()), hollow.get_label()) == ([0.0], "end stop")
    (band,) = axes.collections
    lowest, highest = np.quantile(ERRORS[0][1:], [0.05, 0.95])
    at_rest = band.get_paths()[0].vertices
    at_rest = at_rest[at_rest[:, 0] == 0.0][:, 1]
    assert (at_rest.min(), at_rest.max()) == (pytest.approx(lowest), pytest.approx(highest))
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    assert legend == ["P", "5 to 95 % of the cases", "end stop"]
    assert [text.get_text() for text in axes.texts] == ["Over draw, 20 of 21 cases a point: median"]


@pytest.mark.parametrize("over", [["draw"], []])
def test_a_figure_that_no_case_has_is_an_empty_panel(tmp_path: Path, over: list[str]) -> None:
    empty = FRAME.assign(rms_error_m=pd.Series([None] * len(FRAME), dtype=object))
    (axes,) = draw(panel({"take": "mean"} if over else {}, over=over), empty, tmp_path).axes
    assert list(axes.lines[0].get_ydata()) == []


def test_a_share_is_drawn_without_the_unit_of_its_column(tmp_path: Path) -> None:
    curve = {"take": "share_below", "level": "5.1 mm"}
    (axes,) = draw(panel(curve, over=["draw"], y_unit="%"), FRAME, tmp_path).axes
    assert list(axes.lines[0].get_ydata()) == pytest.approx([100.0 * 4 / 21, 100.0 * 10 / 21])


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"take": "mean", "band": [0.9, 0.1]}, "expected two quantiles from 0 to 1, the lower one first"),
        ({"take": "share_below", "level": "1 mm", "band": [0.1, 0.9]}, "band: belongs to a take of values"),
        ({}, 'curve of "rms_error_m": expected a take such as "median"'),
    ],
)
def test_a_curve_over_draws_that_cannot_be_is_said(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        panel(settings, over=["draw"])


MONTE_CARLO = f"""{STUDY}
[uncertainty]
draws = 3
"""
TABLE = '[[tables]]\nname = "t"\ntitle = "t"\nindex = "rpm"\n'
FIGURE = '[[figures]]\nname = "f"\ntitle = "f"\n[[figures.panels]]\nx = "rpm"\nx_label = "x"\ny_label = "y"\n'


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (
            f'{TABLE}over = ["draw"]\n'
            'columns = [{ result = "limit_cycle", label = "e", take = "share", of = ["hunting"] }]',
            'of: unknown word "hunting"; expected one of none, decaying, too_short, sustained',
        ),
        (f'{TABLE}over = ["drawn"]\ncolumns = [{{ result = "rms_error_m", label = "e", take = "mean" }}]', '"drawn"'),
        (
            f'{TABLE}over = ["draw"]\ncolumns = [{{ result = "limit_cycle", label = "e", take = "mean" }}]',
            'take: got "mean" of limit_cycle, which is words; expected "share"',
        ),
        (
            f'{TABLE}over = ["draw"]\n'
            'columns = [{ result = "rms_error_m", label = "e", take = "share_below", level = "1 s" }]',
            "level: ",
        ),
        (
            '[[tables]]\nname = "t"\ntitle = "t"\nover = ["draw"]\n'
            'rows = [{ result = "rms_error_m", label = "e", take = "mean" }]',
            "is of cases of rpm 0 and rpm 460; say which, or name rpm in over",
        ),
        (
            f'{FIGURE}over = ["machine"]\ncurves = [{{ y = "rms_error_m", take = "mean" }}]',
            'over: unknown axis "machine"',
        ),
        (f'{FIGURE}curves = [{{ y = "limit_cycle" }}]', "limit_cycle is words; a share of them can be drawn with over"),
        (
            FIGURE.replace('x = "rpm"', 'x = "time"') + 'over = ["draw"]\ncurves = [{ y = "position", take = "mean" }]',
            'belongs to a panel of results: expected as x an axis, not the signal "time"',
        ),
    ],
)
def test_check_says_what_cannot_be_taken(tmp_path: Path, asked: str, said: str) -> None:
    fails(workbench("check", write(tmp_path, MONTE_CARLO + asked)), said)


@pytest.mark.parametrize("drawn", ["", "[uncertainty]\n"])
def test_without_draws_there_is_no_such_axis(tmp_path: Path, drawn: str) -> None:
    asked = f'{TABLE}over = ["draw"]\ncolumns = [{{ result = "rms_error_m", label = "e", take = "mean" }}]'
    said = 'over: no axis "draw": draw machines first, with draws = 100 in [uncertainty]'
    fails(workbench("check", write(tmp_path, f"{STUDY}\n{drawn}{asked}")), said)


def test_a_line_through_all_draws_is_warned_of(tmp_path: Path) -> None:
    joined = f'{FIGURE}curves = [{{ y = "rms_error_m" }}]'
    said = "a line joins two cases for rpm 0: draw 1 and draw 2; take a figure of all draws with over"
    assert said in workbench("check", write(tmp_path, MONTE_CARLO + joined)).err
    for silent in (
        'curves = [{ y = "rms_error_m", style = "points" }]',
        'over = ["draw"]\ncurves = [{ y = "rms_error_m", take = "mean" }]',
    ):
        answer = workbench("check", write(tmp_path, f"{MONTE_CARLO}{FIGURE}{silent}"))
        assert answer.code == 0
        assert "joins" not in answer.err


def test_a_study_of_draws_from_end_to_end(tmp_path: Path) -> None:
    table = (
        f'{TABLE}over = ["draw"]\ncolumns = [{{ result = "rms_error_m", label = "e", unit = "mm", take = "maximum" }}]'
    )
    figure = f'{FIGURE}over = ["draw"]\ncurves = [{{ y = "rms_error_m", take = "median", band = [0, 1] }}]'
    out = ran(tmp_path, f"{MONTE_CARLO}{table}\n{figure}")
    results = pd.read_csv(out / "results.csv")
    largest = 1e3 * results.groupby("rpm")["rms_error_m"].max()
    assert pd.read_csv(out / "tables" / "t.csv")["e (mm)"].tolist() == pytest.approx(largest.tolist(), rel=1e-3)
    assert (out / "figures" / "f.pdf").exists()


def test_what_was_drawn_is_told_and_kept(tmp_path: Path) -> None:
    out = ran(tmp_path, f'{MONTE_CARLO}scale.mass = {{ min = 0.8, max = 1.5 }}\nnoise.position = {{ max = "5 um" }}\n')
    drawn = pd.read_csv(out / "draws.csv")
    assert drawn["draw"].tolist() == [1, 2, 3]
    assert drawn["mass (kg)"].between(0.8 * 34.0, 1.5 * 34.0).all()
    assert drawn["mass (kg)"].nunique() == drawn["seed"].nunique() == 3
    assert drawn["noise of position (m)"].between(0.0, 5e-6).all()
    assert {"coulomb (N)", "coulomb_negative (N)"} <= {*drawn}
    assert "supply_pressure (Pa)" not in drawn, "it is the same on all"
    page = (out / "results.html").read_text(encoding="utf-8")
    assert "friction by 1 times its standard deviations; mass times 0.8 to 1.5; noise of position 0.0 to 5 um." in page
    by_python = wb.Study(tmp_path / "study.toml").run(tmp_path / "python").folder
    for name in ("draws.csv", "results.csv", "results.html"):
        assert (by_python / name).read_bytes() == (out / name).read_bytes(), name
    assert not (ran(tmp_path, STUDY, "--overwrite") / "draws.csv").exists()


def test_limit_cycles_of_draws_are_one_line_a_case(tmp_path: Path) -> None:
    relay = 'type = "relay"\namplitude = "2 V"\nhysteresis = "0.1 mm"'
    steps = 'kind = "steps"\nlevels = ["1 mm"]\ndwell = "2 s"'
    text = MONTE_CARLO.replace('type = "pid"\nkp = "500 V/m"', relay).replace('duration = "1 s"', 'duration = "2 s"')
    text = text.replace('kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"', steps).replace(
        'transient = "0.4 s"', 'transient = "0 s"'
    )
    cycles = pd.read_csv(ran(tmp_path, text) / "tables" / "limit_cycles.csv")
    assert cycles["rpm"].tolist() == [0, 460]
    assert cycles["draws with a cycle"].tolist() == ["3 of 3"] * 2


def test_columns_of_cases_are_those_of_each(tmp_path: Path) -> None:
    """All at once and one by one, of parts with axes of their own, of lists, and of draws."""
    parts = (
        '[cases.a]\naxes.rpm = [0, 120]\naxes.controller = ["p"]\n'
        '[cases.b]\naxes."references.sine.amplitude" = ["5 mm", "8 mm", "9 mm"]\n'
    )
    study = read_study(write(tmp_path, STUDY.replace("[axes]\nrpm = [0, 460]\n", "") + parts))
    cases = unfold(study)
    places = np.array([4, 0, 1, 3])
    found = cases.columns_of(places)
    assert [*found] == [*cases.axes]
    for i, place in enumerate(places):
        own = {name: values[i] for name, values in found.items() if values[i] is not None}
        assert own == cases.columns(int(place))


def test_a_report_reads_what_it_shows_alone(tmp_path: Path) -> None:
    """Tables, figures and page are the same from all columns as from those chosen."""
    asked = (
        f'{TABLE}over = ["draw"]\nwhere = {{ limit_cycle = "none" }}\n'
        'columns = [{ result = "friction_slope_N_s_per_m", label = "e", take = "mean" }]\n'
        f'{FIGURE}over = ["draw"]\ncurves = [{{ y = "jerk_rms_m_per_s3", take = "median" }}]'
    )
    out = ran(tmp_path, MONTE_CARLO + asked)
    study, frame = read_study(out / "study.toml"), read_results(out)
    chosen = read_results(out, shown_columns(study, "m"))
    assert {"friction_slope_N_s_per_m", "limit_cycle", "jerk_rms_m_per_s3", "draw"} <= {*chosen} < {*frame}
    before = {path: path.read_bytes() for path in sorted(out.rglob("*.*")) if path.suffix != ".sqlite"}
    write_tables(study, frame, out)
    write_figures(study, frame, out)
    write_pages(study, frame, out)
    assert {path: path.read_bytes() for path in before} == before

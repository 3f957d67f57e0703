"""Figures: what is drawn, what the fits say, and files that are the same bytes each time."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from command import STUDY, changed, fails, ran, workbench, write

from workbench.errors import UserError
from workbench.study.reading import read_study
from workbench.study.report.figures import draw, write_figure
from workbench.study.report.quick_plot import quick_plot
from workbench.study.report.schema import FigureSpec
from workbench.study.store import read_results, trajectory_path

FRAME = pd.DataFrame(
    {
        "rpm": [0, 120, 460],
        "outcome": ["completed"] * 3,
        "rms_error_m": [3e-3, 2e-3, None],
    }
)
TIME = np.linspace(0.0, 2.0, 201)


def panel(curve: dict[str, Any], **settings: Any) -> dict[str, Any]:
    """A panel with one curve."""
    return {"x_label": "x", "y_label": "y", "y_unit": "mm", "curves": [curve], **settings}


def figure(*panels: dict[str, Any]) -> FigureSpec:
    """A figure with these panels."""
    return FigureSpec(name="f", title="a figure", panels=list(panels))


def store(folder: Path, **signals: np.ndarray) -> Path:
    """A folder with the trajectory of one case."""
    path = trajectory_path(folder, 0)
    path.parent.mkdir(parents=True, exist_ok=True)
    pd.DataFrame({"time": TIME[: len(next(iter(signals.values())))], **signals}).to_parquet(path)
    return folder


def lines(spec: FigureSpec, folder: Path) -> list[Any]:
    """The lines of the first pair of axes."""
    return list(draw(spec, FRAME, folder).axes[0].lines)


def test_a_case_that_did_not_simply_complete_is_a_hollow_point(tmp_path: Path) -> None:
    frame = FRAME.assign(outcome=["completed", "torque-limited", "completed"])
    spec = figure(panel({"y": "rms_error_m", "label": "P"}, x="rpm"))
    every, hollow = draw(spec, frame, tmp_path).axes[0].lines
    assert (list(every.get_xdata()), list(hollow.get_xdata())) == ([0.0, 120.0], [120.0])
    assert (hollow.get_label(), hollow.get_markerfacecolor()) == ("torque-limited", "white")
    assert [line.get_label() for line in lines(spec, tmp_path)] == ["P"]


def test_a_signal_in_its_units_and_window(tmp_path: Path) -> None:
    store(tmp_path, position=1e-3 * TIME)
    spec = figure(panel({"y": "position", "where": {"rpm": 0}}, x_unit="ms", start="0.5 s", end="1.5 s"))
    (line,) = lines(spec, tmp_path)
    assert line.get_xdata()[0] == pytest.approx(500.0)
    assert line.get_xdata()[-1] == pytest.approx(1500.0)
    np.testing.assert_allclose(line.get_ydata(), line.get_xdata() * 1e-3, rtol=1e-12)
    axes = draw(spec, FRAME, tmp_path).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (ms)", "y (mm)")


Y_UNITS = {
    "a signal": ([{"y": "axial_friction"}], {}, "y (N)"),
    "signals alike": ([{"y": "axial_friction"}, {"y": "spring_force"}], {"x": "velocity"}, "y (N)"),
    "signals that differ": ([{"y": "axial_friction"}, {"y": "velocity"}], {}, "y"),
    "one without a known unit": ([{"y": "axial_friction"}, {"y": "unknown"}], {}, "y"),
    "a label that has it": ([{"y": "axial_friction"}], {"y_label": "friction (N)"}, "friction (N)"),
    "as it is stored": ([{"y": "axial_friction"}], {"y_unit": "1"}, "y"),
    "beside measured friction": ([{"y": "velocity", "label": "a"}], {"x": "velocity", "measured_rpm": 0}, "y"),
    "a column": ([{"y": "rms_error_m"}], {"x": "rpm"}, "y (m)"),
    "columns that differ": ([{"y": "rms_error_m"}, {"y": "share"}], {"x": "rpm"}, "y"),
}


@pytest.mark.parametrize("case", Y_UNITS)
def test_y_is_in_the_unit_of_its_curves_where_none_is_given(tmp_path: Path, case: str) -> None:
    curves, settings, label = Y_UNITS[case]
    store(tmp_path, **dict.fromkeys(("velocity", "axial_friction", "spring_force", "unknown"), 1e-3 * TIME))
    frame = FRAME.assign(share=0.5)
    of_results = settings.get("x") == "rpm"
    curves = [{"where": {} if of_results else {"rpm": 0}, **curve} for curve in curves]
    shown = {"x_label": "x", "y_label": "y", "curves": curves, **settings}
    axes = draw(figure(shown), frame, tmp_path).axes[0]
    assert axes.get_ylabel() == label
    stored = frame["rms_error_m"].dropna() if of_results else 1e-3 * TIME
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), stored)


FITS = {
    "line": (3.0 * TIME - 2.0, "line", "y = 3.000 x - 2.000,  R$^2$ = 1.0000"),
    "through zero": (-2717.0 * TIME, "line", "y = -2717 x,  R$^2$ = 1.0000"),
    "level": (5.0 + 0.0 * TIME, "line", "y = 5.000"),
    "cubic": (
        -40460.0 * TIME**3 + 2.0 * TIME**2 + 5093.0 * TIME,
        "cubic",
        "y = -40460 x$^3$ + 5093 x,  R$^2$ = 1.0000",
    ),
    "small": (2e-6 * TIME**3 + 1.5e-6, "cubic", "y = 2.000e-06 x$^3$ + 1.500e-06,  R$^2$ = 1.0000"),
    "parabola": (
        TIME**2,
        "line",
        # Over n even points from 0 to 2, m = n - 1: intercept -2/3 + 2/(3 m), R^2 = 15 m^2 / (15 m^2 + n^2 - 4).
        "y = 2.000 x - 0.6633,  R$^2$ = 0.9369",
    ),
}


@pytest.mark.parametrize("case", FITS)
def test_what_a_fit_says(tmp_path: Path, case: str) -> None:
    values, kind, text = FITS[case]
    store(tmp_path, velocity=TIME, axial_friction=values)
    spec = figure(
        panel(
            {"y": "axial_friction", "where": {"rpm": 0}, "label": "a", "fit": kind},
            x="velocity",
            x_unit="1",
            y_unit="N",
        )
    )
    fit, line = lines(spec, tmp_path)
    assert line.get_label() == f"a\n{text}"
    if case != "parabola":
        np.testing.assert_allclose(
            np.interp(TIME, fit.get_xdata(), fit.get_ydata()), values, atol=2e-4 * np.ptp(values)
        )


@pytest.mark.parametrize("samples", [0, 1, 2])
def test_no_fit_of_what_ended_early(tmp_path: Path, samples: int) -> None:
    store(tmp_path, position=TIME[:samples], velocity=TIME[:samples])
    spec = figure(panel({"y": "velocity", "where": {"rpm": 0}, "label": "a", "fit": "cubic"}, y_unit="1"))
    (line,) = lines(spec, tmp_path)
    assert line.get_label() == "a"
    assert len(line.get_xdata()) == samples


def test_results_over_an_axis_beside_the_published(tmp_path: Path) -> None:
    curve = {"y": "rms_error_m", "label": "ours", "published": {"0": 3.5, "460": 1.0}}
    ours, published = lines(figure(panel(curve, x="rpm", x_unit="rpm")), tmp_path)
    assert ours.get_xdata().tolist() == [0, 120]
    np.testing.assert_allclose(ours.get_ydata().astype(float), [3.0, 2.0], rtol=1e-12)
    assert (list(published.get_xdata()), list(published.get_ydata())) == ([0.0, 460.0], [3.5, 1.0])
    assert published.get_linestyle() == "None"


def test_panels_stand_one_above_the_other(tmp_path: Path) -> None:
    store(tmp_path, position=TIME)
    one = panel({"y": "position", "where": {"rpm": 0}}, note="a note", y_range=[0, 1])
    upper, lower = draw(figure(one, one), FRAME, tmp_path).axes
    assert upper.get_position().y0 > lower.get_position().y1
    assert upper.get_ylim() == (0.0, 1.0)
    assert [text.get_text() for text in upper.texts] == ["a note"]


def test_the_note_hides_nothing(tmp_path: Path) -> None:
    """It stands below the numbers and the name of the axis, inside the picture."""
    store(tmp_path, position=TIME)
    drawn = draw(figure(panel({"y": "position", "where": {"rpm": 0}}, note="two\nlines")), FRAME, tmp_path)
    drawn.canvas.draw()
    axes = drawn.axes[0]
    note, name = axes.texts[0].get_window_extent(), axes.xaxis.label.get_window_extent()
    assert note.y0 >= 0.0
    assert note.y1 <= name.y0 + 1.0


def test_curves_differ_in_colour_and_dash(tmp_path: Path) -> None:
    store(tmp_path, position=TIME, velocity=TIME)
    curves = [{"y": "position", "where": {"rpm": 0}} for _ in range(5)]
    drawn = lines(figure({"x_label": "x", "y_label": "y", "y_unit": "mm", "curves": curves}), tmp_path)
    assert len({(line.get_color(), str(line.get_linestyle())) for line in drawn}) == 5
    assert len({line.get_color() for line in drawn}) == 5


def test_sixteen_curves_and_a_level_all_differ(tmp_path: Path) -> None:
    store(tmp_path, position=TIME)
    curves = [{"y": "position", "where": {"rpm": 0}, "label": str(i)} for i in range(16)]
    spec = figure({"x_label": "x", "y_label": "y (mm)", "y_unit": "mm", "curves": curves, "levels": {"true": 0.769}})
    level, *drawn = lines(spec, tmp_path)
    assert set(level.get_ydata()) == {0.769}
    assert len({(line.get_color(), str(line._dash_pattern)) for line in drawn}) == 16
    assert draw(spec, FRAME, tmp_path).axes[0].get_ylabel() == "y (mm)"


def test_three_formats_and_the_same_bytes_twice(tmp_path: Path) -> None:
    store(tmp_path, velocity=TIME, axial_friction=TIME**3)
    curve = {"y": "axial_friction", "where": {"rpm": 0}, "label": "a", "fit": "cubic"}
    spec = figure(panel(curve, x="velocity", x_unit="m/s", y_unit="N", title="K$_p$"))
    paths = write_figure(spec, FRAME, tmp_path)
    assert [path.relative_to(tmp_path).as_posix() for path in paths] == [
        f"figures/f.{e}" for e in ("pdf", "svg", "png")
    ]
    first = [path.read_bytes() for path in paths]
    assert [content[:5] for content in first] == [b"%PDF-", b"<?xml", b"\x89PNG\r"]
    assert [path.read_bytes() for path in write_figure(spec, FRAME, tmp_path)] == first


def test_curves_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(
        UserError, match=r"figure f: the trajectory of rpm 0 was not kept \(kept: none\); run with --keep-traj"
    ):
        lines(figure(panel({"y": "position", "where": {"rpm": 0}})), tmp_path)
    with pytest.raises(UserError, match=r"figure f: 3 cases for no condition, expected one"):
        lines(figure(panel({"y": "position"})), tmp_path)
    store(tmp_path, position=TIME)
    with pytest.raises(UserError, match=r'the plant of that case has no signal "velocity"'):
        lines(figure(panel({"y": "velocity", "where": {"rpm": 0}}, y_unit="m/s")), tmp_path)


# --- workbench plot ---

HEAD = '[[figures]]\nname = "lag"\ntitle = "Lag"\n[[figures.panels]]\nx_label = "time"\ny_label = "y"\n'
DRAWN = STUDY + HEAD + 'y_unit = "mm"\ncurves = [{ y = "position", where = { rpm = 460 } }]\n'


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of a study with a figure."""
    return ran(tmp_path_factory.mktemp("drawn"), DRAWN)


def test_the_figures_of_a_study_again(tmp_path: Path) -> None:
    out = ran(tmp_path, DRAWN)
    paths = [out / "figures" / f"lag.{ending}" for ending in ("pdf", "svg", "png")]
    before = [path.read_bytes() for path in paths]
    for path in paths:
        path.unlink()
    answer = workbench("plot", out)
    assert answer == (0, f"wrote {paths[0]}, {paths[1]}, {paths[2]}\n", "")
    assert [path.read_bytes() for path in paths] == before


def test_a_stored_signal_or_a_column(tmp_path: Path) -> None:
    out = ran(tmp_path, DRAWN)
    signal = workbench("plot", out, "--y", "position", "--y", "velocity", "--where", "rpm=460")
    assert signal == (0, f"wrote {out / 'figures' / 'position_velocity_over_time.png'}\n", "")
    column = workbench("plot", out, "--y", "phase_lag_deg", "--x", "rpm", "--out", tmp_path / "lag.svg")
    assert column == (0, f"wrote {tmp_path / 'lag.svg'}\n", "")
    assert (tmp_path / "lag.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--y", "positon"), 'nothing called "positon" is stored; did you mean "position"?'),
        (("--y", "phase_lag", "--x", "rpm"), 'nothing called "phase_lag" is stored; did you mean "phase_lag_deg"?'),
        (("--y", "position", "--out", "a.gif"), '"a.gif": expected a picture ending in .pdf, .svg, .png'),
        (("--y", "position", "--where", "rpm=7"), "no case has rpm 7"),
        (
            ("--y", "position"),
            "figure plot: the trajectory of rpm 0 was not kept (kept: rpm 460); run with --keep-trajectories for all",
        ),
        (
            ("--y", "motor_current", "--x", "motor_voltage", "--where", "rpm=0"),
            "figure plot: the trajectory of rpm 0 was not kept (kept: rpm 460); run with --keep-trajectories for all",
        ),
    ],
)
def test_a_plot_that_cannot_be(drawn: Path, options: tuple[str, ...], said: str) -> None:
    assert workbench("plot", drawn, *options) == (2, "", f"error: {said}\n")


def test_a_signal_that_some_cases_lack_is_drawn_of_the_others(tmp_path: Path) -> None:
    """The plant of rpm 0 does not turn."""
    out = ran(tmp_path, STUDY, "--keep-trajectories")
    picture = out / "figures" / "rotation_speed_over_time.png"
    said = f"left out: rpm 0 (no rotation_speed)\nwrote {picture}\n"
    assert workbench("plot", out, "--y", "rotation_speed") == (0, said, "")
    assert workbench("plot", out, "--y", "position", "--x", "rotation_speed").out.startswith("left out: rpm 0 (no rot")
    alone = workbench("plot", out, "--y", "motor_voltage", "--where", "rpm=0")
    fails(alone, 'nothing called "motor_voltage" is stored of rpm 0; ')
    unlike = workbench("plot", out, "--y", "qqq", "--where", "rpm=0")
    told, _, more = unlike.err.partition('"qqq" is stored of rpm 0; expected one of ')[2].strip().partition(" and ")
    signals, listed = pd.read_parquet(trajectory_path(out, 0)), set(told.split(", "))
    known = set(signals.columns[signals.notna().any()])
    assert listed < known
    assert more == f"{len(known - listed)} more"


def test_no_figures(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    assert workbench("plot", out) == (
        2,
        "",
        f"error: {out}: its study asks for no figures; say what to draw with --y\n",
    )


def test_one_curve_for_each_value_of_the_other_axes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over rpm, the results of each controller are a curve of their own."""
    frame = pd.DataFrame(
        {
            "rpm": [0, 0, 460, 460],
            "controller": ["p", "pd", "p", "pd"],
            "outcome": ["completed"] * 4,
            "rms_error_m": [4e-3, 3e-3, 2e-3, 1e-3],
        }
    )
    drawn: list[FigureSpec] = []  # the last one in mm, since all is below 1 m

    def watched(spec: FigureSpec, *rest: Any) -> Any:
        drawn.append(spec)
        return draw(spec, *rest)

    monkeypatch.setattr("workbench.study.report.quick_plot.draw", watched)
    quick_plot(tmp_path, frame, "rpm", ["rms_error_m"], {}, tmp_path / "a.png")
    panel = drawn[-1].panels[0]
    assert (panel.y_label, panel.y_unit, panel.legend) == ("rms error", "mm", "outside")
    curves = panel.curves
    assert [curve.label for curve in curves] == ["p", "pd"]
    values = [line.get_ydata().tolist() for line in draw(drawn[-1], frame, tmp_path).axes[0].lines]
    np.testing.assert_allclose(values, [[4.0, 2.0], [3.0, 1.0]])


def over_axis(values: list[Any], axis: str = "references.sine.amplitude", **settings: Any) -> Any:
    """The axes of a figure of the rms error (mm) over an axis with these values."""
    frame = pd.DataFrame(
        {axis: values, "outcome": ["completed"] * len(values), "rms_error_m": 1e-3 * np.arange(1, len(values) + 1)}
    )
    return draw(figure(panel({"y": "rms_error_m"}, x=axis, **settings)), frame, Path()).axes[0]


AXIS_VALUES = {
    "bare numbers are SI": ([0.005, 0.01, 0.04], {"x_unit": "mm"}, [5.0, 10.0, 40.0], "x (mm)"),
    "bare without a unit": ([0.005, 0.01, 0.04], {}, [0.005, 0.01, 0.04], "x"),
    "quantities": (["5 mm", "1 cm", "0.04 m"], {"x_unit": "mm"}, [5.0, 10.0, 40.0], "x (mm)"),
    "the unit of the study": (["5 mm", "1 cm", "0.04 m"], {}, [5.0, 10.0, 40.0], "x (mm)"),
    "SI on request": (["5 mm", "1 cm", "0.04 m"], {"x_unit": "1"}, [0.005, 0.01, 0.04], "x"),
    "zero and a quantity": (["0", "10 mm", "40 mm"], {}, [0.0, 10.0, 40.0], "x (mm)"),
}


@pytest.mark.parametrize("case", AXIS_VALUES)
def test_quantities_stand_where_their_numbers_are(case: str) -> None:
    values, settings, expected, label = AXIS_VALUES[case]
    axes = over_axis(values, **settings)
    np.testing.assert_allclose(np.asarray(axes.lines[0].get_xdata(), dtype=float), expected, rtol=1e-12)
    assert axes.get_xlabel() == label


def test_speeds_of_rotation_stand_where_their_numbers_are() -> None:
    """A bare number is in rpm: 60 rpm are 2 pi rad/s."""
    values = ["0", "60 rpm", "460 rpm"]
    axes = over_axis(values, axis="rpm")
    np.testing.assert_allclose(axes.lines[0].get_xdata(), [0.0, 60.0, 460.0], rtol=1e-12)
    assert axes.get_xlabel() == "x (rpm)"
    turned = over_axis([0, 60, 460], axis="rpm", x_unit="rad/s").lines[0].get_xdata()
    np.testing.assert_allclose(turned, [0.0, 2.0 * np.pi, 46.0 / 6.0 * 2.0 * np.pi], rtol=1e-12)


def test_names_stay_names_on_an_axis() -> None:
    assert list(over_axis(["p", "pd"], axis="controller").lines[0].get_xdata()) == ["p", "pd"]


def test_published_values_stand_beside_quantities(tmp_path: Path) -> None:
    """Whichever way they are written."""
    text = (
        STUDY.replace("[0, 460]", '["120 rpm", "460 rpm"]').replace('"by_rpm"', '"by_rpm"\nmotor_limits = false')
        + HEAD
        + 'x = "rpm"\ny_unit = "deg"\ncurves = [{ y = "phase_lag_deg", published = { "460 rpm" = 3.0, 120 = 4.0 } }]\n'
    )
    out = ran(tmp_path, text)
    study = read_study(out / "study.toml")
    axes = draw(study.file.figures[0], read_results(out), out).axes[0]
    assert [list(line.get_xdata()) for line in axes.lines] == [
        pytest.approx([120.0, 460.0]),
        pytest.approx([460.0, 120.0]),
    ]


@pytest.mark.parametrize(
    ("panel_text", "said"),
    [
        ('x = "rpm"\nx_unit = "mm"', 'panels.0.x_unit: "mm" is not a unit of what is in rpm'),
        ('x = "references.sine.amplitude"\nx_unit = "s"', 'panels.0.x_unit: got "5 mm", expected a quantity in s'),
        ('x = "controller"\nx_unit = "mm"', 'got a unit for "controller", whose value "p" is a name; leave it out'),
        ('x = "max_error_m"\nx_unit = "s"', 'panels.0.x_unit: "s" is not a unit of what is in m'),
    ],
)
def test_check_says_what_cannot_stand_on_an_axis(tmp_path: Path, panel_text: str, said: str) -> None:
    axes = 'rpm = [0, 460]\ncontroller = ["p"]\n"references.sine.amplitude" = ["5 mm", "8 mm"]'
    head = HEAD.replace("x_label", f"{panel_text}\nx_label")
    text = changed("rpm = [0, 460]", axes) + head + 'y_unit = "mm"\ncurves = [{ y = "rms_error_m" }]\n'
    fails(workbench("check", write(tmp_path, text)), said)

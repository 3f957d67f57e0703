"""Tables: numbers in their units beside published ones, as CSV, Markdown and LaTeX."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest
from command import STUDY, ran, workbench

from workbench.errors import UserError
from workbench.publish.tables import shown_number
from workbench.study.report.folder import write_cycles
from workbench.study.report.schema import TableSpec
from workbench.study.report.tables import make_table, write_table
from workbench.study.report.unusual import unusual

FRAME = pd.DataFrame(
    {
        "rpm": [0, 120, 460],
        "outcome": ["completed", "completed", "diverged"],
        "phase_lag_deg": [8.61, 7.985, None],
        "rms_error_m": [3.186e-3, 2.956e-3, None],
        "limit_cycle": ["none", None, None],
        "friction_slope_N_s_per_m": [5117.0, 3585.4, None],
    }
)


def table(**content: Any) -> pd.DataFrame:
    """The table of a spec, over the frame above."""
    return make_table(TableSpec(name="t", title="a title", **content), FRAME)


def test_columns_over_an_axis() -> None:
    found = table(
        index="rpm",
        index_label="rotation (rpm)",
        columns=[
            {"result": "rms_error_m", "label": "rms error", "unit": "mm", "digits": 3},
            {
                "result": "friction_slope_N_s_per_m",
                "label": "slope",
                "unit": "N s/m",
                "published": {"120": 3600.0, "460": 2700.0},
            },
        ],
    )
    assert found.to_dict("list") == {
        "rotation (rpm)": ["0", "120", "460"],
        "rms error (mm)": ["3.19", "2.96", ""],
        "slope (N s/m), this program": ["5117", "3585", ""],
        "published": ["", "3600", "2700"],
        "difference": ["", "-14.6", ""],
        "difference (%)": ["", "-0.41", ""],
    }


def test_two_columns_with_published_values_keep_both() -> None:
    found = table(
        index="rpm",
        columns=[
            {"result": "phase_lag_deg", "label": "lag", "unit": "deg", "published": {"0": 8.55}},
            {"result": "rms_error_m", "label": "rms", "unit": "mm", "published": {"0.0": 3.0}},
        ],
    )
    first = found.iloc[0].to_dict()
    assert first == {
        "rpm": "0",
        "lag (deg), this program": "8.610",
        "lag, published": "8.55",
        "lag, difference": "+0.0600",
        "lag, difference (%)": "+0.70",
        "rms (mm), this program": "3.186",
        "rms, published": "3",
        "rms, difference": "+0.186",
        "rms, difference (%)": "+6.20",
    }


def test_one_result_over_two_axes_stands_side_by_side_with_its_place(tmp_path: Path) -> None:
    frame = pd.DataFrame(
        {
            "scenario": ["a", "a", "a", "b", "b", "b"],
            "controller": ["p", "pd", "pi"] * 2,
            "outcome": ["completed"] * 5 + ["diverged"],
            "rms_error_m": [3e-3, 1e-3, 2e-3, 1e-3, 4e-3, None],
        }
    )
    content = {"index": "controller", "across": "scenario"}
    column = {"result": "rms_error_m", "label": "error", "unit": "mm", "digits": 2}
    spec = TableSpec(name="t", title="a title", columns=[column], **content)
    assert make_table(spec, frame).to_dict("list") == {
        "controller": ["p", "pd", "pi"],
        "error, a (mm)": ["3.0 (3)", "1.0 (1)", "2.0 (2)"],
        "error, b (mm)": ["1.0 (1)", "4.0 (2)", ""],
    }
    _, shown, _ = write_table(spec, frame, tmp_path)
    assert shown.read_text(encoding="utf-8").endswith(
        "\n\nIn brackets the place in the column.\n\n1 of 6 cases: diverged (scenario b, controller pi).\n"
    )


def test_cases_that_did_not_simply_complete_are_named_below_the_table(tmp_path: Path) -> None:
    frame = pd.DataFrame(
        {
            "rpm": [0, 120, 460, 0, 120, 460],
            "controller": ["p"] * 3 + ["pd"] * 3,
            "outcome": ["completed", "stuck", "torque-limited", "completed", "completed", "torque-limited"],
            "rms_error_m": [1e-3] * 6,
        }
    )
    column = {"result": "rms_error_m", "label": "error", "where": {"controller": "pd"}}
    spec = TableSpec(name="t", title="a title", index="rpm", columns=[column])
    _, shown, _ = write_table(spec, frame, tmp_path)
    below = shown.read_text(encoding="utf-8").splitlines()[-1]
    assert below == "1 of 3 cases: torque-limited (rpm 460, controller pd)."
    assert unusual(frame, frame) == [
        "1 of 6 cases: stuck (rpm 120, controller p)",
        "2 of 6 cases: torque-limited (rpm 460, controller p; rpm 460, controller pd)",
    ]
    assert unusual(frame[frame["outcome"] == "stuck"], frame) == ["1 of 1 case: stuck"]
    unchecked = frame.assign(solver_error_m=[1e-9, None, None, None, 1e-9, None], draw=[1, 1, 1, 1, 2, 2])
    assert unusual(unchecked, unchecked)[-1] == "1 of 6 cases: no solver error, a finer integration ends early"


def test_a_table_across_an_axis_has_one_column() -> None:
    column = {"result": "rms_error_m", "label": "error"}
    with pytest.raises(ValueError, match="across: expected index with one column"):
        TableSpec(
            name="t", title="a title", index="rpm", across="controller", columns=[column, {**column, "label": "other"}]
        )


def test_open_axes_are_columns_and_units_are_told_once() -> None:
    frame = pd.DataFrame(
        {"rpm": [0, 0, 460], "controller": ["p", "pd", "p"], "outcome": ["completed"] * 3, "rms_error_m": [1e-3] * 3}
    )
    spec = TableSpec(
        name="t",
        title="t",
        index="rpm",
        compared_with="reference",
        columns=[{"result": "rms_error_m", "label": "rms (mm)", "unit": "mm", "published": {"0": 2.0}}],
    )
    found = make_table(spec, frame)
    assert list(found.columns) == [
        "rpm", "controller", "rms (mm), this program", "reference", "difference", "difference (%)"
    ]  # fmt: skip
    assert found["controller"].tolist() == ["p", "pd", "p"]


def test_rows_of_single_figures() -> None:
    found = table(
        rows=[
            {"where": {"rpm": 0}, "result": "phase_lag_deg", "label": "lag", "unit": "deg", "published": 8.55},
            {"where": {"rpm": 460}, "result": "phase_lag_deg", "label": "lag", "unit": "deg", "published": 7.65},
            {"where": {"rpm": 0}, "result": "limit_cycle", "label": "verdict", "remark": "as expected"},
        ]
    )
    assert found.to_dict("records") == [
        {
            "quantity": "lag",
            "unit": "deg",
            "this program": "8.610",
            "published": "8.55",
            "difference": "+0.0600",
            "difference (%)": "+0.70",
            "remark": "",
        },
        {
            "quantity": "lag",
            "unit": "deg",
            "this program": "",
            "published": "7.65",
            "difference": "",
            "difference (%)": "",
            "remark": "",
        },
        {
            "quantity": "verdict",
            "unit": "",
            "this program": "none",
            "published": "",
            "difference": "",
            "difference (%)": "",
            "remark": "as expected",
        },
    ]


def test_columns_that_are_empty_throughout_are_left_out() -> None:
    found = table(rows=[{"where": {"rpm": 0}, "result": "outcome", "label": "outcome"}])
    assert found.to_dict("records") == [{"quantity": "outcome", "this program": "completed"}]


def test_conditions_of_a_table() -> None:
    columns = [{"result": "phase_lag_deg", "label": "lag"}]
    assert table(index="rpm", where={"rpm": 120}, columns=columns)["lag (deg)"].tolist() == ["7.985"]
    with pytest.raises(UserError, match=r'table t, row "lag": 3 cases for no condition, expected one'):
        table(rows=columns)
    with pytest.raises(UserError, match=r'table t, row "lag": no case for rpm 7, expected one'):
        table(rows=columns, where={"rpm": 7})


@pytest.mark.parametrize(
    ("number", "digits", "text"),
    [
        (3585.43, 4, "3585"),
        (0.0, 4, "0"),
        (0.999986, 4, "1.0000"),
        (0.99951, 3, "1.000"),
        (0.0114, 2, "0.011"),
        (-14.57, 3, "-14.6"),
        (4.926e-05, 4, "4.926e-05"),
        (22166.4, 4, "22166"),
        (5.77e6, 3, "5.77e+06"),
    ],
)
def test_significant_digits(number: float, digits: int, text: str) -> None:
    assert shown_number(number, digits) == text


SPEC = TableSpec(
    name="table_1",
    title="Gain of 50 % & more",
    source="Owen 2001, table_3.1",
    note="K_p ^ ~ # $ {x} \\ y",
    rows=[
        {"where": {"rpm": 0}, "result": "phase_lag_deg", "label": "lag | 0_rpm", "unit": "deg", "published": 8.61},
        {"where": {"rpm": 0}, "result": "limit_cycle", "label": "verdict", "remark": "100 %"},
    ],
)


def test_files(tmp_path: Path) -> None:
    paths = write_table(SPEC, FRAME, tmp_path / "tables")
    assert [path.name for path in paths] == ["table_1.csv", "table_1.md", "table_1.tex"]
    assert paths[0].read_text(encoding="utf-8") == (
        "quantity,unit,this program,published,difference,difference (%),remark\n"
        "lag | 0_rpm,deg,8.610,8.61,0,0.00,\n"
        "verdict,,none,,,,100 %\n"
    )


def test_markdown(tmp_path: Path) -> None:
    lines = write_table(SPEC, FRAME, tmp_path)[1].read_text(encoding="utf-8").splitlines()
    assert lines[0] == "**Gain of 50 % & more**"
    assert [cell.strip() for cell in lines[2].split("|")[1:-1]] == [
        "quantity",
        "unit",
        "this program",
        "published",
        "difference",
        "difference (%)",
        "remark",
    ]
    alignment = [cell[0] + cell[-1] for cell in lines[3].split("|")[1:-1]]
    assert alignment == [":-", ":-", "-:", "-:", "-:", "-:", ":-"]
    assert lines[4].startswith("| lag \\| 0_rpm ")
    assert "Published: Owen 2001, table_3.1." in lines


def test_latex(tmp_path: Path) -> None:
    text = write_table(SPEC, FRAME, tmp_path)[2].read_text(encoding="utf-8")
    assert [text.count(rule) for rule in (r"\toprule", r"\midrule", r"\bottomrule")] == [1, 1, 1]
    aligned = "".join(f"S[table-format={form}]" for form in ("1.3", "1.2", "1.0", "1.2"))
    assert rf"\begin{{tabular}}{{ll{aligned}l}}" in text
    assert r"\label{tab:table_1}" in text
    assert r"{published\tnote{a}\,} & {difference} & {(\unit{\percent})} & {remark} \\" in text
    assert r"lag \textbar{} 0 rpm & \unit{\degree} & 8.610 & 8.61 & 0 & 0.00 &  \\" in text
    assert r"verdict &  & {none} &  &  &  & 100 \% \\" in text
    assert r"\caption{Gain of 50 \% \& more}" in text
    assert r"\item[a] Owen 2001, table\_3.1." in text
    note = r"K\textsubscript{p} \textasciicircum{} \textasciitilde{} \# \$ \{x\} \textbackslash{} y"
    assert rf"\item[] {note}" in text


def test_a_column_for_each_reference_with_its_difference_and_its_source(tmp_path: Path) -> None:
    against = {"thesis, measured": {"0": 9.1}, "another paper": {"120": 8.0, "0": 8.2}}
    column = {"result": "phase_lag_deg", "label": "lag", "unit": "deg", "published": {"0": 8.55}, "against": against}
    sources = {"thesis, measured": "Owen 2001, table 5.3", "another paper": "Somebody 2010"}
    content = {"name": "t", "title": "a title", "index": "rpm", "source": "Owen 2001, table 3.1", "references": sources}
    spec = TableSpec(**content, columns=[column])
    found = make_table(spec, FRAME).to_dict("list")
    assert found == {
        "rpm": ["0", "120", "460"],
        "lag (deg), this program": ["8.610", "7.985", ""],
        "published": ["8.55", "", ""],
        "published, difference": ["+0.0600", "", ""],
        "published, difference (%)": ["+0.70", "", ""],
        "thesis, measured": ["9.1", "", ""],
        "thesis, measured, difference": ["-0.490", "", ""],
        "thesis, measured, difference (%)": ["-5.38", "", ""],
        "another paper": ["8.2", "8", ""],
        "another paper, difference": ["+0.410", "-0.0150", ""],
        "another paper, difference (%)": ["+5.00", "-0.19", ""],
    }
    _, markdown, latex = (path.read_text(encoding="utf-8") for path in write_table(spec, FRAME, tmp_path))
    told = [
        "Published: Owen 2001, table 3.1.",
        "Thesis, measured: Owen 2001, table 5.3.",
        "Another paper: Somebody 2010.",
    ]
    assert markdown.split("\n\n")[2:5] == told
    assert [latex.count(rf"\tnote{{{mark}}}") for mark in "abc"] == [1, 1, 1]
    assert r"\item[b] Owen 2001, table 5.3." in latex


def test_rows_against_several_references() -> None:
    where = {"where": {"rpm": 0}, "result": "phase_lag_deg", "unit": "deg"}
    rows = [
        {**where, "label": "lag", "against": {"a": 8.0, "b": 9.0}},
        {**where, "label": "again", "against": {"b": 8.61}},
    ]
    found = table(references={"a": "A", "b": "B"}, rows=rows)
    assert found.columns.tolist() == [
        *("quantity", "unit", "this program", "a", "a, difference", "a, difference (%)"),
        *("b", "b, difference", "b, difference (%)"),
    ]
    assert found["b, difference"].tolist() == ["-0.390", "0"]
    assert found["a"].tolist() == ["8", ""]


def test_the_command_writes_what_the_study_asks_for(tmp_path: Path) -> None:
    spec = (
        '[[tables]]\nname = "lags"\ntitle = "Lags"\nindex = "rpm"\n'
        'columns = [{ result = "phase_lag_deg", label = "lag", unit = "deg", published = { "460" = 1.0 } }]\n'
    )
    out = ran(tmp_path, STUDY + spec)
    names = [out / "tables" / f"lags.{ending}" for ending in ("csv", "md", "tex")]
    before = [path.read_bytes() for path in names]
    for path in names:
        path.unlink()
    answer = workbench("table", out)
    assert (answer.code, answer.err) == (0, "")
    assert [path.read_bytes() for path in names] == before
    assert answer.out.strip() == before[1].decode().strip()
    lag = pd.read_csv(names[0]).set_index("rpm")["lag (deg), this program"]
    results = pd.read_csv(out / "results.csv").set_index("rpm")["phase_lag_deg"]
    assert lag[460] == pytest.approx(results[460], rel=5e-4)


def test_no_table_of_limit_cycles_without_a_size(tmp_path: Path) -> None:
    """A cycle that is too short to tell may have none yet."""
    planned: Any = SimpleNamespace(axis="m")
    frame = pd.DataFrame({"limit_cycle": ["too_short", "none"], "limit_cycle_amplitude_m": [None, 1e-6]})
    assert write_cycles(planned, frame, tmp_path) == []


def test_a_table_of_no_case_has_its_headings_and_says_so(tmp_path: Path) -> None:
    """Which cases have a verdict is known when they have run."""
    column = {"result": "rms_error_m", "label": "rms", "unit": "mm", "where": {"limit_cycle": "sustained"}}
    spec = TableSpec(name="t", title="a title", index="rpm", columns=[column])
    paths = write_table(spec, FRAME, tmp_path)
    assert paths[0].read_text(encoding="utf-8").splitlines() == ["rpm,rms (mm)"]
    assert "No case has what this table shows." in paths[1].read_text(encoding="utf-8")
    across = TableSpec(name="t", title="a title", index="outcome", across="rpm", columns=[column])
    assert make_table(across, FRAME).columns.tolist() == ["outcome"]

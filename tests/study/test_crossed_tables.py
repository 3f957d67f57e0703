"""Tables over two axes: places within a column, and columns that are of their own cases."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from command import changed, fails, workbench, write

from workbench.errors import UserError
from workbench.study.report.schema import TableSpec
from workbench.study.report.tables import make_table

CROSSED = pd.DataFrame(
    {
        "rpm": [0, 0, 460, 460, 0, 0, 460, 460],
        "controller": ["p", "pd"] * 4,
        "reference": ["sine"] * 4 + ["steps"] * 4,
        "outcome": ["completed"] * 8,
        "phase_lag_deg": [8.0, -12.0, 3.0, -1.0, None, None, None, None],
        "steady_state_error_m": [None] * 4 + [3e-17, 5e-16, 2e-6, 4e-6],
        "hydraulic_power_W": [4.0, -9.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        "solver_error_m": [1e-9] * 8,
    }
)
LAG = {"result": "phase_lag_deg", "label": "lag", "unit": "deg", "digits": 2}
RESTING = {"result": "steady_state_error_m", "label": "rest", "unit": "mm", "digits": 2}


def crossed(**content: Any) -> dict[str, list[Any]]:
    """The table of a spec over the frame above, by column."""
    return make_table(TableSpec(name="t", title="a title", **content), CROSSED).to_dict("list")


def test_side_by_side_no_row_is_lost_where_another_axis_is_open() -> None:
    """Two rpm and two controllers: four lines, the rpm in a column of its own."""
    found = crossed(index="controller", across="reference", where={"reference": "sine"}, columns=[LAG])
    assert found == {
        "controller": ["p", "pd", "p", "pd"],
        "rpm": ["0", "0", "460", "460"],
        "lag, sine (deg)": ["8.0 (3)", "-12 (4)", "3.0 (2)", "-1.0 (1)"],
    }


def test_places_are_by_magnitude_and_of_power_by_value() -> None:
    signed = crossed(index="controller", across="rpm", where={"reference": "sine"}, columns=[LAG])
    assert signed["lag, 0 (deg)"] == ["8.0 (1)", "-12 (2)"]
    power = {"result": "hydraulic_power_W", "label": "power", "unit": "W", "digits": 2}
    paid = crossed(index="controller", across="rpm", where={"reference": "sine"}, columns=[power])
    assert paid["power, 0 (W)"] == ["4.0 (2)", "-9.0 (1)"]


def test_places_can_be_left_out() -> None:
    found = crossed(index="controller", across="rpm", where={"reference": "sine"}, places=False, columns=[LAG])
    assert found["lag, 0 (deg)"] == ["8.0", "-12"]
    with pytest.raises(ValueError, match="places: belongs to a table with across"):
        TableSpec(name="t", title="t", index="rpm", places=False, columns=[LAG])


def test_errors_below_what_is_told_apart_share_a_place() -> None:
    """Both are far below their solver error of 1e-9 m; a stated least size is a number in the unit shown."""
    steps: dict[str, Any] = {"index": "controller", "across": "rpm", "where": {"reference": "steps"}}
    solved = crossed(**steps, columns=[RESTING])
    assert solved["rest, 0 (mm)"] == ["< 1e-06 (1)", "< 1e-06 (1)"]
    assert solved["rest, 460 (mm)"] == ["0.0020 (1)", "0.0040 (2)"]
    stated = crossed(**steps, columns=[{**RESTING, "least": 0.003}])
    assert stated["rest, 460 (mm)"] == ["< 0.003 (1)", "0.0040 (2)"]
    assert stated["rest, 0 (mm)"] == ["< 0.003 (1)"] * 2
    of_rows = crossed(rows=[{**RESTING, "where": {"rpm": 0, "controller": "p", "reference": "steps"}}])
    assert of_rows["this program"] == ["< 1e-06"]


def test_columns_from_different_references() -> None:
    """Lag of the sine's cases beside the steady-state error of the steps' cases, a line a speed of rotation."""
    columns = [{**LAG, "where": {"reference": "sine"}}, {**RESTING, "where": {"reference": "steps"}}]
    found = crossed(index="rpm", where={"controller": "p"}, columns=columns)
    assert found == {"rpm": ["0", "460"], "lag (deg)": ["8.0", "3.0"], "rest (mm)": ["< 1e-06", "0.0020"]}
    assert crossed(index="rpm", columns=columns)["controller"] == ["p", "pd", "p", "pd"]


def test_two_cases_for_one_place_are_told_apart() -> None:
    columns = [{**LAG, "where": {"reference": "sine"}}, RESTING]
    said = (
        'table t: "rest" has two cases for rpm 0: reference sine and reference steps; say which in its where, '
        "or in that of the table"
    )
    with pytest.raises(UserError, match=f"^{said}$"):
        crossed(index="rpm", where={"controller": "p"}, columns=columns)


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        (
            'columns = [{ result = "rms_error_m", label = "e", where = { reference = "sine" } }, '
            '{ result = "max_error_m", label = "m" }]',
            'columns.1: "m" has two cases for rpm 0: reference sine and reference slow; say which',
        ),
        ('columns = [{ result = "rms_error_m", label = "e", where = { reference = "fast" } }]', "no case has"),
        ('columns = [{ result = "rms_error_m", label = "e", where = { ref = "sine" } }]', 'unknown column "ref"'),
        ('columns = [{ result = "rms_error_m", label = "e", least = -1 }]', "greater than or equal to 0"),
        ('places = false\ncolumns = [{ result = "rms_error_m", label = "e" }]', "places: belongs to a table"),
    ],
)
def test_check_says_what_has_no_place(tmp_path: Path, spec: str, said: str) -> None:
    study = changed("rpm = [0, 460]", 'rpm = [0, 460]\nreference = ["sine", "slow"]')
    study += '[references.slow]\nkind = "sine"\namplitude = "1 mm"\nfrequency = "4 Hz"\n'
    table = f'[[tables]]\nname = "t"\ntitle = "t"\nindex = "rpm"\n{spec}\n'
    fails(workbench("check", write(tmp_path, study + table)), said)

"""Rotation against hunting, by the command."""

from pathlib import Path

import pandas as pd
import pytest
from command import STUDIES, workbench

LOOPS = ("pi_50_300", "pi_100_1000", "pi_300_6000")


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory, dots_alone: None) -> pd.DataFrame:
    """Results of studies/hunting_rotation.toml."""
    out: Path = tmp_path_factory.mktemp("hunting_rotation") / "out"
    answer = workbench("run", STUDIES / "hunting_rotation.toml", "--out", out)
    assert (answer.code, answer.err) == (0, "")
    return pd.read_csv(out / "results.csv", keep_default_na=False).set_index(["case", "controller", "rpm"]).sort_index()


@pytest.mark.parametrize("machine", ["thesis_simulation", "thesis_rig"])
@pytest.mark.parametrize("loop", LOOPS)
def test_the_fixed_rod_hunts_and_enough_rotation_ends_it(rows: pd.DataFrame, machine: str, loop: str) -> None:
    verdicts = rows.loc[machine, loop]["limit_cycle"]
    assert verdicts[0] == "sustained"
    lasting = [rpm for rpm, verdict in verdicts.items() if verdict == "sustained"]
    assert max(lasting) < min(set(verdicts.index) - set(lasting)), "once stopped it does not come back at more rpm"
    assert max(lasting) <= 25
    assert "too_short" not in set(verdicts)


def test_the_rod_turns_as_it_is_told_to(rows: pd.DataFrame) -> None:
    turning = rows[rows.index.get_level_values("rpm") > 0]
    real = turning["rotation_speed_mean_rpm"].astype(float)
    assert list(real / turning.index.get_level_values("rpm")) == pytest.approx(len(real) * [1.0], rel=0.02)


def test_what_it_costs_follows_from_the_friction_around_the_rod(rows: pd.DataFrame) -> None:
    """At 50 rpm no loop hunts on either machine; one motor pays for break-away, the other for what was measured."""
    at_50 = rows.xs(50, level="rpm")["motor_electric_power_W"].astype(float)
    assert at_50["thesis_simulation"].min() > 30.0 * at_50["thesis_rig"].max()

"""What the report of a tuning on drawn machines says, of a controller too that cannot be made stable."""

import math
from pathlib import Path

import pytest
from command import Answer, changed
from reported_tuning import STUDY, page, reported, results, table

from workbench.tune.report.tables import number, with_interval
from workbench.tune.result import Quantile

WILD = '[controllers.wild]\ntype = "pid"\nkp = "20000 V/m"\n\n[simulation]'
LIMITS = '[tune.gains.wild]\nkp = { min = "20000 V/m", max = "50000 V/m" }\n'

ON_DRAWS = (
    changed(
        "trials = 16", "trials = 12\ndraws = 8\nfresh_draws = 8\nquantile = 0.5\nwhere = { reference = 'fast' }", STUDY
    )
    .replace("[simulation]", WILD)
    .replace('"p", "pd"', '"p", "pd", "wild"')
) + f"{LIMITS}[uncertainty]\nfriction = 0\n[uncertainty.scale]\nmass = {{ min = 0.8, max = 1.3 }}\n"
"""Half of the machines is a quantile that eight draws bound."""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory, dots_alone: None) -> tuple[Path, Answer]:
    """A tuning on draws, with a controller that no gains make stable."""
    folder = tmp_path_factory.mktemp("drawn")
    return folder / "out", reported(folder, ON_DRAWS)


def test_a_controller_without_feasible_gains_is_told(drawn: tuple[Path, Answer]) -> None:
    out, answer = drawn
    assert answer.code == 0, answer.err
    (line,) = [line for line in answer.out.splitlines() if line.startswith("wild: ")]
    assert "no trial keeps all constraints" in line
    assert line in page(out)
    assert results(out).loc["wild", "outcome"] == line.removeprefix("wild: ").removesuffix(".")
    assert table(out, "tuning").set_index("controller").loc["wild", "outcome"] == "no feasible gains"
    assert not (out / "tuned" / "wild.toml").exists()
    assert not (out / "figures" / "bode_wild.png").exists()
    assert "No loop of wild: " in page(out)


def test_taken_up_again_a_tuning_says_the_same(drawn: tuple[Path, Answer]) -> None:
    """Trials that come from the file leave the same bytes."""
    out, answer = drawn
    before = {name: (out / name).read_bytes() for name in ("results.csv", "trials.csv", "tuning.html")}
    assert reported(out.parent, ON_DRAWS, "--resume") == answer
    assert before == {name: (out / name).read_bytes() for name in before}


def test_quantiles_on_draws_have_intervals(drawn: tuple[Path, Answer]) -> None:
    out, _ = drawn
    cells, rows = table(out, "tuning").set_index("controller"), results(out)
    for name in ("p", "pd"):
        for kind in ("searched", "fresh"):
            for when, key in (("before", "start"), ("after", "tuned")):
                numbers = [rows.loc[name, f"{key}_on_{kind}_{part}"] for part in ("value", "low", "high")]
                value, low, high = map(number, numbers)
                assert cells.loc[name, f"0.5 quantile, {kind} draws, {when}"] == f"{value} ({low} to {high})"
    assert rows.loc["pd", "objective"] == rows.loc["pd", "tuned_on_searched_value"]
    assert rows.loc["pd", "objective_before"] == rows.loc["pd", "start_on_searched_value"]


def test_the_page_says_whether_gains_are_fitted_to_their_draws(drawn: tuple[Path, Answer]) -> None:
    out, _ = drawn
    text, rows = page(out), results(out).loc[["p", "pd"]]
    overlap = (rows["tuned_on_searched_low"] <= rows["tuned_on_fresh_high"]) & (
        rows["tuned_on_fresh_low"] <= rows["tuned_on_searched_high"]
    )
    fine = " and ".join(overlap[overlap].index)
    assert f"No sign of overfitting of {fine}: the intervals on searched and on fresh draws overlap." in text
    assert "Best is pd with a 0.5 quantile of the objective on draws that the search has not seen of " in text
    assert "over 8 drawn machines, the same for every controller, is made small; 8 others check it" in text


def test_an_interval_says_why_it_has_no_end() -> None:
    assert with_interval(Quantile(0.41, 0.38, 0.47, 100), 0.9) == "0.410 (0.380 to 0.470)"
    few = with_interval(Quantile(0.41, 0.38, math.inf, 12), 0.9)
    assert few == "0.410 (0.380 upwards, not bounded by so few draws)"
    failing = with_interval(Quantile(0.41, 0.38, math.inf, 200), 0.9)
    assert failing == "0.410 (0.380 upwards, infinite: runs fail on too many draws)"

"""A dwell that is too short to tell a limit cycle is run on, and nothing else of the row changes."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from command import STUDIES, workbench
from support import registered

from controllers.pid import PID, Gains
from controllers.velocity import filtered_differentiator
from workbench.metrics.evaluate import evaluate
from workbench.metrics.rest import AT_REST
from workbench.simulation.references import Held, ReferenceSignal, Sine, Steps
from workbench.simulation.simulate import Loop, simulate
from workbench.study.resolve import Resolved
from workbench.study.run_on import evaluated, run_on


def hose_fed(kp: float, ki: float, reference: ReferenceSignal, duration: float, limit: float = 120.0) -> Resolved:
    """A PI loop at 1 kHz on hoses of 30 MPa."""
    loop = Loop(PID, Gains(kp, ki, 0.0, 0.0, 0.0, filtered_differentiator(0.002, 1e-3)))
    setup = registered("non_rotating", duration=duration, reference=reference, loop=loop)
    soft = setup.parameters.hydraulics._replace(bulk_modulus=30e6)
    setup = replace(setup, parameters=setup.parameters._replace(hydraulics=soft))
    return Resolved(setup, 0.0, 0.0, hold_limit=limit)


def table_of(folder: Path) -> pd.DataFrame:
    return pd.read_csv(folder / "results.csv", keep_default_na=False).set_index("controller")


@pytest.fixture(scope="module")
def ten(tmp_path_factory: pytest.TempPathFactory) -> tuple[pd.DataFrame, pd.DataFrame, str]:
    """The ten loops held for 12 s, the same held for 120 s, and what the first command printed."""
    base = tmp_path_factory.mktemp("ten")
    text = (STUDIES / "hunting_loops.toml").read_text(encoding="utf-8")
    (base / "long.toml").write_text(text.replace('"12 s"', '"120 s"'), encoding="utf-8")
    short = workbench("run", STUDIES / "hunting_loops.toml", "--out", base / "short")
    long = workbench("run", base / "long.toml", "--out", base / "long")
    assert (short.code, short.err, long.code) == (0, "", 0)
    return table_of(base / "short"), table_of(base / "long"), short.out


def test_ten_loops_that_hunt_are_found(ten: tuple[pd.DataFrame, pd.DataFrame, str]) -> None:
    short, long, printed = ten
    assert list(short["limit_cycle"]) == list(long["limit_cycle"]) == 10 * ["sustained"]
    assert printed.count("| sustained |") == 10
    for figure in ("limit_cycle_amplitude_m", "limit_cycle_period_s"):
        assert list(short[figure].astype(float)) == pytest.approx(list(long[figure].astype(float)), rel=0.02)


def test_the_largest_error_shows_what_the_mean_hides(ten: tuple[pd.DataFrame, pd.DataFrame, str]) -> None:
    short = ten[0]
    largest = short["steady_state_max_error_m"].astype(float)
    swing = short["limit_cycle_amplitude_m"].astype(float)
    assert (largest > 0.45 * swing).all()
    assert (short["steady_state_error_m"].astype(float) < 0.35 * swing).all()


def test_only_the_figures_at_rest_come_from_the_longer_record() -> None:
    case = hose_fed(50.0, 200.0, Steps((10e-3,), 12.0), 12.0)
    run = simulate(case.setup)
    own = evaluate(run, case.setup.reference, 0.0)
    found = evaluated(case, run)
    assert own["limit_cycle"] == "too_short"
    assert found["limit_cycle"] == "sustained"
    changed = {name for name in own if found[name] != own[name]}
    assert changed <= set(AT_REST)
    assert evaluated(case, run) == found, "deterministic"


def test_a_cycle_that_falls_to_a_smaller_one_is_run_on() -> None:
    """In 12 s it only falls; held for 240 s it swings by 0.703 mm, in the last minute as in the one before."""
    case = hose_fed(19.669798561600338, 422.3720923620104, Steps((10e-3,), 12.0), 12.0)
    hydraulics = case.setup.parameters.hydraulics._replace(bulk_modulus=188.70011396739577e6)
    case = replace(case, setup=replace(case.setup, parameters=case.setup.parameters._replace(hydraulics=hydraulics)))
    run = simulate(case.setup)
    assert evaluate(run, case.setup.reference, 0.0)["limit_cycle"] == "decaying"
    found = evaluated(case, run)
    assert found["limit_cycle"] == "sustained"
    assert 0.703e-3 < float(found["limit_cycle_amplitude_m"] or 0.0) < 0.99e-3


def test_it_stops_at_the_limit() -> None:
    for limit, verdict in ((0.0, "too_short"), (12.0, "too_short"), (15.0, "too_short"), (24.0, "sustained")):
        case = hose_fed(50.0, 200.0, Steps((10e-3,), 12.0), 12.0, limit)
        assert evaluated(case, simulate(case.setup))["limit_cycle"] == verdict


def test_the_last_level_is_held_even_where_another_would_follow() -> None:
    case = hose_fed(50.0, 200.0, Steps((10e-3, 20e-3, -20e-3), 12.0), 24.0)
    last = run_on(case)
    assert last is not None
    assert last.cycle.verdict == "sustained"
    alone = run_on(hose_fed(50.0, 200.0, Steps((10e-3, 20e-3), 12.0), 24.0))
    assert last == alone


def test_a_sine_is_not_run_on() -> None:
    assert run_on(hose_fed(50.0, 200.0, Sine(5e-3, 0.5), 12.0)) is None


def test_held() -> None:
    held = Held(Steps((1.0, 2.0, 3.0), 1.0, 0.5), 2.0)
    assert held.dwells(10.0) == [(0.5, 1.5), (1.5, 10.0)]
    assert held.dwells(1.0) == [(0.5, 1.0)]

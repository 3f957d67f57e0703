"""Rotation switched by the speed along: by hand, on the simulated plant, and asked for by a study."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import STUDIES, changed, fails, ran, workbench, write
from position_loops import BELIEF, H

from controllers import rotation_on_demand
from controllers.interface import Reference
from controllers.rotation_on_demand import SWITCHED_ROTATION
from plants.interface import Measurement
from workbench.simulation.simulate import simulate
from workbench.study.reading import read_study
from workbench.study.resolve import resolve
from workbench.study.unfold import unfold

RADIUS = 19e-3
SETTINGS = rotation_on_demand.Settings(switch_speed=0.03)


def turn(speeds: Sequence[float], samples: int = 100) -> tuple[list[float], list[float]]:
    """What is on, and the surface speeds (m/s), after `samples` at each of these speeds along (m/s) in turn."""
    controller = SWITCHED_ROTATION["surface_speed"]
    gains = controller.design(SETTINGS, BELIEF, H)
    state = controller.start(Measurement(0.0, np.nan, np.nan, 0.0), gains)
    position, on, surface = 0.0, [], []
    for speed in speeds:
        for _ in range(samples):
            measured = Measurement(position, np.nan, np.nan, 0.0)
            command, state = controller.step(Reference(5.0, 0.0, 0.0), measured, state, gains, H)
            position += speed * H
        on.append(float(state.on))
        surface.append(float(command))
    return on, surface


def test_switches_with_hysteresis() -> None:
    """On below 30 mm/s, off above 45 mm/s, in either direction; between the two it stays as it was."""
    on, surface = turn([0.0, 0.04, 0.05, 0.04, 0.02, -0.04, -0.05, -0.04, -0.02])
    assert on == [1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0]
    np.testing.assert_allclose(surface, 5.0 * RADIUS * np.array(on), atol=1e-12)


def test_comes_and_goes_no_faster_than_allowed() -> None:
    """5 m/s^2 is 5 mm/s a sample of 1 ms, from standstill, up to 95 mm/s."""
    surface = [turn([0.0], samples)[1][0] for samples in (1, 2, 19, 20)]
    np.testing.assert_allclose(surface, [0.005, 0.01, 0.095, 0.095], rtol=1e-9)


@pytest.mark.parametrize("name", ["switch_speed", "surface_acceleration", "velocity_time_constant"])
def test_settings_that_do_not_serve(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is 0, expected a value above 0"):
        rotation_on_demand.design(SETTINGS._replace(**{name: 0.0}), BELIEF, H)


FAST = (
    changed("rpm = [0, 460]", "rpm = [50]")
    .replace('amplitude = "5 mm"\nfrequency = "2 Hz"', 'amplitude = "20 mm"\nfrequency = "0.5 Hz"')
    .replace('duration = "1 s"', 'duration = "3 s"')
    .replace('transient = "0.4 s"', 'transient = "1 s"')
)
PLANT = 'model = "by_rpm"\nbristle = "isotropic"\n'


def test_a_study_turns_the_rod_only_while_it_moves_slowly(tmp_path: Path) -> None:
    """20 mm at 0.5 Hz reaches 63 mm/s: off in the middle of each stroke, on around its ends."""
    text = FAST.replace('model = "by_rpm"\n', f'{PLANT}rotation = "switched"\nswitch_speed = "30 mm/s"\n')
    study = read_study(write(tmp_path, text))
    run = simulate(resolve(study, unfold(study)[0]).setup)
    late, along = run.time >= 1.0, np.abs(run.signals["velocity"])
    rpm = run.signals["rotation_speed"] * 30.0 / np.pi
    assert np.mean(np.abs(rpm[late & (along > 0.055)])) < 2.5
    np.testing.assert_allclose(rpm[late & (along < 0.020)], 50.0, rtol=0.05)


def test_what_the_shipped_study_says_of_the_fast_sine(tmp_path: Path) -> None:
    """The words under its table, from the rows that they speak of."""
    text = (STUDIES / "rotation_on_demand.toml").read_text(encoding="utf-8")
    short = re.sub(r"(?s)\n\[cases\.hold_.*?(?=\n\[\[tables)", "\n", text).partition("[[tables]]")[0]
    short = short.replace('"slow_sine", ', "").replace("rpm = [25, 50]", "rpm = [50]")
    results = pd.read_csv(ran(tmp_path, short) / "results.csv").set_index(["machine", "case"])
    watts, mm = results["motor_electric_power_W"], 1e3 * results["rms_error_m"]
    note = tomllib.loads(text)["tables"][0]["note"]
    for machine, form in (("thesis_simulation", "{:.0f} W"), ("thesis_rig", "{:.2f} W")):
        assert f"{form} in place of {form}".format(watts[machine, "switched"], watts[machine, "constant"]) in note
        assert f"{mm[machine, 'switched']:.3f} mm in place of {mm[machine, 'constant']:.3f} mm" in note
        assert f"{mm[machine, 'none']:.3f} mm without" in note
    one = "thesis_simulation"
    saved = 1.0 - watts[one, "switched"] / watts[one, "constant"]
    given_up = (mm[one, "switched"] - mm[one, "constant"]) / (mm[one, "none"] - mm[one, "constant"])
    assert f"{100.0 * saved:.0f} % less" in note
    assert f"{100.0 * given_up:.0f} % of what rotation gains is given up" in note
    assert f"Scheduled: {watts[one, 'scheduled']:.0f} W and {mm[one, 'scheduled']:.3f} mm." in note


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ('rotation = "switched"', 'switch_speed belongs to rotation = "switched", which needs one'),
        ('switch_speed = "30 mm/s"', 'switch_speed belongs to rotation = "switched", which needs one'),
        ('rotation = "switched"\nswitch_speed = "0 mm/s"', "greater than 0"),
    ],
)
def test_check_says_what_is_missing(tmp_path: Path, lines: str, said: str) -> None:
    fails(workbench("check", write(tmp_path, FAST.replace('model = "by_rpm"\n', f"{PLANT}{lines}\n"))), said)

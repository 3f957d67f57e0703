"""What a friction estimate is worth beside a measured pressure, a perfect gauge, and none; who may see the gauge."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import workbench, write
from support import registered

from controllers import compensation as comp
from controllers import ekf_compensation as ekf
from controllers.interface import Controller, Reference
from controllers.pid import PID
from controllers.pid import Settings as PidSettings
from controllers.registry import controllers
from controllers.settings import settings_of
from plants.friction_gauge import gauged
from plants.interface import Measurement
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Loop, Run, simulate
from workbench.study.store import read_results

H = 1e-3
BELIEF = registered("rotating_isotropic", duration=1.0).parameters


def made(name: str, **changed: Any) -> tuple[Controller, Any]:
    """A compensator and its gains for the simulated machine at rest around the rod."""
    believed = registered("non_rotating", duration=1.0).parameters
    law = changed.get("law", "valve_inversion")
    if name == "pid":
        return PID, PID.design(PidSettings(kp=500.0, **changed), believed, H)
    if name == "ekf":
        return ekf.ekf_compensator(law), ekf.design(ekf.Settings(**changed), believed, H)
    return comp.compensator(name, law), comp.design(comp.Settings(**changed), believed, H)


def fast_sine(name: str, **changed: Any) -> Run:
    """20 mm at 0.5 Hz over three periods at 0 rpm, what is believed being true."""
    setup = registered("non_rotating", duration=6.0, reference=Sine(0.02, 0.5), loop=Loop(*made(name, **changed)))
    return simulate(replace(setup, plant=gauged(setup.plant)) if name == "friction_gauge" else setup)


def rms(run: Run, signal: str) -> float:
    return float(np.sqrt(np.mean(run.signals[signal][run.time >= 2.0] ** 2)))


FOUND = [
    ("tafazoli", {"law": "acceleration_feedback"}, 0.2358),
    ("tafazoli", {}, 0.0539),
    ("ekf", {}, 0.0542),
    ("lugre", {}, 0.0535),
    ("static_map", {}, 0.0518),
    ("load_pressure", {"pressure_time_constant": 0.0}, 0.0530),
    ("load_pressure", {"pressure_time_constant": 0.0, "lead": 1.0}, 0.0037),
]
"""rms of the error (mm), found by an independent reading of the program before there was a `load_pressure`."""


@pytest.mark.parametrize(("name", "changed", "expected"), FOUND)
def test_the_law_and_the_lag_decide_not_the_friction_model(name: str, changed: dict[str, Any], expected: float) -> None:
    assert rms(fast_sine(name, **changed), "error") * 1e3 == pytest.approx(expected, abs=1e-4)


def test_a_bad_estimate_tracks_as_well_as_a_perfect_one() -> None:
    """The static map, which knows no presliding, is 127 N wrong, the gauge not at all."""
    worst, perfect = fast_sine("static_map"), fast_sine("friction_gauge")
    assert rms(worst, "friction_estimate_error") == pytest.approx(127.0, abs=1.0)
    assert rms(perfect, "friction_estimate_error") < 1e-9
    assert rms(worst, "error") < rms(perfect, "error") < 0.055e-3
    assert rms(fast_sine("friction_gauge", lead=1.0), "error") < 0.2 * rms(perfect, "error")


def test_the_measured_pressure_is_friction_and_inertia() -> None:
    """What `load_pressure` has in the place of friction is off it by M a: 34 kg, 0.197 m/s^2, rms 4.75 N on a sine."""
    run = fast_sine("load_pressure", pressure_time_constant=0.0)
    assert rms(run, "friction_estimate_error") == pytest.approx(34.0 * 0.02 * math.pi**2 / math.sqrt(2.0), rel=0.01)
    expected = run.signals["load_pressure"] * 6.33e-4
    assert run.signals["controller_friction"] == pytest.approx(expected, rel=1e-9, abs=1e-6)


def test_a_short_low_pass_of_the_pressure_costs_nothing_and_keeps_the_loop_from_ringing() -> None:
    """Raw, with the whole lead, the start of the sine (a jump of the velocity by 63 mm/s) rings for most of a second at
    the amplifier's limit; a pole of 2 ms, as the velocity has, leaves 0.0002 mm more in the steady motion.
    """
    raw, filtered = (fast_sine("load_pressure", lead=1.0, pressure_time_constant=t) for t in (0.0, 2e-3))
    assert np.max(np.abs(raw.signals["error"])) > 5e-3
    assert np.mean(np.abs(raw.command[:1000]) > 9.99) > 0.2
    assert np.max(np.abs(filtered.signals["error"])) < 0.2e-3
    assert rms(filtered, "error") < rms(raw, "error") + 0.3e-6
    plain = (rms(fast_sine("load_pressure", pressure_time_constant=t), "error") for t in (0.0, 2e-3))
    assert abs(np.subtract(*plain)) < 0.3e-6


def test_the_lead_of_a_feed_forward_makes_up_for_the_valve_s_lag() -> None:
    """With next to no friction, K_ff (dr + tau ddr) through a lag of tau is K_ff dr, and the error tau ddr / (K_p K_q)
    of the plain feed-forward vanishes. A tenth of the viscous friction keeps the oil column from ringing.
    """
    errors = {}
    for lead in (0.0, 1.0):
        loop = Loop(*made("pid", feedforward=1.0, lead=lead))
        setup = registered("non_rotating", duration=6.0, reference=Sine(0.02, 0.5), loop=loop)
        sides = setup.parameters.friction
        none = {"coulomb": 0.0, "stribeck": 0.0, "bristle_stiffness": 0.0, "bristle_damping": 0.0}
        free = type(sides)(*(side._replace(viscous=0.1 * side.viscous, **none) for side in sides))
        errors[lead] = rms(simulate(replace(setup, parameters=setup.parameters._replace(friction=free))), "error")
    lag = 12e-3 * 0.02 * math.pi**2 / (500.0 * 0.06779)
    assert errors[0.0] == pytest.approx(lag / math.sqrt(2.0), rel=0.1)
    assert errors[1.0] < 0.2 * errors[0.0]


@pytest.mark.parametrize("terms", [{}, {"ki": 300.0}, {"kd": 1.0}, {"ki": 300.0, "kd": 1.0}])
def test_feed_forward_helps_the_whole_pid_family(terms: dict[str, float]) -> None:
    plain, fed = fast_sine("pid", **terms), fast_sine("pid", feedforward=1.0, **terms)
    assert plain.outcome == fed.outcome == "completed"
    assert rms(fed, "error") < 0.25 * rms(plain, "error")


# --- who may see the gauge ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", list(controllers()))
def test_no_other_controller_depends_on_the_gauge(name: str) -> None:
    """Any reading of it gives the same commands, to the last bit; but for the one controller that is made for it."""
    controller = controllers()[name]
    needed = {item.name: 1.0 for item in settings_of(controller.Settings).values() if item.default is None}
    gains = controller.design(controller.Settings(**needed), BELIEF, H)
    given = {reading: _commands(controller, gains, reading) for reading in (math.nan, 0.0, 1e6)}
    if name == "friction_gauge":
        assert controller.gauge
        assert given[0.0] != given[1e6]
    else:
        assert not controller.gauge
        assert given[math.nan] == given[0.0] == given[1e6]


def _commands(controller: Controller, gains: Any, reading: float) -> list[float]:
    def seen(k: int) -> Measurement:
        load = 1e5 * math.cos(0.1 * k)
        return Measurement(1e-3 * math.sin(0.1 * k), 1.5e6 + load, 1.5e6 - load, 3.0, 1.0, reading)

    state, commands = controller.start(seen(0), gains), []
    for k in range(50):
        command, state = controller.step(Reference(1e-3 * k, 1e-2, 1e-3), seen(k), state, gains, H)
        state = controller.commit(command, state, gains, H)
        commands.append(float(command))
    return commands


STUDY = """title = "a study for tests"
[plant]
model = "by_rpm"
bristle = "isotropic"
rotation = "servo"
parameters = "owen2001_simulation"
[axes]
rpm = [0, 25]
controller = ["gauge", "lugre", "p"]
[sensors]
friction_gauge = true
[controllers]
gauge = { type = "friction_gauge" }
lugre = { type = "lugre" }
p = { type = "pid", kp = "500 V/m" }
[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"
[simulation]
duration = "1 s"
transient = "0.5 s"
[probes.estimate_error_N]
signal = "friction_estimate_error"
take = "rms"
"""


def test_a_study_has_the_gauge_and_the_estimate_s_error(tmp_path: Path) -> None:
    """Perfect for the gauge, some newtons for an observer, and no estimate at all for P; with rotation and without."""
    write(tmp_path, STUDY)
    assert workbench("run", tmp_path / "study.toml", "--out", tmp_path / "out").code == 0
    rows = read_results(tmp_path / "out").set_index(["controller", "rpm"])
    for rpm in (0, 25):
        assert rows.loc[("gauge", rpm), "estimate_error_N"] < 1e-9
        assert 0.1 < rows.loc[("lugre", rpm), "estimate_error_N"] < 60.0
        assert np.isnan(rows.loc[("p", rpm), "estimate_error_N"])


def test_a_gauge_needs_a_plant_with_friction_of_its_own() -> None:
    with pytest.raises(ValueError, match="its speed is imposed"):
        gauged(registered("rotating_isotropic_ideal", duration=1.0).plant)

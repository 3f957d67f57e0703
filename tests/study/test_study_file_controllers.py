"""Study files with a mistake in their controllers: types, gains, and settings that have no effect."""

from pathlib import Path

import pytest
from command import DRIVE, STUDY, changed
from mistakes import expect

from controllers.registry import controllers

FORCE = changed('"3 N/m"', '"3 N/m"\nfeedforward = 1', DRIVE)

MISTAKES = {
    "no controllers": (
        changed('[controllers.p]\ntype = "pid"\nkp = "500 V/m"\n', ""),
        "@: controllers: is missing: expected a table such as [controllers.p]",
    ),
    "unknown controller": (
        changed('"pid"', '"pdi"'),
        '@:10: controllers.p.type: unknown controller "pdi"; did you mean "pid"?',
    ),
    "controller without type": (
        changed('type = "pid"\n', ""),
        "@:9: controllers.p.type: is missing; this key is needed here; expected one of " + ", ".join(controllers()),
    ),
    "unknown gain": (changed("kp =", "kpp ="), '@:11: controllers.p.kpp: unknown key; did you mean "kp"?'),
    "missing gain": (
        changed('kp = "500 V/m"\n', ""),
        "@:9: controllers.p.kp: is missing; this key is needed here",
    ),
    "unit of a gain": (
        changed("500 V/m", "500 V"),
        '@:11: controllers.p.kp: got "500 V", expected a quantity in V/m, such as "1 V/m"',
    ),
    "NaN gain": (
        changed('"500 V/m"', "nan"),
        '@:11: controllers.p.kp: got NaN, expected a quantity in V/m, such as "1 V/m"',
    ),
    "two controllers and no axis": (
        STUDY + '[controllers.q]\ntype = "pid"\nkp = 1\n',
        '@:21: controllers.q: there is "p" too: expected an axis controller that says which',
    ),
    "feed-forward of a drive": (
        FORCE,
        "@:6: controllers.p: feedforward needs a plant with a velocity gain (one with a valve); leave it out here",
    ),
    "input of open loop": (
        changed('"pid"\nkp = "3 N/m"', '"open_loop"\ninput = "spring_ende"', DRIVE),
        '@:8: controllers.p.input: plant drive_force has no input "spring_ende"; did you mean "spring_end"?',
    ),
    "hold of open loop": (
        changed('"pid"\nkp = "3 N/m"', '"open_loop"\nhold = "cubic"', DRIVE),
        "@:8: controllers.p.hold: got 'cubic', expected one of linear, zero",
    ),
    "idle law setting": (
        changed('"pid"\nkp = "500 V/m"', '"lugre"\nlaw = "acceleration_feedback"\nposition_rate = 34'),
        '@:12: controllers.p.position_rate: has no effect: it belongs to law = "valve_inversion", and law is '
        '"acceleration_feedback"; leave it out',
    ),
    "idle gain of a law": (
        changed('"pid"\nkp = "500 V/m"', '"lugre"\nlaw = "valve_inversion"\nka = 0.002'),
        '@:12: controllers.p.ka: has no effect: it belongs to law = "acceleration_feedback", and law is '
        '"valve_inversion"; leave it out',
    ),
    "idle estimator setting": (
        changed('"pid"\nkp = "500 V/m"', '"lugre_adaptive"\nlaw = "valve_inversion"\nobserver_gain = 1'),
        "@:12: controllers.p.observer_gain: lugre_adaptive has no use for it here; it uses law, position_rate, "
        "force_rate, compression, lead, injection, sliding_rate, adaptation, velocity, velocity_time_constant, "
        "rotation, rotation_time_constant",
    ),
    "idle adaptation": (
        changed('"pid"\nkp = "500 V/m"', '"friedland_park"\nadaptation = 1'),
        "@:11: controllers.p.adaptation: friedland_park has no use for it here; it uses law, position_rate, "
        "force_rate, compression, lead, observer_gain, exponent, velocity, velocity_time_constant, rotation, "
        "rotation_time_constant",
    ),
    "idle density of a filter": (
        changed('"pid"\nkp = "500 V/m"', '"lugre"\njerk_density = 1\nvelocity = "filter"'),
        '@:11: controllers.p.jerk_density: has no effect: it belongs to velocity = "kalman", and velocity is "filter"; '
        "leave it out",
    ),
    "idle time constant of a Kalman filter": (
        changed('"500 V/m"', '"500 V/m"\nkd = 1\nvelocity = "kalman"\nvelocity_time_constant = "2 ms"'),
        '@:14: controllers.p.velocity_time_constant: has no effect: it belongs to velocity = "filter" or '
        '"thesis_filter", and velocity is "kalman"; leave it out',
    ),
    "idle anti-windup": (
        changed('"500 V/m"', '"500 V/m"\ntracking_time = "1 s"'),
        "@:12: controllers.p.tracking_time: has no effect where ki is 0; leave it out, or set ki",
    ),
    "idle velocity": (
        changed('"500 V/m"', '"500 V/m"\nvelocity_time_constant = "1 ms"'),
        "@:12: controllers.p.velocity_time_constant: has no effect where kd is 0; leave it out, or set kd",
    ),
    "law of the measured load pressure": (
        changed('"pid"\nkp = "500 V/m"', '"load_pressure"\nlaw = "acceleration_feedback"'),
        '@:9: controllers.p: law = "acceleration_feedback" needs a friction estimate, and "load_pressure" has none: '
        'with F^ = A P_L the estimated acceleration (A P_L - F^) / M is always 0; take law = "valve_inversion"',
    ),
    "velocity of the measured load pressure": (
        changed('"pid"\nkp = "500 V/m"', '"load_pressure"\nvelocity = "kalman"'),
        "@:11: controllers.p.velocity: load_pressure has no use for it here; it uses law, position_rate, lead, "
        "pressure_time_constant",
    ),
    "gauge that no rig has": (
        changed('"pid"\nkp = "500 V/m"', '"friction_gauge"'),
        '@: sensors.friction_gauge: is missing: controller type "friction_gauge" needs a gauge of the true friction, '
        "which no rig has; write friction_gauge = true to say so, or take another type",
    ),
    "gauge of an imposed speed": (
        changed('"pid"\nkp = "500 V/m"', '"friction_gauge"').replace(
            'model = "by_rpm"\n', 'model = "by_rpm"\nrotation = "ideal"\n'
        )
        + "[sensors]\nfriction_gauge = true\n",
        "@:22: sensors.friction_gauge: rotating_helical_ideal has no friction gauge: its speed is imposed; take "
        'rotation = "servo"',
    ),
    "idle lead": (
        changed('"500 V/m"', '"500 V/m"\nlead = 1'),
        "@:12: controllers.p.lead: has no effect where feedforward is 0; leave it out, or set feedforward",
    ),
    "time constant of an ignored rotation": (
        changed('"pid"\nkp = "500 V/m"', '"lugre"\nrotation = "ignored"\nrotation_time_constant = "5 ms"'),
        '@:12: controllers.p.rotation_time_constant: has no effect: it belongs to rotation = "measured", and rotation '
        'is "ignored"; leave it out',
    ),
    "feed-forward of a compensator on a drive": (
        changed('"pid"\nkp = "3 N/m"', '"lugre"\nlaw = "acceleration_feedback"\nfeedforward = 1', DRIVE),
        "@:9: controllers.p.feedforward: lugre has no use for it here; it uses law, kp, kd, ka, injection, "
        "sliding_rate, velocity, velocity_time_constant",
    ),
    "negative gain": (
        changed("500 V/m", "-500 V/m"),
        '@:11: controllers.p.kp: got "-500 V/m", expected a value that is not negative',
    ),
    "negative gain of an observer": (
        changed('"pid"\nkp = "500 V/m"', '"friedland_park"\nobserver_gain = -5'),
        "@:11: controllers.p.observer_gain: got -5, expected a value that is not negative",
    ),
    "no blend": (
        changed('"pid"\nkp = "500 V/m"', '"tafazoli"\nblend_velocity = 0'),
        "@:11: controllers.p.blend_velocity: got 0, expected a value above 0",
    ),
    "share": (
        changed('"pid"\nkp = "500 V/m"', '"nonlinear_pi"\nretained = 1.5'),
        "@:11: controllers.p.retained: got 1.5, expected a value between 0 and 1",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(tmp_path: Path, mistake: str) -> None:
    expect(tmp_path, *MISTAKES[mistake])

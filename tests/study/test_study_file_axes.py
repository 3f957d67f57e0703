"""Study files with a mistake in their axes, cases or scenarios: located where it was written."""

from pathlib import Path

import pytest
from command import DRIVE, STUDY, changed
from mistakes import expect, said

SCENARIO = changed("[0, 460]", '[0]\nscenario = ["worn"]')

MISTAKES = {
    "unknown scenario": (
        changed("[0, 460]", '[0]\nscenario = ["won"]') + "[scenarios.worn.plant.scale]\nviscous = 0.5\n",
        '@:8: axes.scenario: unknown scenario "won"; did you mean "worn"? (looked in this file, ',
    ),
    "unknown name on an axis": (
        changed("[0, 460]", '[0]\ncontroller = ["q"]'),
        '@:8: axes.controller: unknown controller "q"; expected one of p',
    ),
    "list on an axis": (
        changed("rpm = [0, 460]", 'reference = [["sine"]]'),
        '@:7: axes.reference: unknown reference "[\'sine\']"; did you mean "sine"?',
    ),
    "unknown axis": (
        changed("rpm =", "rmp ="),
        '@:7: axes.rmp: unknown axis; did you mean "rpm"? (or a dotted key of the file)',
    ),
    "empty axis": (
        changed("[0, 460]", "[]"),
        "@:7: axes.rpm: is empty: expected at least one value (or leave the axis out)",
    ),
    "speed of a gain file": (
        changed("[0, 460]", '["fast"]').replace('type = "pid"', 'gains = "p.toml"'),
        "@:7: axes.rpm: got 'fast', expected a speed of rotation, such as 460 or \"460 rpm\"",
    ),
    "value twice": (changed("[0, 460]", "[0, 0]"), "@:7: axes.rpm: holds a value twice"),
    "axis that is no list": (changed("[0, 460]", "0"), "@:7: axes.rpm: got 0: input should be a valid list"),
    "negative rpm": (changed("460", "-460"), "@:7: axes.rpm: got -460, expected a speed that is not negative"),
    "unit of rpm": (
        changed("[0, 460]", '["460 Hz"]'),
        "@:7: axes.rpm: got '460 Hz', expected a speed of rotation, such as 460 or \"460 rpm\"",
    ),
    "rpm of what does not rotate": (
        changed('"by_rpm"', '"non_rotating"'),
        '@:7: axes.rpm: plant "non_rotating" does not rotate: expected rpm 0 (or turned = "rod")',
    ),
    "rpm of a drive": (
        DRIVE + "[axes]\nrpm = [0, 460]\n",
        '@:18: axes.rpm: plant "drive_force" does not rotate: expected rpm 0 (or turned = "rod")',
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(tmp_path: Path, mistake: str) -> None:
    expect(tmp_path, *MISTAKES[mistake])


def test_where_scenarios_were_looked_for(tmp_path: Path) -> None:
    found = said(tmp_path, changed("[0, 460]", '[0]\nscenario = ["won"]'))
    assert found.startswith('@:8: axes.scenario: unknown scenario "won"; expected one of friction_down, ')
    assert found.endswith(f" (looked in this file, {tmp_path / 'scenarios'} and the program's own)")


PLACES = {
    "case": (
        STUDY + '[cases.a]\n[cases.b]\nplant = { set = { mass = "1 m" } }\n',
        "@:23: cases.b.plant.set.mass: ",
    ),
    "case, over the study's own value": (
        STUDY + '[cases.b.controllers.p]\nkp = "1 s"\n',
        "@:22: cases.b.controllers.p.kp: ",
    ),
    "case, a key that is missing": (
        STUDY + '[cases.b.axes]\ncontroller = ["q"]\n[cases.b.controllers.q]\nkp = "1 V/m"\n',
        "@:23: cases.b.controllers.q.type: is missing",
    ),
    "case, unknown table": (STUDY + "[cases.b]\nplnt = {}\n", '@:22: cases.b.plnt: unknown key; did you mean "plant"?'),
    "case, axis": (STUDY + "[cases.b.axes]\nrpm = [0, -1]\n", "@:22: cases.b.axes.rpm: got -1, "),
    "case, empty axis": (STUDY + "[cases.b]\naxes = { rpm = [] }\n", "@:22: cases.b.axes.rpm: is empty"),
    "case, dotted axis": (
        STUDY + '[cases.b.axes]\n"plant.set.coulomb" = ["1 N", "1 m"]\n',
        '@:22: cases.b.axes.plant.set.coulomb: got "1 m", expected a quantity in N',
    ),
    "scenario": (
        SCENARIO + "[scenarios.worn.plant.scale]\nviscous = 0.5\nbulk_modulu = 0.1\n",
        '@:24: scenarios.worn.plant.scale.bulk_modulu: unknown parameter; did you mean "bulk_modulus"?',
    ),
    "scenario, over a case": (
        SCENARIO + '[cases.a.plant.set]\nmass = "30 kg"\n[scenarios.worn.plant.set]\nmass = "-1 kg"\n',
        "@:25: scenarios.worn.plant.set.mass: got -1 kg, ",
    ),
    "case, what is no table": (
        changed("rpm = [0, 460]", '"controllers.p.kp" = [1, 2]') + "[cases.b]\ncontrollers = 3.5\n",
        "@:22: cases.b.controllers: got 3.5, expected a table",
    ),
    "scenario, what is no table": (
        SCENARIO + "[scenarios.worn]\nreferences = 3.5\n",
        "@:23: scenarios.worn.references: got 3.5, expected a table",
    ),
    "scenario, axes": (
        SCENARIO + "[scenarios.worn]\naxes = {}\n",
        "@:23: scenarios.worn.axes: unknown key; expected one of plant, belief, sensors, simulation, ",
    ),
    "dotted axis": (
        changed("rpm = [0, 460]", '"plant.set.coulomb" = ["370 N", "-1 N"]'),
        "@:7: axes.plant.set.coulomb: got -1 N, expected a value that is not negative",
    ),
    "dotted axis of a reference": (
        changed("rpm = [0, 460]", '"references.sine.amplitude" = ["1 mm", "1 kg"]'),
        '@:7: axes.references.sine.amplitude: got "1 kg", expected a quantity in m',
    ),
    "dotted axis of a sensor": (
        changed("rpm = [0, 460]", '"sensors.position.noise" = ["1 kg"]'),
        '@:7: axes.sensors.position.noise: got "1 kg", expected a quantity in m',
    ),
    "dotted axis of tables": (
        changed("rpm = [0, 460]", '"controllers.p" = [{ type = "pid", kp = 1 }, { type = "pid", kp = "1 kg" }]'),
        '@:7: axes.controllers.p.kp: got "1 kg", expected a quantity in V/m',
    ),
    "dotted axis into no table": (
        changed("rpm = [0, 460]", '"plant.model.coulomb" = ["370 N"]'),
        '@:7: axes.plant.model.coulomb: "model" is not a table',
    ),
    "dotted axis of no controller": (
        changed("rpm = [0, 460]", '"controllers.q.kp" = [1, 2]'),
        '@:7: axes.controllers.q.kp: unknown controller "q"; expected one of p',
    ),
}


@pytest.mark.parametrize("place", PLACES)
def test_a_mistake_is_located_where_it_was_written(tmp_path: Path, place: str) -> None:
    text, expected = PLACES[place]
    assert said(tmp_path, text).startswith(expected)

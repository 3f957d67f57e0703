"""Study files with a mistake in them: one line that names file, line, key, what was expected and the nearest name."""

from pathlib import Path

import pytest
from command import DRIVE, STUDY, changed, workbench, write

from controllers.registry import controllers

FORCE = changed('"3 N/m"', '"3 N/m"\nfeedforward = 1', DRIVE)
SCENARIO = changed("[0, 460]", '[0]\nscenario = ["worn"]')
TABLE = '[[tables]]\nname = "t"\ntitle = "t"\n'
FIGURE = '[[figures]]\nname = "f"\ntitle = "f"\n[[figures.panels]]\nx_label = "x"\ny_label = "y"\ny_unit = "mm"\n'


def said(folder: Path, text: str | bytes) -> str:
    """What `workbench run` says of a study, without its folder; nothing is left behind, and `check` says the same."""
    path = folder / "study.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    answer, checked = workbench("run", path, "--out", folder / "out"), workbench("check", path)
    assert (answer.code, answer.out) == (checked.code, checked.out) == (2, "")
    assert answer.err == checked.err
    assert not (folder / "out").exists()
    assert answer.err.startswith("error: ")
    assert answer.err.count("\n") == 1
    return answer.err.removeprefix("error: ").rstrip("\n").replace(str(folder / "study.toml"), "@")


MISTAKES = {
    "unknown key": (changed("model =", "modl ="), '@:3: plant.modl: unknown key; did you mean "model"?'),
    "missing key": (changed('model = "by_rpm"\n', ""), "@:2: plant.model: is missing; this key is needed here"),
    "missing table": (
        changed('[simulation]\nduration = "1 s"\ntransient = "0.4 s"\n', ""),
        "@: simulation.duration: is missing; this key is needed here",
    ),
    "no controllers": (
        changed('[controllers.p]\ntype = "pid"\nkp = "500 V/m"\n', ""),
        "@: controllers: is missing: expected a table such as [controllers.p]",
    ),
    "wrong unit": (
        STUDY + '[plant.set]\nsupply_pressure = "2.94 kg"\n',
        '@:22: plant.set.supply_pressure: got "2.94 kg", expected a quantity in Pa, such as "1 Pa"',
    ),
    "negative mass": (
        STUDY + '[plant.set]\nmass = "-34 kg"\n',
        "@:22: plant.set.mass: got -34 kg, expected a value that is not negative",
    ),
    "unknown parameter": (
        STUDY + '[plant.set]\nsuply_pressure = "2.94 MPa"\n',
        '@:22: plant.set.suply_pressure: unknown parameter "suply_pressure"; did you mean "supply_pressure"?',
    ),
    "truth value": (
        STUDY + "[plant.set]\ncoulomb = true\n",
        "@:22: plant.set.coulomb: got True: input should be a valid number",
    ),
    "scale of nothing": (
        STUDY + "[plant.scale]\nviscos = 2\n",
        '@:22: plant.scale.viscos: unknown parameter; did you mean "viscous"?',
    ),
    "negative scale": (
        STUDY + "[plant.scale]\nviscous = -2.0\n",
        "@:22: plant.scale.viscous: got -2.0, expected a factor that is not negative",
    ),
    "belief": (
        STUDY + '[belief.set]\nmas = "1 kg"\n',
        '@:22: belief.set.mas: unknown parameter "mas"; did you mean "mass"?',
    ),
    "unknown plant": (changed("by_rpm", "by_rmp"), '@:3: plant.model: unknown plant "by_rmp"; did you mean "by_rpm"?'),
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
    "unknown set": (
        changed("owen2001_simulation", "owen2001_simulaton"),
        '@:4: plant.parameters: unknown parameter set "owen2001_simulaton"; did you mean "owen2001_simulation"? '
        "(a file needs the ending .toml)",
    ),
    "set that lacks values": (
        changed("owen2001_simulation", "canudas1995"),
        '@:4: plant.parameters: "canudas1995" does not serve non_rotating: the parameter set lacks ',
    ),
    "unknown kind": (
        changed('"sine"', '"sin"'),
        '@:14: references.sine.kind: unknown kind "sin"; did you mean "sine"?',
    ),
    "unit of a reference": (
        changed("5 mm", "5 kg"),
        '@:15: references.sine.amplitude: got "5 kg", expected a quantity in m, such as "1 m"',
    ),
    "unit of a level": (
        changed('["1 m"]', '["1 m", "2 s"]', DRIVE),
        '@:12: references.step.levels.1: got "2 s", expected a quantity in m, such as "1 m"',
    ),
    "reference without frequency": (
        changed('frequency = "2 Hz"\n', ""),
        "@:13: references.sine.frequency: is missing; this key is needed here",
    ),
    "triangle without height": (
        changed('kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"', 'kind = "triangle"\namplitude = 0\nspeed = 1'),
        "@:15: references.sine.amplitude: got 0.0, expected a value above 0",
    ),
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
    "value twice": (changed("[0, 460]", "[0, 0]"), "@:7: axes.rpm: holds a value twice"),
    "axis that is no list": (changed("[0, 460]", "0"), "@:7: axes.rpm: got 0: input should be a valid list"),
    "negative rpm": (changed("460", "-460"), "@:7: axes.rpm: got -460, expected a speed that is not negative"),
    "unit of rpm": (
        changed("[0, 460]", '["460 Hz"]'),
        "@:7: axes.rpm: got '460 Hz', expected a speed of rotation, such as 460 or \"460 rpm\"",
    ),
    "rpm of what does not rotate": (
        changed('"by_rpm"', '"non_rotating"'),
        '@:7: axes.rpm: plant "non_rotating" does not rotate: expected rpm 0 (or model = "by_rpm")',
    ),
    "rpm of a drive": (
        DRIVE + "[axes]\nrpm = [0, 460]\n",
        '@:18: axes.rpm: plant "drive_force" does not rotate: expected rpm 0 (or model = "by_rpm")',
    ),
    "NaN": (changed('"1 s"', "nan"), '@:19: simulation.duration: got NaN, expected a quantity in s, such as "1 s"'),
    "NaN parameter": (
        STUDY + "[plant.set]\nmass = nan\n",
        "@:22: plant.set.mass: got nan: input should be a finite number",
    ),
    "NaN gain": (
        changed('"500 V/m"', "nan"),
        '@:11: controllers.p.kp: got NaN, expected a quantity in V/m, such as "1 V/m"',
    ),
    "infinity": (changed('"1 s"', "inf"), "@:19: simulation.duration: got inf, expected a finite value"),
    "infinite amplitude": (
        changed("5 mm", "1e400 mm"),
        "@:15: references.sine.amplitude: got inf, expected a finite value",
    ),
    "transient": (changed("0.4 s", "4 s"), "@:18: simulation: transient 4 s leaves nothing of the duration of 1 s"),
    "too long": (
        changed('"1 s"', '"1e9 s"'),
        "@:18: simulation: duration 1e+09 s at a sample_time of 0.001 s: expected between 1 and 2e+07 samples",
    ),
    "method": (
        STUDY + 'method = "rk5"\n',
        "@:21: simulation.method: got \"rk5\", expected 'euler', 'heun', 'rk4' or 'dormand_prince'",
    ),
    "sensor": (
        STUDY + '[sensors.position]\nnoise = "1 kg"\n',
        '@:22: sensors.position.noise: got "1 kg", expected a quantity in m, such as "1 m"',
    ),
    "negative noise": (
        STUDY + '[sensors.pressure_1]\nnoise = "-1 kPa"\n',
        "@:22: sensors.pressure_1.noise: got '-1 kPa', expected a value that is not negative",
    ),
    "half a converter": (
        STUDY + "[sensors.position]\nbits = 12\n",
        "@:21: sensors.position: expected either resolution, or range together with bits",
    ),
    "two controllers and no axis": (
        STUDY + '[controllers.q]\ntype = "pid"\nkp = 1\n',
        '@:21: controllers.q: there is "p" too: expected an axis controller that says which',
    ),
    "feed-forward of a drive": (
        FORCE,
        "@:6: controllers.p: feedforward needs a plant with a velocity gain (a hydraulic one); leave it out here",
    ),
    "valve of a drive": (
        changed('"drive"', '"drive"\nflow = "chapter3"', DRIVE),
        '@:4: plant.flow: plant "drive_force" has no use for it; leave it out',
    ),
    "hose of a drive": (
        DRIVE + "[plant.set]\nbristle_stifness = 1\n",
        '@:18: plant.set.bristle_stifness: unknown parameter "bristle_stifness"; did you mean "bristle_stiffness"?',
    ),
    "parameter without use": (
        DRIVE + '[plant.set]\nvalve_time_constant = "12 ms"\n',
        '@:18: plant.set.valve_time_constant: plant "drive_force" has no use for it; expected one of ',
    ),
    "input of open loop": (
        changed('"pid"\nkp = "3 N/m"', '"open_loop"\ninput = "spring_ende"', DRIVE),
        '@:8: controllers.p.input: plant drive_force has no input "spring_ende"; did you mean "spring_end"?',
    ),
    "hold of open loop": (
        changed('"pid"\nkp = "3 N/m"', '"open_loop"\nhold = "cubic"', DRIVE),
        "@:8: controllers.p.hold: got 'cubic', expected one of linear, zero",
    ),
    "not TOML": ('title = "a"\nrpm = [0, 120\n[plant]\n', "@: not a TOML file: "),
    "binary": (bytes(range(256)), "@: cannot be read as text ("),
    "empty": ("", "@: title: is missing; this key is needed here"),
    "unknown signal": (
        STUDY + '[probes.top]\nsignal = "positon"\ntake = "maximum"\n',
        '@:22: probes.top.signal: unknown signal "positon"; did you mean "position"?',
    ),
    "case of a probe": (
        STUDY + '[probes.top]\nsignal = "position"\ntake = "maximum"\ncases = ["a"]\n',
        '@:24: probes.top.cases: unknown case "a"; none is expected here',
    ),
    "probe of a taken name": (
        STUDY + '[probes.Rms_error_m]\nsignal = "position"\ntake = "maximum"\n',
        "@:21: probes.Rms_error_m: the results have a column of this name already",
    ),
    "unknown column": (
        STUDY + TABLE + 'index = "rpm"\ncolumns = [{ result = "phase_lag", label = "lag" }]\n',
        '@:25: tables.0.columns.0.result: unknown figure "phase_lag"; did you mean "phase_lag_deg"?',
    ),
    "unit of a column": (
        STUDY + TABLE + 'index = "rpm"\ncolumns = [{ result = "phase_lag_deg", label = "lag", unit = "kg" }]\n',
        '@:25: tables.0.columns.0.unit: "kg" is not a unit of what is in deg',
    ),
    "columns alike": (
        STUDY
        + TABLE
        + 'index = "rpm"\ncolumns = [{ result = "gain_ratio", label = "a" }, { result = "outcome", label = "a" }]\n',
        "@:21: tables.0: two columns have the same label: expected different ones",
    ),
    "two tables of one name": (
        STUDY + 2 * (TABLE + 'index = "rpm"\ncolumns = [{ result = "outcome", label = "a" }]\n'),
        '@:27: tables.1.name: "t" is taken: expected another name',
    ),
    "index": (
        STUDY + TABLE + 'index = "rmp"\ncolumns = [{ result = "phase_lag_deg", label = "lag" }]\n',
        '@:24: tables.0.index: unknown axis "rmp"; did you mean "rpm"?',
    ),
    "row of no case": (
        STUDY + TABLE + '[[tables.rows]]\nresult = "phase_lag_deg"\nlabel = "lag"\nwhere = { rpm = 461 }\n',
        "@:27: tables.0.rows.0.where: no case has rpm 461, expected one",
    ),
    "row of two cases": (
        STUDY + TABLE + '[[tables.rows]]\nresult = "phase_lag_deg"\nlabel = "lag"\n',
        "@:24: tables.0.rows.0.where: 2 cases to choose from, expected one",
    ),
    "published where no number is": (
        STUDY + TABLE + 'index = "rpm"\ncolumns = [{ result = "gain_ratio", label = "a", published = { x = 1.0 } }]\n',
        '@:25: tables.0.columns.0.published: got "x", expected a number as rpm has them',
    ),
    "curve of no signal": (
        STUDY + FIGURE + 'curves = [{ y = "motor_current", where = { rpm = 0 } }]\n',
        '@:28: figures.0.panels.0.curves.0.y: unknown signal "motor_current"; ',
    ),
    "curve of two cases": (
        STUDY + FIGURE + 'curves = [{ y = "position" }]\n',
        "@:28: figures.0.panels.0.curves.0.where: 2 cases to choose from, expected one",
    ),
    "condition on no axis": (
        STUDY + FIGURE + 'curves = [{ y = "position", where = { rmp = 0 } }]\n',
        '@:28: figures.0.panels.0.curves.0.where.rmp: unknown axis "rmp"; did you mean "rpm"?',
    ),
    "unit of a panel": (
        STUDY + FIGURE.replace('"mm"', '"bar"') + 'curves = [{ y = "position", where = { rpm = 0 } }]\n',
        '@:27: figures.0.panels.0.y_unit: "bar" is not a unit of what is in m',
    ),
    "idle law setting": (
        changed('"pid"\nkp = "500 V/m"', '"lugre"\nposition_rate = 34'),
        '@:11: controllers.p.position_rate: has no effect: it belongs to law = "valve_inversion", and law is '
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
        "force_rate, lead, injection, sliding_rate, adaptation, velocity, velocity_time_constant",
    ),
    "idle adaptation": (
        changed('"pid"\nkp = "500 V/m"', '"friedland_park"\nadaptation = 1'),
        "@:11: controllers.p.adaptation: friedland_park has no use for it here; it uses law, kp, kd, ka, feedforward, "
        "observer_gain, exponent, velocity, velocity_time_constant",
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
    "feed-forward of a compensator on a drive": (
        changed('"pid"\nkp = "3 N/m"', '"lugre"\nfeedforward = 1', DRIVE),
        "@:8: controllers.p.feedforward: lugre has no use for it here; it uses law, kp, kd, ka, injection, "
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
    "curve of another controller's signal": (
        STUDY + FIGURE + 'curves = [{ y = "controller_friction", where = { rpm = 0 } }]\n',
        '@:28: figures.0.panels.0.curves.0.y: no signal "controller_friction" here; controller "p" (type pid) has '
        "controller_integral, controller_command, controller_error, controller_first, controller_second, "
        "controller_third",
    ),
    "misspelled signal of a controller": (
        STUDY + '[probes.top]\nsignal = "controller_integra"\ntake = "maximum"\n',
        '@:22: probes.top.signal: no signal "controller_integra" here; did you mean "controller_integral"? controller ',
    ),
    "probe of a signal that none of its cases has": (
        STUDY
        + '[probes.top]\nsignal = "controller_theta"\ntake = "final"\ncases = ["a"]\n'
        + '[cases.a]\n[cases.b.controllers]\np = { type = "lugre", kp = 500 }\n',
        '@:22: probes.top.signal: no signal "controller_theta" here; controller "p" (type pid) has ',
    ),
    "legend": (
        STUDY + FIGURE + 'legend = "top"\ncurves = [{ y = "position", where = { rpm = 0 } }]\n',
        "@:28: figures.0.panels.0.legend: got \"top\", expected 'best', ",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(tmp_path: Path, mistake: str) -> None:
    text, expected = MISTAKES[mistake]
    found = said(tmp_path, text)
    if expected.endswith((" ", "(")):
        found = found[: len(expected)]
    assert found == expected


def test_all_missing_and_unknown_keys_come_at_once(tmp_path: Path) -> None:
    """A missing key for which an unknown one is taken is not told twice; each line has its place."""
    text = changed('title = "a study for tests"\n', "").replace("model =", "modl =").replace("duration", "duraton")
    path = write(tmp_path, text + '[[tables]]\nnam = "t"\n[[figures]]\nname = "f"\n')
    lines = workbench("check", path).err.removeprefix("error: ").replace(str(path), "@").splitlines()
    assert lines == [
        '@:21: tables.0.nam: unknown key; did you mean "name"?',
        "@: title: is missing; this key is needed here",
        "@:20: tables.0.title: is missing; this key is needed here",
        "@:22: figures.0.title: is missing; this key is needed here",
        "@:22: figures.0.panels: is missing; this key is needed here",
    ]


def test_all_missing_and_unknown_keys_of_a_case_come_at_once(tmp_path: Path) -> None:
    text = changed("model =", "modl =").replace("duration", "duraton") + "sed = 1\n"
    path = write(tmp_path, text)
    assert workbench("check", path).err.removeprefix("error: ").replace(str(path), "@").splitlines() == [
        '@:3: plant.modl: unknown key; did you mean "model"?',
        '@:19: simulation.duraton: unknown key; did you mean "duration"?',
        '@:21: simulation.sed: unknown key; did you mean "seed"?',
    ]
    path = write(tmp_path, changed("kp =", "gain =") + "[controllers.p.nothing]\na = 1\n")
    assert workbench("check", path).err.removeprefix("error: ").replace(str(path), "@").splitlines() == [
        "@:11: controllers.p.gain: unknown key; expected one of kp, ki, kd, feedforward, tracking_time, velocity, "
        "velocity_time_constant, position_noise, jerk_density, type",
        "@:21: controllers.p.nothing: unknown key; expected one of kp, ki, kd, feedforward, tracking_time, velocity, "
        "velocity_time_constant, position_noise, jerk_density, type",
        "@:9: controllers.p.kp: is missing; this key is needed here",
    ]


def test_where_scenarios_were_looked_for(tmp_path: Path) -> None:
    found = said(tmp_path, changed("[0, 460]", '[0]\nscenario = ["won"]'))
    assert found.startswith('@:8: axes.scenario: unknown scenario "won"; expected one of friction_down, ')
    assert found.endswith(f" (looked in this file, {tmp_path / 'scenarios'} and the program's own)")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (changed('"5 mm"', "20"), "@:13: references.sine: reaches 20 m, the stroke ends at +-0.03 m"),
        (
            changed('"0.4 s"', '"0.6 s"'),
            '@:19: simulation.duration: "sine" has a period of 0.5 s, and after the transient only 0.4 s are left',
        ),
    ],
)
def test_a_warning_is_one_line_and_no_mistake(tmp_path: Path, text: str, expected: str) -> None:
    path = write(tmp_path, text)
    for answer in (workbench("check", path), workbench("run", path, "--dry-run", "--out", tmp_path / "out")):
        assert answer.code == 0
        assert answer.err.replace(str(path), "@") == f"warning: {expected}\n"


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


RECORDED = changed(
    'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"',
    'kind = "recorded"\nfile = "rig.csv"\ntime = "t"\nvalue = "x"\nunit = "mm"',
)
ROWS = "t,x\n0,0\n0.1,1\n0.2,2\n0.3,3\n"


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        (None, "no such file"),
        ("t,y\n0,0\n1,1\n", 'no column "x"; expected one of t, y'),
        ("t,x_\n0,0\n1,1\n", 'no column "x"; did you mean "x_"?'),
        (ROWS + "0.4,four\n", "row 6 holds no finite number"),
        (ROWS + "0.4,inf\n", "row 6 holds no finite number"),
        (ROWS + "0.3,4\n", "row 6: expected a time after that of the row before"),
        ("t,x\n0,0\n1,1\n", "holds 2 rows, expected at least 4"),
        ("", "cannot be read as a table with a header ("),
    ],
)
def test_a_record_that_cannot_be_used(tmp_path: Path, rows: str | None, expected: str) -> None:
    if rows is not None:
        write(tmp_path, rows, "rig.csv")
    assert said(tmp_path, RECORDED).startswith(f"@:13: references.sine: {tmp_path / 'rig.csv'}: {expected}")


def test_a_record_with_a_wrong_unit(tmp_path: Path) -> None:
    write(tmp_path, ROWS, "rig.csv")
    expected = '@:18: references.sine.unit: got "bar", expected a unit such as "m"'
    assert said(tmp_path, RECORDED.replace('"mm"', '"bar"')) == expected


def test_a_parameter_file_of_a_study(tmp_path: Path) -> None:
    """A mistake in a file that the study names is located in both."""
    write(tmp_path, 'title = "a"\nsource = "b"\n[parameters.mass]\nvalue = "1 m"\nsource = "c"\n', "mine.toml")
    found = said(tmp_path, changed("owen2001_simulation", "mine.toml"))
    place = f"@:4: plant.parameters: {tmp_path / 'mine.toml'}:4: parameters.mass.value: "
    assert found == f'{place}got "1 m", expected a quantity in kg, such as "1 kg"'


def test_a_directory_in_place_of_a_file(tmp_path: Path) -> None:
    answer = workbench("run", tmp_path, "--out", tmp_path / "out")
    assert answer.code == 2
    assert answer.err.startswith(f"error: {tmp_path}: cannot be read as text (")
    assert not (tmp_path / "out").exists()


def test_no_file(tmp_path: Path) -> None:
    write(tmp_path, STUDY)
    answer = workbench("check", tmp_path / "stdy.toml")
    assert answer == (2, "", f'error: {tmp_path / "stdy.toml"}: no such file; did you mean "study.toml"?\n')

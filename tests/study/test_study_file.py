"""Study files with a mistake in them: one line that names file, line, key, what was expected and the nearest name.

Here the file as a whole, its sensors and its simulation; the other parts have test files of their own.
"""

from pathlib import Path

import pytest
from command import STUDY, changed, workbench, write
from mistakes import expect

MISTAKES = {
    "missing table": (
        changed('[simulation]\nduration = "1 s"\ntransient = "0.4 s"\n', ""),
        "@: simulation.duration: is missing; this key is needed here",
    ),
    "NaN": (changed('"1 s"', "nan"), '@:19: simulation.duration: got NaN, expected a quantity in s, such as "1 s"'),
    "infinity": (changed('"1 s"', "inf"), "@:19: simulation.duration: got inf, expected a finite value"),
    "transient": (changed("0.4 s", "4 s"), "@:18: simulation: transient 4 s leaves nothing of the duration of 1 s"),
    "too long": (
        changed('"1 s"', '"1e9 s"'),
        "@:18: simulation: duration 1e+09 s at a sample_time of 0.001 s: expected between 1 and 2e+07 samples",
    ),
    "method": (
        STUDY + 'method = "rk5"\n',
        '@:21: simulation.method: unknown integration method "rk5"; did you mean "rk4"?',
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
    "not TOML": ('title = "a"\nrpm = [0, 120\n[plant]\n', "@: not a TOML file: "),
    "binary": (bytes(range(256)), "@: cannot be read as text ("),
    "empty": ("", "@: title: is missing; this key is needed here"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(tmp_path: Path, mistake: str) -> None:
    expect(tmp_path, *MISTAKES[mistake])


def test_all_missing_and_unknown_keys_come_at_once(tmp_path: Path) -> None:
    """A missing key for which an unknown one is taken is not told twice; each line has its place."""
    text = changed('title = "a study for tests"\n', "").replace("model =", "modl =").replace("duration", "duraton")
    path = write(tmp_path, text + '[[tables]]\nnam = "t"\n[[figures]]\nname = "f"\n')
    lines = workbench("check", path).err.removeprefix("error: ").replace(str(path), "@").splitlines()
    assert lines == [
        '@:21: tables.0.nam: unknown key; did you mean "name"?',
        "@: title: is missing; this key is needed here",
        "... and 3 more",
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
        "velocity_time_constant, position_noise, jerk_density, lead, dead_band, dead_band_smoothing, type",
        "@:21: controllers.p.nothing: unknown key; expected one of kp, ki, kd, feedforward, tracking_time, velocity, "
        "velocity_time_constant, position_noise, jerk_density, lead, dead_band, dead_band_smoothing, type",
        "@:9: controllers.p.kp: is missing; this key is needed here",
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (changed('"5 mm"', "20"), "@:13: references.sine: reaches 20 m, the stroke ends at +-0.03 m"),
        (
            changed('"2 Hz"', '"900 Hz"'),
            '@:13: references.sine: "sine" has 900 Hz, and a controller sampled at 1000 Hz sees half of that',
        ),
        (
            changed('"0.4 s"', '"0.6 s"'),
            '@:19: simulation.duration: "sine" has a period of 0.5 s, and after the transient only 0.4 s are left',
        ),
        (
            changed(
                'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"',
                'kind = "steps"\nlevels = ["5 mm"]\ndwell = "1 s"',
            ),
            '@:20: simulation.transient: "sine" jumps for the last time at 0 s, and the transient of 0.4 s leaves '
            "nothing of that to rms_error_m and max_error_m; shorten it, or ask for steady-state errors",
        ),
    ],
)
def test_a_warning_is_one_line_and_no_mistake(tmp_path: Path, text: str, expected: str) -> None:
    path = write(tmp_path, text)
    for answer in (workbench("check", path), workbench("run", path, "--dry-run", "--out", tmp_path / "out")):
        assert answer.code == 0
        assert answer.err.replace(str(path), "@") == f"warning: {expected}\n"


def test_a_directory_in_place_of_a_file(tmp_path: Path) -> None:
    answer = workbench("run", tmp_path, "--out", tmp_path / "out")
    assert answer.code == 2
    assert answer.err.startswith(f"error: {tmp_path}: cannot be read as text (")
    assert not (tmp_path / "out").exists()


def test_no_file(tmp_path: Path) -> None:
    write(tmp_path, STUDY)
    answer = workbench("check", tmp_path / "stdy.toml")
    assert answer == (2, "", f'error: {tmp_path / "stdy.toml"}: no such file; did you mean "study.toml"?\n')

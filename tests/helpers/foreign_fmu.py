"""An FMU that this program did not make, and a study of it."""

import functools
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from workbench.fmu.platforms import binary_place

FOLDER = Path(__file__).parent / "foreign_motor"

DESCRIPTION = (FOLDER / "modelDescription.xml").read_text(encoding="utf-8")

PARAMETERS = 'title = "what is believed of the motor"\nsource = "its data sheet"\n' + "".join(
    f'[parameters.{name}]\nvalue = "{value}"\nsource = "data sheet"\n'
    for name, value in {
        "torque_gain": "0.25 N m/V",
        "voltage_limit": "24 V",
        "inertia": "0.02 kg m^2",
        "load_torque": "0 N m",
        "end_stop_stiffness": "0 N m/rad",
        "end_stop_damping": "0 s/rad",
        "coulomb": "0.4 N m",
        "stribeck": "0 N m",
        "viscous": "0.175 N m s/rad",
        "stribeck_velocity": "0.01 rad/s",
        "bristle_stiffness": "400 N m/rad",
        "bristle_damping": "1 N m s/rad",
    }.items()
)

STUDY = """\
title = "a motor of another maker"
[plant]
model = "rotary_voltage"
parameters = "motor.toml"
fmu = "motor.fmu"
inputs = { drive_voltage = "u" }
outputs = { position = "phi", velocity = "w" }

[axes]
"plant.start_values.coulomb" = ["0 N m", "0.4 N m", "0.8 N m"]

[controllers.pid]
type = "pid"
kp = "100 V/rad"
kd = "4 V s/rad"
ki = "200 V/(rad s)"

[references.sine]
kind = "sine"
amplitude = "10 deg"
frequency = "1 Hz"

[simulation]
duration = "2 s"
transient = "1 s"
"""


@functools.cache
def library() -> bytes:
    """The motor's binary for this platform."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "motor"
        command = ["cc", "-std=c99", "-Wall", "-pedantic", "-Werror", "-O1", "-fPIC", "-shared"]
        subprocess.run([*command, str(FOLDER / "motor.c"), "-o", str(made), "-lm"], check=True)
        return made.read_bytes()


def motor_fmu(folder: Path, description: str = DESCRIPTION, more: Mapping[str, bytes] | None = None) -> Path:
    """The motor's FMU and its parameters in a folder; `more` are further files of the archive."""
    (folder / "motor.toml").write_text(PARAMETERS, encoding="utf-8")
    path = folder / "motor.fmu"
    files = {"modelDescription.xml": description.encode(), binary_place(2, "motor"): library(), **(more or {})}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path

"""What the bench is opened with: a study, a folder of results, a parameter file or a corrected plant, or nothing."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from controllers.belief import drive_gain, moved_mass, velocity_gain
from plants.axis import LINEAR
from plants.interface import Plant
from plants.registry import PLANTS
from workbench.bench.loop import BenchLoop, loop_of
from workbench.bench.measured import PLANT_FILE, measured_loop
from workbench.errors import UserError
from workbench.parameters.sets import axis_of, build, lacks, read_parameters, serves
from workbench.records.experiment import is_experiment
from workbench.study.fmu_plant import refuse_fmu
from workbench.study.layers import layer_of
from workbench.study.names import in_words, matches
from workbench.study.reading import layer_trial, read_study, study_of
from workbench.study.resolve import resolve
from workbench.study.store import STUDY_COPY
from workbench.study.study import Study
from workbench.study.unfold import unfold
from workbench.toml.reading import read_toml

BANDWIDTH = 10.0
"""rad/s, of the loop that a parameter file is opened with."""

DAMPING = 1.4
"""Twice the damping ratio of that loop, where a force drives."""

SWING, STRAIGHT, TURNING = 0.1, 0.01, 0.5
"""Share of the travel that its reference covers to either side; m, or rad, where there are no stops."""

DEFAULT: Mapping[str, Any] = {
    "title": "The thesis's actuator, turning at 120 rpm",
    "plant": {"model": "by_rpm", "parameters": "owen2001_simulation"},
    "controllers": {"p": {"type": "pid", "kp": "500 V/m"}},
    "references": {"sine": {"kind": "sine", "amplitude": "20 mm", "frequency": "0.9 Hz"}},
    "simulation": {"duration": "5 s", "transient": "1.1 s"},
    "axes": {"rpm": [120]},
}


def opened(path: Path | None, where: Mapping[str, object] | None = None) -> BenchLoop:
    """The loop with which the bench begins: the first case of a study that has the values of axes in `where`.

    Args:
        path: a study, machine, scenario or parameter file; a folder of results, whose study it is, or that of an
            identification or diagnosis, whose plant it is; None for the thesis's actuator.
        where: values by axis.

    Raises:
        UserError: none of these, no case with these values, or a mistake in it.
    """
    loop = _opened(path, where or {})
    _ = loop.resolved
    return loop


def _opened(path: Path | None, where: Mapping[str, object]) -> BenchLoop:
    if path is None:
        return _case(study_of(DEFAULT, "", Path("bench")), where)
    if path.is_dir():
        files = [path / name for name in (STUDY_COPY, PLANT_FILE) if (path / name).exists()]
        if not files:
            raise UserError(
                f"{path}: holds neither {STUDY_COPY} nor {PLANT_FILE}; expected a folder of results, of an "
                "identification or of a diagnosis"
            )
        path = files[0]
    data, _ = read_toml(path)
    if "parameters" in data:
        return _plant(path)
    if is_experiment(data):
        return measured_loop(path)
    layer = layer_of(path)
    return _case(read_study(path) if layer is None else layer_trial(layer, path), where)


def _case(study: Study, where: Mapping[str, object]) -> BenchLoop:
    refuse_fmu(study, "the bench")
    cases = unfold(study)
    found = next((case for case in cases if matches(case.columns, where)), None)
    if found is None:
        axes = ", ".join(dict.fromkeys(name for case in cases for name in case.columns))
        raise UserError(f"{study.path}: no case with {in_words(where)}; the axes are {axes or 'none'}")
    resolve(study, found)  # a mistake is told by its line in the file
    return loop_of(study, found)


def _plant(path: Path) -> BenchLoop:
    """A loop around the first plant that a parameter file serves, with a P or PD controller of `BANDWIDTH`."""
    values = read_parameters(path)
    axis = axis_of(values)
    served = [one for one in PLANTS.working().values() if one.axis == axis and lacks(one, values) is None]
    plant = next((one for one in served if not one.rotary_command), None)
    if plant is None:
        raise UserError(f"{path}: {'; '.join(serves(values))}")
    turning = any(one.rotary_command for one in served) and plant.name == "non_rotating"
    amplitude = SWING * float(plant.travel(build(plant.Parameters, values)))
    if not math.isfinite(amplitude):
        amplitude = STRAIGHT if axis == LINEAR else TURNING
    content = {
        "title": str(read_toml(path)[0].get("title", path.stem)),
        "plant": {"model": "by_rpm" if turning else plant.name, "parameters": path.name},
        "controllers": {"pid": {"type": "pid", **_gains(plant, values)}},
        "references": {"sine": {"kind": "sine", "amplitude": amplitude, "frequency": 0.5}},
        "simulation": {"duration": 6.0, "transient": 2.0},
    }
    return _case(study_of(content, "", path.parent / "bench"), {})


def _gains(plant: Plant, values: Mapping[str, float]) -> dict[str, float]:
    """Gains of the bandwidth: K_p = w/K_q of a valve with velocity gain K_q, m w^2 and 1.4 m w over the drive's gain of
    a mass m that a force drives.
    """
    belief = build(plant.Parameters, values)
    try:
        return {"kp": BANDWIDTH / velocity_gain(belief, "the bench").forward}
    except ValueError:
        pass  # no valve: a force drives, or a pump
    try:
        mass, gain = moved_mass(belief), drive_gain(belief)  # type: ignore[arg-type] # some plants have no body
    except AttributeError:
        return {"kp": BANDWIDTH}
    return {"kp": mass * BANDWIDTH**2 / gain, "kd": DAMPING * mass * BANDWIDTH / gain}

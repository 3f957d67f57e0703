"""The numbers of the figures of an identification, apart from their drawing."""

from pathlib import Path

import numpy as np
import pytest
from command import write
from experiments import AXIAL, CURVE, LINE, axial_record

from workbench.identify.identification import identify
from workbench.identify.report.figures.every import figures_of
from workbench.identify.report.figures.friction import friction_data
from workbench.identify.report.figures.over_rpm import over_rpm_data
from workbench.identify.result import Identification
from workbench.identify.thesis.method import steady
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records


@pytest.fixture(scope="module")
def two_speeds(tmp_path_factory: pytest.TempPathFactory) -> Identification:
    """Slow extensions at 0 and 25 rpm, by the thesis's method."""
    folder = tmp_path_factory.mktemp("two_speeds")
    axial_record(folder / "run_a.parquet", CURVE, 0.0)
    axial_record(folder / "run_b.parquet", LINE, 25.0)
    return identify(read_experiment(write(folder, AXIAL, "experiment.toml")), "thesis")


def test_friction_over_velocity_of_one_speed(two_speeds: Identification) -> None:
    """The curve that was found, as far as the record moves, and only in the direction in which it does."""
    data = friction_data(two_speeds, 0.0)
    assert (data.rotary, data.simulated, len(data.measured)) == (False, False, 1)
    assert [curve.source for curve in data.curves] == ["thesis's method"]
    (found,) = data.curves
    assert (found.velocity[0], found.velocity[-1]) == (0.0, pytest.approx(np.nanmax(data.measured[0].velocity)))
    sliding = found.velocity > 1e-3
    expected = steady(found.velocity[sliding], **CURVE)
    np.testing.assert_allclose(found.force[sliding], expected, atol=10.0)


def test_friction_whose_parameter_is_not_declared_is_left_out_with_that_reason(tmp_path: Path) -> None:
    """The record of a cylinder whose areas nobody knows, of a plant that is moved by a force."""
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    text = AXIAL.partition("[[published]]")[0].replace("non_rotating", "drive_force")
    text = text.replace("owen2001_experiment", "canudas1995").replace(
        'column = "valve_voltage", unit = "V"', 'column = "valve_voltage", unit = "N"'
    )
    text = text.replace("valve_voltage =", "command =")
    for figure, name in (("", "friction_velocity"), ('[[figures]]\nname = "slow"\ntitle = "slow"\n', "slow")):
        experiment = read_experiment(write(tmp_path, text + figure, "experiment.toml"))
        figures, left_out = figures_of(Identification(experiment, read_records(experiment), None, None))
        assert figures == {}
        assert left_out == {name: "friction from pressures needs the parameter piston_area_1; set it in [plant.set]"}


def test_a_parameter_over_the_speed_of_rotation(two_speeds: Identification) -> None:
    forward, backward = over_rpm_data(two_speeds, "coulomb").directions
    assert (forward.direction, list(forward.found.rpm)) == ("forward", [0.0, 25.0])
    assert forward.found.values == pytest.approx([330.0, 40.0], abs=10.0)
    (printed,) = forward.published
    assert (list(printed.rpm), list(printed.values), list(printed.stds)) == ([0.0, 25.0], [300.0, 0.0], [0.0, 0.0])
    assert (list(backward.found.rpm), list(backward.published)) == ([], [])

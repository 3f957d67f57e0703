"""What is large on the machine of a record: by what is declared of it, or by what the record shows."""

from pathlib import Path

import numpy as np
import pytest

from workbench.diagnose.residuals.motion import LEVELS, Motion, motion_of
from workbench.diagnose.residuals.scales import LOAD_FRICTIONS, scales_of
from workbench.records.reading import Record


def moved(**channels: np.ndarray) -> Motion:
    """20 mm at 0.5 Hz over 10 s, with other channels."""
    time = 1e-3 * np.arange(10_000)
    draw = np.random.default_rng(1)
    series = {"position": 0.02 * np.sin(np.pi * time) + 1e-7 * draw.standard_normal(time.size), **channels}
    return motion_of(Record("made", Path("made"), "fit", 0.0, time, series, np.ones(time.size, dtype=bool)))


def test_of_a_hydraulic_machine_by_its_data_sheets() -> None:
    values = {
        **{"piston_area_1": 6e-4, "piston_area_2": 4e-4, "supply_pressure": 3e6, "spool_limit": 6e-4},
        **{"valve_flow_gain": 5.9e-4, "voltage_limit": 10.0, "stroke": 0.1, "mass": 30.0, "coulomb": 400.0},
    }
    scales = scales_of([moved()], values)
    assert scales.drive == pytest.approx(6e-4 * 3e6)
    assert scales.conductance * 3e6 == pytest.approx(5.9e-4 * 6e-4 * np.sqrt(1.5e6)), "the rated flow"
    assert (scales.voltage, scales.spool, scales.travel, scales.force) == (10.0, 6e-4, 0.1, 400.0)
    assert scales.flow == pytest.approx(6e-4 * 0.02 * np.pi, rel=0.02)
    assert (scales.turn, scales.sample_time) == (np.inf, pytest.approx(1e-3))


def test_of_a_drive_by_its_limit_or_by_what_it_gave() -> None:
    given = 25.0 * np.cos(np.pi * 1e-3 * np.arange(10_000))
    values = {"mass": 2.0, "coulomb": 4.0}
    assert scales_of([moved(force=given)], {**values, "force_limit": 60.0}).drive == 60.0
    assert scales_of([moved(force=given)], values).drive == pytest.approx(25.0, rel=0.01)
    assert scales_of([moved()], values).drive == pytest.approx(LOAD_FRICTIONS * 4.0)
    turning = scales_of([moved()], {"inertia": 2.0, "coulomb": 4.0, "torque_limit": 12.0})
    assert (turning.drive, turning.turn) == (12.0, pytest.approx(2.0 * np.pi))


def test_the_noise_of_a_fine_sensor_is_its_own_and_of_a_balance_that_of_twelve_bits() -> None:
    fine = moved()
    assert fine.sensed["position"] == pytest.approx(1e-7, rel=0.05)
    assert fine.noise["position"] == pytest.approx(0.04 / LEVELS / np.sqrt(12.0), rel=0.01)


def test_what_moves_as_a_record_begins_is_measured_as_it_moves() -> None:
    begun = moved()
    assert begun.velocity[0] == pytest.approx(0.02 * np.pi, rel=0.01)
    assert begun.position[0] == pytest.approx(0.0, abs=1e-6)


def test_a_record_that_is_blurred_throughout_has_no_better_part() -> None:
    pressed = 1e6 * np.sign(np.sin(2.0 * np.pi * 60.0 * 1e-3 * np.arange(10_000)))
    assert not np.any(moved(pressure_1=pressed).blurred)

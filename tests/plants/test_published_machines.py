"""The machines of measured or published parameter sets, held against figures of their sources.

What could be had, and how sure it is:

- The differential cylinder's friction was measured: the fourth record of the actuator was held out of the fit. Its
  plateaus at 13 mm/s scatter by 0.2 kN within a stroke (the pump's ripple, friction that falls while the rod moves): a
  level is met within 10 % of some 1.8 kN. The records, looked for beside the project in ../shared/data, show no
  stick-slip.
- Of the pneumatic cylinder's publication (Guenther et al. 2006) no more than the abstract could be read: its step and
  sine responses could not be had, and none is compared. What its own numbers, remembered, ask of a simulation is that
  a crawling piston takes F_s = 38.5 N, three digits. The valve's nominal flow is 700 l/min from 6 to 5 bar above the
  atmosphere (data sheet, remembered), in litres of 20 C or of 0 C, which are 9 % apart.

No figure was digitised. Stick-slip periods, velocities for an opening and rise times of these machines could not be
had.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import savgol_filter

from plants.pneumatics import NORMAL_DENSITY, mass_flow
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import ReferenceSignal, Sine, Steps
from workbench.simulation.simulate import Feed, Run, Setup, simulate

RECORD = Path(__file__).parents[3] / "shared" / "data" / "eha" / "exp_data_1_4.csv.gz"
OFFSET = 161.0
"""N, of the records' pressure force: the zero of pressure 2, as the parameter file says."""


def driven(name: str, model: str, voltage: ReferenceSignal, duration: float) -> Run:
    """A machine from rest at mid-stroke, its valve fed with a voltage."""
    plant = plants()[model]
    parameters = build(plant.Parameters, read_parameters(named_sets()[name]))
    state, inputs = plant.equilibrium(parameters, 0.0)
    run = simulate(Setup(plant, parameters, state, inputs, duration, feeds=(Feed("valve_voltage", voltage),)))
    assert run.outcome == "completed"
    return run


def test_the_differential_cylinder_takes_the_force_that_was_measured_either_way() -> None:
    if not RECORD.is_file():
        pytest.skip(f"the measured records are not here: {RECORD}")
    columns = np.genfromtxt(RECORD, delimiter=";", skip_header=1, usecols=(2, 3, 14)).T
    pressure_1, pressure_2 = (0.0625 * columns[0] - 0.625) * 1e5, (0.07576 * columns[1] - 18.333) * 1e5
    area_1, area_2 = (read_parameters(named_sets()["differential_cylinder"])[f"piston_area_{i}"] for i in (1, 2))
    measured = pressure_1 * area_1 - pressure_2 * area_2 - OFFSET
    velocity = savgol_filter(columns[2] * 25e-6, 61, 2, deriv=1, delta=1e-3)
    signals = driven("differential_cylinder", "cylinder", Sine(0.6, 0.5), 4.0).signals
    simulated = signals["pressure_1"] * area_1 - signals["pressure_2"] * area_2
    for way in (1.0, -1.0):
        level = np.mean(measured[np.abs(way * velocity - 13e-3) < 1e-3])
        force = np.mean(simulated[np.abs(way * signals["velocity"] - 13e-3) < 1e-3])
        assert force == pytest.approx(level, rel=0.1)
        assert abs(force) > 1.5e3  # and neither way is the other's: the viscous friction differs with direction
    assert np.max(np.abs(velocity)) < 0.02  # beyond which nothing was measured


def test_the_pneumatic_valve_passes_its_nominal_flow() -> None:
    parameters = build(plants()["pneumatic_cylinder"].Parameters, read_parameters(named_sets()["guenther2006"]))
    air = parameters.pneumatics
    litres = float(mass_flow(air.sonic_conductance, 6e5, 5e5, air)) / NORMAL_DENSITY * 6e4
    assert litres == pytest.approx(700.0, rel=0.09)


def test_a_crawling_pneumatic_piston_takes_the_static_friction_and_a_faster_one_less() -> None:
    """38.5 N at 2 mm/s, a tenth of the Stribeck velocity; less at 25 mm/s. Between them friction falls as speed rises,
    and still the piston does not stick: bristles of 4500 N/m are soft beside the air."""
    forces, lowest = [], []
    for volts, duration in ((0.002, 60.0), (0.02, 8.0)):
        signals = driven("guenther2006", "pneumatic_cylinder", Steps((volts,), duration), duration).signals
        late = slice(3 * len(signals["velocity"]) // 4, None)
        forces.append(np.mean(signals["load_pressure"][late]) * 4.19e-4)
        lowest.append(np.min(signals["velocity"][late]) / np.mean(signals["velocity"][late]))
    assert forces[0] == pytest.approx(38.5, abs=0.2)
    assert forces[1] < forces[0] - 2.0
    assert min(lowest) > 0.9

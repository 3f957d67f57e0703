"""Energy: what valve and motor put into a machine, less what is lost and stored, closes."""

from typing import Any

import numpy as np
import pytest
from drawn_machines import MOTOR, hydraulic, pneumatic
from scipy.integrate import solve_ivp

from plants.equation import from_array, to_array
from plants.interface import Plant
from plants.pneumatics import GAS_CONSTANT
from plants.registry import plants
from workbench.parameters.sets import build

DURATION = 0.4


def oil_power(state: Any, rates: Any, p: Any, q: dict[str, float], frozen: bool) -> tuple[float, float]:
    """Power (W) from pump less to tank, lost over edges and past the piston; and that which compresses the oil."""
    h = p.hydraulics
    forward, backward = max(state.spool_position, 0.0), max(-state.spool_position, 0.0)

    def root(drop: float) -> float:
        return float(np.sign(drop) * np.sqrt(abs(drop))) if abs(drop) > 1e4 else 25e-4 * drop * (5 - (drop / 1e4) ** 2)

    drops = (h.supply_pressure - state.pressure_1, state.pressure_1 - h.tank_pressure)
    others = (h.supply_pressure - state.pressure_2, state.pressure_2 - h.tank_pressure)
    flows = [h.valve_flow_gain * way * root(drop) for way, drop in zip((forward, backward), drops, strict=True)]
    flows += [h.valve_flow_gain * way * root(drop) for way, drop in zip((backward, forward), others, strict=True)]
    put_in = h.supply_pressure * (flows[0] + flows[2]) - h.tank_pressure * (flows[1] + flows[3])
    lost = sum(flow * drop for flow, drop in zip(flows, (*drops, *others), strict=True))
    lost += h.leakage_coefficient * (state.pressure_1 - state.pressure_2) ** 2
    moved = 0.0 if frozen else state.position
    dead_1, dead_2 = (h.hose_volume + q[f"dead_volume_{side}"] for side in (1, 2))
    volume_1 = dead_1 + h.piston_area_1 * (0.5 * h.stroke + moved)
    volume_2 = dead_2 + h.piston_area_2 * (0.5 * h.stroke - moved)
    stored = volume_1 * state.pressure_1 * rates.pressure_1 + volume_2 * state.pressure_2 * rates.pressure_2
    return put_in - lost, stored / h.bulk_modulus


def air_power(state: Any, rates: Any, p: Any, q: dict[str, float], frozen: bool) -> tuple[float, float]:
    """n/(n-1) R T m' that enters the chambers, less the work on the atmosphere; and d/dt P V / (n - 1)."""
    air = p.pneumatics
    n, ambient = air.polytropic_exponent, air.ambient_pressure
    volume_1 = air.dead_volume_1 + air.piston_area_1 * (0.5 * air.stroke + state.position)
    volume_2 = air.dead_volume_2 + air.piston_area_2 * (0.5 * air.stroke - state.position)

    def flow(conductance: float, up: float, down: float) -> float:
        if up < down:
            return -flow(conductance, down, up)
        ratio, b = down / up, air.critical_pressure_ratio
        within = min(max(min(ratio, 0.999) - b, 0.0) / (1.0 - b), 1.0)
        return conductance * 1.185 * up * float(np.sqrt(1.0 - within**2)) * min((1.0 - ratio) / 0.001, 1.0)

    p1, p2, ps = (g + ambient for g in (state.pressure_1, state.pressure_2, air.supply_pressure))
    opened = air.sonic_conductance * abs(state.spool_position) / air.spool_limit
    leak = flow(air.leakage_conductance, p1, p2)
    if state.spool_position >= 0.0:
        m1, m2 = flow(opened, ps, p1) - leak, leak - flow(air.exhaust_gain * opened, p2, ambient)
    else:
        m1, m2 = -flow(air.exhaust_gain * opened, p1, ambient) - leak, flow(opened, ps, p2) + leak
    energy = n / (n - 1.0) * GAS_CONSTANT * air.air_temperature
    around = ambient * (air.piston_area_1 - air.piston_area_2) * state.velocity
    swept = (p1 * air.piston_area_1 - p2 * air.piston_area_2) * state.velocity
    stored = (volume_1 * rates.pressure_1 + volume_2 * rates.pressure_2 + swept) / (n - 1.0)
    return energy * (m1 + m2) - around, stored


MACHINES = [(name, turns) for name in ("cylinder", "two_chamber", "pneumatic_cylinder") for turns in (False, True)]


@pytest.mark.parametrize(("name", "turns"), MACHINES, ids=lambda item: str(item))
@pytest.mark.parametrize("seed", [0, 1])
def test_energy_closes(name: str, turns: bool, seed: int) -> None:
    """To 1e-6 of what is moved, over a run through reversals: fluid, motor, mass, bristles, friction, load."""
    fluid = pneumatic(seed) if name == "pneumatic_cylinder" else {**hydraulic(seed), "leakage_coefficient": 1e-13}
    values = {**fluid, **MOTOR}
    plant: Plant = plants()[name]
    plant = plant.with_turning_rod("isotropic") if turns else plant
    p = build(plant.Parameters, values)
    state, inputs = plant.equilibrium(p, 2.0 * values["piston_radius"] if turns else 0.0)
    power_of = air_power if name == "pneumatic_cylinder" else oil_power
    swing = 0.2 * values["voltage_limit"]

    def balance(time: float, y: np.ndarray) -> np.ndarray:
        """Rates of the states, of the energy that is not accounted for, and of all that is moved."""
        at = from_array(plant.State, y[:-2].tolist())
        fed = inputs._replace(valve_voltage=swing * np.sin(2.0 * np.pi * 5.0 * time))
        rates = plant.derivatives(time, at, fed, p)
        rates = from_array(plant.State, [float(rate) for rate in to_array(rates)])
        shown = plant.signals(time, at, fed, p)
        put_in, stored = power_of(at, rates, p, values, name == "two_chamber")
        kinetic = p.body.mass * at.velocity * rates.velocity
        heat = float(shown.axial_friction) * at.velocity
        electric = 0.0
        if turns:
            motor = p.motor
            speed, spin = at.surface_speed / motor.piston_radius, rates.surface_speed / motor.piston_radius
            electric = fed.motor_voltage * at.motor_current
            heat += float(shown.rotary_friction) * at.surface_speed + motor.bearing_viscous * speed**2
            heat += motor.motor_resistance * at.motor_current**2
            kinetic += motor.rotary_inertia * speed * spin
            stored += motor.motor_inductance * at.motor_current * rates.motor_current
        work = p.body.load_force * at.velocity
        left = put_in + electric - heat - kinetic - stored - work
        return np.array([*to_array(rates), left, abs(put_in) + abs(electric)])

    start = np.array([*[float(number) for number in to_array(state)], 0.0, 0.0])
    end = solve_ivp(balance, (0.0, DURATION), start, "LSODA", rtol=1e-8, atol=1e-9).y[:, -1]
    assert end[-1] > 0.0
    assert abs(end[-2]) < 1e-6 * end[-1]

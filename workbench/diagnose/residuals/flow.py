"""The flow balances: what the valve, or a pump, delivers less what piston and oil take up. And the pressures' sum."""

from collections.abc import Mapping

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import lfilter

from plants import effects as fx
from plants.hydraulics import Hydraulics, internal_leakage, valve_opening
from plants.pump_cylinder import filling_area
from plants.two_chamber import TWO_CHAMBER, chamber_volumes, valve_flows
from workbench.diagnose.residuals.motion import Motion, smoothed, window_points, with_backlash
from workbench.parameters.sets import build

PLATEAU = 0.3
"""s over which a pump's speed has to be steady."""

STEADY = 0.08
"""Share of its largest speed by which it may vary over that time."""


def opening_of(motion: Motion, values: Mapping[str, float], h: Hydraulics) -> np.ndarray:
    """How far (m) the spool opens the ports, smoothed as all else; the overlap's kinks come before the smoothing."""
    step = motion.record.sample_time
    opening = valve_opening(spool_of(motion, values), h)
    return smoothed(opening, window_points(step))[:: round(opening.size / motion.time.size)]


def spool_of(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """The spool's position (m) at every sample, from the voltage: within its travel, delayed, behind the valve's lag.

    The voltage holds from sample to sample, so the lag is solved exactly.
    """
    step, voltage = motion.record.sample_time, motion.voltage
    if voltage is None:
        raise ValueError("a record without the valve's voltage has no spool")
    delay = values.get("command_delay", 0.0)
    if delay:
        time = step * np.arange(voltage.size)
        voltage = np.interp(time - delay, time, voltage)
    limit = values["spool_limit"]
    target = np.clip(values["valve_position_gain"] * voltage, -limit, limit)
    share = -np.expm1(-step / values["valve_time_constant"])
    spool, _ = lfilter([0.0, share], [1.0, share - 1.0], target, zi=[target[0] * (1.0 - share)])
    return np.asarray(spool)


def flow_residuals(motion: Motion, values: Mapping[str, float], flow: str = "derived") -> tuple[np.ndarray, np.ndarray]:
    """Net flow (m^3/s) into each chamber less what its pressure takes up.

        Q_1 - A_1 v - C P_L - V_1 dP_1/dt / beta_1,   A_2 v + C P_L - Q_2 - V_2 dP_2/dt / beta_2

    With `pump_speed` in the place of a valve see `pump_residual`.
    """
    p = build(TWO_CHAMBER.Parameters, values, flow)
    h = p.hydraulics
    motion = with_backlash(motion, p.backlash_width)
    pressure_1 = motion.channels["pressure_1"] - p.pressure_1_offset
    pressure_2 = motion.channels["pressure_2"]
    opening = opening_of(motion, values, h)
    into, out = valve_flows(opening, pressure_1, pressure_2, h._replace(valve_overlap=0.0), p.flow_effects)
    volume_1, volume_2 = chamber_volumes(h, p.area_ratio)
    leakage = internal_leakage(pressure_1 - pressure_2, h)
    stored_1 = volume_1 * motion.rates["pressure_1"] * fx.compliance(pressure_1, h.bulk_modulus, p.flow_effects)
    stored_2 = volume_2 * motion.rates["pressure_2"] * fx.compliance(pressure_2, h.bulk_modulus, p.flow_effects)
    return (
        np.asarray(into - h.piston_area_1 * motion.velocity - leakage - stored_1),
        np.asarray(p.area_ratio * h.piston_area_2 * motion.velocity + leakage - out - stored_2),
    )


def flow_noise(motion: Motion, values: Mapping[str, float]) -> float:
    """Standard deviation (m^3/s) that the sensors' noise alone leaves in a chamber's residual."""
    volume = values["hose_volume"] + 0.5 * values["piston_area_1"] * values["stroke"]
    _, slope, _ = motion.smooth
    parts = [
        values["piston_area_1"] * slope * motion.noise["position"],
        volume / values["bulk_modulus"] * slope * motion.noise["pressure_1"],
    ]
    return float(np.linalg.norm(parts))


def pressure_sum(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """P_1 + P_2 - P_s - P_T (Pa): 0 for a valve of matched edges and equal areas."""
    total = motion.channels["pressure_1"] + motion.channels["pressure_2"] - values.get("pressure_1_offset", 0.0)
    return np.asarray(total - values["supply_pressure"] - values["tank_pressure"])


def on_plateau(motion: Motion) -> np.ndarray:
    """Where the pump's speed is steady. While it runs up, what fills lines and turns valves is no flow of the balance:
    fitted with that, the displacement of a measured pump comes out 9 % too small.
    """
    speed, points = motion.channels["pump_speed"], max(round(PLATEAU / motion.sample_time), 1)
    span = maximum_filter1d(speed, points) - minimum_filter1d(speed, points)
    return np.asarray(span < STEADY * np.max(np.abs(speed)))


def pump_residual(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """Pump's flow (m^3/s) less what the piston and the oil take, on plateaus: D n - A v - C P_L - (V/beta) dP_L/dt.

    As in `plants.pump_cylinder`: D `pump_displacement` (m^3/rad), n `pump_speed` (rad/s), A the area of
    the chamber which fills. Without both pressures leakage and compression are left out.
    """
    area = filling_area(
        motion.velocity, values["piston_area_1"], values["piston_area_2"], values.get("area_ratio", 1.0)
    )
    net = values["pump_displacement"] * motion.channels["pump_speed"] - area * motion.velocity
    if motion.has("pressure_1", "pressure_2"):
        leakage = values.get("leakage_coefficient", 0.0)
        volume = values["hose_volume"] + 0.5 * values["piston_area_1"] * values["stroke"]
        net = net - leakage * (motion.channels["pressure_1"] - motion.channels["pressure_2"])
        net = net - volume / values["bulk_modulus"] * (motion.rates["pressure_1"] - motion.rates["pressure_2"])
    return np.where(on_plateau(motion), net, 0.0)


def pump_speed_errors(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """Error of the pump's speed (rad/s) on plateaus while it turns, the mean of each piece of `PLATEAU`: what its flow
    balance leaves over D, without the pump's ripple.
    """
    speed = np.abs(motion.channels["pump_speed"])
    counts = motion.valid & on_plateau(motion) & (speed > STEADY * np.max(speed))
    error = pump_residual(motion, values) / values["pump_displacement"]
    points = max(round(PLATEAU / motion.sample_time), 1)
    pieces = [slice(start, start + points) for start in range(0, speed.size - points + 1, points)]
    return np.array([np.mean(error[piece]) for piece in pieces if np.all(counts[piece])])

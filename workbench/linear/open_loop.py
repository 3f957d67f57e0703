"""The linearised loop of any plant with any controller, and its stability margins.

    loop = open_loop(setup, 0.03)       # L(z), control.StateSpace at the loop's sample time; closed loop 1 / (1 + L)
    control.bode_plot(loop)
    margins(setup, 0.03)                # gain_dB, phase_deg, gain_frequency, phase_frequency, stable, speed

The plant's Jacobians are exact; the controller's are central differences of the compiled functions that the simulation
runs, which takes any controller, whatever it is made of.
"""

import ctypes
from dataclasses import dataclass

import control
import numpy as np
from scipy.signal import cont2discrete

from plants.equation import fields, to_array
from workbench.errors import UserError
from workbench.linear.linearise import jacobians, measurement_jacobian
from workbench.linear.margins import Margins, margins_of
from workbench.linear.operating_point import OperatingPoint, slide, without_end_stops
from workbench.simulation.compilation import controller_addresses
from workbench.simulation.setup import DELAY_SLACK, Loop, Setup

RELATIVE_STEP = 1e-7
"""Of a central difference, in shares of the quantity's reach. Its square is the truncation where the equation bends on
the scale of the quantity itself; a velocity differentiated from position bends a thousand times sooner and leaves 1e-8,
rounding 1e-9. Linear controllers come out to 1e-9 of their largest gain."""

TURNING = ("surface_speed", "motor_current")
"""States of a plant that a controlled rotation holds."""

_POINTER = ctypes.c_void_p
_STEP = ctypes.CFUNCTYPE(ctypes.c_double, _POINTER, _POINTER, _POINTER, _POINTER, ctypes.c_double)
_COMMIT = ctypes.CFUNCTYPE(None, ctypes.c_double, _POINTER, _POINTER, ctypes.c_double)

Matrices = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class LinearController:
    """x+ = A x + B y, u = C x + D y: deviations of memory, measurement and command, each in units of its reach."""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray


def open_loop(setup: Setup, speed: float) -> control.StateSpace:
    """L(z) of the loop in `setup` about the rod's sliding at `speed` (m/s), broken between amplifier and plant.

    The closed loop is 1 / (1 + L), so that L is what textbooks plot. The break is behind the amplifier: the command
    that a controller learns to have been realised (its `commit`) is its own, as if the plant's gain were uncertain, and
    not the amplifier's. Hence P and the other linear laws keep the L of the textbook, with their anti-windup idle.

    In it: the plant at the operating point of `workbench.linear.operating_point`, its command held over each sample
    (exactly) and its delay, anti-alias filters and the delay of the sensors (exactly, whole samples and the rest), and
    the controller's sampled equations. Rotation stays in the plant: fed with a voltage, that is held as it is there; a
    rotation that is controlled is taken to hold its speed, since its servo is an order of magnitude faster than the
    loop. The growing reference and position are the motion from which deviations count. States that the command does
    not reach or that do not reach the command (a frozen theta, a dither's phase, a motor) are left out; the others
    are in units of their magnitude.

    Raises:
        UserError: the loop does not slide steadily at that speed, or the speed is 0.
    """
    point = slide(setup, speed)
    if point.trouble:
        raise UserError(
            f"plant {setup.plant.name} with controller {setup.loop.controller.name} has no open loop at {speed:g} m/s: "
            f"{point.trouble}; take another speed, or gains with which it slides"
        )
    return control.ss(*_loop_matrices(setup, point), 0.0, setup.sample_time)


def margins(setup: Setup, speed: float) -> Margins:
    """Stability margins of the loop in `setup` about the rod's sliding at `speed` (m/s); see `open_loop`.

    A loop that does not slide steadily is not stable there: its margins are -inf, and `note` says what it does. A call
    takes 2 to 10 ms with OPENBLAS_NUM_THREADS=1; threads make matrices this small many times slower.

    Raises:
        UserError: the speed is 0.
    """
    point = slide(setup, speed)
    if point.trouble:
        return Margins(-np.inf, -np.inf, np.inf, np.inf, False, speed, point.trouble)
    return margins_of(*_loop_matrices(setup, point), setup.sample_time, speed)


def _loop_matrices(setup: Setup, point: OperatingPoint) -> Matrices:
    """A, B, C of L = C (zI - A)^-1 B, without states that play no part in it; end stops do not act, as in the slide."""
    setup = without_end_stops(setup)
    controller = linear_controller(setup.loop, point, setup.sample_time)
    a, b, c, late = _plant_with_filters(setup, point)
    plant = _sampled(a, b, c, setup.sensors.delay + late, setup.sample_time)
    return _joined(plant, controller)


def linear_controller(loop: Loop, point: OperatingPoint, sample_time: float) -> LinearController:
    """The sampled controller about an operating point, by central differences of its compiled step and commit.

    The realised command is the controller's own. Differences are of 1e-7 of each quantity's reach (`RELATIVE_STEP`).
    """
    step_address, commit_address = controller_addresses(loop.controller)
    step, commit = _STEP(step_address), _COMMIT(commit_address)
    gains, reference = to_array(loop.gains), np.ascontiguousarray(point.reference)
    count = point.memory.size
    here = np.concatenate([point.memory, point.measurement])
    scales = _scales(*point.reach)

    def respond(values: np.ndarray) -> np.ndarray:
        memory, measurement = values[:count].copy(), values[count:].copy()
        pointers = (memory.ctypes.data, gains.ctypes.data)
        command = step(reference.ctypes.data, measurement.ctypes.data, *pointers, sample_time)
        commit(command, *pointers, sample_time)
        return np.append(memory, command)

    jacobian = np.zeros((count + 1, here.size))
    for i in np.flatnonzero(np.isfinite(here)):  # a rig without a sensor reads NaN
        above, below = here.copy(), here.copy()
        above[i] += RELATIVE_STEP * scales[i]
        below[i] -= RELATIVE_STEP * scales[i]
        jacobian[:, i] = (respond(above) - respond(below)) / (above[i] - below[i]) * scales[i]
    jacobian[:count] /= scales[:count, None]
    return LinearController(*_quarters(jacobian, count))


def _quarters(jacobian: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
    top, bottom = jacobian[:count], jacobian[count:]
    return top[:, :count], top[:, count:], bottom[:, :count], bottom[:, count:]


def _scales(*reaches: np.ndarray) -> np.ndarray:
    """Magnitudes to divide by: 1 for what never moved or is not measured."""
    reach = np.concatenate(reaches)
    return np.where(np.isfinite(reach) & (reach > 0.0), reach, 1.0)


def _plant_with_filters(setup: Setup, point: OperatingPoint) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """A, B, C of the plant from its command to the readings, in continuous time, with the anti-alias filters; and by
    how much (s) the command comes late, which to the loop is the same as late readings.
    """
    plant, parameters = setup.plant, setup.parameters
    scales = np.array([item.scale for item in fields(plant.State)])
    outputs = _scales(point.reach[1])
    rates, by_inputs = jacobians(plant, parameters, point.state, point.inputs)
    if setup.rotary is not None:
        rates[[i for i, item in enumerate(fields(plant.State)) if item.name in TURNING]] = 0.0
    a = rates * scales / scales[:, None]
    driven, late = plant.input_index(plant.command), 0.0
    for name, delay in plant.delayed.items():  # of those that move it, one side of a valve at a time
        if np.any(by_inputs[:, plant.input_index(name)]):
            driven, late = plant.input_index(name), float(delay(parameters))
    b = by_inputs[:, [driven]] / scales[:, None]
    c = measurement_jacobian(plant, parameters, point.state) * scales / outputs[:, None]
    cutoffs = np.where(np.isnan(point.measurement), 0.0, setup.sensors.cutoffs())
    filtered = np.flatnonzero(cutoffs > 0.0)
    if not filtered.size:
        return a, b, c, late
    low_pass, count = np.diag(cutoffs[filtered]), len(scales)
    shown = np.zeros((len(outputs), count + filtered.size))
    shown[:, :count] = np.where(cutoffs[:, None] > 0.0, 0.0, c)
    shown[filtered, count + np.arange(filtered.size)] = 1.0
    a = np.block([[a, np.zeros((count, filtered.size))], [low_pass @ c[filtered], -low_pass]])
    return a, np.vstack([b, np.zeros((filtered.size, 1))]), shown, late


def _sampled(a: np.ndarray, b: np.ndarray, c: np.ndarray, delay: float, sample_time: float) -> Matrices:
    """The plant from sample to sample, its command held; readings are `delay` (s) old.

    y_k = C x((k - n) h - rest):  C x_k for no delay, else n + 1 registers (n without a rest), of which the first
    takes C x(t_k + h - rest) = C (Phi(h - rest) x_k + Gamma(h - rest) u_k)
    """
    whole = int(np.floor(delay / sample_time + DELAY_SLACK))
    rest = max(delay - whole * sample_time, 0.0)
    late = rest > DELAY_SLACK * sample_time
    a, b, c = _used_by_output(a, b, c)
    phi, gamma = _held(a, b, sample_time)
    registers = whole + late
    if not registers:
        return phi, gamma, c
    ahead, by_command = _held(a, b, sample_time - rest) if late else (np.eye(len(a)), np.zeros_like(b))
    return _with_registers(phi, gamma, c @ ahead, c @ by_command, registers)


def _with_registers(
    phi: np.ndarray, gamma: np.ndarray, taken: np.ndarray, by_command: np.ndarray, count: int
) -> Matrices:
    """The sampled plant with `count` samples of the readings in store; the output is the oldest."""
    states, width = len(phi), len(taken)
    size = states + count * width
    a, b, c = np.zeros((size, size)), np.zeros((size, 1)), np.zeros((width, size))
    a[:states, :states], b[:states] = phi, gamma
    a[states : states + width, :states], b[states : states + width] = taken, by_command
    a[states + width :, states:-width] = np.eye((count - 1) * width)
    c[:, -width:] = np.eye(width)
    return a, b, c


def _held(a: np.ndarray, b: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Phi = exp(A t) and Gamma = integral of exp(A s) B over 0 to t, also where A is singular."""
    phi, gamma, *_ = cont2discrete((a, b, np.eye(len(a)), np.zeros_like(b)), time)
    return phi, gamma


def _used_by_output(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> Matrices:
    """Without the states that the input does not reach, or that do not reach the output, by the pattern of zeros."""
    used = _closure(a, np.any(b != 0.0, axis=1)) & _closure(a.T, np.any(c != 0.0, axis=0))
    return a[np.ix_(used, used)], b[used], c[:, used]


def _closure(a: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Which states the states `start` reach, themselves among them."""
    reached = start
    for _ in range(len(a)):
        reached = reached | np.any(a[:, reached] != 0.0, axis=1)
    return reached


def _joined(plant: Matrices, k: LinearController) -> Matrices:
    """Plant before controller, sign turned: L = -C(z) P(z)."""
    phi, gamma, c = plant
    a = np.block([[phi, np.zeros((len(phi), len(k.a)))], [k.b @ c, k.a]])
    b = np.vstack([gamma, np.zeros((len(k.a), 1))])
    return _used_by_output(a, b, -np.hstack([k.d @ c, k.c]))

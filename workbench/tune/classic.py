"""Classic starting points for a PID: Ziegler and Nichols after a relay experiment, pole placement, LQR.

    for point in starting_points(setup, belief, 0.03):
        point.name, point.settings, point.note

Settings are those of `controllers.pid`: kp (command/m), ki (command/(m s)), kd (command s/m, on the velocity's error).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import control
import numpy as np

from controllers.pid import PID
from controllers.pid import Settings as PidSettings
from plants.equation import NumbersT, fields, from_array, named
from workbench.errors import UserError
from workbench.linear.margins import Margins
from workbench.linear.open_loop import margins
from workbench.linear.slow_model import SlowModel, slow_model
from workbench.simulation.setup import Loop, Numbers, Setup
from workbench.tune.relay_experiment import relay_test

PidGains = dict[str, float]

DAMPING = float(np.sqrt(0.5))
"""Of placed poles: the damping ratio of a second-order Butterworth filter, an overshoot of 4 %."""

GAIN_MARGIN_DB, PHASE_MARGIN_DEG = 6.0, 45.0
"""What the fastest loop of pole placement and LQR has to keep: within the usual 2 to 5, and 30 to 60 degrees (Astrom
and Murray, Feedback Systems, 2008, section 9.3)."""

FREQUENCIES = np.geomspace(1000.0, 1.0, 49)
"""rad/s. Speeds of the closed loop that are tried, from the fastest."""

INTEGRAL_PERIODS = 5.0
"""Of 1 / natural frequency: how long LQR accepts an error of the accepted size."""

RELAY_SHARE = 0.1
"""Amplitude of the relay in shares of a large command."""


@dataclass(frozen=True)
class StartingPoint:
    """Gains to begin with, SI. `controller` is the type, `note` says what was assumed and what margins came out.

    A method that has no answer leaves `settings` empty and says why in `note`; `margins` is then None.
    """

    name: str
    method: str
    controller: str
    settings: PidGains
    note: str
    margins: Margins | None = None


def ziegler_nichols(ultimate_gain: float, ultimate_period: float) -> dict[str, PidGains]:
    """Settings for "p", "pi", "pd", "pid" from ultimate gain K_u (command/m) and ultimate period T_u (s).

        P 0.5 K_u;  PI 0.45 K_u, T_i = T_u/1.2;  PID 0.6 K_u, T_i = T_u/2, T_d = T_u/8;  PD 0.8 K_u, T_d = T_u/8

    with K_i = K_p / T_i and K_d = K_p T_d. J. G. Ziegler, N. B. Nichols, Optimum settings for automatic controllers,
    Trans. ASME 64, 1942; PD is not theirs, but from the tables of later handbooks. They aim at a decay to a quarter,
    which on a plant that integrates leaves little phase margin, with I often none.

    Raises:
        UserError: a gain or a period that is not above 0.
    """
    for name, value in (("ultimate gain", ultimate_gain), ("ultimate period", ultimate_period)):
        if not (np.isfinite(value) and value > 0.0):
            raise UserError(f"{name} is {value:g}, expected a value above 0")
    k, t = ultimate_gain, ultimate_period
    return {
        "p": _gains(0.5 * k),
        "pi": _gains(0.45 * k, ki=0.45 * k * 1.2 / t),
        "pd": _gains(0.8 * k, kd=0.8 * k * t / 8.0),
        "pid": _gains(0.6 * k, ki=0.6 * k * 2.0 / t, kd=0.6 * k * t / 8.0),
    }


def _gains(kp: float, ki: float = 0.0, kd: float = 0.0) -> PidGains:
    return {"kp": float(kp), "ki": float(ki), "kd": float(kd)}


def _with_integral(model: SlowModel) -> tuple[np.ndarray, np.ndarray]:
    """The model's A and B over position, velocity and the position's integral."""
    a, b = model.matrices()
    whole = np.zeros((3, 3))
    whole[:2, :2], whole[2, 0] = a, 1.0
    return whole, np.vstack([b, [[0.0]]])


def pole_placement(
    model: SlowModel, natural_frequency: float, damping: float = DAMPING, integral_pole: float = 0.0
) -> PidGains:
    """PD or PID whose closed loop with the slow model has the poles that are asked for (`control.acker`).

        (s^2 + 2 zeta w s + w^2)                     PD:  K_p = (w^2 - a0) / b,  K_d = (2 zeta w - a1) / b
        (s^2 + 2 zeta w s + w^2) (s + p)             PID, p = `integral_pole` (1/s), 0: PD

    Args:
        natural_frequency: w (rad/s), above 0.
        damping: zeta (1), above 0.

    Raises:
        UserError: an argument out of its range, or poles that need a negative gain: slower than the plant's own.
    """
    if not (natural_frequency > 0.0 and damping > 0.0 and integral_pole >= 0.0):
        raise UserError(
            f"poles of {natural_frequency:g} rad/s, damping {damping:g}, integral pole {integral_pole:g} 1/s: "
            "expected values above 0 (0 for no integral)"
        )
    real, imaginary = -damping * natural_frequency, natural_frequency * np.sqrt(complex(damping**2 - 1.0))
    poles = [real + imaginary, real - imaginary]
    if integral_pole:
        gains = control.acker(*_with_integral(model), [*poles, -integral_pole]).ravel()
    else:
        gains = np.append(control.acker(*model.matrices(), poles).ravel(), 0.0)
    kp, kd, ki = (float(np.real(value)) for value in gains)
    if min(kp, kd, ki) < 0.0:
        raise UserError(
            f"poles of {natural_frequency:g} rad/s, damping {damping:g} need kp {kp:.4g}, ki {ki:.4g}, kd {kd:.4g}; "
            "a PID has no negative gain: the plant's own poles are faster; ask for a higher frequency or damping"
        )
    return _gains(kp, ki, kd)


def lqr(model: SlowModel, acceptable_error: float, largest_command: float, integral_time: float = np.inf) -> PidGains:
    """PD or PID that minimises the integral of (e/e_m)^2 + (u/u_m)^2 + (int e dt / (e_m T))^2 (`control.lqr`).

    Bryson's weights: one over the square of what is acceptable. The velocity has none.

    Args:
        acceptable_error: e_m (m). largest_command: u_m. integral_time: T (s), infinite for a PD.

    Raises:
        UserError: an argument that is not above 0, or a command without a finite limit.
    """
    if not (0.0 < acceptable_error < np.inf and 0.0 < largest_command < np.inf and integral_time > 0.0):
        raise UserError(
            f"acceptable error {acceptable_error:g} m, largest command {largest_command:g}, integral time "
            f"{integral_time:g} s: expected finite values above 0 (an infinite time for a PD)"
        )
    weights = [1.0 / acceptable_error**2, 0.0]
    matrices = model.matrices()
    if np.isfinite(integral_time):
        weights.append(1.0 / (acceptable_error * integral_time) ** 2)
        matrices = _with_integral(model)
    gains, _, _ = control.lqr(*matrices, np.diag(weights), np.array([[largest_command**-2]]))
    kp, kd, ki = np.append(np.ravel(gains), 0.0)[:3]
    return _gains(kp, ki, kd)


def starting_points(
    setup: Setup, belief: Numbers, speed: float, largest_command: float | None = None
) -> list[StartingPoint]:
    """What a control engineer would begin with, by each of the classic methods, with the margins that it has.

    Ziegler and Nichols's settings come from a relay experiment on the rig, `setup`, with a relay of a tenth of the
    largest command. Pole placement and LQR use the belief alone: its slow model, and the fastest closed loop whose
    margins on the whole believed plant, sampling and velocity filter included, are 6 dB and 45 degrees. LQR's accepted
    error is the one that gives an undamped model that frequency, b u_m / w^2; the PID's third pole is at -w. Margins
    are those of the believed plant throughout, about the slide at `speed`.

    Args:
        belief: what is believed of the plant, an object of its parameter class.
        speed: at which the rod slides (m/s), not 0.
        largest_command: a command that counts as large; by default the amplifier's limit.

    Raises:
        UserError: no largest command where the amplifier has no limit, or a speed of 0.
    """
    limit = float(setup.plant.command_limit(belief)) if largest_command is None else largest_command
    if not 0.0 < limit < np.inf:
        raise UserError(
            f"plant {setup.plant.name} has a largest command of {limit:g} {setup.plant.command_unit}: expected a "
            "finite value above 0; give largest_command"
        )
    believed = _believed(setup, belief)
    return [*_by_relay(setup, believed, speed, RELAY_SHARE * limit), *_by_model(believed, speed, limit)]


def _believed(setup: Setup, belief: Numbers) -> Setup:
    """The setup with the plant that is believed in: it has none of the effects that the true one may have."""
    plant = setup.plant if isinstance(belief, setup.plant.Parameters) else setup.plant.bare or setup.plant
    return replace(
        setup,
        plant=plant,
        parameters=belief,
        state=_part(plant.State, setup.state),
        inputs=_part(plant.Inputs, setup.inputs),
        feeds=(),
    )


def _part(cls: type[NumbersT], of: Numbers) -> NumbersT:
    """Those numbers, by name, that a class has."""
    values = named(of)
    return from_array(cls, [values[item.name] for item in fields(cls)])


def _by_relay(setup: Setup, believed: Setup, speed: float, amplitude: float) -> Iterator[StartingPoint]:
    method = "relay experiment, Ziegler-Nichols"
    relay = relay_test(setup, amplitude, speed)
    if relay.note:
        yield StartingPoint("ziegler_nichols", method, PID.name, {}, relay.note)
        return
    ultimate = f"ultimate gain {relay.ultimate_gain:.4g}, period {relay.ultimate_period:.3g} s"
    for kind, gains in ziegler_nichols(relay.ultimate_gain, relay.ultimate_period).items():
        yield _judged(f"ziegler_nichols_{kind}", method, gains, ultimate, believed, speed)


def _by_model(believed: Setup, speed: float, limit: float) -> Iterator[StartingPoint]:
    """Pole placement and LQR, PD and PID, each the fastest that keeps the margins."""
    try:
        model = slow_model(believed, speed)
    except UserError as error:
        yield StartingPoint("pole_placement", "pole placement and LQR", PID.name, {}, str(error))
        return

    def place(frequency: float, integral_pole: float) -> PidGains:
        return pole_placement(model, frequency, DAMPING, integral_pole)

    def optimal(frequency: float, integral_time: float) -> PidGains:
        return lqr(model, abs(model.b) * limit / frequency**2, limit, integral_time)

    designs: dict[str, tuple[str, Callable[[float], PidGains]]] = {
        "pole_placement_pd": ("pole placement", lambda w: place(w, 0.0)),
        "pole_placement_pid": ("pole placement", lambda w: place(w, w)),
        "lqr_pd": ("LQR, Bryson's weights", lambda w: optimal(w, np.inf)),
        "lqr_pid": ("LQR, Bryson's weights", lambda w: optimal(w, INTEGRAL_PERIODS / w)),
    }
    for name, (method, design) in designs.items():
        yield _fastest(name, method, design, believed, speed)


def _fastest(
    name: str, method: str, design: Callable[[float], PidGains], believed: Setup, speed: float
) -> StartingPoint:
    """The design for the highest frequency at which the margins are kept."""
    for frequency in FREQUENCIES:
        try:
            gains = design(float(frequency))
        except UserError:
            continue  # slower than the plant's own poles
        reached = margins(_under(believed, gains), speed)
        if reached.stable and reached.gain_dB >= GAIN_MARGIN_DB and reached.phase_deg >= PHASE_MARGIN_DEG:
            return StartingPoint(
                name, method, PID.name, gains, f"{frequency:.3g} rad/s; {_words(reached, believed)}", reached
            )
    slid = f"{speed:g} {believed.plant.axis}/s"
    note = f"no closed loop of this kind keeps {GAIN_MARGIN_DB:g} dB and {PHASE_MARGIN_DEG:g} degrees at {slid}"
    return StartingPoint(name, method, PID.name, {}, note)


def _judged(name: str, method: str, gains: PidGains, basis: str, believed: Setup, speed: float) -> StartingPoint:
    reached = margins(_under(believed, gains), speed)
    return StartingPoint(name, method, PID.name, gains, f"{basis}; {_words(reached, believed)}", reached)


def _under(setup: Setup, gains: PidGains) -> Setup:
    """The setup under a PID of those gains."""
    settings = PidSettings(gains["kp"], gains["ki"], gains["kd"])
    return replace(setup, loop=Loop(PID, PID.design(settings, setup.parameters, setup.sample_time)))


def _words(reached: Margins, believed: Setup) -> str:
    speed = f"{reached.speed:.3g} {believed.plant.axis}/s"
    if not reached.stable:
        return f"not stable at {speed} on the believed plant: {reached.note}"
    return f"{reached.gain_dB:.1f} dB and {reached.phase_deg:.0f} degrees at {speed} on the believed plant"

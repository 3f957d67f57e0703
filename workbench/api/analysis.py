"""Linear analysis of a loop, with python-control's objects: the plant at an operating point, the loop gain, margins."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from plants.equation import fields
from workbench.api.loops import A_LOOP, LoopSetup
from workbench.api.plain import Quantity, expect
from workbench.errors import UserError
from workbench.simulation.setup import Numbers, Setup
from workbench.toml.units import QuantityError, si

if TYPE_CHECKING:
    import control

    from workbench.linear.margins import Margins


def linearise(
    setup: LoopSetup,
    *,
    speed: Quantity | None = None,
    state: tuple[object, ...] | None = None,
    inputs: tuple[object, ...] | None = None,
    outputs: Sequence[str] = ("position",),
) -> "control.StateSpace":
    """The plant of a loop for small deviations from an operating point: d(dx)/dt = A dx + B du, dy = C dx + D du.

    The point is an equilibrium: by default the rod at rest, turning as the setup says; with `speed` its steady slide
    in the loop. Elsewhere the deviations would be from a motion that leaves the point at once, and poles and margins
    would be those of no state that lasts. Such a point is an error, since a note would be lost as soon as the model is
    handed on; `workbench.linear.linearise` takes any point.

    At rest LuGre's bristles are a spring: what holds there says nothing of a rod that slides.

    Args:
        setup: whose plant, with its true parameters.
        speed: of the slide, m/s, or rad/s of an axis that turns; not 0.
        state: another operating point, of the plant's `State` (SI);
        inputs: of the plant's `Inputs` (SI); default those of the rod at rest.
        outputs: names of signals of the plant.

    Returns:
        states, inputs and outputs by name, in the order of the plant; SI units; continuous time.

    Raises:
        UserError: the point is no equilibrium, the loop does not slide steadily, or no such signal.

    Example:
        >>> loop = wb.setup("rotating", "owen2001_simulation", rpm=120, controller=wb.pid(kp=500))
        >>> model = wb.linearise(loop, speed="30 mm/s")
        >>> model.nstates, model.input_labels[0], model.output_labels
        (7, 'valve_voltage', ['position'])
        >>> rest, held = loop.plant.equilibrium(loop.parameters, 0.0)
        >>> wb.linearise(loop, state=rest, inputs=held._replace(valve_voltage=1.0))
        Traceback (most recent call last):
        workbench.errors.UserError: linearise: this is no equilibrium of rotating_helical: spool_position changes at
        0.005 m/s; give a state with the inputs that hold it, or speed=... for a steady slide
    """
    from workbench.linear.equilibrium import at_rest
    from workbench.linear.linearise import linearise as linearised
    from workbench.linear.operating_point import slide

    expect(setup, LoopSetup, "linearise", A_LOOP)
    case = setup.simulation
    if speed is not None and (state is not None or inputs is not None):
        raise UserError("linearise: got a speed and a point; expected one of them")
    if speed is not None:
        point = slide(case, _speed(speed, case))
        if point.trouble:
            raise UserError(
                f"linearise: the rod does not slide steadily at {speed} with {case.loop.controller.name}: "
                f"{point.trouble}; take another speed, or other gains"
            )
        state, inputs = point.state, point.inputs
    else:
        rest, holding = at_rest(case)
        state, inputs = rest if state is None else state, holding if inputs is None else inputs
        _check_equilibrium(case, state, inputs)
    return linearised(case.plant, case.parameters, state, inputs, outputs)


def loop_gain(setup: LoopSetup, *, speed: Quantity) -> "control.StateSpace":
    """L(z) of the loop about the rod's sliding at `speed`, sampled, broken behind the amplifier; closed it is 1/(1+L).

    In it: the plant with its command held, anti-alias filters and the delay of the sensors, and all that the
    controller does, as `workbench.linear.open_loop` says in full.

    Args:
        setup: the loop.
        speed: m/s, or rad/s of an axis that turns; not 0.

    Returns:
        one input, one output, at the loop's sample time; for `control.bode_plot` and all else of python-control.

    Raises:
        UserError: the loop does not slide steadily at that speed.

    Example:
        >>> loop = wb.setup("rotating", "owen2001_simulation", rpm=120, controller=wb.pid(kp=500))
        >>> wb.loop_gain(loop, speed="30 mm/s").dt
        0.001
    """
    from workbench.linear.open_loop import open_loop

    expect(setup, LoopSetup, "loop_gain", A_LOOP)
    return open_loop(setup.simulation, _speed(speed, setup.simulation))


def margins(setup: LoopSetup, *, speed: Quantity) -> "Margins":
    """Gain and phase margin of `loop_gain` about the rod's sliding at `speed`, and whether the loop is stable there.

    Args:
        setup: the loop.
        speed: m/s, or rad/s of an axis that turns; not 0.

    Returns:
        `gain_dB`, `phase_deg`, `gain_frequency` and `phase_frequency` (rad/s), `stable`, and a `note` where it is not:
        a loop that does not slide steadily has margins of -inf, and the note says what it does.

    Raises:
        UserError: a speed of 0, at which a loop with friction has no margins.

    Example:
        >>> loop = wb.setup("rotating", "owen2001_simulation", rpm=120, controller=wb.pid(kp=500))
        >>> margins = wb.margins(loop, speed=0.03)
        >>> margins.stable, round(margins.gain_dB, 1), round(margins.phase_deg, 1)
        (True, 30.7, 68.8)
    """
    from workbench.linear.open_loop import margins as margins_at

    expect(setup, LoopSetup, "margins", A_LOOP)
    return margins_at(setup.simulation, _speed(speed, setup.simulation))


def _speed(speed: Quantity, case: Setup) -> float:
    try:
        return si(speed, f"{case.plant.axis}/s")
    except QuantityError as error:
        raise UserError(f"speed: {error}") from None


def _check_equilibrium(case: Setup, state: Numbers, inputs: Numbers) -> None:
    """Raise UserError where the plant does not stay in this state."""
    from workbench.linear.equilibrium import changing

    units = {item.name: item.unit for item in fields(case.plant.State)}
    rates = changing(case.plant, case.parameters, state, inputs)
    if rates:
        told = ", ".join(f"{name} changes at {rate:.3g} {units[name]}/s" for name, rate in rates.items())
        raise UserError(
            f"linearise: this is no equilibrium of {case.plant.name}: {told}; give a state with the inputs that hold "
            "it, or speed=... for a steady slide"
        )

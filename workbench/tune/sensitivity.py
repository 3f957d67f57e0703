"""How the mean square of the tracking error answers to the controller's gains: exact, by algorithmic differentiation.

    loop = closed_loop(setup, first, last)               # a window of samples, both ends within
    loop.value(to_array(gains))                          # mean square of reference - position, m^2
    loop.value_and_gradient(to_array(gains))             # and its gradient by every number of the gains

The loop is that of `workbench.simulation` without noise: the same equations, the plant by fixed steps of Runge and
Kutta. At a kink (a limit, a sign, a reversal) the derivative is that of one side; what a shift of a jump by less than
a sample does is not in it.
"""

from dataclasses import dataclass, replace

import numpy as np

from plants.equation import fields, from_array, to_array
from workbench.errors import UserError
from workbench.linear import jacobians
from workbench.simulation.simulate import Run, Setup, simulate
from workbench.tune.sampled_loop import BLOCK, NotSymbolicError, SampledLoop, sampled_loop

LONGEST_STEP = 2.5e-4
"""s. Steps of Runge and Kutta are no longer: the bristle of the simulation plant, whose rate sigma0 |v| / g grows with
the speed, is then stable up to 0.71 m/s, the valve's largest flow, and the hydraulic resonance turns by 0.3 rad."""

STABLE_TURN = 1.4
"""Step times fastest eigenvalue: half of what the method bears (2.78 for a decay, 2.83 for an oscillation), so that
gains which move a turning piston's bristle twice as fast are still served."""

MOST_SUBSTEPS = 40
"""Steps a sample. A plant that needs more is not worth an explicit method."""

PROBED = 100
"""States of a run at which its eigenvalues are found."""

DEPARTURE, SMALL_DEPARTURE = 0.02, 1e-6
"""The rms of the error may depart from the simulated one by this share, or by so much (m)."""

FLAWS = ("noise", "resolution", "anti_alias", "offset", "gain_error", "calibration_error")
"""Of a sensor's channel: what an ideal one has none of."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """The sampled loop of one setup and the window of samples `first` to `last` over which its error is taken.

    `wanted` holds the reference (m, m/s, m/s^2) and the time (s) at each sample from 0 to `last`, shape (4, last + 1).
    """

    loop: SampledLoop
    setup: Setup
    first: int
    last: int
    substeps: int
    wanted: np.ndarray

    def positions(self, gains: np.ndarray) -> np.ndarray:
        """Positions (m) at the samples 0 to `last` under `gains` (vector of `plants.equation.to_array`)."""
        return self._position(self._states(self._constants(gains)))

    def value(self, gains: np.ndarray) -> float:
        """Mean square (m^2) of reference - position over the window; infinite for a run that diverges."""
        return self._mean_square(self.positions(gains))

    def value_and_gradient(self, gains: np.ndarray) -> tuple[float, np.ndarray]:
        """The mean square (m^2), and its derivative by each gain (m^2 over the gain's unit), shape (gains,).

        A run that diverges has the value infinity and a gradient of NaN.
        """
        constants = self._constants(gains)
        states = self._states(constants)
        positions = self._position(states)
        value = self._mean_square(positions)
        if not np.isfinite(value):
            return value, np.full(np.size(gains), np.nan)
        slopes = np.zeros(self.last + 1)
        window = slice(self.first, self.last + 1)
        slopes[window] = 2.0 * (positions - self.wanted[0])[window] / (self.last + 1 - self.first)
        return value, self._backward(constants, states, slopes)

    def _constants(self, gains: np.ndarray) -> np.ndarray:
        s = self.setup
        numbers = [s.sample_time, float(s.plant.command_limit(s.parameters))]
        return np.concatenate([gains, to_array(s.parameters), to_array(s.inputs), numbers])

    def _position(self, states: np.ndarray) -> np.ndarray:
        names = [item.name for item in fields(self.setup.plant.State)]
        return states[names.index("position"), : self.last + 1]

    def _mean_square(self, positions: np.ndarray) -> float:
        error = (self.wanted[0] - positions)[self.first :]
        with np.errstate(all="ignore"):  # a diverged run holds numbers beyond all bounds
            value = float(np.mean(error**2))
        return value if np.isfinite(value) else np.inf

    def _states(self, constants: np.ndarray) -> np.ndarray:
        """States of the loop at the samples 0 to one after the last block, shape (states, samples)."""
        wanted = _whole_blocks(self.wanted)
        now = self.loop.start(to_array(self.setup.state), constants).full()
        parts = [now]
        for begin in range(0, wanted.shape[1], BLOCK):
            after = self.loop.forward(parts[-1][:, -1], wanted[:, begin : begin + BLOCK], constants)
            parts.append(after.full())
        return np.hstack(parts)

    def _backward(self, constants: np.ndarray, states: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Gradient by the gains. Samples that fill the last block up have slope 0 and change nothing."""
        wanted = _whole_blocks(self.wanted)
        count = wanted.shape[1]
        slopes = np.concatenate([slopes, np.zeros(count - slopes.size)])
        states = np.hstack([states[:, : self.last + 1], np.repeat(states[:, [self.last]], count - self.last - 1, 1)])
        adjoint, gradient = np.zeros(states.shape[0]), 0.0
        for end in range(count, 0, -BLOCK):
            block = slice(end - BLOCK, end)
            arguments = (states[:, block][:, ::-1], wanted[:, block][:, ::-1], constants, slopes[block][::-1])
            earlier, terms = self.loop.backward(adjoint, *arguments)
            adjoint = earlier.full()[:, -1]
            gradient = gradient + np.sum(terms.full(), axis=1)
        first = self.loop.start_backward(adjoint, to_array(self.setup.state), constants)
        return gradient + first.full()[:, 0]


def not_served(setup: Setup) -> str | None:
    """Why there is no gradient for this setup, in words; None where there is one."""
    if setup.reference is None:
        return "it has no reference: the loop is open"
    if setup.rotary is not None:
        return "its rotation is controlled: only a constant motor voltage or surface speed is served"
    if setup.feeds:
        return "an input of its plant is fed with a signal"
    if setup.sensors.delay > 0.0:
        return "its sensors are delayed"
    for name, channel in setup.sensors.channels.items():
        if any(getattr(channel, flaw) for flaw in FLAWS):
            return f"its sensor of {name} is not ideal"
    try:
        sampled_loop(setup.plant, setup.loop.controller, _fewest_substeps(setup))
    except NotSymbolicError as error:
        return str(error)
    return None


def closed_loop(setup: Setup, first: int, last: int, substeps: int | None = None) -> ClosedLoop:
    """The loop of `setup` with the window of samples `first` to `last`, both within.

    It is held against a run of `workbench.simulation` with the setup's gains, by which it also finds its step.

    Args:
        setup: plant, parameters, start, controller with gains, reference.
        substeps: steps of Runge and Kutta a sample; None: as many as the plant needs (`needed_substeps`).

    Raises:
        UserError: a setup that is not served, a window outside of the run, a plant that is too fast, a loop that
            departs from the simulation.
    """
    reason = not_served(setup)
    if reason is not None or setup.reference is None:
        raise UserError(f"no gradient for this run: {reason}")
    samples = round(setup.duration / setup.sample_time) + 1
    if not 0 <= first <= last < samples:
        raise UserError(f"window of samples {first} to {last}, expected one within 0 to {samples - 1}")
    run = simulate(replace(setup, duration=last * setup.sample_time))
    steps = needed_substeps(setup, run) if substeps is None else substeps
    if steps > MOST_SUBSTEPS:
        raise UserError(f"no gradient for this run: it needs {steps} steps a sample, more than {MOST_SUBSTEPS}")
    time = setup.sample_time * np.arange(last + 1)
    wanted = np.vstack([*setup.reference(time), time])
    loop = ClosedLoop(sampled_loop(setup.plant, setup.loop.controller, steps), setup, first, last, steps, wanted)
    _compare(loop, run)
    return loop


def _compare(loop: ClosedLoop, run: Run) -> None:
    """Raises UserError if the loop's error is not that of the exact run: equations may lose a symbol unnoticed."""
    if run.diverged:
        return
    exact = float(np.sqrt(np.mean((loop.wanted[0] - run.state("position"))[loop.first :] ** 2)))
    found = float(np.sqrt(loop.value(to_array(loop.setup.loop.gains))))
    if not abs(found - exact) <= max(DEPARTURE * exact, SMALL_DEPARTURE):
        raise UserError(
            f"no gradient for this run: by fixed steps and symbols its error is {found:.3g} m rms, "
            f"simulated it is {exact:.3g} m"
        )


def needed_substeps(setup: Setup, run: Run) -> int:
    """Steps of Runge and Kutta a sample that `run` of `setup` needs, from the plant's eigenvalues along it.

    The smallest number at which the step is within `LONGEST_STEP`, and step times largest |eigenvalue| within
    `STABLE_TURN`, over `PROBED` states of the run and that of its largest speed.
    """
    usable = np.flatnonzero(np.all(np.isfinite(run.states), axis=1))
    chosen = usable[np.linspace(0, usable.size - 1, PROBED).astype(int)]
    fastest = usable[np.argmax(np.abs(run.state("velocity")[usable]))]
    largest = 0.0
    for k in (*chosen, fastest):
        state, inputs = from_array(setup.plant.State, run.states[k]), from_array(setup.plant.Inputs, run.inputs[k])
        slopes, _ = jacobians(setup.plant, setup.parameters, state, inputs)
        if np.all(np.isfinite(slopes)):
            largest = max(largest, float(np.max(np.abs(np.linalg.eigvals(slopes)))))
    return max(_fewest_substeps(setup), int(np.ceil(largest * setup.sample_time / STABLE_TURN)))


def _fewest_substeps(setup: Setup) -> int:
    return int(np.ceil(setup.sample_time / LONGEST_STEP - 1e-9))


def _whole_blocks(wanted: np.ndarray) -> np.ndarray:
    """`wanted` to a whole number of blocks, its last column repeated."""
    return np.pad(wanted, ((0, 0), (0, -wanted.shape[1] % BLOCK)), mode="edge")

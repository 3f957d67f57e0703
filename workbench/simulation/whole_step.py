"""A whole step of a plant by a Runge-Kutta method, as machine code of any number of states and lanes.

The method's sums are written out over vectors of lanes: plants alike that go side by side. Of a linearly implicit one
so is the elimination of its linear system, without pivots: where h g J is large its diagonal is as well, since what is
fast in a plant is damped, or swings and then stands beside the diagonal with opposite signs; where a pivot fails, the
error is no number, and the step becomes shorter. The plant itself is known by
the address of its rates, so that a step serves every plant of so many states. Beside the plant's states stand those of
the sensors' anti-alias filters, so that these are integrated as exactly as the plant.
"""

import functools
from collections.abc import Sequence
from typing import Any

from llvmlite import ir

from plants.equation import Equation, from_array, leaves, select, size_of
from plants.interface import Measurement, Plant
from workbench.recording.lowering import ALIGNED, COMPARING, NUMBER_TYPE, POINTER_TYPE, constant
from workbench.recording.machine_code import MachineCode, compiled
from workbench.simulation.elimination import Eliminated
from workbench.simulation.integrators.interface import IntegrationMethod

CLOCK, KNOWN, RAMPED = 5, 3, 4
"""Numbers of a step's clock: its start and its length (s), when its inputs began to change; and, of all lanes the first
one's, whether the slopes at its start are known, and whether inputs are ramps: 1, else 0.
"""

NUDGE = 1.5e-8
"""Share of a state and of its typical magnitude by which a difference quotient moves it: the root of the rounding."""

AHEAD = 1e-3
"""Share of a step over which a ramp of the inputs is seen."""


def filtered_rates(plant: Plant) -> Equation:
    """Rates of a plant and of the filters of its sensors: the equation

        rates(time, y, inputs, parameters) -> dy/dt,   dr_i/dt = c_i (measured_i - r_i)

    of tuples of numbers: behind the plant's states stand the filtered readings r, behind its parameters the cutoffs c
    (rad/s), 0 for no filter.
    """
    states, numbers = size_of(plant.State), size_of(plant.Parameters)

    def rates(time: Any, y: Any, inputs: Any, given: Any) -> Any:
        state, parameters = from_array(plant.State, y[:states]), from_array(plant.Parameters, given[:numbers])
        own = leaves(plant.derivatives(time, state, inputs, parameters))
        filters = [
            select(cutoff > 0.0, cutoff * (reading - filtered), 0.0)
            for cutoff, reading, filtered in zip(
                given[numbers:], leaves(plant.measure(state, parameters)), y[states:], strict=True
            )
        ]
        return (*own, *filters)

    return rates


def sizes_of(plant: Plant, filtered: bool) -> tuple[int, int, int]:
    """How many states, inputs and parameters a step of it knows, with `filtered` sensors or without."""
    more = len(Measurement._fields) if filtered else 0
    return size_of(plant.State) + more, size_of(plant.Inputs), size_of(plant.Parameters) + more


def work_size(method: IntegrationMethod, states: int, inputs: int) -> int:
    """Numbers of a lane that a step works on: slopes, the state and the inputs of a stage, its time, and one more rate
    of an implicit method.
    """
    return (method.count + 1 + bool(method.implicit)) * states + inputs + 1


@functools.cache
def whole_step(method: IntegrationMethod, states: int, inputs: int, lanes: int) -> MachineCode:
    """A step as a C function

        step(rates, clock, y, inputs, slopes, parameters, control, work, behind)

    of an address and pointers: `clock` is (start, length h, time from which the inputs changed) in s, whether the first
    slopes are in `work` already, and whether inputs are ramps; `inputs` at that time and their `slopes` per s;
    `control` the tolerance and the scale of each of `y`. Of several lanes the numbers of each stand one behind another,
    as `rates` takes them. `behind` is (y behind the step, error): the largest of
    |h sum e_i k_i| / (tolerance (scale + |y|)), no number where one is none; a method of steps of one length gives
    none.
    """
    return _Writer(method, states, inputs, lanes).written()


class _Writer:
    """A whole step in the making."""

    def __init__(self, method: IntegrationMethod, states: int, inputs: int, lanes: int) -> None:
        self.method, self.states, self.inputs, self.lanes = method, states, inputs, lanes
        self.kind = NUMBER_TYPE if lanes == 1 else ir.VectorType(NUMBER_TYPE, lanes)
        integer = ir.IntType(64)
        self.module = ir.Module(name="step")
        signature = ir.FunctionType(ir.VoidType(), [integer, *(POINTER_TYPE,) * 8])
        function = ir.Function(self.module, signature, name="equations")
        self.builder = ir.IRBuilder(function.append_basic_block())
        (rates, self.clock, self.y, self.now, self.slopes, self.parameters, self.control, work, self.behind) = (
            function.args
        )
        self.found = work
        self.trial, self.given, self.time = (
            self._at(work, place)
            for place in (method.count * states, (method.count + 1) * states, (method.count + 1) * states + inputs)
        )
        self.nudged = self._at(work, (method.count + 1) * states + inputs + 1)
        self.ramped = self._holds(RAMPED)
        self.fed = self.builder.select(self.ramped, self.given, self.now)
        by_value = NUMBER_TYPE if lanes == 1 else POINTER_TYPE
        called = ir.FunctionType(ir.VoidType(), [by_value, *(POINTER_TYPE,) * 4])
        self.rates = self.builder.inttoptr(rates, called.as_pointer())

    def written(self) -> MachineCode:
        """The code of it."""
        method, builder = self.method, self.builder
        start, h = self._load(self.clock, 0), self._load(self.clock, 1)
        begun = [self._load(self.y, j) for j in range(self.states)]
        if method.implicit:
            self._implicitly(start, h, begun)
        else:
            self._explicitly(start, h, begun)
        builder.ret_void()
        engine = compiled(str(self.module))
        return MachineCode(engine.get_function_address("equations"), (True,) * 9, False, engine)

    def _explicitly(self, start: Any, h: Any, begun: Sequence[Any]) -> None:
        method, builder = self.method, self.builder
        if method.errors:  # the last slopes of a step are the first of the next one
            with builder.if_then(builder.not_(self._holds(KNOWN))):
                self._rate(start, self.y, 0)
        else:
            self._rate(start, self.y, 0)
        for stage, (node, row) in enumerate(zip(method.nodes, method.stages, strict=True), start=1):
            last = stage == len(method.stages) and bool(method.errors)
            target = self.behind if last else self.trial
            self._advance(target, begun, h, row)
            self._rate(builder.fadd(start, builder.fmul(self._number(node), h)), target, stage)
        if method.errors:
            self._store(self._error(begun, h), self.behind, self.states)
        else:
            self._advance(self.behind, begun, h, method.weights)

    def _implicitly(self, start: Any, h: Any, begun: Sequence[Any]) -> None:
        method, builder = self.method, self.builder
        self._rate(start, self.y, 0)
        rates = [self._load(self.found, j) for j in range(self.states)]
        own, onward = method.implicit[0][-1], self._onward(start, h, rates)
        share = builder.fmul(self._number(own), h)
        system = Eliminated(builder, self._system(start, begun, rates, share))
        for stage, row in enumerate(method.implicit):
            if stage > 0:
                later = builder.fmul(self._number(method.nodes[stage - 1]), h)
                self._advance(self.trial, begun, h, method.stages[stage - 1])
                self._rate(builder.fadd(start, later), self.trial, stage)
            ahead = [builder.fmul(self._number(sum(row)), each) for each in onward]
            self._solve(stage, system, [value / own for value in row[:-1]], ahead)
        self._advance(self.behind, begun, h, method.weights)
        if method.errors:
            self._store(self._error(begun, h), self.behind, self.states)

    def _solve(self, stage: int, system: Eliminated, weights: Sequence[float], ahead: Sequence[Any]) -> None:
        """The slopes of a stage in the place of its rates: k = (I - h g J)^-1 (f + ahead + s) - s, s = sum w_j k_j."""
        builder, given = self.builder, list[Any]()
        before = [self._combined(weights, j) for j in range(self.states)]
        for j, own in enumerate(before):
            rate = builder.fadd(self._load(self.found, stage * self.states + j), ahead[j])
            given.append(rate if own is None else builder.fadd(rate, own))
        for j, (own, both) in enumerate(zip(before, system.solved(given), strict=True)):
            self._store(both if own is None else builder.fsub(both, own), self.found, stage * self.states + j)

    def _onward(self, start: Any, h: Any, rates: Sequence[Any]) -> list[Any]:
        """h df/dt, of inputs that are ramps."""
        builder = self.builder
        for j in range(self.states):
            self._store(self._number(0.0), self.nudged, j)
        with builder.if_then(self.ramped):
            self._rate(builder.fadd(start, builder.fmul(self._number(AHEAD), h)), self.y, self.method.count + 1)
            for j, rate in enumerate(rates):
                moved = builder.fsub(self._load(self.nudged, j), rate)
                self._store(builder.fdiv(moved, self._number(AHEAD)), self.nudged, j)
        return [self._load(self.nudged, j) for j in range(self.states)]

    def _system(self, start: Any, begun: Sequence[Any], rates: Sequence[Any], share: Any) -> list[list[Any]]:
        """I - h g J, by rows; `share` is h g."""
        builder, places = self.builder, range(self.states)
        columns = []
        for j in places:
            self._store(begun[j], self.trial, j)
        for j, old in enumerate(begun):
            nudge = builder.fmul(self._number(NUDGE), builder.fadd(self._load(self.control, 1 + j), self._size(old)))
            self._store(builder.fadd(old, nudge), self.trial, j)
            self._rate(start, self.trial, self.method.count + 1)
            self._store(old, self.trial, j)
            over = builder.fdiv(share, builder.fsub(builder.fadd(old, nudge), old))
            columns.append([builder.fmul(over, builder.fsub(rates[i], self._load(self.nudged, i))) for i in places])
        one = self._number(1.0)
        return [[builder.fadd(one, columns[j][i]) if i == j else columns[j][i] for j in places] for i in places]

    def _holds(self, place: int) -> Any:
        """What the clock says of all lanes."""
        number = self.builder.load(self._at(self.clock, place), align=ALIGNED)
        return self.builder.fcmp_ordered("!=", number, ir.Constant(NUMBER_TYPE, 0.0))

    def _rate(self, time: Any, y: Any, stage: int) -> None:
        """The rates of a stage, in the place of its slopes; behind the last one's those of no stage."""
        builder = self.builder
        with builder.if_then(self.ramped):
            since = builder.fsub(time, self._load(self.clock, 2))
            for j in range(self.inputs):
                moved = builder.fadd(self._load(self.now, j), builder.fmul(self._load(self.slopes, j), since))
                self._store(moved, self.given, j)
        if self.lanes > 1:
            self._store(time, self.time, 0)
            time = self.time
        into = self._at(self.found, stage * self.states) if stage < self.method.count else self.nudged
        builder.call(self.rates, [time, y, self.fed, self.parameters, into])

    def _advance(self, target: Any, begun: Sequence[Any], h: Any, weights: Sequence[float]) -> None:
        """y + h sum w_i k_i."""
        builder = self.builder
        for j, old in enumerate(begun):
            self._store(builder.fadd(old, builder.fmul(h, self._combined(weights, j))), target, j)

    def _error(self, begun: Sequence[Any], h: Any) -> Any:
        builder, size, worst = self.builder, self._size, self._number(0.0)
        for j, old in enumerate(begun):
            larger = COMPARING["maximum"](builder, size(old), size(self._load(self.behind, j)))
            allowed = builder.fadd(self._load(self.control, 1 + j), larger)
            allowed = builder.fmul(self._load(self.control, 0), allowed)
            error = size(builder.fmul(h, self._combined(self.method.errors, j)))
            worst = COMPARING["maximum"](builder, worst, builder.fdiv(error, allowed))
        return worst

    def _combined(self, weights: Sequence[float], j: int) -> Any:
        """The sum of w_i k_i in place `j`, of those slopes that have a weight; None of none."""
        builder, total = self.builder, None
        for stage, weight in enumerate(weights):
            if weight != 0.0:
                term = builder.fmul(self._number(weight), self._load(self.found, stage * self.states + j))
                total = term if total is None else builder.fadd(total, term)
        return total

    def _size(self, value: Any) -> Any:
        lanes = "" if self.lanes == 1 else f"v{self.lanes}"
        name, kind = f"llvm.fabs.{lanes}f64", self.kind
        known = self.module.globals.get(name)
        return self.builder.call(known or ir.Function(self.module, ir.FunctionType(kind, [kind]), name=name), [value])

    def _number(self, value: float) -> Any:
        return constant(self.kind, value)

    def _load(self, pointer: Any, place: int) -> Any:
        return self.builder.load(self._cast(self._at(pointer, place)), align=ALIGNED)

    def _store(self, value: Any, pointer: Any, place: int) -> None:
        self.builder.store(value, self._cast(self._at(pointer, place)), align=ALIGNED)

    def _cast(self, pointer: Any) -> Any:
        return pointer if self.lanes == 1 else self.builder.bitcast(pointer, self.kind.as_pointer())

    def _at(self, pointer: Any, place: int) -> Any:
        return self.builder.gep(pointer, [ir.Constant(ir.IntType(64), place * self.lanes)])

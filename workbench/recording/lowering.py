"""What was recorded, as a function of LLVM's intermediate representation."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from llvmlite import ir

from workbench.recording.branches import WHOLE, Branches, Side, branches_of
from workbench.recording.symbols import INPUT, NUMBER, Recording, needed

NUMBER_TYPE = ir.DoubleType()
POINTER_TYPE = NUMBER_TYPE.as_pointer()

ALIGNED = 8
"""Bytes to which every double is aligned, and no vector to more."""

ARITHMETIC = {"add": "fadd", "subtract": "fsub", "multiply": "fmul", "divide": "fdiv", "negative": "fneg"}

ORDER = {"less": "<", "less_equal": "<=", "greater": ">", "greater_equal": ">=", "equal": "=="}
"""Comparisons that do not hold where an operand is no number."""

LOGIC = {"logical_and": "and_", "logical_or": "or_", "logical_not": "not_"}

LLVM = {
    "absolute": "fabs",
    "power": "pow",
    **{
        name: name
        for name in ("sqrt", "exp", "log", "log10", "sin", "cos", "floor", "ceil", "rint", "trunc", "copysign")
    },
}
"""Functions that LLVM has itself."""

LIBRARY = {
    "arcsin": "asin",
    "arccos": "acos",
    "arctan": "atan",
    "arctan2": "atan2",
    **{name: name for name in ("hypot", "expm1", "log1p", "tan", "sinh", "cosh", "tanh")},
}
"""Functions of the C library."""


class Function:
    """A function of LLVM in the making. Arguments are doubles, and pointers to consecutive ones.

    `reads` says of each input of the recording which argument it is, or which double behind it. Of several `lanes` each
    number is a vector of so many, and what a scalar function would branch on is chosen.
    """

    def __init__(
        self,
        recording: Recording,
        pointers: Sequence[bool],
        reads: Mapping[str, tuple[int, int | None]],
        gives: bool,
        lanes: int = 1,
    ) -> None:
        self._recording, self._reads, self._lanes = recording, reads, lanes
        self._kind = NUMBER_TYPE if lanes == 1 else ir.VectorType(NUMBER_TYPE, lanes)
        self.module = ir.Module(name="equations")
        kinds = [POINTER_TYPE if pointer else NUMBER_TYPE for pointer in pointers]
        kind = ir.FunctionType(NUMBER_TYPE if gives else ir.VoidType(), kinds)
        self._function = ir.Function(self.module, kind, name="equations")
        self._builder = ir.IRBuilder(self._function.append_basic_block())
        self._values: dict[int, Any] = {}
        self._branches = Branches({})

    def write(self, stored: Sequence[int], into: int, given: int | None) -> None:
        """Compute places of the recording: those `stored` behind the pointer `into`, and the one that is returned."""
        results = [*stored, *([] if given is None else [given])]
        places = needed(self._recording, results)
        if self._lanes == 1:
            self._branches = branches_of(self._recording.instructions, places, results)
        else:
            self._branches = Branches(dict.fromkeys(places, WHOLE))
        self._compute(WHOLE)
        for i, place in enumerate(stored):
            self._builder.store(self._values[place], self._at(into, i), align=ALIGNED)
        if given is None:
            self._builder.ret_void()
        else:
            self._builder.ret(self._values[given])

    def _compute(self, side: Side) -> None:
        for place in self._branches.within[side]:
            self._values[place] = self._value(place)

    def _value(self, place: int) -> Any:
        instruction = self._recording.instructions[place]
        if instruction.operation == INPUT:
            argument, index = self._reads[instruction.text]
            if index is None:
                return self._function.args[argument]
            return self._builder.load(self._at(argument, index), align=ALIGNED)
        if instruction.operation == NUMBER:
            return constant(self._kind, float(instruction.text))
        if instruction.operation == "where" and self._branches.branches(place):
            return self._branch(place, *instruction.operands)
        return self._operation(instruction.operation, [self._values[operand] for operand in instruction.operands])

    def _branch(self, place: int, condition: int, when_true: int, when_false: int) -> Any:
        builder = self._builder
        blocks = [self._function.append_basic_block() for _ in range(3)]
        *sides, behind = blocks
        builder.cbranch(self._values[condition], *sides)
        ends = []
        for number, (block, operand) in enumerate(zip(sides, (when_true, when_false), strict=True), start=1):
            builder.position_at_end(block)
            self._compute((place, number))
            ends.append((self._values[operand], builder.block))
            builder.branch(behind)
        builder.position_at_end(behind)
        chosen = builder.phi(NUMBER_TYPE)
        for value, block in ends:
            chosen.add_incoming(value, block)
        return chosen

    def _operation(self, name: str, operands: Sequence[Any]) -> Any:
        builder = self._builder
        if name in ARITHMETIC:
            return getattr(builder, ARITHMETIC[name])(*operands)
        if name in ORDER:
            return builder.fcmp_ordered(ORDER[name], *operands)
        if name in LOGIC:
            return getattr(builder, LOGIC[name])(*operands)
        if name in COMPARING:
            return COMPARING[name](builder, *operands)
        if name in LLVM:
            lanes = f"v{self._lanes}" if self._lanes > 1 else ""
            return builder.call(self._callee(f"llvm.{LLVM[name]}.{lanes}f64", self._kind, len(operands)), operands)
        callee = self._callee(LIBRARY[name], NUMBER_TYPE, len(operands))
        if self._lanes == 1:
            return builder.call(callee, operands)
        result = ir.Constant(self._kind, ir.Undefined)
        for lane in range(self._lanes):
            place = ir.Constant(ir.IntType(32), lane)
            own = builder.call(callee, [builder.extract_element(operand, place) for operand in operands])
            result = builder.insert_element(result, own, place)
        return result

    def _callee(self, name: str, kind: Any, arguments: int) -> Any:
        found = self.module.globals.get(name)
        return found or ir.Function(self.module, ir.FunctionType(kind, [kind] * arguments), name=name)

    def _at(self, argument: int, index: int) -> Any:
        builder = self._builder
        place = builder.gep(self._function.args[argument], [ir.Constant(ir.IntType(64), index * self._lanes)])
        return place if self._lanes == 1 else builder.bitcast(place, self._kind.as_pointer())


def constant(kind: Any, number: float) -> Any:
    """A number, in every lane of a vector's type."""
    return ir.Constant(kind, number if kind == NUMBER_TYPE else [number] * kind.count)


def _not_equal(builder: Any, one: Any, other: Any) -> Any:
    return builder.fcmp_unordered("!=", one, other)


def _where(builder: Any, condition: Any, when_true: Any, when_false: Any) -> Any:
    return builder.select(condition, when_true, when_false)


def _extreme(order: str) -> Callable[..., Any]:
    """The smaller or the larger of two; what is no number wins, as in NumPy."""

    def choose(builder: Any, one: Any, other: Any) -> Any:
        first = builder.or_(builder.fcmp_ordered(order, one, other), builder.fcmp_unordered("uno", one, one))
        return builder.select(first, one, other)

    return choose


def _sign(builder: Any, one: Any) -> Any:
    zero, plus, minus = (constant(one.type, number) for number in (0.0, 1.0, -1.0))
    negative = builder.select(builder.fcmp_ordered("<", one, zero), minus, one)
    return builder.select(builder.fcmp_ordered(">", one, zero), plus, negative)


COMPARING: dict[str, Callable[..., Any]] = {
    "not_equal": _not_equal,
    "where": _where,
    "minimum": _extreme("<="),
    "maximum": _extreme(">="),
    "sign": _sign,
}

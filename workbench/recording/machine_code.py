"""Equations as machine code: C functions over doubles and pointers to doubles, made by LLVM in this process.

An equation is recorded with symbols in place of numbers, and what was recorded is compiled as it is: in the order of
the equation, in double precision, without what would round otherwise. That takes some hundredths of a second, so that
nothing is kept on disk.

Of an equation that is wanted for several sets of numbers at once, processors compute some side by side: its function
then takes and gives so many numbers, its `lanes`, in the place of each, one behind another.
"""

import ctypes
import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import llvmlite.binding as llvm

from plants.equation import Equation, from_array, leaves, size_of
from workbench.recording.lowering import Function
from workbench.recording.symbols import Recording


@dataclass(frozen=True)
class MachineCode:
    """A C function, which lives as long as this object does."""

    address: int
    pointers: tuple[bool, ...]
    gives: bool
    _engine: Any = field(repr=False)

    @property
    def ctypes(self) -> Callable[..., Any]:
        """The function for Python: of floats and of pointers to doubles."""
        kinds = [ctypes.POINTER(ctypes.c_double) if pointer else ctypes.c_double for pointer in self.pointers]
        function: Any = ctypes.CFUNCTYPE(ctypes.c_double if self.gives else None, *kinds)(self.address)
        function.code = self  # lives as long as the function may be called
        return function


def machine_code(
    equation: Equation, given: Sequence[type[NamedTuple] | int | None], into: int, gives: bool = False, lanes: int = 1
) -> MachineCode:
    """An equation as a C function.

    Args:
        equation: a function of numbers, tuples of them and NamedTuples.
        given: what it takes: None for a number, a double in C; or the class of a NamedTuple or the size of a tuple, a
            pointer.
        into: behind which pointer the NamedTuple that the equation gives is stored: one of the arguments, or a
            further one, the last.
        gives: whether the equation gives (number, NamedTuple), of which the number is returned.
        lanes: for how many sets of numbers it is computed at once, to the same bits; of pointers alone if several.

    Raises:
        UnrecordableError: the equation does what cannot be recorded.
    """
    recording, reads, arguments = Recording(), dict[str, tuple[int, int | None]](), list[Any]()
    for number, cls in enumerate(given):
        size = cls if isinstance(cls, int) else 1 if cls is None else size_of(cls)
        names = [f"{number}"] if cls is None else [f"{number}.{i}" for i in range(size)]
        reads |= {name: (number, None if cls is None else i) for i, name in enumerate(names)}
        symbols = [recording.input(name) for name in names]
        if isinstance(cls, int):
            arguments.append(tuple(symbols))
        else:
            arguments.append(symbols[0] if cls is None else from_array(cls, symbols))
    result = equation(*arguments)
    returned, stored = result if gives else (None, result)
    pointers = tuple(cls is not None for cls in given) + (True,) * (into == len(given))
    function = Function(recording, pointers, reads, gives, lanes)
    function.write(
        [recording.number_place(value) for value in leaves(stored)],
        into,
        recording.number_place(returned) if gives else None,
    )
    engine = compiled(str(function.module))
    return MachineCode(engine.get_function_address("equations"), pointers, gives, engine)


def compiled(text: str) -> Any:
    """LLVM's engine that holds a module, optimised for this processor."""
    machine = _machine()
    module = llvm.parse_assembly(text)
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return engine


@functools.cache
def _initialised() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple()


def _machine() -> Any:
    features = llvm.get_host_cpu_features().flatten()
    return _initialised().create_target_machine(opt=3, cpu=llvm.get_host_cpu_name(), features=features, jit=True)

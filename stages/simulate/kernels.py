"""How a Taichi kernel is declared in this stage: annotations that both Taichi and mypy understand.

Kernels are module-level functions over NumPy arrays. `Array` marks such an argument, `Value` an argument of an inlined
function, and `kernel` drops the `-> None` that mypy wants and Taichi 1.7 does not understand.
"""

import functools
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import taichi as ti
from taichi.lang import impl

_F = TypeVar("_F", bound=Callable[..., Any])

if TYPE_CHECKING:
    Array = Any
    Value = Any
    Int = int
    Real = float
else:
    Array = ti.types.ndarray()
    Value = ti.template()
    Int = ti.i32
    Real = ti.f64

BLOCKS = 128
"""Blocks that every sum is cut into, whatever the number of threads: equal bits on one core or many."""

TASK = 512
"""Iterations that Taichi 1.7 gives to a thread at once: a parallel loop of fewer runs on one thread."""


class Light:
    """How loops run that take less time for ten thousand vertices than waking a thread for them does, 0.1 ms.

    Attributes:
        serial: On the thread that launches them; set before the first kernel is compiled.
    """

    serial = True


light = Light()


def kernel(function: _F) -> _F:
    """`function` as a Taichi kernel that remembers its last calls, see `Launcher`."""
    function.__annotations__.pop("return", None)
    compiled: Any = ti.kernel(function)
    compiled._primal.return_type = ()
    result: _F = functools.wraps(function)(Launcher(compiled))  # type: ignore[assignment]
    return result


class Launcher:
    """A kernel whose calls are cheap when they name arrays that an earlier call named.

    Taichi 1.7 spends 15 us on every NumPy argument of every launch, as long as a loop over ten thousand vertices takes.
    The launch context of a call is kept, and taken again when all arrays are the same objects: only numbers are set
    anew. Arrays are held weakly, so that none lives longer for it.
    """

    MOST = 64
    """Contexts kept at a time."""

    def __init__(self, compiled: Any) -> None:
        self.compiled, self.primal = compiled, compiled._primal
        self.known: dict[tuple[int, ...], tuple[list[weakref.ref[np.ndarray]], Any, Any]] = {}
        kinds = [argument.annotation for argument in self.primal.arguments]
        self.arrays = [k for k, kind in enumerate(kinds) if isinstance(kind, type(Array))]
        self.reals = [k for k, kind in enumerate(kinds) if kind in (ti.f32, ti.f64)]
        self.integers = [k for k, kind in enumerate(kinds) if kind is ti.i32]
        self.plain = len(self.arrays) + len(self.reals) + len(self.integers) == len(kinds)

    def __call__(self, *arguments: Any) -> None:
        key = tuple([id(arguments[k]) for k in self.arrays])
        found = self.known.get(key)
        if found is None or any(ref() is not arguments[k] for ref, k in zip(found[0], self.arrays)):
            self.compiled(*arguments)  # compiles, checks and runs
            if self.plain:
                self._remember(key, arguments)
            return
        _, context, code = found
        for k in self.reals:
            context.set_arg_float((k,), float(arguments[k]))
        for k in self.integers:
            context.set_arg_int((k,), int(arguments[k]))
        impl.get_runtime().prog.launch_kernel(code, context)

    def _remember(self, key: tuple[int, ...], arguments: tuple[Any, ...]) -> None:
        source = self.primal.compiled_kernels[self.primal.ensure_compiled(*arguments)]
        context = source.make_launch_context()
        for k in self.arrays:
            a = arguments[k]
            if not isinstance(a, np.ndarray) or not a.flags.c_contiguous:
                return  # what a GPU holds is launched as Taichi does
            context.set_arg_external_array_with_shape((k,), int(a.ctypes.data), a.nbytes, a.shape, 0)
        prog = impl.get_runtime().prog
        code = prog.compile_kernel(prog.config(), prog.get_device_caps(), source)
        if len(self.known) >= self.MOST:
            self.known.clear()
        self.known[key] = ([weakref.ref(arguments[k]) for k in self.arrays], context, code)


def inline(function: _F) -> _F:
    """`function` as a Taichi function, inlined where kernels call it."""
    function.__annotations__.pop("return", None)
    compiled: _F = ti.func(function)
    return compiled


@inline
def vec(a: Value, i: Value) -> Any:
    """Row i of `a` [n, 3] as a vector."""
    return ti.Vector([a[i, 0], a[i, 1], a[i, 2]])


@inline
def put(a: Value, i: Value, v: Value) -> None:
    """Row i of `a` [n, 3] = v."""
    for c in ti.static(range(3)):
        a[i, c] = v[c]

"""How a Taichi kernel is declared in this stage: annotations that both Taichi and mypy understand.

Kernels are module-level functions over NumPy arrays. `Array` marks such an argument, `Value` an argument of an inlined
function, and `kernel` drops the `-> None` that mypy wants and Taichi 1.7 does not understand.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import taichi as ti

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


def kernel(function: _F) -> _F:
    """`function` as a Taichi kernel."""
    function.__annotations__.pop("return", None)
    compiled: Any = ti.kernel(function)
    compiled._primal.return_type = ()
    result: _F = compiled
    return result


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

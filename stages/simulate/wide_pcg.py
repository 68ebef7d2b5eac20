"""The linear solve of `pcg` for a GPU: one loop over all rows after the other instead of threads that wait at a gate.

A GPU's threads are too many to wait for each other within a launch. So the matrix goes to the device once a solve, an
iteration is a launch of loops, and the host only asks now and then whether it is done. Sums run over the same blocks in
the same order as on the CPU.
"""

from typing import Any

import numpy as np
import taichi as ti

from stages.simulate.kernels import BLOCKS, Array, Int, Real, kernel, put, vec
from stages.simulate.pcg import Pcg, product_row
from stages.simulate.preconditioner import (
    corrected,
    interpolate_coarse,
    restrict,
    restrict_second,
    restrict_third,
    solved_third,
    spread_third,
)

ASKED = 4
"""Iterations between two looks at whether the solve is done; those after its end change nothing."""

LISTS = (2, 3, 4, 6, 7)
"""Places in the matrix of what stays as it is for a whole scene: the gather lists of springs and bending."""

GAMMA, ALPHA, FIRST, COUNT, GOING = range(5)
"""Places in the state of a solve: r.z and step of the last iteration, the first r.z, iterations, whether to go on."""


@kernel
def begin(residual: Array, dx: Array, r: Array, p: Array, q: Array, state: Array) -> None:
    """Start from dx = 0."""
    for i in range(r.shape[0]):
        for c in ti.static(range(3)):
            dx[i, c] = 0.0
            p[i, c] = 0.0
            q[i, c] = 0.0
            r[i, c] = residual[i, c]
    for k in range(state.shape[0]):
        state[k] = 0.0
        if k == GOING:
            state[k] = 1.0


@kernel
def precondition(
    at: Array,
    first: Array,
    index: Array,
    weight: Array,
    inverse: Array,
    coarse_inverse: Array,
    coarsest: Array,
    n1: Int,
    n2: Int,
    n3: Int,
    r: Array,
    # outputs
    coarse: Array,
    top: Array,
    z: Array,
) -> None:
    """z = M^-1 r on all levels; `top` [n3, 3] is z3; see `preconditioner` for the rest."""
    for a in range(n1):
        restrict(at, first, index, weight, r, a, coarse)
    for a in range(n2):
        restrict_second(at, first, index, weight, coarse_inverse, a, n1, 2 * n1 + n2 + n3, coarse)
    for a in range(n3):
        restrict_third(at, first, index, weight, a, n1, n1 + n2, coarse)
    for b in range(n3):
        put(top, b, solved_third(coarsest, n3, b, n1 + n2, coarse))
    for _ in range(1):
        for b in range(n3):
            spread_third(at, first, index, weight, b, vec(top, b), 2 * n1 + n2 + n3, coarse)
    for a in range(n1):
        interpolate_coarse(at, first, index, weight, coarse_inverse, a, coarse)
    for i in range(r.shape[0]):
        put(z, i, corrected(at, first, index, weight, inverse, i, r, coarse))


@kernel
def go_on(
    diagonal: Array,
    start: Array,
    neighbour: Array,
    spring: Array,
    block: Array,
    bend_start: Array,
    bend_neighbour: Array,
    bend: Array,
    bend_scale: Array,
    pair_vertices: Array,
    pair_weights: Array,
    pair_stiffness: Array,
    pair_start: Array,
    pair_index: Array,
    enough: Real,
    most: Int,
    z: Array,
    # outputs
    dx: Array,
    r: Array,
    p: Array,
    q: Array,
    w: Array,
    part: Array,
    state: Array,
) -> None:
    """One iteration of `conjugate_gradients` from z on; none once it is done."""
    for i in range(z.shape[0]):
        y = product_row(
            i, diagonal, start, neighbour, spring, block, bend_start, bend_neighbour, bend, bend_scale,
            pair_vertices, pair_weights, pair_stiffness, pair_start, pair_index, z,
        )  # fmt: skip
        put(w, i, y)
    for b in range(part.shape[0]):
        gamma, delta = ti.f64(0.0), ti.f64(0.0)
        for i in range(b * z.shape[0] // part.shape[0], (b + 1) * z.shape[0] // part.shape[0]):
            gamma += ti.f64(vec(z, i).dot(vec(r, i)))
            delta += ti.f64(vec(z, i).dot(vec(w, i)))
        part[b, 0] = gamma
        part[b, 1] = delta
    for _ in range(1):
        if state[GOING] > 0:
            gamma, delta, beta = ti.f64(0.0), ti.f64(0.0), ti.f64(0.0)
            for b in range(part.shape[0]):
                gamma += part[b, 0]
                delta += part[b, 1]
            if state[COUNT] > 0:
                beta = gamma / state[GAMMA]
                delta -= beta * gamma / state[ALPHA]
            else:
                state[FIRST] = gamma
            part[0, 0] = beta
            if gamma > enough * state[FIRST] and delta > 0 and state[COUNT] < most:
                state[GAMMA] = gamma
                state[ALPHA] = gamma / delta
                state[COUNT] += 1
            else:
                state[GOING] = 0.0
    for i in range(z.shape[0]):
        if state[GOING] > 0:
            for c in ti.static(range(3)):
                p[i, c] = z[i, c] + part[0, 0] * p[i, c]
                q[i, c] = w[i, c] + part[0, 0] * q[i, c]
                dx[i, c] += state[ALPHA] * p[i, c]
                r[i, c] -= state[ALPHA] * q[i, c]


class WidePcg:
    """Solves the systems of a `Pcg` on the device; what the device holds is kept from solve to solve."""

    def __init__(self, pcg: Pcg) -> None:
        self.pcg = pcg
        self.held: dict[str, tuple[Any, Any]] = {}

    def solve(
        self,
        residual: np.ndarray,
        matrix: tuple[np.ndarray, ...],
        levels: tuple[np.ndarray, ...],
        tolerance: float,
        most: int,
    ) -> None:
        """Sets `dx` and `done` of the `Pcg`.

        Args:
            residual: Right-hand side [N, 3].
            matrix: What `conjugate_gradients` takes of it, bending and pairs of cloth, in its order.
            levels: What it takes of the coarse levels.
            tolerance: Relative residual to end at; most: iterations.
        """
        pcg = self.pcg
        diagonal, inverse, *rows = (self._there(f"matrix {k}", values, k in LISTS) for k, values in enumerate(matrix))
        gathers = [self._there(f"levels {k}", values, k < 4) for k, values in enumerate(levels)]
        n1, n2, n3 = (int(size) for size in levels[0][6:9])
        sizes = {"coarse": 2 * n1 + 2 * n2 + n3, "top": max(n3, 1)}
        r, z, p, q, w, dx = (self._room(name, pcg.dx) for name in ("r", "z", "p", "q", "w", "dx"))
        coarse, top = (self._room(name, np.zeros((size, 3), pcg.dx.dtype)) for name, size in sizes.items())
        part, state = self._room("part", np.zeros((BLOCKS, 2))), self._room("state", np.zeros(5))
        begin(self._there("residual", residual, False), dx, r, p, q, state)
        now = np.eye(5)[GOING]
        while now[GOING] > 0:
            for _ in range(ASKED):
                precondition(*[*gathers[:4], inverse, *gathers[4:], n1, n2, n3, r, coarse, top, z])
                go_on(*[diagonal, *rows, tolerance**2, most, z, dx, r, p, q, w, part, state])
            now = state.to_numpy()
        pcg.dx[:] = dx.to_numpy()
        pcg.done[0] = int(now[COUNT])

    def _there(self, name: str, values: np.ndarray, constant: bool) -> Any:
        """The device's copy of `values`."""
        array, of = self._room(name, values), self.held[name][1]
        if not (constant and of is values):
            array.from_numpy(values)
            self.held[name] = (array, values)
        return array

    def _room(self, name: str, like: np.ndarray) -> Any:
        """An array of the device of the shape and type of `like`, that of an earlier solve if it has them."""
        found = self.held.get(name)
        if found is None or found[0].shape != like.shape:
            self.held[name] = found = (ti.ndarray(_TYPES[like.dtype.type], like.shape), None)
        return found[0]


_TYPES = {np.float32: ti.f32, np.float64: ti.f64, np.int32: ti.i32}

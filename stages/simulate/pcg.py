"""Conjugate gradients on the step's linear system, preconditioned on several levels of detail at once."""

from typing import Any

import numpy as np
import taichi as ti

from stages.simulate.kernels import BLOCKS, TASK, Array, Int, Real, Value, inline, kernel, put, vec
from stages.simulate.preconditioner import corrected, interpolate_coarse, restrict, solve_coarse, sym_times
from stages.simulate.runtime import start_taichi

SLOW = 8.0
"""How many times slower than the best a shared solve may be before one thread works alone..."""
ALONE = 100
"""... for so many solves."""


@inline
def meet(gate: Value, crew: Value, count: Value) -> Value:
    """Wait until all of the `crew` have come here for the `count`-th time; returns the count of the next meeting."""
    if crew > 1:
        ti.atomic_add(gate[0], 1)
        while ti.atomic_max(gate[0], 0) < count * crew:
            pass
    return count + 1


@inline
def product_row(
    i: Value,
    diagonal: Value,
    start: Value,
    neighbour: Value,
    spring: Value,
    block: Value,
    bend_start: Value,
    bend_neighbour: Value,
    bend: Value,
    bend_scale: Value,
    pair_vertices: Value,
    pair_weights: Value,
    pair_stiffness: Value,
    pair_start: Value,
    pair_index: Value,
    z: Value,
) -> Value:
    """Row i of A z: D z - sum (a + w w^T) z_j + bending + contacts.

    A contact between cloth adds weight_i K_c (sum_k weight_k z_k), K_c = a I + w w^T.
    """
    y = sym_times(diagonal, i, vec(z, i))
    for e in range(start[i], start[i + 1]):
        s = spring[e]
        zj = vec(z, neighbour[e])
        d = ti.Vector([block[s, 1], block[s, 2], block[s, 3]])
        y -= block[s, 0] * zj + d * d.dot(zj)
    t = y * 0
    for e in range(bend_start[i], bend_start[i + 1]):
        t += bend[e] * vec(z, bend_neighbour[e])
    y += bend_scale[i] * t
    for e in range(pair_start[i], pair_start[i + 1]):
        c = pair_index[e] // 4
        s = vec(z, pair_vertices[c, 0]) * pair_weights[c, 0]
        for k in ti.static(range(1, 4)):
            s += vec(z, pair_vertices[c, k]) * pair_weights[c, k]
        d = ti.Vector([pair_stiffness[c, 1], pair_stiffness[c, 2], pair_stiffness[c, 3]])
        y += pair_weights[c, pair_index[e] % 4] * (pair_stiffness[c, 0] * s + d * d.dot(s))
    return y


@kernel
def conjugate_gradients(
    residual: Array,
    diagonal: Array,
    inverse: Array,
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
    at: Array,
    first: Array,
    index: Array,
    weight: Array,
    coarse_inverse: Array,
    coarsest: Array,
    blocks: Int,
    enough: Real,
    most: Int,
    crew: Int,
    # outputs
    coarse: Array,
    dx: Array,
    r: Array,
    z: Array,
    p: Array,
    q: Array,
    w: Array,
    part: Array,
    gate: Array,
    done: Array,
) -> None:
    """Solve A dx = residual until r.z is `enough` of its first value, in at most `most` iterations; done[0]: how many.

    In the form with one reduction (Chronopoulos and Gear 1989): z = M^-1 r, w = A z, p, q = A p. The whole solve is one
    launch: each of a `crew` of threads has its share of the rows, and they wait for each other at the `gate` (0 at the
    start), since waking a thread for every loop would take longer than the loop. Every sum runs over the same `blocks`
    whatever the crew.
    """
    for k in range(crew * TASK):
        if k % TASK == 0:
            t = k // TASK
            n, n1 = r.shape[0], at[6]
            low, high = t * blocks // crew, (t + 1) * blocks // crew
            i0, i1 = low * n // blocks, high * n // blocks
            a0, a1 = t * n1 // crew, (t + 1) * n1 // crew
            count = 1
            for i in range(i0, i1):
                for c in ti.static(range(3)):
                    dx[i, c] = 0.0
                    p[i, c] = 0.0
                    q[i, c] = 0.0
                    r[i, c] = residual[i, c]
            old_gamma, old_alpha, first_gamma = ti.f64(0.0), ti.f64(0.0), ti.f64(0.0)
            going = 1
            iteration = 0
            while going == 1:
                count = meet(gate, crew, count)
                for a in range(a0, a1):
                    restrict(at, first, index, weight, r, a, coarse)
                count = meet(gate, crew, count)
                if t == 0:
                    solve_coarse(at, first, index, weight, coarse_inverse, coarsest, coarse)
                count = meet(gate, crew, count)
                for a in range(a0, a1):
                    interpolate_coarse(at, first, index, weight, coarse_inverse, a, coarse)
                count = meet(gate, crew, count)
                for b in range(low, high):
                    gamma = ti.f64(0.0)
                    for i in range(b * n // blocks, (b + 1) * n // blocks):
                        y = corrected(at, first, index, weight, inverse, i, r, coarse)
                        put(z, i, y)
                        gamma += ti.f64(y.dot(vec(r, i)))
                    part[b, 0] = gamma
                count = meet(gate, crew, count)
                gamma = ti.f64(0.0)
                for b in range(blocks):
                    gamma += part[b, 0]
                if iteration == 0:
                    first_gamma = gamma
                going = 0
                if gamma > enough * first_gamma and iteration < most:
                    for b in range(low, high):
                        delta = ti.f64(0.0)
                        for i in range(b * n // blocks, (b + 1) * n // blocks):
                            y = product_row(
                                i, diagonal, start, neighbour, spring, block,
                                bend_start, bend_neighbour, bend, bend_scale,
                                pair_vertices, pair_weights, pair_stiffness, pair_start, pair_index, z,
                            )  # fmt: skip
                            put(w, i, y)
                            delta += ti.f64(vec(z, i).dot(y))
                        part[b, 1] = delta
                    count = meet(gate, crew, count)
                    delta = ti.f64(0.0)
                    for b in range(blocks):
                        delta += part[b, 1]
                    beta = ti.f64(0.0)
                    if iteration > 0:
                        beta = gamma / old_gamma
                        delta -= beta * gamma / old_alpha
                    if delta > 0:
                        going = 1
                        old_gamma, old_alpha = gamma, gamma / delta
                        for i in range(i0, i1):
                            for c in ti.static(range(3)):
                                p[i, c] = z[i, c] + beta * p[i, c]
                                q[i, c] = w[i, c] + beta * q[i, c]
                                dx[i, c] += old_alpha * p[i, c]
                                r[i, c] -= old_alpha * q[i, c]
                        iteration += 1
            if t == 0:
                done[0] = iteration


class Pcg:
    """Buffers of the linear solve.

    Solves A dx = residual until sqrt(r.z) falls below `tolerance` times its first value (z = M^-1 r).
    """

    def __init__(self, count: int, dtype: Any = np.float32) -> None:
        self.dx, self.r, self.z, self.p, self.q, self.w = (np.zeros((count, 3), dtype) for _ in range(6))
        self.diagonal, self.inverse = np.zeros((count, 6), dtype), np.zeros((count, 6), dtype)
        self.part, self.gate, self.done = np.zeros((BLOCKS, 2)), np.zeros(1, np.int32), np.zeros(1, np.int32)
        self.most_crew, self.alone, self.pace = start_taichi(), 0, np.inf

    @property
    def crew(self) -> int:
        """How many threads to share a solve; results don't depend on it."""
        return 1 if self.alone > 0 else self.most_crew

    def clock(self, seconds: float) -> None:
        """Take note of how long a solve took.

        Threads that wait for each other lose whole slices of time where others want the cores: after a solve that was
        many times slower than the best, one thread works alone for a while.
        """
        each = seconds / max(int(self.done[0]), 1)
        if self.alone > 0:
            self.alone -= 1
        elif each > SLOW * self.pace:
            self.alone = ALONE
        else:
            self.pace = min(self.pace, each)

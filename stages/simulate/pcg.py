"""Conjugate gradients on the step's linear system, preconditioned on several levels of detail at once."""

from typing import Any

import numpy as np
import taichi as ti

from stages.simulate.kernels import BLOCKS, Array, Int, Value, inline, kernel, put, vec

SWEEPS = 4
"""Iterations fused in one kernel launch, after which the residual is looked at."""


@inline
def sym_times(m: Value, i: Value, v: Value) -> Value:
    """Symmetric block i of `m` [n, 6] times v."""
    return ti.Vector(
        [
            m[i, 0] * v[0] + m[i, 1] * v[1] + m[i, 2] * v[2],
            m[i, 1] * v[0] + m[i, 3] * v[1] + m[i, 4] * v[2],
            m[i, 2] * v[0] + m[i, 4] * v[1] + m[i, 5] * v[2],
        ]
    )


@inline
def gathered(at: Value, first: Value, index: Value, weight: Value, k: Value, a: Value, v: Value, base: Value) -> Value:
    """Row a of the product of gather list k with the rows of `v` from `base` on."""
    t = ti.Vector([v[0, 0], v[0, 0], v[0, 0]]) * 0
    row = at[k] + a
    for e in range(first[row], first[row + 1]):
        t += weight[e] * vec(v, base + index[e])
    return t


@inline
def restrict(at: Value, first: Value, index: Value, weight: Value, r: Value, a: Value, coarse: Value) -> None:
    """Row a of r1 = P1^T r."""
    put(coarse, a, gathered(at, first, index, weight, 3, a, r, 0))


@inline
def solve_coarse(
    at: Value, first: Value, index: Value, weight: Value, inverse: Value, coarsest: Value, coarse: Value
) -> None:
    """z1 = P2 (D2^-1 + P3 A3^-1 P3^T) P2^T r1 but for P2, in place: rows of `coarse` are r1, r2, r3, z1, z2."""
    n1, n2, n3 = at[6], at[7], at[8]
    r2, r3, z2 = n1, n1 + n2, 2 * n1 + n2 + n3
    for a in range(n2):
        put(coarse, r2 + a, gathered(at, first, index, weight, 4, a, coarse, 0))
        put(coarse, z2 + a, sym_times(inverse, n1 + a, vec(coarse, r2 + a)))
    for a in range(n3):
        put(coarse, r3 + a, gathered(at, first, index, weight, 5, a, coarse, r2))
    for b in range(n3):
        t = vec(coarse, 0) * 0
        for c in range(n3):
            rc = vec(coarse, r3 + c)
            for k in ti.static(range(3)):
                for j in ti.static(range(3)):
                    t[k] += coarsest[3 * b + k, 3 * c + j] * rc[j]
        row = at[5] + b
        for e in range(first[row], first[row + 1]):
            a = z2 + index[e]
            put(coarse, a, vec(coarse, a) + weight[e] * t)


@inline
def interpolate_coarse(
    at: Value, first: Value, index: Value, weight: Value, inverse: Value, a: Value, coarse: Value
) -> None:
    """Row a of z1 = D1^-1 r1 + P2 z2."""
    n1, n2, n3 = at[6], at[7], at[8]
    t = sym_times(inverse, a, vec(coarse, a))
    put(coarse, n1 + n2 + n3 + a, t + gathered(at, first, index, weight, 1, a, coarse, 2 * n1 + n2 + n3))


@inline
def corrected(
    at: Value, first: Value, index: Value, weight: Value, inverse: Value, i: Value, r: Value, coarse: Value
) -> Value:
    """Row i of z = D^-1 r + P1 z1."""
    return sym_times(inverse, i, vec(r, i)) + gathered(at, first, index, weight, 0, i, coarse, at[6] + at[7] + at[8])


@kernel
def begin(
    residual: Array,
    inverse: Array,
    at: Array,
    first: Array,
    index: Array,
    weight: Array,
    coarse_inverse: Array,
    coarsest: Array,
    # outputs
    coarse: Array,
    dx: Array,
    r: Array,
    z: Array,
    p: Array,
    q: Array,
    scalars: Array,
) -> None:
    """dx = p = q = 0, r = residual, z = M^-1 r; scalars = 0."""
    for i in range(r.shape[0]):
        for c in ti.static(range(3)):
            dx[i, c] = 0.0
            p[i, c] = 0.0
            q[i, c] = 0.0
            r[i, c] = residual[i, c]
        if i < 4:
            scalars[i] = 0.0
    for a in range(at[6]):
        restrict(at, first, index, weight, r, a, coarse)
    ti.loop_config(serialize=True)
    for _ in range(1):
        solve_coarse(at, first, index, weight, coarse_inverse, coarsest, coarse)
    for a in range(at[6]):
        interpolate_coarse(at, first, index, weight, coarse_inverse, a, coarse)
    for i in range(r.shape[0]):
        put(z, i, corrected(at, first, index, weight, inverse, i, r, coarse))


@kernel
def iterate(
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
    # outputs
    coarse: Array,
    dx: Array,
    r: Array,
    z: Array,
    p: Array,
    q: Array,
    w: Array,
    part: Array,
    scalars: Array,
) -> None:
    """SWEEPS iterations in the form with one reduction (Chronopoulos and Gear 1989): z = M^-1 r, w = A z, p, q = A p.

    The product A z is D z - sum (a + w w^T) z_j + bending + contacts, gathered vertex by vertex. A contact between
    cloth adds weight_i K_c (sum_k weight_k z_k), K_c = a I + w w^T. scalars: r.z, alpha, beta, r.z at the start.
    """
    n = r.shape[0]
    for _ in ti.static(range(SWEEPS)):
        for b in range(blocks):
            gamma, delta = ti.f64(0.0), ti.f64(0.0)
            for i in range(b * n // blocks, (b + 1) * n // blocks):
                zi = vec(z, i)
                y = sym_times(diagonal, i, zi)
                for e in range(start[i], start[i + 1]):
                    s = spring[e]
                    zj = vec(z, neighbour[e])
                    d = ti.Vector([block[s, 1], block[s, 2], block[s, 3]])
                    y -= block[s, 0] * zj + d * d.dot(zj)
                t = zi * 0
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
                for c in ti.static(range(3)):
                    w[i, c] = y[c]
                gamma += ti.f64(zi.dot(vec(r, i)))
                delta += ti.f64(zi.dot(y))
            part[b, 0] = gamma
            part[b, 1] = delta
        ti.loop_config(serialize=True)
        for _s in range(1):
            gamma, delta = ti.f64(0.0), ti.f64(0.0)
            for b in range(blocks):
                gamma += part[b, 0]
                delta += part[b, 1]
            beta = 0.0
            if scalars[0] > 0:
                beta = gamma / scalars[0]
                delta -= beta * gamma / scalars[1]
            else:
                scalars[3] = gamma
            alpha = 0.0
            if delta > 0:
                alpha = gamma / delta
            scalars[0] = gamma
            scalars[1] = alpha
            scalars[2] = beta
            if alpha == 0.0:
                scalars[0] = 0.0
        for i in range(n):
            alpha, beta = scalars[1], scalars[2]
            for c in ti.static(range(3)):
                p[i, c] = z[i, c] + beta * p[i, c]
                q[i, c] = w[i, c] + beta * q[i, c]
                dx[i, c] += alpha * p[i, c]
                r[i, c] -= alpha * q[i, c]
        for a in range(at[6]):
            restrict(at, first, index, weight, r, a, coarse)
        ti.loop_config(serialize=True)
        for _s in range(1):
            solve_coarse(at, first, index, weight, coarse_inverse, coarsest, coarse)
        for a in range(at[6]):
            interpolate_coarse(at, first, index, weight, coarse_inverse, a, coarse)
        for i in range(n):
            put(z, i, corrected(at, first, index, weight, inverse, i, r, coarse))


class Pcg:
    """Buffers of the linear solve, and the loop around its kernels.

    Solves A dx = residual until sqrt(r.z) falls below `tolerance` times its first value (z = inverse r).
    """

    def __init__(self, count: int, dtype: Any = np.float32) -> None:
        self.dx, self.r, self.z, self.p, self.q, self.w = (np.zeros((count, 3), dtype) for _ in range(6))
        self.diagonal, self.inverse = np.zeros((count, 6), dtype), np.zeros((count, 6), dtype)
        self.part, self.scalars = np.zeros((BLOCKS, 2)), np.zeros(4)
        self.iterations = 0

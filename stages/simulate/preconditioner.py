"""The preconditioner of the step's linear system, row by row: z = M^-1 r on several levels of detail at once.

z = D^-1 r + P1 z1, z1 = D1^-1 r1 + P2 z2, z2 = D2^-1 r2 + P3 z3, z3 = A3^-1 r3 and r1 = P1^T r, r2 = P2^T r1,
r3 = P3^T r2. Rows of `coarse` are r1, r2, r3, z1, z2, those of `inverse` lie as r1 and r2 do; arguments r2, r3, z2 are
where these begin. `Multilevel` tells what `at`, `first`, `index` and `weight` hold.
"""

import taichi as ti

from stages.simulate.kernels import Value, inline, put, vec


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
def restrict_second(
    at: Value, first: Value, index: Value, weight: Value, inverse: Value, a: Value, r2: Value, z2: Value, coarse: Value
) -> None:
    """Row a of r2 = P2^T r1 and of D2^-1 r2, which z2 begins with."""
    put(coarse, r2 + a, gathered(at, first, index, weight, 4, a, coarse, 0))
    put(coarse, z2 + a, sym_times(inverse, r2 + a, vec(coarse, r2 + a)))


@inline
def restrict_third(
    at: Value, first: Value, index: Value, weight: Value, a: Value, r2: Value, r3: Value, coarse: Value
) -> None:
    """Row a of r3 = P3^T r2."""
    put(coarse, r3 + a, gathered(at, first, index, weight, 5, a, coarse, r2))


@inline
def solved_third(coarsest: Value, n3: Value, b: Value, r3: Value, coarse: Value) -> Value:
    """Row b of z3 = A3^-1 r3."""
    t = vec(coarse, 0) * 0
    for c in range(n3):
        rc = vec(coarse, r3 + c)
        for k in ti.static(range(3)):
            for j in ti.static(range(3)):
                t[k] += coarsest[3 * b + k, 3 * c + j] * rc[j]
    return t


@inline
def spread_third(
    at: Value, first: Value, index: Value, weight: Value, b: Value, t: Value, z2: Value, coarse: Value
) -> None:
    """z2 += P3 z3, as far as row b of z3 goes, which is t."""
    row = at[5] + b
    for e in range(first[row], first[row + 1]):
        a = z2 + index[e]
        put(coarse, a, vec(coarse, a) + weight[e] * t)


@inline
def solve_coarse(
    at: Value, first: Value, index: Value, weight: Value, inverse: Value, coarsest: Value, coarse: Value
) -> None:
    """z2 = (D2^-1 + P3 A3^-1 P3^T) P2^T r1, all of it."""
    n1, n2, n3 = at[6], at[7], at[8]
    r2, r3, z2 = n1, n1 + n2, 2 * n1 + n2 + n3
    for a in range(n2):
        restrict_second(at, first, index, weight, inverse, a, r2, z2, coarse)
    for a in range(n3):
        restrict_third(at, first, index, weight, a, r2, r3, coarse)
    for b in range(n3):
        spread_third(at, first, index, weight, b, solved_third(coarsest, n3, b, r3, coarse), z2, coarse)


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

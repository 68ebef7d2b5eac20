"""Kernels that form the matrices of the coarse levels and invert what the preconditioner needs of them."""

import taichi as ti

from stages.simulate.kernels import Array, Int, kernel


@kernel
def galerkin_springs(
    start: Array,
    index: Array,
    weight: Array,
    springs: Int,
    spring_block: Array,
    own_block: Array,
    # outputs
    block: Array,
) -> None:
    """block[e] = sum of weight * B over the list of e, B the block of a spring, or a vertex's own beyond `springs`.

    A spring's isotropic part, negative where bending rides along, is left out where it is.
    """
    for e in range(block.shape[0]):
        m = ti.Vector([0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        for k in range(start[e], start[e + 1]):
            s, c = index[k], ti.f64(weight[k])
            if s < springs:
                a = ti.max(ti.f64(spring_block[s, 0]), 0.0)
                u, v, w = ti.f64(spring_block[s, 1]), ti.f64(spring_block[s, 2]), ti.f64(spring_block[s, 3])
                m += c * ti.Vector([a + u * u, u * v, u * w, a + v * v, v * w, a + w * w])
            else:
                for i in ti.static(range(6)):
                    m[i] += c * ti.f64(own_block[s - springs, i])
        for i in ti.static(range(6)):
            block[e, i] = m[i]


@kernel
def galerkin_blocks(
    start: Array,
    index: Array,
    weight: Array,
    fine: Array,
    # outputs
    block: Array,
) -> None:
    """block[e] = sum of weight * fine block over the list of e."""
    for e in range(block.shape[0]):
        m = ti.Vector([0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        for k in range(start[e], start[e + 1]):
            for i in ti.static(range(6)):
                m[i] += ti.f64(weight[k]) * ti.f64(fine[index[k], i])
        for i in ti.static(range(6)):
            block[e, i] = m[i]


@kernel
def coarse_inverses(
    place: Array,
    block: Array,
    base: Int,
    # outputs
    inverse: Array,
) -> None:
    """Inverses of the diagonal blocks at `place`, 0 where there is none, in rows from `base` on."""
    for k in range(place.shape[0]):
        e = place[k]
        a = base + k
        for i in ti.static(range(6)):
            inverse[a, i] = 0.0
        if e >= 0:
            m00, m01, m02 = ti.f64(block[e, 0]), ti.f64(block[e, 1]), ti.f64(block[e, 2])
            m11, m12, m22 = ti.f64(block[e, 3]), ti.f64(block[e, 4]), ti.f64(block[e, 5])
            c00, c01, c02 = m11 * m22 - m12 * m12, m02 * m12 - m01 * m22, m01 * m12 - m02 * m11
            det = m00 * c00 + m01 * c01 + m02 * c02
            if det > 0:
                inverse[a, 0] = c00 / det
                inverse[a, 1] = c01 / det
                inverse[a, 2] = c02 / det
                inverse[a, 3] = (m00 * m22 - m02 * m02) / det
                inverse[a, 4] = (m01 * m02 - m00 * m12) / det
                inverse[a, 5] = (m00 * m11 - m01 * m01) / det


@kernel
def invert_coarsest(
    pairs: Array,
    block: Array,
    # outputs
    work: Array,
    inverse: Array,
) -> None:
    """Inverse of the whole matrix of the last level, by Gauss-Jordan without pivoting: it is positive definite.

    A row without an entry keeps a 0 on the diagonal and gets a 0 in the inverse.
    """
    n = work.shape[0]
    ti.loop_config(serialize=True)
    for _ in range(1):
        for i in range(n):
            for j in range(n):
                work[i, j] = 0.0
        for e in range(pairs.shape[0]):
            a, b = 3 * pairs[e, 0], 3 * pairs[e, 1]
            for i in ti.static(range(3)):
                for j in ti.static(range(3)):
                    k = ti.static((0, 1, 2, 1, 3, 4, 2, 4, 5)[3 * i + j])
                    work[a + i, b + j] = block[e, k]
                    work[b + j, a + i] = block[e, k]
        for k in range(n):
            pivot = work[k, k]
            if pivot > 1e-12:
                work[k, k] = 1.0
                for j in range(n):
                    work[k, j] /= pivot
                for i in range(n):
                    if i != k and work[i, k] != 0.0:
                        f = work[i, k]
                        work[i, k] = 0.0
                        for j in range(n):
                            work[i, j] -= f * work[k, j]
            else:
                for j in range(n):
                    work[k, j] = 0.0
                    work[j, k] = 0.0
        for i in range(n):
            for j in range(n):
                inverse[i, j] = work[i, j]

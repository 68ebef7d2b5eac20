"""Forces and stiffness of the cloth itself: inertia, gravity, drag, stretch and bending.

The step solves for x the stationary point of the incremental potential (Kane et al. 2000)

    Phi(x) = 1/2 (x - y)^T M (x - y) / h^2 + E_stretch(x) + E_bend(x) - g^T M x  (+ drag, damping, contact)

with y the inertial target and h the effective step of the integrator. `residual` is -dPhi/dx, and each block of the
matrix is positive definite by construction: a spring's block is a I + w w^T, kept as 4 numbers.
"""

import taichi as ti

from stages.simulate.kernels import Array, Int, Real, kernel, light, put, vec


@kernel
def spring_blocks(
    x: Array,
    x_bar: Array,
    edges: Array,
    rest_length: Array,
    stiffness: Array,
    limit: Array,
    stiffening: Array,
    damping: Array,
    edge_bend: Array,
    h: Real,
    # outputs
    pull: Array,
    block: Array,
) -> None:
    """Force on the first end, and block (a, w) of the matrix, of every spring.

    E = k/2 (l - l0)^2 + k (s - 1)/2 max(0, l - l0 (1 + limit))^2, f = -dE/dx = -T n with tension T = dE/dl.
    d2E/dx2 = k' n n^T + T/l (I - n n^T); T/l is clamped at 0, without which compressed springs make it indefinite
    (Choi and Ko 2002). Damping: T += damping * k * n.(v_i - v_j), v = (x - x_bar) / h. The bending pairs that
    are edges (`edge_bend`, q_ij) ride along: see `gather_rows`.
    """
    for s in range(edges.shape[0]):
        i, j = edges[s, 0], edges[s, 1]
        d = vec(x, i) - vec(x, j)
        length = ti.max(d.norm(), 1e-9)
        n = d / length
        l0 = rest_length[s]
        k = stiffness[s]
        slope = k
        tension = k * (length - l0)
        beyond = length - l0 * (1.0 + limit[s])
        if beyond > 0:
            slope = k * stiffening[s]
            tension += k * (stiffening[s] - 1.0) * beyond
        viscous = damping[s] * k / h
        a = ti.max(tension, 0.0) / length
        w = ti.sqrt(ti.max(slope + viscous - a, 0.0)) * n
        moved = d - (vec(x_bar, i) - vec(x_bar, j))
        q = edge_bend[s]
        put(pull, s, -(tension + viscous * n.dot(moved)) * n + q * (d + damping[s] / h * moved))
        block[s, 0] = a - q * (1.0 + damping[s] / h)
        block[s, 1] = w[0]
        block[s, 2] = w[1]
        block[s, 3] = w[2]


@kernel
def gather_rows(
    x: Array,
    x_bar: Array,
    y: Array,
    mass: Array,
    inertia: Array,
    area: Array,
    drag: Array,
    gravity: Real,
    wind: Array,
    h: Real,
    start: Array,
    neighbour: Array,
    spring: Array,
    pull: Array,
    block: Array,
    bend_start: Array,
    bend_neighbour: Array,
    bend: Array,
    bend_sum: Array,
    bend_damping: Array,
    outer_force: Array,
    outer_block: Array,
    pair_block: Array,
    fixed: Array,
    # outputs
    residual: Array,
    diagonal: Array,
    inverse: Array,
    own: Array,
) -> None:
    """Residual, diagonal block and its inverse for every vertex; `own` is the block without springs and bending.

    Bending: E = -1/2 sum q_ij |x_i - x_j|^2, f_i = sum_j q_ij (x_i - x_j), damping times q_ij (v_i - v_j); here the
    pairs that aren't edges.
    `outer_*` is contact with what isn't cloth; `pair_block` the diagonal of contact between cloth, in the
    preconditioner only, since the product adds those contacts whole. Symmetric blocks are xx, xy, xz, yy, yz, zz.
    """
    for i in range(x.shape[0]):
        xi = vec(x, i)
        vi = (xi - vec(x_bar, i)) / h
        air = drag[i] * area[i]
        f = -inertia[i] * (xi - vec(y, i)) - air * (vi - ti.Vector([wind[0], wind[1], wind[2]]))
        f[2] += mass[i] * gravity
        f += vec(outer_force, i)
        iso = inertia[i] + air / h - bend_sum[i] * (1.0 + bend_damping[i] / h)
        m00, m01, m02 = outer_block[i, 0], outer_block[i, 1], outer_block[i, 2]
        m11, m12, m22 = outer_block[i, 3], outer_block[i, 4], outer_block[i, 5]
        alone = inertia[i] + air / h
        own[i, 0], own[i, 1], own[i, 2] = m00 + alone, m01, m02
        own[i, 3], own[i, 4], own[i, 5] = m11 + alone, m12, m22 + alone
        for e in range(start[i], start[i + 1]):
            s = spring[e]
            t = vec(pull, s)
            if neighbour[e] > i:
                f += t
            else:
                f -= t
            a, u, v, w = ti.f64(block[s, 0]), ti.f64(block[s, 1]), ti.f64(block[s, 2]), ti.f64(block[s, 3])
            iso += a
            m00 += u * u
            m01 += u * v
            m02 += u * w
            m11 += v * v
            m12 += v * w
            m22 += w * w
        bend_force = ti.Vector([0.0, 0.0, 0.0])
        bend_rate = ti.Vector([0.0, 0.0, 0.0])
        for e in range(bend_start[i], bend_start[i + 1]):
            j = bend_neighbour[e]
            dx = xi - vec(x, j)
            bend_force += bend[e] * dx
            bend_rate += bend[e] * (vi - (vec(x, j) - vec(x_bar, j)) / h)
        f += bend_force + bend_damping[i] * bend_rate
        m00 += iso
        m11 += iso
        m22 += iso
        for c in ti.static(range(3)):
            residual[i, c] = f[c]
        diagonal[i, 0], diagonal[i, 1], diagonal[i, 2] = m00, m01, m02
        diagonal[i, 3], diagonal[i, 4], diagonal[i, 5] = m11, m12, m22
        if fixed[i] == 1:
            for c in ti.static(range(6)):
                inverse[i, c] = 0.0
            for c in ti.static(range(3)):
                residual[i, c] = 0.0
        else:
            m00 += pair_block[i, 0]
            m01 += pair_block[i, 1]
            m02 += pair_block[i, 2]
            m11 += pair_block[i, 3]
            m12 += pair_block[i, 4]
            m22 += pair_block[i, 5]
            c00, c01, c02 = m11 * m22 - m12 * m12, m02 * m12 - m01 * m22, m01 * m12 - m02 * m11
            scale = 1.0 / (m00 * c00 + m01 * c01 + m02 * c02)
            inverse[i, 0] = c00 * scale
            inverse[i, 1] = c01 * scale
            inverse[i, 2] = c02 * scale
            inverse[i, 3] = (m00 * m22 - m02 * m02) * scale
            inverse[i, 4] = (m01 * m02 - m00 * m12) * scale
            inverse[i, 5] = (m00 * m11 - m01 * m01) * scale


@kernel
def inertial_target(
    x: Array,
    v: Array,
    x_old: Array,
    v_old: Array,
    w: Real,
    dt: Real,
    fixed: Array,
    goal: Array,
    mass: Array,
    fresh: Array,
    # outputs
    x_bar: Array,
    y: Array,
    guess: Array,
    inertia: Array,
) -> None:
    """Start of a step of BDF2 with ratio w of this step to the last; w = 0 is the implicit Euler step.

    x' = x_bar + h v', v' = v_bar + h a', h = dt (1 + w) / (1 + 2 w),
    x_bar = ((1 + w)^2 x - w^2 x_old) / (1 + 2 w), v_bar alike (Hairer, Norsett, Wanner, "Solving ODEs I", III.5).
    The first guess is x + dt v; fixed vertices go to their goal. `inertia` is mass / h^2 [kg/s^2].
    An impact is no smooth motion, which two steps would tell the course of: vertices that have just met the skin or
    left it (`fresh`) take a step of implicit Euler, x' = x + dt v'; x_bar then holds for damping and drag, roughly.
    """
    ti.loop_config(serialize=light.serial)
    for i in range(x.shape[0]):
        c1 = (1.0 + w) * (1.0 + w) / (1.0 + 2.0 * w)
        c2 = w * w / (1.0 + 2.0 * w)
        h = dt * (1.0 + w) / (1.0 + 2.0 * w)
        xb = c1 * vec(x, i) - c2 * vec(x_old, i)
        vb = c1 * vec(v, i) - c2 * vec(v_old, i)
        put(x_bar, i, xb)
        put(y, i, xb + h * vb)
        inertia[i] = mass[i] / (h * h)
        if fresh[i] == 1:
            put(y, i, vec(x, i) + dt * vec(v, i))
            put(x_bar, i, vec(x, i) + (dt - h) * vec(v, i))
            inertia[i] = mass[i] / (dt * dt)
        if fixed[i] == 1:
            put(guess, i, vec(goal, i))
        else:
            put(guess, i, vec(x, i) + dt * vec(v, i))


@kernel
def advance(
    x: Array,
    dx: Array,
    longest: Real,
    blocks: Int,
    # outputs
    out: Array,
    largest: Array,
) -> None:
    """out = x + dx with no vertex moved by more than `longest`; the largest |dx| of each block, 1e30 if not finite."""
    n = x.shape[0]
    ti.loop_config(serialize=light.serial)
    for b in range(blocks):
        most = ti.f64(0.0)
        for i in range(b * n // blocks, (b + 1) * n // blocks):
            d = ti.Vector([ti.f64(dx[i, 0]), ti.f64(dx[i, 1]), ti.f64(dx[i, 2])])
            size = d.norm()
            if not (size < 1e30):
                most = ti.f64(1e30)
            else:
                most = ti.max(most, size)
                if size > longest:
                    d *= longest / size
            put(out, i, vec(x, i) + d)
        largest[b] = most

"""Kernels of what the moving body does to each cloth vertex: pressure, friction, ties."""

import taichi as ti

from stages.simulate.kernels import Array, Real, Value, inline, kernel, light, put, vec

SKIN_YIELD = 3000.0
"""Most friction that skin bears over its area [Pa]: what pulls harder slides.

An assumption, not a measurement: as much as friction holds of a garment of a kilogram that hangs on 20 square
centimetres of shoulder, at a coefficient of 0.6. A hem that is narrower than a stride pulls harder, and rides up.
"""


@inline
def add_outer(block: Value, i: Value, k: Value, n: Value) -> None:
    """block += k n n^T."""
    block[i, 0] += k * n[0] * n[0]
    block[i, 1] += k * n[0] * n[1]
    block[i, 2] += k * n[0] * n[2]
    block[i, 3] += k * n[1] * n[1]
    block[i, 4] += k * n[1] * n[2]
    block[i, 5] += k * n[2] * n[2]


@kernel
def press(
    x: Array,
    x_start: Array,
    face: Array,
    bary: Array,
    normal: Array,
    distance: Array,
    face2: Array,
    normal2: Array,
    distance2: Array,
    body: Array,
    body_start: Array,
    faces: Array,
    area: Array,
    friction: Array,
    shear: Array,
    reaction: Array,
    margin: Real,
    stiffness: Real,
    damping: Real,
    dt: Real,
    grip: Real,
    # outputs
    force: Array,
    block: Array,
    shear_new: Array,
) -> None:
    """Penalty and friction of the body on every vertex.

    Normal: pressure `stiffness` [N/m^3] times how much of `margin` is missing, plus damping of approach [s].
    Friction: an elastic grip that yields at Coulomb's limit (Mindlin): the tangential slip s since the grip closed,
    s = P (s_start + (x - x_start) - (b - b_start)), f = -k_t s while k_t |s| <= mu N, else -mu N s / |s|. So cloth at
    rest holds still instead of creeping, and sliding cloth feels mu N exactly. `shear_new` is s, cut to the limit. No
    more than `SKIN_YIELD` times the area is borne, however hard the cloth presses.
    N is `reaction`, what the last linear solve balanced, see `foresee`: skin is so stiff that the depth of an iterate
    tells hardly anything about the force that the cloth ends up with.
    """
    ti.loop_config(serialize=light.serial)
    for i in range(x.shape[0]):
        f = ti.Vector([0.0, 0.0, 0.0])
        for c in ti.static(range(6)):
            block[i, c] = 0.0
        s = ti.Vector([0.0, 0.0, 0.0])
        gap = margin - distance[i]
        if face[i] >= 0 and gap > 0:
            n = vec(normal, i)
            b = face[i]
            move = vec(x, i) - vec(x_start, i)
            for c in ti.static(range(3)):
                move -= bary[i, c] * (vec(body, faces[b, c]) - vec(body_start, faces[b, c]))
            k = stiffness * area[i]
            load = k * gap
            viscous = k * damping / dt
            approach = -n.dot(move)
            if approach > 0:
                f += viscous * approach * n
                add_outer(block, i, viscous, n)
            f += load * n
            add_outer(block, i, k, n)
            s = vec(shear, i) + move
            s -= n * n.dot(s)
            kt = k * grip
            limit = ti.min(friction[i] * reaction[i], SKIN_YIELD * area[i])
            size = s.norm()
            hold = kt
            if kt * size >= limit:
                hold = limit / ti.max(size, 1e-12)
                # The secant, not the tangent, which along the slip is 0: what is about to stick would overshoot.
                s *= limit / ti.max(kt * size, 1e-12 * kt)
            f -= kt * s
            add_outer(block, i, -hold, n)
            block[i, 0] += hold
            block[i, 3] += hold
            block[i, 5] += hold
        if face2[i] >= 0:
            gap2 = margin - distance2[i]
            if gap2 > 0:
                n2 = vec(normal2, i)
                f += stiffness * area[i] * gap2 * n2
                add_outer(block, i, stiffness * area[i], n2)
        put(force, i, f)
        put(shear_new, i, s)


@kernel
def foresee(
    x: Array,
    solved: Array,
    face: Array,
    normal: Array,
    distance: Array,
    area: Array,
    friction: Array,
    margin: Real,
    stiffness: Real,
    grip: Real,
    # outputs
    reaction: Array,
    shear_new: Array,
) -> None:
    """Normal force [N] of the skin, and grip, where a linear solve from `x` ended: at the `solved` positions."""
    ti.loop_config(serialize=light.serial)
    for i in range(x.shape[0]):
        gap = margin - distance[i]
        reaction[i] = 0.0
        if face[i] >= 0 and gap > 0:
            n = vec(normal, i)
            d = vec(solved, i) - vec(x, i)
            k = stiffness * area[i]
            reaction[i] = k * ti.max(gap - n.dot(d), 0.0)
            s = vec(shear_new, i) + d - n * n.dot(d)
            longest = ti.min(friction[i] * reaction[i], SKIN_YIELD * area[i]) / (k * grip)
            put(shear_new, i, s * ti.min(1.0, longest / ti.max(s.norm(), 1e-12)))


@kernel
def hold_attached(
    x: Array,
    x_start: Array,
    face: Array,
    bary: Array,
    offset: Array,
    stiffness: Array,
    body: Array,
    faces: Array,
    # outputs
    force: Array,
    block: Array,
) -> None:
    """Soft ties of cloth to points that move with the body: E = k/2 |x - (b + offset n)|^2."""
    for i in range(x.shape[0]):
        if stiffness[i] > 0:
            f = face[i]
            a, b, c = vec(body, faces[f, 0]), vec(body, faces[f, 1]), vec(body, faces[f, 2])
            n = (b - a).cross(c - a)
            n /= ti.max(n.norm(), 1e-20)
            goal = bary[i, 0] * a + bary[i, 1] * b + bary[i, 2] * c + offset[i] * n
            put(force, i, vec(force, i) + stiffness[i] * (goal - vec(x, i)))
            block[i, 0] += stiffness[i]
            block[i, 3] += stiffness[i]
            block[i, 5] += stiffness[i]

"""Kernels that move a solved step out of the skin, and tell what that means for its velocity."""

import taichi as ti

from stages.simulate.kernels import BLOCKS, Array, Real, kernel, light, put, vec


@kernel
def lift_out(
    face: Array,
    normal: Array,
    distance: Array,
    fixed: Array,
    floor: Real,
    x: Array,
    # outputs
    active: Array,
    deepest: Array,
    moved: Array,
) -> None:
    """Move every active vertex nearer than `floor` out to it; only those moved stay active.

    Per block: the smallest distance found, and how many vertices moved.
    """
    n = x.shape[0]
    ti.loop_config(serialize=light.serial)
    for b in range(BLOCKS):
        least = 1e9
        count = 0
        for i in range(b * n // BLOCKS, (b + 1) * n // BLOCKS):
            move = 0
            if active[i] == 1 and face[i] >= 0 and fixed[i] == 0:
                least = ti.min(least, distance[i])
                if distance[i] < floor:
                    put(x, i, vec(x, i) + (floor - distance[i]) * vec(normal, i))
                    move = 1
            active[i] = move
            count += move
        deepest[b] = least
        moved[b] = count


@kernel
def take_over(
    solved: Array,
    x: Array,
    x_bar: Array,
    h: Real,
    dt: Real,
    face: Array,
    distance: Array,
    bary: Array,
    normal: Array,
    body: Array,
    body_start: Array,
    faces: Array,
    margin: Real,
    # outputs
    touched: Array,
    fresh: Array,
    v: Array,
    before: Array,
) -> None:
    """Velocity of the step from its `solved` positions, and what moving them to `x` afterwards means for it.

    A correction of position is no motion: the step's start `before` moves along, so that the next step of the
    two-step integrator doesn't take it for speed. Only the speed towards the body is lost.
    `touched` tells what the skin touches now, `fresh` where that has changed: see `inertial_target`.
    """
    ti.loop_config(serialize=light.serial)
    for i in range(x.shape[0]):
        u = (vec(solved, i) - vec(x_bar, i)) / h
        touches = 0
        if face[i] >= 0 and distance[i] < margin:
            touches = 1
        changed = 0
        if touches != touched[i]:
            changed = 1
        if changed == 1 or fresh[i] == 1:
            u = (vec(solved, i) - vec(before, i)) / dt
        fresh[i] = changed
        touched[i] = touches
        shift = vec(x, i) - vec(solved, i)
        if shift.norm_sqr() > 0:
            put(before, i, vec(before, i) + shift)
            f = face[i]
            if f >= 0:
                n = vec(normal, i)
                rate = n.dot(u)
                for c in ti.static(range(3)):
                    b = vec(body, faces[f, c]) - vec(body_start, faces[f, c])
                    rate -= bary[i, c] * n.dot(b) / dt
                if rate < 0:
                    u -= rate * n
        put(v, i, u)

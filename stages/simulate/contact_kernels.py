"""Kernels of contact between cloth vertices and the moving body."""

import taichi as ti

from stages.simulate.closest import closest_on_triangle, pseudo_normal
from stages.simulate.kernels import BLOCKS, Array, Int, Real, Value, inline, kernel, put, vec
from stages.simulate.patch_kernels import out_of_box

SKIN_YIELD = 3000.0
"""Most friction that skin bears over its area [Pa]: what pulls harder slides.

An assumption, not a measurement: as much as friction holds of a garment of a kilogram that hangs on 20 square
centimetres of shoulder, at a coefficient of 0.6. A hem that is narrower than a stride pulls harder, and rides up.
"""


@kernel
def find_candidates(
    x: Array,
    v: Array,
    body: Array,
    body_start: Array,
    faces: Array,
    centre: Array,
    radius: Array,
    reach: Real,
    furthest: Real,
    dt: Real,
    patch: Array,
    patch_start: Array,
    patch_box: Array,
    met_count: Array,
    met: Array,
    # outputs
    count: Array,
    found: Array,
) -> None:
    """Triangles nearer to each vertex than `reach` and their motion past it in `dt`, of the patches that its can meet.

    found[i, :count[i]], ascending; count goes on beyond the width of `found`, so that the caller sees how much room is
    missing.
    """
    for i in range(x.shape[0]):
        p = vec(x, i)
        n = 0
        for e in range(met_count[patch[i]]):
            m = met[patch[i], e]
            last = patch_start[m + 1]
            if out_of_box(p, p, patch_box, m, furthest):
                last = patch_start[m]
            for f in range(patch_start[m], last):
                d2 = (vec(centre, f) - p).norm_sqr()
                far = furthest + radius[f]
                if d2 < far * far:
                    a = faces[f, 0]
                    slip = dt * vec(v, i) - (vec(body, a) - vec(body_start, a))
                    far = ti.min(reach + 1.25 * slip.norm(), furthest) + radius[f]
                    if d2 < far * far:
                        if n < found.shape[1]:
                            found[i, n] = f
                        n += 1
        count[i] = n


@inline
def surface_point(body: Value, faces: Value, f: Value, u: Value) -> Value:
    """Point of face f of `body` at barycentric coordinates u."""
    return u[0] * vec(body, faces[f, 0]) + u[1] * vec(body, faces[f, 1]) + u[2] * vec(body, faces[f, 2])


@kernel
def touch(
    x: Array,
    active: Array,
    count: Array,
    found: Array,
    body: Array,
    faces: Array,
    across: Array,
    start: Array,
    incident: Array,
    face_normal: Array,
    centre: Array,
    radius: Array,
    margin: Real,
    moved: Int,
    # outputs
    face: Array,
    bary: Array,
    normal: Array,
    distance: Array,
    face2: Array,
    normal2: Array,
    distance2: Array,
    pinched: Array,
    looked: Array,
) -> None:
    """Closest surface point of every vertex (face -1 if none), signed; and a second one where skin faces skin.

    The second contact is the closest triangle whose normal differs by more than 60 degrees and whose outside the
    vertex is on: without it a vertex in a fold of the body would be pushed from one side into the other. A surface
    that the vertex is behind, while another is nearer, is left alone: there the body overlaps itself and hides it.
    Vertices that have other skin near, facing away from the nearest, are marked as `pinched`. Unless the body has
    `moved`, vertices are left as they were that were too far away, where they were last looked at, to touch it now.
    """
    for i in range(x.shape[0]):
        p = vec(x, i)
        far = moved == 0 and distance[i] - (p - vec(looked, i)).norm() > 1.5 * margin
        if active[i] == 1 and not far:
            put(looked, i, p)
            best, best_f = 1e30, -1
            best_u = ti.Vector([0.0, 0.0, 0.0, 0.0])
            near = 1e15
            # The face that was nearest is likely to be so still: most others are then known to be further away.
            last = -1
            if count[i] > 0:
                last = face[i]
            for k in range(-1, count[i]):
                f = last
                if k >= 0:
                    f = found[i, k]
                if f >= 0 and (k < 0 or f != last) and (p - vec(centre, f)).norm() - radius[f] < near:
                    u = closest_on_triangle(p, vec(body, faces[f, 0]), vec(body, faces[f, 1]), vec(body, faces[f, 2]))
                    d2 = (p - surface_point(body, faces, f, u)).norm_sqr()
                    if d2 < best:
                        best, best_f, best_u = d2, f, u
                        near = ti.sqrt(d2)
            face[i] = best_f
            face2[i] = -1
            distance[i] = 1e9
            distance2[i] = 1e9
            if best_f >= 0:
                d = p - surface_point(body, faces, best_f, best_u)
                out = pseudo_normal(best_f, best_u[3], body, faces, across, start, incident, face_normal)
                length = ti.sqrt(best)
                sign = 1.0
                if d.dot(out) < 0:
                    sign = -1.0
                n = out / ti.max(out.norm(), 1e-20)
                if length > 1e-6:
                    n = sign * d / length
                distance[i] = sign * length
                put(normal, i, n)
                for c in ti.static(range(3)):
                    bary[i, c] = best_u[c]
                for k in range(count[i]):
                    if vec(face_normal, found[i, k]).dot(vec(face_normal, best_f)) < 0:
                        pinched[i] = 1
                if ti.abs(distance[i]) < 1.5 * margin:
                    best2 = margin * margin
                    n1 = vec(face_normal, best_f)
                    for k in range(count[i]):
                        f = found[i, k]
                        m = vec(face_normal, f)
                        if m.dot(n1) < 0.5 and (p - vec(centre, f)).norm() - radius[f] < margin:
                            a, b, c = vec(body, faces[f, 0]), vec(body, faces[f, 1]), vec(body, faces[f, 2])
                            u = closest_on_triangle(p, a, b, c)
                            e = p - surface_point(body, faces, f, u)
                            d2 = e.norm_sqr()
                            if d2 < best2 and e.dot(m) > 0.7 * ti.sqrt(d2):
                                best2 = d2
                                face2[i] = f
                                distance2[i] = ti.sqrt(d2)
                                put(normal2, i, e / ti.max(ti.sqrt(d2), 1e-12))


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

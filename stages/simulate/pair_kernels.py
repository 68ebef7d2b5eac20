"""Kernels of contact between cloth and cloth, vertex against face and edge against edge: sides, forces, corrections."""

import taichi as ti

from stages.simulate.closest import closest_on_edges, closest_on_triangle
from stages.simulate.kernels import Array, Int, Real, Value, inline, kernel, light, put, vec

NO_PAIR = -1.0
"""Gap [m] of what isn't to be kept apart."""


@inline
def face_normal_of(x: Value, a: Value, b: Value, c: Value) -> Value:
    """Unit normal of the triangle of vertices a, b, c."""
    n = (vec(x, b) - vec(x, a)).cross(vec(x, c) - vec(x, a))
    return n / ti.max(n.norm(), 1e-20)


@kernel
def write_pairs(
    x: Array,
    rest: Array,
    vertex_normal: Array,
    faces: Array,
    edges: Array,
    layer: Array,
    crossing: Array,
    ordered: Int,
    thickness: Real,
    vf_start: Array,
    vf_count: Array,
    vf_found: Array,
    ee_start: Array,
    ee_count: Array,
    ee_found: Array,
    # outputs
    vertices: Array,
    side: Array,
    gap: Array,
) -> None:
    """The pairs found: their four vertices, the direction from the second to the first part, and the distance to keep.

    `side` is where the first part is now relative to the second. Between garments whose normals agree it is where it
    ought to be, by the order of the layers, so that garments that start or get entangled come apart. Parts that are
    close together at rest keep at most 0.7 of that distance, and those that are all `crossing` none.
    """
    ti.loop_config(serialize=light.serial)
    for i in range(vf_count.shape[0]):
        for k in range(vf_count[i]):
            f = vf_found[i, k]
            a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
            o = vf_start[i] + k
            vertices[o, 0], vertices[o, 1], vertices[o, 2], vertices[o, 3] = i, a, b, c
            n = face_normal_of(x, a, b, c)
            u = closest_on_triangle(vec(x, i), vec(x, a), vec(x, b), vec(x, c))
            d = vec(x, i) - u[0] * vec(x, a) - u[1] * vec(x, b) - u[2] * vec(x, c)
            way = 1.0
            if d.dot(n) < 0:
                way = -1.0
            keep = thickness
            crossed = crossing[i] == 1 and crossing[a] + crossing[b] + crossing[c] == 3
            if layer[i] != layer[a]:
                if ordered == 1 and n.dot(vec(vertex_normal, i)) > 0.2:
                    way = 1.0
                    if layer[i] < layer[a]:
                        way = -1.0
                elif crossed:
                    keep = NO_PAIR
            else:
                u = closest_on_triangle(vec(rest, i), vec(rest, a), vec(rest, b), vec(rest, c))
                d = vec(rest, i) - u[0] * vec(rest, a) - u[1] * vec(rest, b) - u[2] * vec(rest, c)
                keep = ti.min(thickness, 0.7 * d.norm())
                if crossed:
                    keep = NO_PAIR
            put(side, o, way * n)
            gap[o] = keep
    ti.loop_config(serialize=light.serial)
    for e in range(ee_count.shape[0]):
        for k in range(ee_count[e]):
            g = ee_found[e, k]
            a, b, c, d = edges[e, 0], edges[e, 1], edges[g, 0], edges[g, 1]
            o = ee_start[e] + k
            vertices[o, 0], vertices[o, 1], vertices[o, 2], vertices[o, 3] = a, b, c, d
            st = closest_on_edges(vec(x, a), vec(x, b), vec(x, c), vec(x, d))
            s, t = st[0], st[1]
            w = (1 - s) * vec(x, a) + s * vec(x, b) - (1 - t) * vec(x, c) - t * vec(x, d)
            keep = thickness
            crossed = crossing[a] + crossing[b] == 2 and crossing[c] + crossing[d] == 2
            if layer[a] != layer[c]:
                n1 = vec(vertex_normal, a) + vec(vertex_normal, b)
                n2 = vec(vertex_normal, c) + vec(vertex_normal, d)
                # Only edges one above the other say something of the order of the layers, not those side by side.
                above = ti.abs(w.dot(n1 + n2)) > 0.7 * w.norm() * (n1 + n2).norm()
                if ordered == 1 and n1.dot(n2) > 0.8 and above:
                    w = n1 + n2
                    if layer[a] < layer[c]:
                        w = -w
                elif crossed:
                    keep = NO_PAIR
            else:
                st = closest_on_edges(vec(rest, a), vec(rest, b), vec(rest, c), vec(rest, d))
                s, t = st[0], st[1]
                r = (1 - s) * vec(rest, a) + s * vec(rest, b) - (1 - t) * vec(rest, c) - t * vec(rest, d)
                keep = ti.min(thickness, 0.7 * r.norm())
                if crossed:
                    keep = NO_PAIR
            put(side, o, w / ti.max(w.norm(), 1e-12))
            gap[o] = keep


@inline
def pair_state(x: Value, vertices: Value, o: Value, faces_first: Value, side: Value) -> Value:
    """Weights (4), normal (3) and signed distance of pair o; distance 1e9 where its parts don't face each other."""
    a, b, c, d = vertices[o, 0], vertices[o, 1], vertices[o, 2], vertices[o, 3]
    ref = vec(side, o)
    w = ti.Vector([0.0, 0.0, 0.0, 0.0])
    n = ti.Vector([0.0, 0.0, 0.0])
    inside = False
    if o < faces_first:
        u = closest_on_triangle(vec(x, a), vec(x, b), vec(x, c), vec(x, d))
        w = ti.Vector([1.0, -u[0], -u[1], -u[2]])
        n = face_normal_of(x, b, c, d)
        inside = u[3] > 5.5
    else:
        st = closest_on_edges(vec(x, a), vec(x, b), vec(x, c), vec(x, d))
        s, t = st[0], st[1]
        w = ti.Vector([1 - s, s, t - 1, -t])
        u, v = vec(x, b) - vec(x, a), vec(x, d) - vec(x, c)
        m = u.cross(v)
        size = m.norm()
        n = m / ti.max(size, 1e-20)
        # Nearly parallel edges have no reliable normal; their ends' faces see to them.
        inside = s > 0 and s < 1 and t > 0 and t < 1 and size > 0.05 * u.norm() * v.norm()
        # Edges that have turned too far since they were found have no side any more, until they are found again.
        inside = inside and ti.abs(n.dot(ref)) > 0.5
    if n.dot(ref) < 0:
        n = -n
    z = w[0] * vec(x, a) + w[1] * vec(x, b) + w[2] * vec(x, c) + w[3] * vec(x, d)
    distance = 1e9
    if inside:
        distance = z.dot(n)
    return ti.Vector([w[0], w[1], w[2], w[3], n[0], n[1], n[2], distance])


@kernel
def press_pairs(
    x: Array,
    x_start: Array,
    vertices: Array,
    side: Array,
    gap: Array,
    faces_first: Int,
    total: Int,
    whole: Int,
    area: Array,
    sheet: Array,
    friction: Array,
    stiffness: Real,
    viscous: Real,
    # outputs
    active: Array,
    weights: Array,
    block: Array,
    force: Array,
) -> None:
    """Force on the first part of every pair nearer than its gap, and its stiffness a I + w w^T.

    E = k/2 (gap - d)^2, damped by `viscous` times k a move apart or together, but never pulling; friction mu times that
    against the slip of the step, at most half the normal stiffness.

    From `total` on to `whole` the first part is pulled along `side` until it has gone as far as `gap` past the second
    since `x_start`, as strongly as the cloth, of stiffness `sheet` [N/m], holds it back.
    """
    ti.loop_config(serialize=light.serial)
    for o in range(total, whole):
        u = closest_on_triangle(*[vec(x, vertices[o, c]) for c in ti.static(range(4))])
        w = ti.Vector([1.0, -u[0], -u[1], -u[2]])
        missing, k = gap[o], 0.0
        for c in ti.static(range(4)):
            v = vertices[o, c]
            weights[o, c] = w[c]
            missing -= w[c] * (vec(x, v) - vec(x_start, v)).dot(vec(side, o))
            k += 0.25 * sheet[v]
        active[o] = 0
        if missing > 0:
            active[o] = 1
            r = ti.sqrt(k) * vec(side, o)
            put(force, o, k * missing * vec(side, o))
            block[o, 0] = 0.0
            block[o, 1] = r[0]
            block[o, 2] = r[1]
            block[o, 3] = r[2]
    ti.loop_config(serialize=light.serial)
    for o in range(total):
        q = pair_state(x, vertices, o, faces_first, side)
        n = ti.Vector([q[4], q[5], q[6]])
        missing = gap[o] - q[7]
        active[o] = 0
        # Deeper than this the pair isn't a contact: the surfaces have passed each other elsewhere.
        if missing > 0 and missing < 0.02:
            active[o] = 1
            patch, mu = 0.0, 0.0
            slip = ti.Vector([0.0, 0.0, 0.0])
            for c in ti.static(range(4)):
                v = vertices[o, c]
                patch += 0.25 * area[v]
                mu += 0.25 * friction[v]
                weights[o, c] = q[c]
                slip += q[c] * (vec(x, v) - vec(x_start, v))
            parting = n.dot(slip)
            slip -= n * parting
            k = stiffness * patch
            # What has crossed is put back by moving it, see `part_pairs`: a force as large as its depth would fling it.
            load = k * ti.min(missing, gap[o]) - viscous * k * parting
            if load <= 0:
                load = 0.0
                k *= 0.01
            else:
                k *= 1.0 + viscous
            hold = ti.min(0.5 * stiffness * patch, mu * load / ti.max(slip.norm(), 1e-9))
            f = load * n - hold * slip
            put(force, o, f)
            r = ti.sqrt(ti.max(k - hold, 0.0)) * n
            block[o, 0] = hold
            block[o, 1] = r[0]
            block[o, 2] = r[1]
            block[o, 3] = r[2]


@kernel
def compact_pairs(
    total: Int,
    active: Array,
    vertices: Array,
    weights: Array,
    block: Array,
    force: Array,
    # outputs
    kept: Array,
    kept_vertices: Array,
    kept_weights: Array,
    kept_block: Array,
    kept_force: Array,
    start: Array,
    index: Array,
) -> None:
    """The active pairs in order, and for each vertex its places in them: index = 4 pair + corner. kept[0]: how many."""
    for i in range(start.shape[0]):
        start[i] = 0
    ti.loop_config(serialize=True)
    for _ in range(1):
        m = 0
        for o in range(total):
            if active[o] == 1:
                for c in ti.static(range(4)):
                    kept_vertices[m, c] = vertices[o, c]
                    kept_weights[m, c] = weights[o, c]
                    kept_block[m, c] = block[o, c]
                    start[vertices[o, c] + 2] += 1
                for c in ti.static(range(3)):
                    kept_force[m, c] = force[o, c]
                m += 1
        kept[0] = m
        for i in range(start.shape[0] - 2):
            start[i + 2] += start[i + 1]
        for o in range(m):
            for c in ti.static(range(4)):
                v = kept_vertices[o, c] + 1
                index[start[v]] = 4 * o + c
                start[v] += 1


@kernel
def gather_pairs(
    start: Array,
    index: Array,
    weights: Array,
    block: Array,
    pair_force: Array,
    # outputs
    force: Array,
    diagonal: Array,
) -> None:
    """Add the pairs' forces to `force`, and set the diagonal blocks of their stiffness, vertex by vertex."""
    ti.loop_config(serialize=light.serial)
    for i in range(diagonal.shape[0]):
        f = vec(force, i)
        iso = 0.0
        for c in ti.static(range(6)):
            diagonal[i, c] = 0.0
        for e in range(start[i], start[i + 1]):
            o, c = index[e] // 4, index[e] % 4
            w = ti.f64(weights[o, c])
            f += w * vec(pair_force, o)
            u, v, z = ti.f64(block[o, 1]), ti.f64(block[o, 2]), ti.f64(block[o, 3])
            w2 = w * w
            iso += w2 * ti.f64(block[o, 0])
            diagonal[i, 0] += w2 * u * u
            diagonal[i, 1] += w2 * u * v
            diagonal[i, 2] += w2 * u * z
            diagonal[i, 3] += w2 * v * v
            diagonal[i, 4] += w2 * v * z
            diagonal[i, 5] += w2 * z * z
        diagonal[i, 0] += iso
        diagonal[i, 3] += iso
        diagonal[i, 5] += iso
        put(force, i, f)


@kernel
def part_pairs(
    x: Array,
    vertices: Array,
    side: Array,
    gap: Array,
    faces_first: Int,
    total: Int,
    mass: Array,
    fixed: Array,
    # outputs
    active: Array,
    weights: Array,
    force: Array,
) -> None:
    """Displacement that would bring every pair that has come too near back to a quarter of its gap.

    `weights` holds each vertex's share of it, light vertices moving more: w_i / m_i over sum w_j^2 / m_j.
    """
    ti.loop_config(serialize=light.serial)
    for o in range(total):
        q = pair_state(x, vertices, o, faces_first, side)
        missing = 0.25 * gap[o] - q[7]
        active[o] = 0
        if missing > 0 and missing < 0.02:
            total_share = 0.0
            for c in ti.static(range(4)):
                v = vertices[o, c]
                if fixed[v] == 0:
                    total_share += q[c] * q[c] / mass[v]
            if total_share > 0:
                active[o] = 1
                put(force, o, missing * ti.Vector([q[4], q[5], q[6]]))
                for c in ti.static(range(4)):
                    v = vertices[o, c]
                    weights[o, c] = 0.0
                    if fixed[v] == 0:
                        weights[o, c] = q[c] / (mass[v] * total_share)


@kernel
def move_parted(
    start: Array,
    index: Array,
    weights: Array,
    shift: Array,
    # outputs
    x: Array,
) -> None:
    """Move each vertex by the mean of what its pairs ask of it."""
    ti.loop_config(serialize=light.serial)
    for i in range(x.shape[0]):
        n = start[i + 1] - start[i]
        if n > 0:
            d = ti.Vector([0.0, 0.0, 0.0])
            for e in range(start[i], start[i + 1]):
                o, c = index[e] // 4, index[e] % 4
                d += ti.f64(weights[o, c]) * vec(shift, o)
            put(x, i, vec(x, i) + d / n)

"""Kernels that find which parts of the cloth are near each other: vertices and faces, edges and edges."""

import taichi as ti

from stages.simulate.closest import closest_on_edges, closest_on_triangle
from stages.simulate.kernels import Array, Real, kernel, light, put, vec
from stages.simulate.patch_kernels import out_of_box


@kernel
def edge_spheres(
    x: Array,
    edges: Array,
    # outputs
    centre: Array,
    radius: Array,
) -> None:
    """Midpoint and half length of every edge."""
    ti.loop_config(serialize=light.serial)
    for e in range(edges.shape[0]):
        a, b = vec(x, edges[e, 0]), vec(x, edges[e, 1])
        put(centre, e, 0.5 * (a + b))
        radius[e] = 0.5 * (a - b).norm()


@kernel
def find_vertex_faces(
    x: Array,
    v: Array,
    drift: Array,
    faces: Array,
    layer: Array,
    centre: Array,
    radius: Array,
    normal: Array,
    rest: Array,
    vertex_normal: Array,
    near: Real,
    horizon: Real,
    furthest: Real,
    far: Real,
    beside: Real,
    patch: Array,
    patch_start: Array,
    box: Array,
    met_count: Array,
    met: Array,
    # outputs
    count: Array,
    found: Array,
    slip: Array,
) -> None:
    """Faces that are as close to each vertex as `near` or may be so within the time `horizon` [s], but not its own.

    Only those within `furthest` are looked at, in another garment all those within `far`; and only in patches that
    its own patch can touch. `slip` is the greatest closing speed [m/s] of a face looked at.
    """
    for i in range(x.shape[0]):
        p = vec(x, i)
        q = p + horizon * (vec(v, i) - ti.Vector([drift[0], drift[1], drift[2]]))
        n = 0
        fastest = 0.0
        reach = ti.max(near, far)
        ni, ri = vec(vertex_normal, i), vec(rest, i)
        for e in range(met_count[patch[i]]):
            m = met[patch[i], e]
            if not out_of_box(p, q, box, m, reach):
                for f in range(patch_start[m], patch_start[m + 1]):
                    away = p - vec(centre, f)
                    bound = ti.max(1.25 * furthest, far) + radius[f]
                    if away.norm_sqr() < bound * bound:
                        i0, i1, i2 = faces[f, 0], faces[f, 1], faces[f, 2]
                        # Cloth next to itself that isn't folded can't touch.
                        known = vec(normal, f).dot(ni) > 0.3 and (vec(rest, i0) - ri).norm() < beside
                        if layer[i0] != layer[i]:
                            known = False
                        if i != i0 and i != i1 and i != i2 and not known:
                            d = vec(v, i) - (vec(v, i0) + vec(v, i1) + vec(v, i2)) / 3.0
                            # Sliding along each other brings cloth together round corners only.
                            speed = ti.max(ti.abs(d.dot(vec(normal, f))), d.norm() / 3.0)
                            limit = ti.min(near + horizon * speed, furthest)
                            if layer[i0] != layer[i]:
                                limit = ti.max(limit, far)
                            fastest = ti.max(fastest, speed)
                            # A face is no nearer than its plane.
                            if ti.abs(away.dot(vec(normal, f))) < limit:
                                u = closest_on_triangle(p, vec(x, i0), vec(x, i1), vec(x, i2))
                                d = p - u[0] * vec(x, i0) - u[1] * vec(x, i1) - u[2] * vec(x, i2)
                                if d.norm_sqr() < limit * limit:
                                    if n < found.shape[1]:
                                        found[i, n] = f
                                    n += 1
        count[i] = n
        slip[i] = fastest


@kernel
def mark_close(
    faces: Array,
    count: Array,
    found: Array,
    # outputs
    close: Array,
) -> None:
    """close[i] = 1 for vertices near a face not their own, and for those of such faces."""
    ti.loop_config(serialize=light.serial)
    for i in range(close.shape[0]):
        close[i] = 0
    ti.loop_config(serialize=light.serial)
    for i in range(count.shape[0]):
        for k in range(ti.min(count[i], found.shape[1])):
            close[i] = 1
            for c in ti.static(range(3)):
                close[faces[found[i, k], c]] = 1


@kernel
def find_edge_edges(
    x: Array,
    v: Array,
    drift: Array,
    edges: Array,
    close: Array,
    layer: Array,
    vertex_normal: Array,
    centre: Array,
    radius: Array,
    near: Real,
    horizon: Real,
    furthest: Real,
    patch: Array,
    edge_start: Array,
    box: Array,
    met_count: Array,
    met: Array,
    # outputs
    count: Array,
    found: Array,
) -> None:
    """Edges of higher index as close to each edge as in `find_vertex_faces` that share no vertex with it.

    Only of edges with an end that is `close` to a face: elsewhere the cloth is by itself. The edges of patch m are
    edge_start[m]:edge_start[m + 1], `patch` [E] tells whose each is.
    """
    for e in range(edges.shape[0]):
        n = 0
        i0, i1 = edges[e, 0], edges[e, 1]
        if close[i0] + close[i1] > 0:
            xa, xb = vec(x, i0), vec(x, i1)
            p = vec(centre, e)
            q = p + horizon * (0.5 * (vec(v, i0) + vec(v, i1)) - ti.Vector([drift[0], drift[1], drift[2]]))
            for k in range(met_count[patch[e]]):
                m = met[patch[e], k]
                if edge_start[m + 1] > e + 1 and not out_of_box(p, q, box, m, near + radius[e]):
                    for g in range(ti.max(e + 1, edge_start[m]), edge_start[m + 1]):
                        bound = furthest + radius[g] + radius[e]
                        if (vec(centre, g) - p).norm_sqr() < bound * bound:
                            j0, j1 = edges[g, 0], edges[g, 1]
                            apart = i0 != j0 and i0 != j1 and i1 != j0 and i1 != j1
                            # Vertices and faces keep garments apart that lie flat on each other.
                            flat = layer[i0] != layer[j0] and vec(vertex_normal, i0).dot(vec(vertex_normal, j0)) > 0.7
                            if apart and not flat:
                                st = closest_on_edges(xa, xb, vec(x, j0), vec(x, j1))
                                d = (1 - st[0]) * xa + st[0] * xb - (1 - st[1]) * vec(x, j0) - st[1] * vec(x, j1)
                                slip = 0.5 * (vec(v, i0) + vec(v, i1) - vec(v, j0) - vec(v, j1))
                                speed = ti.max(ti.abs(slip.dot(d)) / ti.max(d.norm(), 1e-9), slip.norm() / 3.0)
                                limit = ti.min(near + horizon * speed, furthest)
                                if d.norm_sqr() < limit * limit:
                                    if n < found.shape[1]:
                                        found[e, n] = g
                                    n += 1
        count[e] = n

"""Kernels that find which parts of the cloth are near each other: vertices and faces, edges and edges."""

import taichi as ti

from stages.simulate.closest import closest_on_edges, closest_on_triangle
from stages.simulate.grid import cell_of
from stages.simulate.kernels import Array, Real, kernel, put, vec


@kernel
def face_spheres(
    x: Array,
    faces: Array,
    # outputs
    centre: Array,
    radius: Array,
    normal: Array,
) -> None:
    """Centroid, bounding radius about it and unit normal of every face."""
    for f in range(faces.shape[0]):
        a, b, c = vec(x, faces[f, 0]), vec(x, faces[f, 1]), vec(x, faces[f, 2])
        m = (a + b + c) / 3.0
        put(centre, f, m)
        radius[f] = ti.sqrt(ti.max((a - m).norm_sqr(), (b - m).norm_sqr(), (c - m).norm_sqr()))
        n = (b - a).cross(c - a)
        put(normal, f, n / ti.max(n.norm(), 1e-20))


@kernel
def edge_spheres(
    x: Array,
    edges: Array,
    # outputs
    centre: Array,
    radius: Array,
) -> None:
    """Midpoint and half length of every edge."""
    for e in range(edges.shape[0]):
        a, b = vec(x, edges[e, 0]), vec(x, edges[e, 1])
        put(centre, e, 0.5 * (a + b))
        radius[e] = 0.5 * (a - b).norm()


@kernel
def find_vertex_faces(
    x: Array,
    faces: Array,
    layer: Array,
    normal: Array,
    rest: Array,
    vertex_normal: Array,
    near: Real,
    far: Real,
    widest: Real,
    lo: Array,
    size: Real,
    dims: Array,
    first: Array,
    items: Array,
    balls: Array,
    # outputs
    count: Array,
    found: Array,
) -> None:
    """Faces closer to each vertex than `near` in its own garment, or `far` in another, but not its own faces."""
    for i in range(x.shape[0]):
        p = vec(x, i)
        n = 0
        reach = ti.max(near, far)
        ni, ri = vec(vertex_normal, i), vec(rest, i)
        r = ti.Vector([1.0, 1.0, 1.0]) * (reach + widest)
        a, b = cell_of(p - r, lo, size, dims), cell_of(p + r, lo, size, dims)
        for cz in range(a[2], b[2] + 1):
            for cy in range(a[1], b[1] + 1):
                row = (cz * dims[1] + cy) * dims[0]
                for k in range(first[row + a[0]], first[row + b[0] + 1]):
                    away = p - vec(balls, k)
                    bound = reach + balls[k, 3]
                    if away.norm_sqr() < bound * bound:
                        f = items[k]
                        i0, i1, i2 = faces[f, 0], faces[f, 1], faces[f, 2]
                        limit = near
                        # Cloth next to itself that isn't folded can't touch.
                        known = vec(normal, f).dot(ni) > 0.3 and (vec(rest, i0) - ri).norm() < 2.0 * widest
                        if layer[i0] != layer[i]:
                            limit = far
                            known = False
                        # A face is no nearer than its plane.
                        apart = i != i0 and i != i1 and i != i2
                        if apart and not known and ti.abs(away.dot(vec(normal, f))) < limit:
                            u = closest_on_triangle(p, vec(x, i0), vec(x, i1), vec(x, i2))
                            d = p - u[0] * vec(x, i0) - u[1] * vec(x, i1) - u[2] * vec(x, i2)
                            if d.norm_sqr() < limit * limit:
                                if n < found.shape[1]:
                                    found[i, n] = f
                                n += 1
        count[i] = n


@kernel
def mark_close(
    faces: Array,
    count: Array,
    found: Array,
    # outputs
    close: Array,
) -> None:
    """close[i] = 1 for vertices near a face not their own, and for those of such faces."""
    for i in range(close.shape[0]):
        close[i] = 0
    for i in range(count.shape[0]):
        for k in range(ti.min(count[i], found.shape[1])):
            close[i] = 1
            for c in ti.static(range(3)):
                close[faces[found[i, k], c]] = 1


@kernel
def find_edge_edges(
    x: Array,
    edges: Array,
    close: Array,
    layer: Array,
    vertex_normal: Array,
    centre: Array,
    radius: Array,
    near: Real,
    widest: Real,
    lo: Array,
    size: Real,
    dims: Array,
    first: Array,
    items: Array,
    balls: Array,
    # outputs
    count: Array,
    found: Array,
) -> None:
    """Edges of higher index closer to each edge than `near` that share no vertex with it.

    Only of edges with an end that is `close` to a face: elsewhere the cloth is by itself.
    """
    for e in range(edges.shape[0]):
        n = 0
        if close[edges[e, 0]] + close[edges[e, 1]] > 0:
            p = vec(centre, e)
            r = ti.Vector([1.0, 1.0, 1.0]) * (near + widest + radius[e])
            i0, i1 = edges[e, 0], edges[e, 1]
            xa, xb = vec(x, i0), vec(x, i1)
            a, b = cell_of(p - r, lo, size, dims), cell_of(p + r, lo, size, dims)
            for cz in range(a[2], b[2] + 1):
                for cy in range(a[1], b[1] + 1):
                    row = (cz * dims[1] + cy) * dims[0]
                    for k in range(first[row + a[0]], first[row + b[0] + 1]):
                        bound = near + balls[k, 3] + radius[e]
                        if (vec(balls, k) - p).norm_sqr() < bound * bound:
                            g = items[k]
                            j0, j1 = edges[g, 0], edges[g, 1]
                            apart = i0 != j0 and i0 != j1 and i1 != j0 and i1 != j1
                            # Vertices and faces keep garments apart that lie flat on each other.
                            flat = layer[i0] != layer[j0] and vec(vertex_normal, i0).dot(vec(vertex_normal, j0)) > 0.7
                            if g > e and apart and not flat:
                                st = closest_on_edges(xa, xb, vec(x, j0), vec(x, j1))
                                d = (1 - st[0]) * xa + st[0] * xb - (1 - st[1]) * vec(x, j0) - st[1] * vec(x, j1)
                                if d.norm_sqr() < near * near:
                                    if n < found.shape[1]:
                                        found[e, n] = g
                                    n += 1
        count[e] = n

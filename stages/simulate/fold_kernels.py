"""Kernels for cloth hidden where the body overlaps itself, in an armpit or a bent elbow."""

import taichi as ti

from stages.simulate.closest import closest_on_triangle
from stages.simulate.contact_search import surface_point
from stages.simulate.kernels import Array, Real, kernel, put, vec


@kernel
def count_windings(
    points: Array,
    body: Array,
    faces: Array,
    patch_start: Array,
    box: Array,
    # outputs
    winding: Array,
) -> None:
    """How many times the closed surface encloses each point: signed crossings of the ray upwards from it.

    Crossings of the triangle's outline in the plane are counted half-open, so that no edge or corner counts twice.
    """
    for k in range(points.shape[0]):
        px, py, pz = points[k, 0], points[k, 1], points[k, 2]
        total = 0
        for m in range(box.shape[0]):
            last = patch_start[m]
            if box[m, 5] >= pz and box[m, 0] <= px and box[m, 3] >= px and box[m, 1] <= py and box[m, 4] >= py:
                last = patch_start[m + 1]
            for f in range(patch_start[m], last):
                a, b, c = vec(body, faces[f, 0]), vec(body, faces[f, 1]), vec(body, faces[f, 2])
                if ti.max(a[2], b[2], c[2]) >= pz and ti.min(a[0], b[0], c[0]) <= px and ti.max(a[0], b[0], c[0]) >= px:
                    turns = 0
                    for e in ti.static(range(3)):
                        u, w = ti.static(((a, b), (b, c), (c, a))[e])
                        if (u[1] > py) != (w[1] > py):
                            across = (w[0] - u[0]) * (py - u[1]) - (px - u[0]) * (w[1] - u[1])
                            if w[1] > u[1] and across > 0:
                                turns += 1
                            if w[1] < u[1] and across < 0:
                                turns -= 1
                    if turns != 0:
                        n = (b - a).cross(c - a)
                        height = n.dot(a - ti.Vector([px, py, pz]))
                        # The ray meets the plane above the point: (a - p).n / n_z > 0, and comes out of the body there.
                        if height * n[2] > 0:
                            total += turns
        winding[k] = total


@kernel
def lay_on_skin(
    hidden: Array,
    body: Array,
    faces: Array,
    centre: Array,
    radius: Array,
    depth: Real,
    # outputs
    x: Array,
) -> None:
    """Move the vertices `hidden` of x towards the closest point of the whole surface, to `depth` from it."""
    for k in range(hidden.shape[0]):
        p = vec(x, hidden[k])
        best, near = ti.f64(1e30), ti.f64(1e15)
        c = p
        for f in range(faces.shape[0]):
            if (p - vec(centre, f)).norm() - radius[f] < near:
                u = closest_on_triangle(p, vec(body, faces[f, 0]), vec(body, faces[f, 1]), vec(body, faces[f, 2]))
                q = surface_point(body, faces, f, u)
                if (p - q).norm_sqr() < best:
                    best = (p - q).norm_sqr()
                    near = ti.sqrt(best)
                    c = q
        put(x, hidden[k], c + (p - c) * ti.min(1.0, depth / ti.max(near, 1e-12)))

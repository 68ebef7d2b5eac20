"""Kernels that find where the moving body is near each cloth vertex: candidates, and the closest of them."""

import taichi as ti

from stages.simulate.closest import closest_on_triangle, pseudo_normal
from stages.simulate.kernels import Array, Int, Real, Value, inline, kernel, put, vec
from stages.simulate.patch_kernels import out_of_box


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

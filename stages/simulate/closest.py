"""Closest points of triangles and of segments, and of a body's surface among candidates with the right sign."""

import taichi as ti

from stages.simulate.kernels import Value, inline, vec


@inline
def closest_on_triangle(p: Value, a: Value, b: Value, c: Value) -> Value:
    """Barycentric coordinates (3) of the point of triangle abc closest to p, and its feature.

    Feature: 0, 1, 2 = that corner; 3, 4, 5 = the edge opposite to corner 0, 1, 2; 6 = the inside.
    (Ericson 2005, "Real-time collision detection", 5.1.5.)
    """
    ab, ac, ap = b - a, c - a, p - a
    d1, d2 = ab.dot(ap), ac.dot(ap)
    bp = p - b
    d3, d4 = ab.dot(bp), ac.dot(bp)
    cp = p - c
    d5, d6 = ab.dot(cp), ac.dot(cp)
    vc = d1 * d4 - d3 * d2
    vb = d5 * d2 - d1 * d6
    va = d3 * d6 - d5 * d4
    u = ti.Vector([1.0, 0.0, 0.0, 0.0])
    if d1 <= 0 and d2 <= 0:
        u = ti.Vector([1.0, 0.0, 0.0, 0.0])
    elif d3 >= 0 and d4 <= d3:
        u = ti.Vector([0.0, 1.0, 0.0, 1.0])
    elif d6 >= 0 and d5 <= d6:
        u = ti.Vector([0.0, 0.0, 1.0, 2.0])
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        t = d1 / ti.max(d1 - d3, 1e-30)
        u = ti.Vector([1.0 - t, t, 0.0, 5.0])
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        t = d2 / ti.max(d2 - d6, 1e-30)
        u = ti.Vector([1.0 - t, 0.0, t, 4.0])
    elif va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        t = (d4 - d3) / ti.max((d4 - d3) + (d5 - d6), 1e-30)
        u = ti.Vector([0.0, 1.0 - t, t, 3.0])
    else:
        s = 1.0 / ti.max(va + vb + vc, 1e-30)
        v, w = vb * s, vc * s
        u = ti.Vector([1.0 - v - w, v, w, 6.0])
    return u


@inline
def pseudo_normal(
    f: Value, feature: Value, x: Value, faces: Value, across: Value, start: Value, incident: Value, face_normal: Value
) -> Value:
    """Pseudo-normal of a feature of face f, not of unit length: its sign tells inside from outside.

    Of a corner, the angle-weighted sum of the faces about it (Baerentzen and Aanaes 2005); of an edge, the sum of two.
    """
    n = vec(face_normal, f)
    if feature < 2.5:
        i = faces[f, ti.i32(feature)]
        n *= 0.0
        for e in range(start[i], start[i + 1]):
            g, k = incident[e] // 3, incident[e] % 3
            u = vec(x, faces[g, (k + 1) % 3]) - vec(x, i)
            v = vec(x, faces[g, (k + 2) % 3]) - vec(x, i)
            n += ti.atan2(u.cross(v).norm(), u.dot(v)) * vec(face_normal, g)
    elif feature < 5.5:
        n += vec(face_normal, across[f, ti.i32(feature) - 3])
    return n


@inline
def closest_on_edges(a: Value, b: Value, c: Value, d: Value) -> Value:
    """Parameters (s, t) of the closest points of segments ab and cd, clamped to [0, 1] (Ericson 2005, 5.1.9)."""
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = u.dot(u), v.dot(v), u.dot(v)
    uw, vw = u.dot(w), v.dot(w)
    den = uu * vv - uv * uv
    s = 0.5
    if den > 1e-9 * uu * vv:
        s = ti.max(0.0, ti.min(1.0, (uv * vw - uw * vv) / den))
    t = (uv * s + vw) / ti.max(vv, 1e-30)
    if t < 0.0:
        t = 0.0
        s = ti.max(0.0, ti.min(1.0, -uw / ti.max(uu, 1e-30)))
    elif t > 1.0:
        t = 1.0
        s = ti.max(0.0, ti.min(1.0, (uv - uw) / ti.max(uu, 1e-30)))
    return ti.Vector([s, t])

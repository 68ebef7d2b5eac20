"""Kernels that find cloth that has passed through cloth."""

import taichi as ti

from stages.simulate.kernels import Array, Int, kernel, vec


@kernel
def find_crossings(
    x: Array,
    edges: Array,
    faces: Array,
    centre: Array,
    radius: Array,
    near: Array,
    layer: Array,
    others: Int,
    of_edge: Array,
    patch_start: Array,
    met_count: Array,
    met: Array,
    # outputs
    count: Array,
    found: Array,
) -> None:
    """Faces that every edge with an end that is `near` other cloth passes through, of the patches its own can touch.

    Those of its own garment, with `others` of all. Each face is in a ball of `radius` about its `centre`. count goes on
    beyond the width of `found`.
    """
    for e in range(edges.shape[0]):
        i, j = edges[e, 0], edges[e, 1]
        p, d = vec(x, i), vec(x, j) - vec(x, i)
        middle, half = p + 0.5 * d, 0.5 * d.norm()
        n = 0
        looked = 0
        if near[i] + near[j] > 0:
            looked = met_count[of_edge[e]]
        for k in range(looked):
            m = met[of_edge[e], k]
            for f in range(patch_start[m], patch_start[m + 1]):
                bound = radius[f] + half
                if (vec(centre, f) - middle).norm_sqr() < bound * bound:
                    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
                    own = False
                    for corner in ti.static(range(3)):
                        own = own or faces[f, corner] == i or faces[f, corner] == j
                    if not own and (others == 1 or layer[a] == layer[i]):
                        u, v, s = vec(x, b) - vec(x, a), vec(x, c) - vec(x, a), p - vec(x, a)
                        normal = u.cross(v)
                        steep = normal.dot(d)
                        if ti.abs(steep) > 1e-16:
                            t = -normal.dot(s) / steep
                            q = s + t * d
                            wide = normal.norm_sqr()
                            g, h = q.cross(v).dot(normal) / wide, u.cross(q).dot(normal) / wide
                            if t > 0 and t < 1 and g > 0 and h > 0 and g + h < 1:
                                if n < found.shape[1]:
                                    found[e, n] = f
                                n += 1
        count[e] = n

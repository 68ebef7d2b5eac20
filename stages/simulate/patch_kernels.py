"""Kernels that find which patches of the cloth can touch each other, or patches of the body, within some time."""

import taichi as ti

from stages.simulate.kernels import Array, Real, Value, inline, kernel, light, vec

GROUP = 16
"""Patches, one behind the other and so near each other, that have a common box."""


@kernel
def bound_patches(
    x: Array,
    ahead: Array,
    faces: Array,
    start: Array,
    # outputs
    box: Array,
    group_box: Array,
) -> None:
    """Boxes (lo, hi) of what the faces of each patch sweep between `x` and `ahead`, and of every GROUP patches."""
    ti.loop_config(serialize=light.serial)
    for k in range(box.shape[0]):
        lo, hi = ti.Vector([1e30, 1e30, 1e30]), ti.Vector([-1e30, -1e30, -1e30])
        for f in range(start[k], start[k + 1]):
            for c in ti.static(range(3)):
                p, q = vec(x, faces[f, c]), vec(ahead, faces[f, c])
                lo, hi = ti.min(lo, p, q), ti.max(hi, p, q)
        for c in ti.static(range(3)):
            box[k, c] = lo[c]
            box[k, 3 + c] = hi[c]
    ti.loop_config(serialize=light.serial)
    for g in range(group_box.shape[0]):
        for c in ti.static(range(3)):
            lo, hi = ti.f64(1e30), ti.f64(-1e30)
            for m in range(GROUP * g, ti.min(GROUP * (g + 1), box.shape[0])):
                lo, hi = ti.min(lo, box[m, c]), ti.max(hi, box[m, 3 + c])
            group_box[g, c] = lo
            group_box[g, 3 + c] = hi


@kernel
def bound_normals(
    normal: Array,
    start: Array,
    # outputs
    cone: Array,
) -> None:
    """Cone (axis, angle [rad]) of the normals of each patch of faces."""
    ti.loop_config(serialize=light.serial)
    for k in range(cone.shape[0]):
        axis = ti.Vector([0.0, 0.0, 0.0])
        for f in range(start[k], start[k + 1]):
            axis += vec(normal, f)
        axis /= ti.max(axis.norm(), 1e-20)
        least = 1.0
        for f in range(start[k], start[k + 1]):
            least = ti.min(least, axis.dot(vec(normal, f)))
        for c in ti.static(range(3)):
            cone[k, c] = axis[c]
        cone[k, 3] = ti.acos(ti.max(-1.0, least))


@inline
def boxes_apart(a: Value, k: Value, b: Value, m: Value, reach: Value) -> Value:
    """Whether box k of `a` and box m of `b` are further than `reach` from each other along an axis."""
    apart = a[k, 2] > b[m, 5] + reach or b[m, 2] > a[k, 5] + reach
    if not apart:
        apart = a[k, 0] > b[m, 3] + reach or b[m, 0] > a[k, 3] + reach
        if not apart:
            apart = a[k, 1] > b[m, 4] + reach or b[m, 1] > a[k, 4] + reach
    return apart


@kernel
def meet_patches(
    box: Array,
    cone: Array,
    layer: Array,
    near_start: Array,
    near: Array,
    reach: Real,
    far: Real,
    widest_cone: Real,
    group_box: Array,
    # outputs
    count: Array,
    met: Array,
) -> None:
    """For every patch those that it can touch: met[k, :count[k]], ascending, itself included where it is folded.

    Boxes within `reach` of each other, or `far` between garments. A patch and those next to it on the same cloth
    (near[near_start[k]:...], ascending, itself included) can't touch while all their normals lie within a narrow cone:
    cloth has to fold for that (Volino and Magnenat-Thalmann 1994; the contour is not tested).
    """
    for k in range(count.shape[0]):
        n = 0
        e = near_start[k]
        for g in range(group_box.shape[0]):
            if not boxes_apart(box, k, group_box, g, ti.max(reach, far)):
                for m in range(GROUP * g, ti.min(GROUP * (g + 1), count.shape[0])):
                    limit = reach
                    if layer[k] != layer[m]:
                        limit = ti.max(reach, far)
                    if not boxes_apart(box, k, box, m, limit):
                        while e < near_start[k + 1] and near[e] < m:
                            e += 1
                        flat = False
                        if e < near_start[k + 1] and near[e] == m:
                            u, w = vec(cone, k), vec(cone, m)
                            turn = ti.acos(ti.max(-1.0, ti.min(1.0, u.dot(w))))
                            flat = cone[k, 3] + cone[m, 3] + turn < widest_cone
                        if not flat:
                            if n < met.shape[1]:
                                met[k, n] = m
                            n += 1
        count[k] = n


@kernel
def meet_others(
    box: Array,
    other: Array,
    group_box: Array,
    reach: Real,
    # outputs
    count: Array,
    met: Array,
) -> None:
    """For every box those of `other` within `reach` of it: met[k, :count[k]], ascending."""
    for k in range(count.shape[0]):
        n = 0
        for g in range(group_box.shape[0]):
            if not boxes_apart(box, k, group_box, g, reach):
                for m in range(GROUP * g, ti.min(GROUP * (g + 1), other.shape[0])):
                    if not boxes_apart(box, k, other, m, reach):
                        if n < met.shape[1]:
                            met[k, n] = m
                        n += 1
        count[k] = n


@kernel
def keep_meeting(
    x: Array,
    faces: Array,
    start: Array,
    other: Array,
    reach: Real,
    count: Array,
    met: Array,
    # outputs
    kept_count: Array,
    kept: Array,
) -> None:
    """Those of `met` whose box in `other` is within `reach` of the faces of each patch at `x`, in the same order."""
    for k in range(count.shape[0]):
        lo, hi = ti.Vector([1e30, 1e30, 1e30]), ti.Vector([-1e30, -1e30, -1e30])
        if count[k] > 0:
            for f in range(start[k], start[k + 1]):
                for c in ti.static(range(3)):
                    p = vec(x, faces[f, c])
                    lo, hi = ti.min(lo, p), ti.max(hi, p)
        n = 0
        for e in range(count[k]):
            m = met[k, e]
            apart = lo[2] > other[m, 5] + reach or other[m, 2] > hi[2] + reach
            apart = apart or lo[0] > other[m, 3] + reach or other[m, 0] > hi[0] + reach
            apart = apart or lo[1] > other[m, 4] + reach or other[m, 1] > hi[1] + reach
            if not apart:
                kept[k, n] = m
                n += 1
        kept_count[k] = n


@inline
def out_of_box(p: Value, q: Value, box: Value, m: Value, reach: Value) -> Value:
    """Whether the segment from p to q stays further than `reach` from box m along an axis."""
    apart = False
    for c in ti.static(range(3)):
        apart = apart or ti.min(p[c], q[c]) > box[m, 3 + c] + reach or ti.max(p[c], q[c]) < box[m, c] - reach
    return apart

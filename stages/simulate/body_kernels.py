"""Kernels of the moving body: interpolation in time, normals, bounds."""

import taichi as ti

from stages.simulate.kernels import Array, Real, kernel, light, put, vec


@kernel
def between_frames(
    before: Array,
    left: Array,
    right: Array,
    after: Array,
    s: Real,
    # outputs
    out: Array,
) -> None:
    """Cubic Hermite at s in [0, 1] from `left` to `right`, slopes by central differences (Catmull and Rom 1974)."""
    ti.loop_config(serialize=light.serial)
    for i in range(left.shape[0]):
        s2, s3 = s * s, s * s * s
        for c in ti.static(range(3)):
            m0, m1 = 0.5 * (right[i, c] - before[i, c]), 0.5 * (after[i, c] - left[i, c])
            out[i, c] = (
                (2 * s3 - 3 * s2 + 1) * left[i, c]
                + (s3 - 2 * s2 + s) * m0
                + (3 * s2 - 2 * s3) * right[i, c]
                + (s3 - s2) * m1
            )


@kernel
def face_frames(
    x: Array,
    faces: Array,
    # outputs
    normal: Array,
    centre: Array,
    radius: Array,
) -> None:
    """Unit normal (0 if without area), centroid and bounding radius about it of every triangle."""
    ti.loop_config(serialize=light.serial)
    for f in range(faces.shape[0]):
        a, b, c = vec(x, faces[f, 0]), vec(x, faces[f, 1]), vec(x, faces[f, 2])
        n = (b - a).cross(c - a)
        put(normal, f, n / ti.max(n.norm(), 1e-20))
        m = (a + b + c) / 3.0
        put(centre, f, m)
        radius[f] = ti.sqrt(ti.max((a - m).norm_sqr(), (b - m).norm_sqr(), (c - m).norm_sqr()))

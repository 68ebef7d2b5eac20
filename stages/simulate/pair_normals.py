"""Vertex normals of the cloth, which tell whether two garments face the same way."""

import taichi as ti

from stages.simulate.kernels import Array, kernel, light, put, vec


@kernel
def cloth_normals(
    start: Array,
    corner: Array,
    face_normal: Array,
    # outputs
    normal: Array,
) -> None:
    """Mean of the normals of the faces about each vertex, of unit length."""
    ti.loop_config(serialize=light.serial)
    for i in range(normal.shape[0]):
        n = ti.Vector([0.0, 0.0, 0.0])
        for e in range(start[i], start[i + 1]):
            n += vec(face_normal, corner[e] // 3)
        put(normal, i, n / ti.max(n.norm(), 1e-20))

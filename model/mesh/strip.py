"""Triangulate the strip between two paths."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def strip_faces(vertices: ArrayLike, left: ArrayLike, right: ArrayLike) -> NDArray[np.int64]:
    """Joins two paths that run the same way with triangles, at each step by the shorter diagonal.

    The paths may share their first vertex. Seen from outside with the paths running down, `left` lies to the left.

    Args:
        vertices: Vertices [m], shape [V, 3].
        left: Vertices of one path, shape [P].
        right: Vertices of the other path, shape [Q].

    Returns:
        Triangles, counter-clockwise seen from outside: P + Q - 2, one fewer if the paths share their start.
    """
    points = np.asarray(vertices, dtype=np.float64)
    a, b = np.asarray(left).tolist(), np.asarray(right).tolist()
    i = j = 0
    out: list[tuple[int, int, int]] = []
    while i < len(a) - 1 or j < len(b) - 1:
        forward_left = float(np.linalg.norm(points[a[i + 1]] - points[b[j]])) if i < len(a) - 1 else np.inf
        forward_right = float(np.linalg.norm(points[b[j + 1]] - points[a[i]])) if j < len(b) - 1 else np.inf
        # Ties (mirrored paths) alternate, so that the diagonals do not fan out from one side.
        tie = abs(forward_left - forward_right) < 1e-9
        if (i <= j) if tie else forward_left < forward_right:
            out.append((a[i], a[i + 1], b[j]))
            i += 1
        else:
            out.append((a[i], b[j + 1], b[j]))
            j += 1
    return np.array([face for face in out if len(set(face)) == 3], dtype=np.int64).reshape(-1, 3)

"""Insert an iso-line into a triangle mesh."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def split_along(
    vertices: ArrayLike, faces: ArrayLike, field: ArrayLike, snap: float = 1e-3
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.bool_]]:
    """Splits the faces that the zero line of a field crosses, so that every face lies on one side of it.

    Args:
        vertices: Vertices, shape [V, 3].
        faces: Triangles, shape [F, 3].
        field: One value per vertex, linear over each face, shape [V].
        snap: Values whose size is below this share of the largest one count as 0, so that no sliver is cut.

    Returns:
        Vertices [V', 3], the old ones first; faces [F', 3], oriented as before; whether each new face lies on the
        side where the field is positive, shape [F'].
    """
    points = np.asarray(vertices, dtype=np.float64)
    triangles = np.asarray(faces, dtype=np.int64)
    s = np.array(field, dtype=np.float64)
    s[np.abs(s) < snap * np.abs(s).max()] = 0.0
    low, high = s[triangles].min(axis=1), s[triangles].max(axis=1)
    crossed = (low < 0) & (high > 0)

    added: list[NDArray[np.float64]] = []
    of_edge: dict[tuple[int, int], int] = {}

    def crossing(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in of_edge:
            i, j = key
            t = s[i] / (s[i] - s[j])
            of_edge[key] = len(points) + len(added)
            added.append((1 - t) * points[i] + t * points[j])
        return of_edge[key]

    parts: list[tuple[int, int, int]] = []
    positive: list[bool] = []
    for triangle in triangles[crossed].tolist():
        ring: list[int] = []
        side: list[float] = []
        for a, b in zip(triangle, triangle[1:] + triangle[:1], strict=True):
            ring.append(a)
            side.append(s[a])
            if s[a] * s[b] < 0:
                ring.append(crossing(a, b))
                side.append(0.0)
        for sign in (1.0, -1.0):
            corner = [v for v, value in zip(ring, side, strict=True) if value * sign >= 0]
            parts += [(corner[0], corner[k], corner[k + 1]) for k in range(1, len(corner) - 1)]
            positive += [sign > 0] * (len(corner) - 2)
    whole = triangles[~crossed]
    new_points = np.vstack([points, np.reshape(added, (-1, 3))])
    new_faces = np.vstack([whole, np.reshape(np.array(parts, dtype=np.int64), (-1, 3))])
    return new_points, new_faces, np.concatenate([high[~crossed] > 0, np.array(positive, dtype=bool)])

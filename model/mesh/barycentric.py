"""Points carried by the faces of a mesh."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def carry(vertices: ArrayLike, faces: ArrayLike, face: ArrayLike, barycentric: ArrayLike) -> NDArray[np.float64]:
    """Positions of points that are fixed to a mesh's faces.

    Args:
        vertices: Vertices [m], shape [..., M, 3]: one mesh, or one per frame.
        faces: Triangles, shape [F, 3].
        face: Face of each point, -1 for none, shape [N].
        barycentric: Weights of the face's corners, shape [N, 3].

    Returns:
        Points [m], shape [..., N, 3]; 0 where there is no face.
    """
    index = np.asarray(face)
    corners = np.asarray(faces)[np.maximum(index, 0)]
    weights = np.where((index >= 0)[:, None], np.asarray(barycentric, dtype=np.float64), 0.0)
    points = np.asarray(vertices)
    out = weights[:, :1] * points[..., corners[:, 0], :]
    out += weights[:, 1:2] * points[..., corners[:, 1], :]
    out += weights[:, 2:] * points[..., corners[:, 2], :]
    return np.asarray(out)

"""The garment as the target of registration: where the layer's vertices belong on it."""

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from model.mesh.geometry import face_normals
from model.mesh.topology import edges_with_counts
from stages.register.flange import add_flange

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Hits:
    """Points of a surface that were found for some queries.

    Attributes:
        points: The points [m], shape [Q, 3].
        faces: Faces of the flanged garment that they lie in, shape [Q].
        distance: Distance to the query [m], infinite where nothing was found, shape [Q].
        at_rim: Whether they lie at the flange's outer rim, beyond which nothing is known, shape [Q].
    """

    points: Array
    faces: NDArray[np.int64]
    distance: Array
    at_rim: NDArray[np.bool_]


class Target:
    """A garment with a flange along its borders, and the trees to search it.

    Attributes:
        vertices: Garment, then flange [m], shape [V, 3].
        faces: Garment, then flange, shape [F, 3].
        normals: Unit normals of the faces, shape [F, 3].
        garment_faces: Number of the garment's own faces G, which come first.
        border_edges: The garment's borders, shape [B, 2].
        border_faces: The garment's face at each border edge, shape [B].
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, flange: float = 0.03, normal_scale: float = 0.1) -> None:
        """Extends the garment and builds the trees.

        Args:
            vertices: Garment [m], shape [M, 3].
            faces: Triangles, counter-clockwise seen from outside, shape [G, 3].
            flange: Width of the flange [m].
            normal_scale: Distance that a difference of 1 between unit normals counts for in `alike` [m].
        """
        extended = add_flange(vertices, faces, flange, rings=3)
        self.vertices = np.ascontiguousarray(extended.vertices)
        self.faces = np.ascontiguousarray(extended.faces)
        self.garment_faces = extended.garment_faces
        self.normals = face_normals(self.vertices, self.faces)
        self.border_edges, self.border_faces = _borders(self.faces[: self.garment_faces])
        rim = np.zeros(len(self.vertices), dtype=bool)
        edges, counts = edges_with_counts(self.faces)
        rim[edges[counts == 1].reshape(-1)] = True
        self._rim_faces: NDArray[np.bool_] = np.asarray(rim[self.faces].any(axis=1))
        self._tree = igl.AABB()
        self._tree.init(self.vertices, self.faces)
        self._scale = normal_scale
        self._centres = self.vertices[self.faces].mean(axis=1)
        self._alike_tree = cKDTree(np.hstack([self._centres, normal_scale * self.normals]))

    def closest(self, queries: Array) -> Hits:
        """The closest point of the flanged garment to each query [m], shape [Q, 3]."""
        squared, index, points = self._tree.squared_distance(self.vertices, self.faces, np.ascontiguousarray(queries))
        return Hits(points=points, faces=index, distance=np.sqrt(squared), at_rim=self._rim_faces[index])

    def alike(self, queries: Array, normals: Array, reach: float) -> Hits:
        """The face that is closest in position and normal together: a loose tube is then matched all around.

        The closest point alone would crowd the matches of an arm that lies at the top of a wide sleeve at the top.

        Args:
            queries: Points [m], shape [Q, 3].
            normals: Their unit normals, shape [Q, 3].
            reach: Largest distance, normals included [m].

        Returns:
            The centres of those faces.
        """
        features = np.hstack([queries, self._scale * normals])
        _, index = self._alike_tree.query(features, distance_upper_bound=reach)
        found = index < len(self.faces)
        index = np.where(found, index, 0).astype(np.int64)
        points = self._centres[index]
        distance = np.where(found, np.linalg.norm(points - queries, axis=1), np.inf)
        return Hits(points=points, faces=index, distance=distance, at_rim=self._rim_faces[index])


def _borders(faces: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges with one face [B, 2], smaller vertex first, and that face [B]."""
    edges, counts = edges_with_counts(faces)
    border = np.ascontiguousarray(edges[counts == 1])
    base = int(faces.max()) + 1
    half = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1) @ [base, 1]
    order = np.argsort(half, kind="stable")
    return border, order[np.searchsorted(half[order], border @ [base, 1])] // 3

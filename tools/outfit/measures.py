"""What is measured on a finished garment, by code that the outfit stage does not use: libigl, CGAL, plain formulas."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import igl
import igl.copyleft.cgal as cgal
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

SHARP = 15.0
"""Angles below this are counted [degrees]."""

PROBES = 24
"""Vertices at which the exact winding number of the body is taken: it is one number over a mesh that the body does not
cross, as CGAL decides, so that any vertex would do."""


@dataclass(frozen=True)
class Measures:
    """One garment on the body of shape + tightness."""

    vertices: int
    faces: int
    manifold: bool
    """No edge with more than two faces, one fan of faces at each vertex."""
    oriented: bool
    """Neighbouring faces alike, and outwards; which side is outwards is asked of a manifold garment only."""
    components: int
    self_crossings: int
    """Pairs of faces that meet and should not, by CGAL."""
    body_crossings: int
    """Pairs of its and the body's faces that meet, by CGAL."""
    inside: int
    """Probes with an exact winding number of the body above one half."""
    body_distance: float
    """Of the nearest vertex from the body [m]."""
    smallest_angle: float
    """[degrees]."""
    sharp: int
    """Faces with an angle below `SHARP`."""
    edges: int
    short: int
    """Edges below half the target."""
    long: int
    """Edges above twice the target."""
    shortest: float
    """As a share of the target."""
    longest: float
    mean_edge: float

    def faults(self) -> list[str]:
        """What is wrong with the garment, in words; a few sharp angles are no fault."""
        words = {
            "not manifold": not self.manifold,
            "not oriented": not self.oriented,
            "more than one component": self.components != 1,
            "passes through itself": self.self_crossings > 0,
            "meets the body": self.body_crossings > 0,
            "vertices inside the body": self.inside > 0,
            "over 0.1 % of faces sharp": self.sharp > 1e-3 * self.faces,
            "edges out of 0.5-2 of the target": self.short + self.long > 0,
        }
        return [word for word, wrong in words.items() if wrong]

    def plain(self) -> dict[str, Any]:
        """As JSON values, to six digits."""
        return {name: float(f"{v:.6g}") if isinstance(v, float) else v for name, v in asdict(self).items()}


def measure(vertices: Array, faces: Faces, edge: float, body: Array, body_faces: Faces) -> Measures:
    """Measures one garment.

    Args:
        vertices: Its vertices [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        edge: Target edge length [m].
        body: Vertices of the body it is made for [m], shape [V, 3].
        body_faces: Triangles of the body, shape [G, 3].
    """
    points, f = np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(faces, dtype=np.int64)
    undirected, counts = np.unique(np.sort(f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True)
    directed = np.unique(f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=0)
    length = np.linalg.norm(points[undirected[:, 0]] - points[undirected[:, 1]], axis=1) / edge
    links = coo_matrix((np.ones(len(undirected)), undirected.T), shape=(len(points), len(points)))
    angles = np.degrees(igl.internal_angles(points, f)).min(axis=1)
    probes = points[np.linspace(0, len(points) - 1, PROBES).astype(int)]
    manifold = bool(counts.max() <= 2) and bool(np.all(igl.is_vertex_manifold(f)))
    return Measures(
        vertices=len(points),
        faces=len(f),
        manifold=manifold,
        oriented=len(directed) == 3 * len(f) and (not manifold or _outwards(points, f)),
        components=int(connected_components(links, directed=False)[0]),
        self_crossings=len(cgal.remesh_self_intersections(points, f, True)[2]),
        body_crossings=crossings(points, f, body, body_faces),
        inside=int((igl.winding_number(body, body_faces, np.ascontiguousarray(probes)) > 0.5).sum()),
        body_distance=float(np.sqrt(igl.point_mesh_squared_distance(points, body, body_faces)[0].min())),
        smallest_angle=float(angles.min()),
        sharp=int((angles < SHARP).sum()),
        edges=len(undirected),
        short=int((length < 0.5).sum()),
        long=int((length > 2.0).sum()),
        shortest=float(length.min()),
        longest=float(length.max()),
        mean_edge=float(length.mean()),
    )


def crossings(points: Array, faces: Faces, others: Array, other_faces: Faces) -> int:
    """Pairs of faces of two meshes [m] that meet, by CGAL."""
    found = cgal.intersect_other(points, faces, others, other_faces, True)
    # Among what it returns is a table of two columns.
    return next(len(part) for part in found if isinstance(part, np.ndarray) and part.ndim == 2 and part.shape[1] == 2)


def _outwards(points: Array, faces: Faces) -> bool:
    """Whether a manifold garment looks outwards: closing each border with a fan, its volume is positive."""
    half = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    known = {(a, b) for a, b in half.tolist()}
    following = {b: a for a, b in known if (b, a) not in known}
    corners = [points[faces]]
    while following:
        start, after = next(iter(following.items()))
        loop = [start]
        while after != start:
            loop.append(after)
            after = following.pop(after)
        following.pop(start, None)
        ring = points[loop]
        corners.append(np.stack([ring, np.roll(ring, -1, axis=0), np.broadcast_to(ring.mean(axis=0), ring.shape)], 1))
    a, b, c = np.concatenate(corners).transpose(1, 0, 2)
    return bool(np.einsum("ni,ni->", a, np.cross(b, c)) > 0)

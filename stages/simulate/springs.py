"""Springs of a cloth mesh: edges that stretch and shear, and the linear bending operator, as gather lists.

Every sum over a vertex's springs runs over that vertex's own list, in one order, so that the result has the same
bits at any number of threads.
"""

from __future__ import annotations

import numpy as np

from stages.spec import DataError

STEEPEST = 5.0
"""Greatest cotangent in a hinge that bends with its fabric's whole rigidity."""

COARSE, SATURATION = 0.78, 0.2
"""A chain of links d bends too easily: it is to be stiffer by the share COARSE s / (1 + SATURATION s), s = (d / c)^2.

c is the bending length of its fabric. Chains of hinges hang like the elastica, overhanging by 2 c (the standards'
cantilever) or 3.6 c (Cusick's for cotton), with 0.44 and 0.55 for COARSE and with this SATURATION. Strips of triangles
want 0.7, as the cantilever is then that of theory within 1.2 % up to edges of 20 mm; but Cusick's disc, which bends in
two directions, then hangs lower at 20 mm than at 10, denim by 4.9 %. With 0.78 both are within 3 %."""

CORD, SLACK = 500.0, 1e-8
"""Stiffness of a taut cord [N/m], as that of a seam's edges, and that of a slack one as a share of it."""

GRAVITY = 9.81
"""[m/s^2]; a fabric's bending length is its own, whatever the gravity of a scene."""


def unique_edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (E, 2) int32 of `faces` (F, 3), sorted, and the edge (F, 3) opposite to each corner of each face."""
    corners = faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2)
    edges, inverse = _unique_pairs(np.sort(corners, axis=1))
    return edges, inverse.reshape(-1, 3).astype(np.int32)


def _unique_pairs(pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distinct rows (P, 2) int32 of `pairs` (K, 2), sorted, and the place (K,) of each row among them."""
    wide = int(pairs.max(initial=0)) + 1
    key, inverse = np.unique(pairs[:, 0].astype(np.int64) * wide + pairs[:, 1], return_inverse=True)
    return np.column_stack([key // wide, key % wide]).astype(np.int32), inverse.ravel()


def face_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area (F,) [m^2] of each face."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def hinges(faces: np.ndarray) -> np.ndarray:
    """Inner edges (H, 4): the two vertices of the shared edge, then the two opposite; manifold meshes only."""
    edges, face_edge = unique_edges(faces)
    flat = face_edge.ravel()
    order = np.argsort(flat, kind="stable")
    count = np.bincount(flat, minlength=len(edges))
    if (count > 2).any():
        a, b = edges[int(np.argmax(count))]
        raise DataError(f"cloth mesh: edge {a}-{b} is shared by {count.max()} faces, at most 2 can be; repair the mesh")
    start = np.concatenate([[0], np.cumsum(count)])[:-1][count == 2]
    first, second = order[start], order[start + 1]
    opposite = faces.ravel()
    return np.column_stack([edges[count == 2], opposite[first], opposite[second]]).astype(np.int32)


def bending_rows(
    vertices: np.ndarray,
    faces: np.ndarray,
    rigidity: np.ndarray,
    length: np.ndarray | None = None,
    share: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (P, 2) and coefficients (P,) [N/m] of the quadratic bending energy of a sheet that is flat at rest.

    E = 1/2 sum_h B f / (A1 + A2) |sum_k c_k x_k|^2 over inner edges h, with cotangent coefficients c whose sum is
    zero: |sum c x| is the edge's length times its fold. The Hessian is constant and E vanishes for any flat state.
    (Bergou et al. 2006, "A quadratic bending model for inextensible surfaces", Eq. 3-5; theirs has a factor of 3.
    With 1 a cylinder on a regular mesh holds B A / (2 R^2), as a plate does, and so does one on an equilateral mesh,
    by Seung and Nelson 1988.) f is 1 for equilateral triangles; see `_evenness` for others.
    A pair (i, j), i < j, holds q_ij with E = -1/2 sum_pairs q_ij |x_i - x_j|^2 .

    Cloth that folds on the scale of its bending length bends too easily on hinges that are as far apart. They are made
    stiffer by as much, see `COARSE`, so that it drapes alike on all meshes.

    Args:
        vertices: Rest positions [m], shape [N, 3].
        faces: Shape [F, 3].
        rigidity: Flexural rigidity of each vertex's fabric [N m], shape [N].
        length: Bending length of each vertex's fabric [m], shape [N]; without it no hinge is made stiffer.
        share: Factor on each of `hinges`, shape [H].
    """
    h = hinges(faces)
    if not len(h):
        return np.zeros((0, 2), np.int32), np.zeros(0)
    x0, x1, x2, x3 = (vertices[h[:, k]] for k in range(4))
    e0 = x1 - x0

    def cot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        sine = np.maximum(np.linalg.norm(np.cross(u, v), axis=1), 1e-12)
        return np.asarray((u * v).sum(1) / sine)

    c01, c02 = cot(e0, x2 - x0), cot(e0, x3 - x0)  # angles at x0 in the two faces
    c03, c04 = cot(-e0, x2 - x1), cot(-e0, x3 - x1)  # angles at x1
    area = 0.5 * (np.linalg.norm(np.cross(e0, x2 - x0), axis=1) + np.linalg.norm(np.cross(e0, x3 - x0), axis=1))
    c = np.column_stack([c03 + c04, c01 + c02, -(c01 + c03), -(c02 + c04)])
    # A sliver's hinge is made weaker as a whole: so its coefficients still cancel where the cloth is flat.
    steepest = np.maximum(np.abs([c01, c02, c03, c04]).max(0), 1e-9)
    factor = rigidity[h].mean(1) / np.maximum(area, 1e-12) * np.minimum(1.0, STEEPEST / steepest) ** 2
    factor *= _evenness(c, vertices[h], area)
    if length is not None:
        apart = (area / np.linalg.norm(e0, axis=1) / np.maximum(length[h].mean(1), 1e-9)) ** 2
        factor *= 1 + COARSE * apart / (1 + SATURATION * apart)
    if share is not None:
        factor *= share
    pairs, values = [], []
    for a in range(4):
        for b in range(a + 1, 4):
            pairs.append(np.sort(h[:, [a, b]], axis=1))
            values.append(factor * c[:, a] * c[:, b])
    rows, inverse = _unique_pairs(np.concatenate(pairs))
    return rows, np.bincount(inverse, np.concatenate(values), minlength=len(rows))


def bending_length(rigidity: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Bending length c = (B / w)^(1/3) [m] of fabrics of `rigidity` [N m] and `density` [kg/m^2]."""
    return np.cbrt(rigidity / (density * GRAVITY))


def _evenness(c: np.ndarray, corners: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Factor (H,) with which hinges of any shape hold what a third of their area does, of cylinders in all directions.

    On z = (n.x)^2 / 2 a hinge's sum c z is n^T G n, G = 1/2 sum_k c_k x_k x_k^T, whose square is on average over n
    (2 |G|^2 + (tr G)^2) / 8, and that is to be (A1 + A2)^2 / 3. Uneven meshes are else a tenth too stiff.
    """
    x = corners - corners.mean(1, keepdims=True)
    g = 0.5 * np.einsum("hk,hki,hkj->hij", c, x, x)
    held = (2 * (g**2).sum((1, 2)) + np.trace(g, axis1=1, axis2=2) ** 2) / 8
    return np.asarray(np.clip(area**2 / 3 / np.maximum(held, 1e-30), 0.5, 2.0))


def gather_lists(pairs: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each of `count` vertices, which pairs it is in.

    Returns:
        start (count + 1,), neighbour (2 P,) and pair index (2 P,), all int32: vertex i meets neighbour[k] through pair
        index[k] for k in start[i]:start[i + 1], neighbours ascending.
    """
    owner = np.concatenate([pairs[:, 0], pairs[:, 1]])
    other = np.concatenate([pairs[:, 1], pairs[:, 0]])
    index = np.tile(np.arange(len(pairs)), 2)
    order = np.lexsort((other, owner))
    start = np.searchsorted(owner[order], np.arange(count + 1))
    return start.astype(np.int32), other[order].astype(np.int32), index[order].astype(np.int32)


class Springs:
    """Springs of one scene's cloth: constants and gather lists.

    Attributes:
        mass: Lumped mass [kg], shape [N].
        area: A third of the adjacent faces' area [m^2], shape [N].
        edges: Shape [E, 2]: the `woven` ones, which are edges of faces, then the cords.
        length [m] in the garment as made, rest_scale, and rest_length [m] in force; stiffness [N/m], limit, stiffening,
            damping [s]: each [E].
        start, neighbour, spring: The gather lists over `edges`.
        edge_bend: Bending coefficient q_ij of each edge [N/m], shape [E].
        bend_start, bend_neighbour, bend: Gather lists over the bending pairs that aren't edges, with q_ij [N/m] for
            each entry; bend_sum [N/m] the sum over a vertex, shape [N]; bend_damping [s], shape [N].
    """

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        *,
        density: np.ndarray,
        stretch_stiffness: np.ndarray,
        bend_stiffness: np.ndarray,
        stretch_limit: np.ndarray,
        stiffening: np.ndarray,
        damping: np.ndarray,
        rest_scale: np.ndarray | None = None,
        cords: np.ndarray | None = None,
        cord_length: np.ndarray | None = None,
    ) -> None:
        """Build from rest `vertices` [N, 3] and `faces` [F, 3]; every constant has shape [N], rest_scale is per edge.

        Cords join the vertices `cords` [C, 2] and pull where these are further apart than `cord_length` [m], shape [C].

        Raises:
            DataError: If a face or an edge is degenerate at rest, or a vertex has no face.
        """
        n = len(vertices)
        areas = face_areas(vertices, faces)
        edges, face_edge = unique_edges(faces)
        length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
        if length.min() < 1e-6:
            a, b = edges[int(np.argmin(length))]
            raise DataError(f"cloth mesh: edge {a}-{b} is {length.min():.2e} m long at rest, must be >= 1e-6 m; remesh")
        self.area = np.bincount(faces.ravel(), np.repeat(areas / 3, 3), minlength=n)
        if self.area.min() <= 0:
            raise DataError(f"cloth mesh: vertex {int(np.argmin(self.area))} has no face with area; remove it")
        self.mass = self.area * density
        edge_area = np.bincount(face_edge.ravel(), np.repeat(areas, 3), minlength=len(edges))

        def mean(values: np.ndarray) -> np.ndarray:
            return np.ascontiguousarray(values[edges].mean(1))

        # Van Gelder 1998: k = E A / l^2 over adjacent faces, exact for equilateral triangles. A sliver's area is raised
        # to what keeps its springs no weaker than a tenth of an equilateral one's.
        area = np.maximum(edge_area, 0.1 * np.sqrt(3) / 2 * length**2)
        self.edges, self.woven = edges, len(edges)
        self.stiffness = mean(stretch_stiffness) * area / length**2
        self.length, self.rest_scale = length, np.ones(len(edges)) if rest_scale is None else rest_scale
        self.rest_length = self.length * self.rest_scale
        self.limit, self.damping = mean(stretch_limit), mean(damping)
        # An elastic gives way as far as it is pulled: it is not its crimp that is pulled straight.
        self.stiffening = np.where(self.rest_scale < 1.0, 1.0, mean(stiffening))
        if cords is not None and cord_length is not None and len(cords):
            self._add_cords(np.sort(cords, axis=1).astype(np.int32), cord_length)
        self.start, self.neighbour, self.spring = gather_lists(self.edges, n)
        self.set_bending(*bending_rows(vertices, faces, bend_stiffness, bending_length(bend_stiffness, density)))
        self.bend_damping = np.ascontiguousarray(damping, np.float64)
        self.degenerate_faces = int((areas <= 0).sum())

    def _add_cords(self, cords: np.ndarray, length: np.ndarray) -> None:
        """Springs that are next to nothing up to their length, and stiffen there to `CORD`."""
        own = {"edges": cords, "length": length, "rest_scale": 1.0, "rest_length": length, "stiffness": SLACK * CORD}
        for name, value in {**own, "limit": 0.0, "stiffening": 1 / SLACK, "damping": 0.0}.items():
            held = getattr(self, name)
            more = np.broadcast_to(np.asarray(value, held.dtype), (len(cords), *held.shape[1:]))
            setattr(self, name, np.concatenate([held, more]))

    def set_bending(self, rows: np.ndarray, q: np.ndarray) -> None:
        """Bend by the pairs `rows` (P, 2) with coefficients `q` (P,) [N/m], see `bending_rows`."""
        # Pairs that are edges too are added to their spring's block, which spares the solve half of the bending lists.
        n, edges = len(self.mass), self.edges[: self.woven]
        key, edge_key = rows[:, 0] * np.int64(n) + rows[:, 1], edges[:, 0] * np.int64(n) + edges[:, 1]
        place = np.minimum(np.searchsorted(edge_key, key), len(edges) - 1)
        on_edge = edge_key[place] == key
        # Without any pair NumPy would count in integers.
        self.edge_bend = np.bincount(place[on_edge], q[on_edge], minlength=len(self.edges)).astype(np.float64)
        rows, q = rows[~on_edge], q[~on_edge]
        self.bend_start, self.bend_neighbour, index = gather_lists(rows, n)
        self.bend = np.ascontiguousarray(q[index]) if len(index) else np.zeros(1)
        if not len(index):
            self.bend_neighbour = np.zeros(1, np.int32)
        owner = np.repeat(np.arange(n), np.diff(self.bend_start))
        self.bend_sum = np.bincount(owner, self.bend[: len(owner)], minlength=n).astype(np.float64)
        self._bending = [(held, held.copy()) for held in (self.edge_bend, self.bend, self.bend_sum)]

    def stiffen(self, factor: float) -> None:
        """Bend `factor` times as stiffly as the fabrics do."""
        for held, own in self._bending:
            np.multiply(own, factor, out=held)

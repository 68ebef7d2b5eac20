"""A garment while it is made: a mesh whose vertices remember which template vertices they come from."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.mesh.topology import compact

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangle mesh cut from a template."""

    vertices: Array
    """Positions [m], shape [N, 3]."""
    faces: Faces
    """Triangles, counter-clockwise seen from outside, shape [F, 3]."""
    rows: sp.csr_matrix
    """Each vertex as a mean of template vertices, shape [N, N_template]: `rows @ field` carries a field over."""

    @classmethod
    def whole(cls, vertices: Array, faces: Faces) -> "Surface":
        """A mesh that is its own template."""
        return cls(vertices, faces, sp.identity(len(vertices), format="csr"))

    def compacted(self) -> "Surface":
        """The same without vertices that no face uses."""
        faces, kept = compact(self.faces, len(self.vertices))
        return Surface(self.vertices[kept], faces, self.rows[kept])


def grown(marked: NDArray[np.bool_], faces: Faces, rings: int) -> NDArray[np.bool_]:
    """Marked vertices and those within some rings of neighbours, shape [N]."""
    marked = marked.copy()
    a, b, c = faces.T
    for _ in range(rings):
        marked[faces[marked[a] | marked[b] | marked[c]]] = True
    return marked

"""Carries the displacement of a body's shape over to a garment (CLOTH3D, Resizing)."""

from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.body import BodyModel, load_free_body
from model.body.size import size_directions
from model.mesh.topology import adjacency, edge_list
from stages.outfit.template import load_template, nearest_on_body, rest_body

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


def tight_betas(betas: Array, tightness: tuple[float, float], model: BodyModel | None = None) -> Array:
    """Betas of the body that the garment is made for: positive tightness is a smaller, thinner body.

    CLOTH3D's factor (-1)^(g + 1) serves the opposite signs that SMPL's two models have; here they are told from the
    model itself.

    Args:
        betas: Shape of the wearer, shape [B].
        tightness: How much smaller, and how much thinner [standard deviations].
        model: The wearer's body model; the embedded one if left out.

    Returns:
        Shape [B].
    """
    tight: Array = betas - tightness @ size_directions(model or load_free_body("female"))[:, : len(betas)]
    return tight


def transferred_shape(model: BodyModel, betas: Array, garment: str, edge: float, width: float) -> Array:
    """How a template moves when its wearer's shape goes from the mean to `betas`.

    Each vertex takes the displacement of the nearest point of the mean body; iterated Laplacian smoothing of that
    field then removes the body's detail and leaves the garment's own geometry as it is.

    Args:
        model: The free body of the template's gender, or the free twin of another body.
        betas: Shape to go to, shape [B].
        garment: Name of the template.
        edge: Edge length of the template [m].
        width: Standard deviation of the smoothing along the cloth [m].

    Returns:
        Displacements of the template's vertices in the rest frame [m], shape [N, 3].
    """
    displacement = rest_body(model, betas) - _mean_body(model.gender)
    face, weights = nearest_on_body(garment, model.gender, edge)
    field = np.einsum("nk,nkd->nd", weights, displacement[model.faces[face]])
    # One step of averaging spreads by half a squared edge length, shared by the two directions along the cloth.
    steps = round(4.0 * (width / edge) ** 2)
    return smooth_field(field, _averaging(garment, model.gender, edge), steps)


def smooth_field(field: Array, averaging: sp.csr_matrix, steps: int) -> Array:
    """Applies `steps` of averaging to a field [n, d]."""
    for _ in range(steps):
        field = averaging @ field
    return field


def averaging_matrix(faces: Faces, vertex_count: int) -> sp.csr_matrix:
    """One Laplacian step: half the vertex's own value, half its neighbours' mean, shape [N, N]."""
    links = adjacency(edge_list(faces), vertex_count)
    degree = np.maximum(np.asarray(links.sum(axis=1)).reshape(-1), 1.0)
    return (0.5 * sp.identity(vertex_count, format="csr") + sp.diags(0.5 / degree) @ links).tocsr()


@lru_cache(maxsize=32)
def _averaging(garment: str, gender: str, edge: float) -> sp.csr_matrix:
    template = load_template(garment, gender, edge)
    return averaging_matrix(template.faces, len(template.vertices))


@lru_cache(maxsize=2)
def _mean_body(gender: str) -> Array:
    model = load_free_body(gender)
    return rest_body(model, np.zeros(model.beta_count))

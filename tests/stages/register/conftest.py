"""Garments with a known answer: the layer pushed out and waved, cut along a known line, and meshed anew."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from model.body import load_free_body
from model.body.layer import GarmentLayer, garment_layer
from model.mesh.geometry import vertex_normals
from model.mesh.remesh import remesh
from model.mesh.split import split_along
from model.mesh.topology import compact, largest_component_faces
from stages.register.source import source_surface


@dataclass(frozen=True, eq=False)
class Made:
    """A garment made from the layer.

    Attributes:
        vertices: [m], shape [M, 3], not in the layer's tessellation.
        faces: Shape [G, 3].
        true: Where each vertex of the layer was pushed [m], shape [N, 3].
        inside: Field that is positive where the garment covers the layer [m], shape [N].
    """

    vertices: np.ndarray
    faces: np.ndarray
    true: np.ndarray
    inside: np.ndarray


def make(layer: GarmentLayer, topology: str, field: Callable[[np.ndarray], np.ndarray], ease: float) -> Made:
    """Pushes the layer out by `ease` plus waves of 3 mm, and cuts it where `field` of the rest position is 0."""
    source = source_surface(layer, np.zeros(10), topology)
    faces = layer.faces(topology)
    push = ease + 0.003 * np.sin(60 * source[:, 0]) * np.cos(50 * source[:, 2])
    true = source + push[:, None] * vertex_normals(source, faces)
    inside = field(source)
    points, triangles, positive = split_along(true, faces, inside)
    kept = triangles[positive]
    kept = kept[largest_component_faces(kept)]
    triangles, used = compact(kept, len(points))
    vertices, triangles = remesh(points[used], triangles, 0.012, passes=4)
    return Made(vertices, triangles, true, inside)


@pytest.fixture(scope="session")
def layer() -> GarmentLayer:
    """The layer of the free female body."""
    return garment_layer(load_free_body("female"))


@pytest.fixture(scope="session")
def tshirt(layer: GarmentLayer) -> Made:
    """Ends at the hips, above the elbows and in a round neckline, 12 mm off the skin."""

    def field(x: np.ndarray) -> np.ndarray:
        neck = np.linalg.norm(x - (0.0, 0.0, 0.55), axis=1) - 0.11
        return np.minimum.reduce([x[:, 2] - 0.02, 0.35 - np.abs(x[:, 0]), neck])

    return make(layer, "skirt", field, 0.012)


@pytest.fixture(scope="session")
def skirt(layer: GarmentLayer) -> Made:
    """From the waist to below the knees, 15 mm off the smoothed tube around both legs."""
    return make(layer, "skirt", lambda x: np.minimum(0.13 - x[:, 2], x[:, 2] + 0.55), 0.015)


@pytest.fixture(scope="session")
def trousers(layer: GarmentLayer) -> Made:
    """From the waist to the shins, 10 mm off the skin."""
    return make(layer, "body", lambda x: np.minimum(0.13 - x[:, 2], x[:, 2] + 0.6), 0.010)


@pytest.fixture(scope="session")
def long_shirt(layer: GarmentLayer) -> Made:
    """A sleeveless tube around the trunk and the upper thighs, to 8 cm below the crotch."""

    def field(x: np.ndarray) -> np.ndarray:
        return np.minimum.reduce([x[:, 2] + 0.18, 0.3 - x[:, 2], 0.24 - np.abs(x[:, 0])])

    return make(layer, "skirt", field, 0.012)

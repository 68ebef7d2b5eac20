"""A small sphere in four segments, whose "skirt" lacks a strip of faces, as the mesh of the networks' tests."""

import numpy as np
import pytest

from model.gcvae.graphs import MeshGraphs
from model.gcvae.hierarchy import Hierarchy, build_hierarchy


@pytest.fixture(scope="session")
def sphere() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (1152, 3) and faces of a sphere without its poles."""
    rings, sides = 36, 32
    polar = np.linspace(0.15, np.pi - 0.15, rings)
    around = np.arange(sides) * 2 * np.pi / sides
    p, a = np.meshgrid(polar, around, indexing="ij")
    vertices = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=-1).reshape(-1, 3)
    u, v = np.meshgrid(np.arange(rings - 1), np.arange(sides), indexing="ij")
    i, j = u * sides + v, u * sides + (v + 1) % sides
    faces = np.concatenate(
        [np.stack([i, i + sides, j + sides], -1).reshape(-1, 3), np.stack([i, j + sides, j], -1).reshape(-1, 3)]
    )
    return vertices, faces


@pytest.fixture(scope="session")
def hierarchy(sphere: tuple[np.ndarray, np.ndarray]) -> Hierarchy:
    vertices, faces = sphere
    segments = 2 * (vertices[:, 2] > 0) + (vertices[:, 1] > 0)
    ring, side = np.divmod(faces, 32)
    slit = ((side == 3) | (side == 4)).all(axis=1) & (ring < 10).all(axis=1)
    return build_hierarchy(vertices, faces, faces[~slit], segments)


@pytest.fixture(scope="session")
def graphs(hierarchy: Hierarchy) -> MeshGraphs:
    return MeshGraphs(hierarchy)

"""A tube in four segments as the layer of the stage's tests, and synthetic garments on it."""

import numpy as np
import pytest

from model.gcvae.graphs import MeshGraphs
from model.gcvae.hierarchy import Hierarchy, build_hierarchy
from model.gcvae.losses import FaceNormals
from model.mesh.geometry import vertex_normals
from stages.train.experiment import Mesh
from stages.train.fill import Fill
from stages.train.samples import Samples

RINGS, SIDES = 40, 28


@pytest.fixture(scope="session")
def tube() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (1120, 3) [m] and faces of an upright tube."""
    u, v = np.meshgrid(np.arange(RINGS), np.arange(SIDES), indexing="ij")
    angle = v * 2 * np.pi / SIDES
    vertices = np.stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.04 * u], axis=-1).reshape(-1, 3)
    i = (u * SIDES + v)[:-1].reshape(-1)
    j = (u * SIDES + (v + 1) % SIDES)[:-1].reshape(-1)
    faces = np.concatenate([np.stack([i, j, j + SIDES], -1), np.stack([i, j + SIDES, i + SIDES], -1)])
    return vertices, faces.astype(np.int32)


@pytest.fixture(scope="session")
def hierarchy(tube: tuple[np.ndarray, np.ndarray]) -> Hierarchy:
    vertices, faces = tube
    return build_hierarchy(vertices, faces, faces, np.arange(len(vertices)) * 4 // len(vertices))


@pytest.fixture(scope="session")
def mesh(tube: tuple[np.ndarray, np.ndarray], hierarchy: Hierarchy) -> Mesh:
    faces = {"body": tube[1], "skirt": tube[1]}
    normals = {name: FaceNormals(array, len(tube[0])) for name, array in faces.items()}
    return Mesh(hierarchy=hierarchy, graphs=MeshGraphs(hierarchy), faces=faces, normals=normals)


@pytest.fixture(scope="session")
def samples(tube: tuple[np.ndarray, np.ndarray], hierarchy: Hierarchy) -> Samples:
    """Forty garments of two types whose length and ease vary; the last ten are held out."""
    vertices, faces = tube
    rng = np.random.default_rng(7)
    count = 40
    girth = rng.uniform(0.8, 1.2, count)
    body = (vertices * np.stack([girth, girth, np.ones(count)], 1)[:, None, :]).astype(np.float32)
    normals = np.stack([vertex_normals(v, faces) for v in body]).astype(np.float32)
    skirt = rng.random(count) < 0.5
    hem, ease = rng.uniform(0.2, 0.7, count), rng.uniform(0.005, 0.03, count)
    mask = np.where(skirt[:, None], vertices[:, 2] < 0.3 + hem[:, None], vertices[:, 2] > hem[:, None])
    flare = 1 + 2 * skirt[:, None] * (1.6 - vertices[None, :, 2])
    offsets = normals * (ease[:, None] * flare)[..., None]
    fill = Fill(hierarchy, "body")
    return Samples(
        names=tuple(f"item{k}/garment" for k in range(count)),
        types=tuple("skirt" if s else "top" for s in skirt),
        skirt=skirt,
        train=np.arange(count) < 30,
        target=np.stack([fill(o, m) for o, m in zip(offsets, mask)]),
        cvar=np.stack([girth, ease * 50], axis=1).astype(np.float32),
        garment=np.arange(count),
        wearer=np.arange(count),
        mask=mask,
        worn=None,
        body=body,
        normals=normals,
    )

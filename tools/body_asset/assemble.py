"""Puts the embedded body together: a population, its basis, the rig, the T-pose."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model.body.model import BodyModel
from model.body.skeleton import PARENTS
from tools.body_asset.basis import ShapeBasis, body_mass_index, guided_basis
from tools.body_asset.phenotype import coefficients, load_blendshapes, sample_adult
from tools.body_asset.rig import joint_regressor, skin_weights
from tools.body_asset.source import Source
from tools.body_asset.t_pose import Rerest, rerest_to_t_pose

POPULATION = 300
"""Adults per gender; held-out adults are then met within 0.5 mm on average by ten betas."""

SEED = 1


@dataclass(frozen=True, eq=False)
class Assembly:
    """All vertices of the base mesh in the T-pose frame, helpers included."""

    gender: str
    basis: ShapeBasis
    rerest: Rerest

    def field(self, beta: int | None = None) -> NDArray[np.float64]:
        """The mean, or one shape direction, in the T-pose [m], shape [N, 3]."""
        return self.rerest.vertices(self.basis.mean if beta is None else self.basis.directions[beta])

    def joint_field(self, beta: int | None = None) -> NDArray[np.float64]:
        """The joints of the mean, or of one shape direction, in the T-pose [m], shape [24, 3]."""
        return self.rerest.joints(self.basis.mean if beta is None else self.basis.directions[beta])


def triangulate(quads: NDArray[np.int32]) -> NDArray[np.int32]:
    """Splits quads [Q, 4] along their first diagonal into triangles [F, 3]; a repeated corner gives one triangle."""
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


def assemble(source: Source, gender: str) -> Assembly:
    """Computes shape space and T-pose of one gender.

    Args:
        source: The data.
        gender: `female` or `male`.

    Returns:
        The assembly over all vertices of the base mesh.
    """
    base = source.base_mesh()
    faces = triangulate(base.groups["body"])
    body = np.unique(faces)
    regressor = joint_regressor(source)
    blendshapes = load_blendshapes(source, gender)
    flat = blendshapes.displacements.reshape(len(blendshapes.labels), -1)
    rng = np.random.default_rng(SEED)
    adults = [sample_adult(rng, gender) for _ in range(POPULATION)]
    weights = np.stack([coefficients(blendshapes.labels, adult) for adult in adults])
    samples = (weights @ flat).reshape(POPULATION, -1, 3) + base.vertices.astype(np.float32)
    # The pelvis is the origin: where a person stands is the pose's business.
    pelvis = np.stack([(regressor @ sample)[0] for sample in samples])
    samples = (samples - pelvis[:, None]).astype(np.float32)
    stature = np.ptp(samples[:, body, 1], axis=1).astype(np.float64)
    bmi = np.array([body_mass_index(sample, faces) for sample in samples])
    basis = guided_basis(samples, stature, bmi)
    return Assembly(gender, basis, rerest_to_t_pose(basis.mean, skin_weights(source), regressor))


def body_model(source: Source, assembly: Assembly) -> BodyModel:
    """The body alone, as a model in SMPL's schema."""
    quads = source.base_mesh().groups["body"]
    keep = np.unique(quads)
    renumber = np.full(len(assembly.basis.mean), -1, np.int32)
    renumber[keep] = np.arange(len(keep), dtype=np.int32)
    betas = range(len(assembly.basis.directions))
    weights = assembly.rerest.weights[keep]
    return BodyModel(
        gender=assembly.gender,
        v_template=assembly.field()[keep].astype(np.float32),
        shapedirs=np.stack([assembly.field(b)[keep] for b in betas], axis=2).astype(np.float32),
        joint_template=assembly.joint_field(),
        joint_shapedirs=np.stack([assembly.joint_field(b) for b in betas], axis=2),
        weights=weights.astype(np.float32),
        parents=PARENTS.copy(),
        faces=renumber[triangulate(quads)],
    )

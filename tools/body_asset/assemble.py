"""Puts the embedded body together: a population, its basis, the rig, the T-pose."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model.body.model import BodyModel
from model.body.skeleton import JOINT_NAMES, PARENTS
from tools.body_asset.basis import ShapeBasis, body_mass_index, guided_basis
from tools.body_asset.fold import unfolded_scale
from tools.body_asset.outer_skin import outer_skin
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


def assemble(source: Source, gender: str) -> Assembly:
    """Computes shape space and T-pose of one gender.

    Args:
        source: The data.
        gender: `female` or `male`.

    Returns:
        The assembly over all vertices of the base mesh.
    """
    base = source.base_mesh()
    faces = outer_skin(base)
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
    rerest = rerest_to_t_pose(basis.mean, skin_weights(source), regressor)
    return Assembly(gender, _without_folds(basis, rerest, faces), rerest)


def _without_folds(basis: ShapeBasis, rerest: Rerest, faces: NDArray[np.int32]) -> ShapeBasis:
    """Shrinks the unit of each direction whose ends would fold the clothed part of the body: no head, hands, feet."""
    template, joints = rerest.vertices(basis.mean), rerest.joints(basis.mean)
    top, bottom, reach = (
        joints[JOINT_NAMES.index("neck"), 1],
        joints[JOINT_NAMES.index("left_ankle"), 1],
        joints[JOINT_NAMES.index("left_wrist"), 0],
    )
    x, y, _ = template[faces].mean(axis=1).T
    clothed = faces[(y < top) & (y > bottom) & (np.abs(x) < reach)]
    scales = [unfolded_scale(template, rerest.vertices(direction), clothed) for direction in basis.directions]
    return replace(basis, directions=basis.directions * np.array(scales)[:, None, None])


def body_model(source: Source, assembly: Assembly) -> BodyModel:
    """The body alone, as a model in SMPL's schema."""
    faces = outer_skin(source.base_mesh())
    keep = np.unique(faces)
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
        faces=renumber[faces],
    )

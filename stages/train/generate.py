"""New garments on new people: codes from the latent spaces, conditions from the training set's range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.body import REST_POSE, BodyModel
from model.body.layer import TOPOLOGY, GarmentLayer
from model.gcvae.garment import garment_mesh, lift_out
from model.offsets import rest_to_pose
from stages.train.config import TrainConfig
from stages.train.evaluate import decode
from stages.train.experiment import Trained
from stages.train.records import Record, facing_front, person_conditions, pose_conditions
from stages.train.sampling import CodeSampler

# A code whose mask covers next to nothing is drawn again, so many times.
ATTEMPTS = 8
SMALLEST_GARMENT = 0.05


@dataclass(frozen=True, kw_only=True)
class Model:
    """A trained network and where its codes lie."""

    trained: Trained
    sampler: CodeSampler


@dataclass(frozen=True, kw_only=True, eq=False)
class Generated:
    """A generated garment on its body, z up, root joint at the origin.

    Attributes:
        vertices: Garment [m], shape (M, 3).
        faces: Garment triangles, shape (F, 3).
        body_vertices: Posed body [m], shape (V, 3).
        body_faces: Body triangles, shape (G, 3).
        about: Type, gender, tightness and how it was drawn.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    body_vertices: NDArray[np.float32]
    body_faces: NDArray[np.int32]
    about: dict[str, Any]


def generate(
    static: Model,
    dynamic: Model | None,
    records: Sequence[Record],
    bodies: Mapping[str, BodyModel],
    layers: Mapping[str, GarmentLayer],
    config: TrainConfig,
    rng: np.random.Generator,
) -> list[Generated]:
    """Draw `config.generated` garments, the types in turn if codes are drawn by type.

    Wrinkles are added to the types that DVAE was trained on; others are posed by the skin alone, and say so.

    Args:
        static: SVAE.
        dynamic: DVAE, or None if nothing moved.
        records: Training items: people are drawn from their range, poses from those that move.
        bodies: Body model of each gender.
        layers: Layer of each gender.
        config: Number and source of the codes.
        rng: Source of all draws.
    """
    made = []
    for index in range(config.generated):
        drawn = [records[int(k)] for k in rng.integers(len(records), size=2 + len(records[0].betas))]
        gender, tightness = drawn[0].gender, drawn[1].tightness
        betas = np.array([record.betas[k] for k, record in enumerate(drawn[2:])])
        cvar = person_conditions(betas, gender, tightness)
        kind, code, offsets, mask = _draw(static, cvar, index, config, rng)
        pose, theta = _draw_pose(records, kind, config, rng)
        note = f"z ~ {'N(0, I)' if config.latent_source == 'prior' else 'the Gaussian of its type'}, sample {index}"
        if dynamic is not None and kind in dynamic.sampler.kinds:
            wrinkles = dynamic.sampler.of_type(kind, config.temperature, rng)
            conditions = np.concatenate([cvar, code, theta])[None]
            trained = dynamic.trained
            beyond = decode(trained.network, trained.scales, wrinkles[None], conditions, TOPOLOGY[kind])[0][0]
        else:
            beyond = np.zeros_like(offsets)
            note += ", posed by the skin without wrinkles"
        layer = layers[gender]
        at_rest = layer.model.pose(betas, REST_POSE[None])[0] + offsets
        positions = rest_to_pose(layer, betas, pose[None], TOPOLOGY[kind]).repose(beyond, at_rest)[0]
        vertices, faces = garment_mesh(positions, mask, layer.faces(TOPOLOGY[kind]))
        body = bodies[gender].pose(betas, pose[None])[0]
        vertices, inside = lift_out(vertices, faces, body, bodies[gender].faces)
        about: dict[str, Any] = {"type": kind, "gender": gender, "topology": TOPOLOGY[kind], "note": note}
        about |= {
            "lifted_share": inside,
            "betas": betas.tolist(),
            "tightness": tightness.tolist(),
            "pose": pose.tolist(),
        }
        made.append(
            Generated(
                vertices=vertices,
                faces=faces,
                body_vertices=body,
                body_faces=bodies[gender].faces,
                about=about,
            )
        )
    return made


def _draw(
    static: Model, cvar: NDArray[np.float32], index: int, config: TrainConfig, rng: np.random.Generator
) -> tuple[str, NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Type, code (Z,), offsets [m] (N, 3) and mask (N,) of a garment; the last attempt stands whatever it covers."""
    sampler, trained = static.sampler, static.trained
    attempt = 0
    while True:
        attempt += 1
        if config.latent_source == "prior":
            code = np.float32(config.temperature) * rng.standard_normal(sampler.means.shape[1:], np.float32)
            kind = sampler.nearest_type(code)
        else:
            kind = sampler.kinds[index % len(sampler.kinds)]
            code = sampler.of_type(kind, config.temperature, rng)
        offsets, masks = decode(trained.network, trained.scales, code[None], cvar[None], TOPOLOGY[kind])
        assert masks is not None, "SVAE predicts masks"
        if masks[0].mean() >= SMALLEST_GARMENT or attempt == ATTEMPTS:
            return kind, code, offsets[0], masks[0]


def _draw_pose(
    records: Sequence[Record], kind: str, config: TrainConfig, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """A pose (24, 3) facing -y and theta that belongs to it; the rest pose if nothing moves.

    It is one that the type was seen in, if there is any: DVAE knows no other wrinkles of it.
    """
    moving = [record for record in records if record.sequence]
    moving = [record for record in moving if kind in {worn.kind for worn in record.garments}] or moving
    if not moving:
        pose = np.array(REST_POSE, np.float64)
        return pose, np.tile(pose.reshape(-1), config.frames).astype(np.float32)
    record = moving[int(rng.integers(len(moving)))]
    frame = np.array([rng.integers(len(record.pose))])
    theta = pose_conditions(record.pose, frame, config.frames, config.frame_spacing)[0]
    return facing_front(record.pose[frame])[0], theta

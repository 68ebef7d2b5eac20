"""Samples of the two networks from encoded items."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from model.body import REST_POSE
from model.body.layer import GarmentLayer
from model.mesh.geometry import vertex_normals
from model.offsets import rest_to_pose
from stages.train.config import TrainConfig
from stages.train.fill import Fill
from stages.train.records import Record, headings, pose_conditions
from stages.train.samples import Samples

HELD_OUT_FRAMES = 0.2
FRAMES_AT_ONCE = 16


def static_samples(records: Sequence[Record], layers: Mapping[str, GarmentLayer], fills: Mapping[str, Fill]) -> Samples:
    """Every garment of every record at rest, in the records' order."""
    worn = [(index, garment) for index, record in enumerate(records) for garment in record.garments]
    body, normals = rest_bodies(records, layers)
    return Samples(
        names=tuple(f"{records[index].item}/{garment.name}" for index, garment in worn),
        types=tuple(garment.kind for _, garment in worn),
        skirt=np.array([garment.topology == "skirt" for _, garment in worn]),
        train=np.array([records[index].train for index, _ in worn]),
        target=np.stack([fills[garment.topology](garment.at_rest, garment.mask) for _, garment in worn]),
        cvar=np.stack([records[index].static_conditions for index, _ in worn]),
        garment=np.arange(len(worn)),
        wearer=np.array([index for index, _ in worn]),
        mask=np.stack([garment.mask for _, garment in worn]),
        worn=None,
        body=body,
        normals=normals,
    )


def rest_bodies(
    records: Sequence[Record], layers: Mapping[str, GarmentLayer]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Layer vertices [m] and unit normals of each record's body in the rest pose, root at the origin, (W, N, 3)."""
    body = np.stack([layers[r.gender].model.pose(r.betas, REST_POSE[None])[0] for r in records])
    normals = np.stack([vertex_normals(v, layers[r.gender].body_faces) for v, r in zip(body, records)])
    return body, normals.astype(np.float32)


def dynamic_samples(
    records: Sequence[Record],
    layers: Mapping[str, GarmentLayer],
    fills: Mapping[str, Fill],
    at_rest: Samples,
    codes: NDArray[np.float32],
    config: TrainConfig,
) -> Samples:
    """Every garment of every moving record in each of its frames.

    The target is X_new = R^T (C_d - K(C_s)): what posing the garment at rest by the skin lacks, seen in the rest frame;
    see `model.offsets.RestToPose`.

    Args:
        records: Items that move.
        layers: Layer of each gender.
        fills: Continuation outside the garment, for each topology.
        at_rest: `static_samples` of the same records.
        codes: z_s of each garment, shape (G, Z).
        config: Frames to condition on.
    """
    targets, cvars, garments, frames, posed, train, names = [], [], [], [], [], [], []
    row, first = 0, 0
    held_out = hold_out_frames(records)
    for record in records:
        model = layers[record.gender].model
        poses = record.pose[record.frames]
        layer = model.pose(record.betas, poses)
        theta = pose_conditions(record.pose, record.frames, config.frames, config.frame_spacing)
        posed.append(layer @ headings(poses).astype(np.float32))
        for garment in record.garments:
            rest = at_rest.body[at_rest.wearer[row]] + at_rest.target[row]
            unposed = unpose(layers[record.gender], record, poses, layer + garment.moving, rest, garment.topology)
            targets.append(np.stack([fills[garment.topology](frame, garment.mask) for frame in unposed]))
            own = np.concatenate([record.static_conditions, codes[row]])
            cvars.append(np.concatenate([np.tile(own, (len(theta), 1)), theta], axis=1))
            garments.append(np.full(len(theta), row))
            frames.append(first + np.arange(len(theta)))
            train.append(record.frames < held_out[record.item] if record.train else np.zeros(len(theta), bool))
            names += [f"{record.item}/{garment.name}/{frame}" for frame in record.frames]
            row += 1
        first += len(theta)
    garment_rows = np.concatenate(garments)
    return Samples(
        names=tuple(names),
        types=tuple(at_rest.types[k] for k in garment_rows),
        skirt=at_rest.skirt[garment_rows],
        train=np.concatenate(train),
        target=np.concatenate(targets),
        cvar=np.concatenate(cvars).astype(np.float32),
        garment=garment_rows,
        wearer=at_rest.wearer[garment_rows],
        mask=at_rest.mask,
        worn=at_rest.target,
        body=at_rest.body,
        normals=at_rest.normals,
        frame=np.concatenate(frames),
        posed=np.concatenate(posed),
    )


def unpose(
    layer: GarmentLayer, record: Record, poses: NDArray, dynamic: NDArray, static: NDArray, topology: str
) -> NDArray[np.float64]:
    """X_new of a garment in frames (T, N, 3), a few frames at a time: K takes 0.3 kB a vertex and frame."""
    parts = []
    for start in range(0, len(poses), FRAMES_AT_ONCE):
        chunk = slice(start, start + FRAMES_AT_ONCE)
        parts.append(rest_to_pose(layer, record.betas, poses[chunk], topology).unpose(dynamic[chunk], static))
    return np.concatenate(parts)


def hold_out_frames(records: Sequence[Record]) -> dict[str, int]:
    """First frame of each item that training may not see: none if a whole item is held out, else the last fifth."""
    whole = any(not record.train for record in records)
    return {
        record.item: len(record.pose) if whole else round((1 - HELD_OUT_FRAMES) * len(record.pose))
        for record in records
    }

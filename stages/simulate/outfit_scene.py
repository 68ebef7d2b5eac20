"""An outfit on a body sequence, as a scene: transition first, then the sequence's own frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stages.simulate.config import SimulateConfig
from stages.simulate.fabric import Fabric
from stages.simulate.scene import Garment, Scene, edge_scale
from stages.simulate.transition import PoseBody, Transition, make_transition

WAISTBAND = -1
"""Mark of waistband vertices beside the outfit's elastic ids, which are positive."""


def make_garment(
    name: str,
    vertices: np.ndarray,
    faces: np.ndarray,
    elastic: np.ndarray,
    waistband: np.ndarray,
    about: Mapping[str, Any],
) -> Garment:
    """One garment of an outfit shard.

    Args:
        name: Its name.
        vertices: Rest frame [m], shape [N, 3]; faces: shape [F, 3].
        elastic: Id of the elastic loop of each vertex, 0 for none, shape [N].
        waistband: Vertices of the band that holds it up, shape [N].
        about: The shard's metadata of this garment: fabric, elastics, waistband, fastenings.
    """
    ratios = {int(number): float(loop["rest_ratio"]) for number, loop in (about.get("elastics") or {}).items()}
    scale = edge_scale(faces, elastic.astype(np.int64), ratios)
    band = about.get("waistband")
    if band:
        scale *= edge_scale(faces, np.where(waistband, WAISTBAND, 0), {WAISTBAND: float(band["rest_ratio"])})
    cords = [pair for held in (about.get("fastenings") or {}).values() for pair in held["cords"]]
    lengths = [length for held in (about.get("fastenings") or {}).values() for length in held["length_m"]]
    return Garment(
        name=name,
        vertices=np.asarray(vertices, np.float64),
        faces=np.asarray(faces, np.int32),
        fabric=Fabric.of(about["fabric"], name),
        rest_scale=scale,
        tied=np.asarray(waistband, bool),
        cords=np.array(cords, np.int32).reshape(-1, 2),
        cord_length=np.array(lengths, np.float64),
    )


def dress(
    garments: Sequence[Garment],
    body: PoseBody,
    body_faces: np.ndarray,
    *,
    rest_pose: np.ndarray,
    betas: np.ndarray,
    tight_betas: np.ndarray,
    pose: np.ndarray,
    trans: np.ndarray,
    vertices: np.ndarray,
    fps: float,
    config: SimulateConfig,
) -> tuple[Scene, Transition]:
    """The scene of `garments` (inner to outer) on a body.

    Args:
        garments: In the rest frame of the body with `tight_betas`.
        body: Poses the body; body_faces: shape [F, 3].
        rest_pose: Shape [K, 3]; betas, tight_betas: [B]; pose [T, K, 3]; trans [T, 3].
        vertices: The sequence's body [m], relative to trans, its skin parted from itself, shape [T, V, 3].
        fps: Frames a second.
        config: Speeds of the transition.
    """
    first = body(betas, np.asarray(pose[:1], np.float64), np.zeros((1, 3)))[0]
    way = make_transition(
        body,
        rest_pose,
        tight_betas,
        betas,
        pose,
        trans,
        vertices[0].astype(np.float64) - first,
        fps=fps,
        shape_speed=config.shape_speed,
        pose_speed=config.pose_speed,
        run_up=config.run_up,
        settle_frames=config.settle_frames,
    )
    before = len(way.vertices)

    def frame(k: int) -> np.ndarray:
        if k < before:
            return way.vertices[k]
        return vertices[k - before].astype(np.float64) + trans[k - before]

    start = np.concatenate([g.vertices @ way.turn.T + way.shift for g in garments])
    scene = Scene(
        garments=garments,
        start=start,
        body_faces=body_faces,
        body=frame,
        body_frames=before + len(vertices),
        frames=before + len(vertices) - 1,
        record=before,
        ease_in=way.shape_frames + way.settle_frames,
        fps=fps,
        velocity=way.velocity,
    )
    return scene, way


def split(x: np.ndarray, garments: Sequence[Garment], trans: np.ndarray) -> dict[str, np.ndarray]:
    """Positions x (T, N, 3) of all garments, as positions relative to `trans` (T, 3) by name."""
    parts = np.split(x - trans[:, None], np.cumsum([len(g.vertices) for g in garments])[:-1], axis=1)
    return {g.name: part for g, part in zip(garments, parts)}

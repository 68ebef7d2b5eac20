"""People of the pipeline's own: a body, an outfit made for it, and a clip, through the stages' own functions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.body import REST_POSE, load_free_body
from stages.body.figure import measure
from stages.body.hygiene import open_limbs
from stages.body.parts import divide
from stages.body.sequence import cut, embedded
from stages.fabrics import load_fabrics
from stages.outfit.config import Config as OutfitConfig
from stages.outfit.making import make_outfit
from stages.outfit.plan import draw_plan
from stages.outfit.resizing import tight_betas
from stages.simulate.config import SimulateConfig
from stages.simulate.outfit_scene import dress, make_garment
from stages.simulate.scene import Scene

FPS = 30.0
GAPS = 0.010, 0.008
"""Free space at arms and between legs [m]: less than a recipe's; the committed tables were measured with it."""


def person(
    gender: str,
    outfit: str,
    betas: tuple[float, ...] = (),
    tightness: tuple[float, float] | None = None,
    motion: str = "walk",
    start: int = 0,
    frames: int = 30,
    edge: float = 0.01,
    config: SimulateConfig | None = None,
) -> Scene:
    """A dressed person in motion, transition included.

    Args:
        gender: Of the embedded body.
        outfit: Kind of outfit; its cut is drawn, always the same.
        betas: First shape coefficients; the others are 0.
        tightness: Of both components; drawn if left out.
        motion: Embedded clip; start: its first frame; frames: how many.
        edge: Edge length of the garments [m].
        config: Speeds of the transition.
    """
    model = load_free_body(gender)
    shape = np.zeros(10)
    shape[: len(betas)] = betas
    settings = OutfitConfig(edge_length=edge)
    plan = draw_plan(outfit, settings, np.random.default_rng(7))
    if tightness is not None:
        plan = replace(plan, tightness=tightness)
    made = make_outfit(plan, model, shape, settings, load_fabrics(), lambda label: None)
    clip = cut(embedded(measure(model, shape), motion), start, frames, motion, whole=True)
    clip, _ = open_limbs(measure(model, shape), divide(model, shape), clip, GAPS)
    scene, _ = dress(
        [make_garment(g.plan.name, g.vertices, g.faces, g.elastic, g.waistband, g.attrs) for g in made],
        model.pose,
        model.faces,
        rest_pose=REST_POSE,
        betas=shape,
        tight_betas=tight_betas(shape, plan.tightness),
        pose=clip.pose,
        trans=clip.trans,
        vertices=model.pose(shape, clip.pose, np.zeros_like(clip.trans)),
        fps=FPS,
        config=config or SimulateConfig(),
    )
    return scene

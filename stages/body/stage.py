"""The shell of the body stage: draws a person, reads or makes the motion, frees the limbs, publishes the sequence."""

from pathlib import Path
from typing import Any

import numpy as np

from model.body import REST_POSE
from stages.body import SPEC
from stages.body.acquire import acquire
from stages.body.config import Config
from stages.body.figure import measure
from stages.body.hygiene import open_limbs
from stages.body.motion import FPS
from stages.body.parts import divide
from stages.body.sampling import draw_betas
from stages.body.sequence import judge, stand_at_rest
from stages.body_model import body_model_attrs, load_body_model
from stages.settings import build
from stages.spec import Progress, Task
from store import publish


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Makes the body of one item and publishes it.

    Args:
        task: The task; `params` holds gender and, for a sequence, motion, motion_sha256, action, start and
            frames.
        progress: Told the step at hand.

    Returns:
        Figures for the receipt.

    Raises:
        DataError: The motion can't be used, or the person's limbs can't be freed.
    """
    config = build(Config, task.config)
    model = load_body_model(task.params)
    betas = draw_betas(config.shape_range, config.betas, np.random.default_rng(task.seed))
    name, action, motion = "rest", "rest", stand_at_rest()
    figures: dict[str, float] = {}
    if task.kind == "sequence":
        figure = measure(model, betas)
        motion, name, action = acquire(figure, task.params, config.joints, config.rate)
        progress(1, 16, "the motion is on the person")
        rounds = iter(range(2, 16))
        gaps = config.arm_gap, config.leg_gap
        motion, opening = open_limbs(
            figure, divide(model, betas), motion, gaps, lambda label: progress(next(rounds), 16, label)
        )
        figures = judge(opening, config.smallest_gap, config.largest_turn, config.largest_shift, task.item)
    arrays = {
        "betas": betas,
        "pose": motion.pose,
        "trans": motion.trans,
        "rest_pose": REST_POSE,
        "faces": model.faces,
        "vertices": model.pose(betas, motion.pose, np.zeros_like(motion.trans)),
        "rest_vertices": model.pose(betas, REST_POSE[None], np.zeros((1, 3)))[0],
    }
    attrs = {"gender": model.gender, "motion": name, "action": action, "fps": FPS, "kind": task.kind}
    attrs |= body_model_attrs(task.params)
    publish(Path(task.output), SPEC.schema, task.key, arrays, attrs | {"seed": task.seed, "opening": figures})
    progress(16, 16, "published")
    return {"frames": len(motion), "action": action, **figures}

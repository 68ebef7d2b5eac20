"""The shell of the body stage: draws a person, reads or makes the motion, frees the body, publishes the sequence."""

from pathlib import Path
from typing import Any

import numpy as np

from model.body import REST_POSE
from stages.body import SPEC
from stages.body.acquire import Performance, acquire
from stages.body.config import Config
from stages.body.failure import record_failure
from stages.body.figure import Figure
from stages.body.freeing import UnsolvableError, free_body
from stages.body.motion import FPS, Motion
from stages.body.sampling import draw_betas
from stages.body.sequence import stand_at_rest
from stages.body_model import body_model_attrs, load_body_model
from stages.settings import build
from stages.spec import Progress, Task
from store import publish

STEPS = 60
"""More than there are steps to tell about."""

REST = Performance(motion="rest", action="rest", mended="", on=lambda figure: stand_at_rest())
"""What people without a motion do."""


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Makes the body of one item and publishes it.

    Args:
        task: The task; `params` holds gender and, for a sequence, motion, motion_sha256, action, start and
            frames.
        progress: Told the step at hand.

    Returns:
        Figures for the receipt.

    Raises:
        DataError: The motion can't be used, or the body's collisions can't be solved; of the latter a picture and the
            circumstances are left in `failures`.
    """
    config = build(Config, task.config)
    model = load_body_model(task.params)
    betas = draw_betas(config.shape_range, config.betas, np.random.default_rng(task.seed))
    still = task.kind != "sequence"
    performance = REST if still else acquire(task.params, config.joints, config.rate)
    about = {"motion": performance.motion, "action": performance.action}
    if not still:
        about["mended"] = performance.mended
    steps = iter(range(1, STEPS))

    def move(figure: Figure) -> Motion:
        motion = performance.on(figure)
        tell("the motion is on the person")
        return motion

    def tell(label: str) -> None:
        progress(next(steps, STEPS - 1), STEPS, label)

    try:
        freed = free_body(model, betas, move, config, task.item, still=still, tell=tell)
    except UnsolvableError as error:
        known = about | {"seed": task.seed, "betas": betas.tolist(), "gender": model.gender}
        record_failure(Path(task.output), task.item, model.faces, error, known)
        raise
    arrays = {
        "betas": freed.betas,
        "pose": freed.motion.pose,
        "trans": freed.motion.trans,
        "rest_pose": REST_POSE,
        "faces": model.faces,
        "face_kept": freed.face_kept,
        "vertices": freed.vertices,
        "rest_vertices": model.pose(freed.betas, REST_POSE[None], np.zeros((1, 3)))[0],
    }
    arrays |= {f"collision/{name}": values for name, values in freed.moved.items()}
    attrs = {"gender": model.gender, **about, "fps": FPS, "kind": task.kind, "seed": task.seed}
    attrs |= body_model_attrs(task.params) | {"opening": freed.opening, "collision": freed.record}
    publish(Path(task.output), SPEC.schema, task.key, arrays, attrs)
    progress(STEPS, STEPS, "published")
    return {"frames": len(freed.motion), "action": about["action"], **freed.opening, "collision": freed.record["case"]}

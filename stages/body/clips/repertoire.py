"""The embedded clips by name, and how one is performed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.clips import dance, jump, run, squat, turn, walk
from stages.body.figure import Figure
from stages.body.motion import FPS, Motion
from stages.body.posture import Posture, assemble

Array = NDArray[np.float64]
Contacts = tuple[NDArray[np.bool_], NDArray[np.bool_]]

FINE = 8
"""Moments per published frame at which a clip is made: the ends of footfalls lie between frames."""


@dataclass(frozen=True)
class Clip:
    """One embedded motion."""

    act: Callable[[Figure, Array], tuple[Posture, Contacts]]
    """Makes the posture and the foot contacts of a person at given times [s]."""
    seconds: float
    """Length [s]."""
    action: str
    """Label of the action."""


CLIPS: dict[str, Clip] = {
    "walk": Clip(walk.walk, walk.SECONDS, "walking"),
    "run": Clip(run.run, run.SECONDS, "running"),
    "jump": Clip(jump.jump, jump.SECONDS, "jumping"),
    "squat": Clip(squat.squat, squat.SECONDS, "squatting"),
    "turn": Clip(turn.turn, turn.SECONDS, "turning"),
    "dance": Clip(dance.dance, dance.SECONDS, "dancing"),
}


def perform(figure: Figure, name: str) -> Motion:
    """Lets a person perform an embedded clip.

    Args:
        figure: The person.
        name: Name of the clip.

    Returns:
        The whole clip at 30 fps.
    """
    clip = CLIPS[name]
    frames = round(clip.seconds * FPS)
    times = np.arange((frames - 1) * FINE + 1) / (FPS * FINE)
    posture, planted = clip.act(figure, times)
    pose, trans, _ = assemble(figure, posture)
    return Motion(pose=pose[::FINE], trans=trans[::FINE], planted=np.stack(planted, axis=-1)[::FINE])

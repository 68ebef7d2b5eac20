"""From an embedded clip or a recording to the frames that were asked for, on one person, ready to be dressed."""

from dataclasses import replace

import numpy as np

from model.body import REST_POSE
from stages.body.clips import CLIPS, perform
from stages.body.figure import Figure
from stages.body.grounding import ground
from stages.body.motion import Motion
from stages.body.recording import Recording
from stages.body.repair import drop_fake_start, mend_flips
from stages.body.resample import resample
from stages.body.retarget import local_rotations, retarget
from stages.body.root_order import mend_root_order
from stages.body.turns import WORLD_FROM_MODEL, axis_angle
from stages.spec import DataError


def stand_at_rest() -> Motion:
    """The rest pose, one frame, the root joint at the origin."""
    return Motion(pose=REST_POSE[None].copy(), trans=np.zeros((1, 3)), planted=np.ones((1, 2), dtype=bool))


def embedded(figure: Figure, name: str) -> Motion:
    """A whole embedded clip.

    Args:
        figure: The person.
        name: Name of the clip.

    Returns:
        The motion.

    Raises:
        DataError: There is no such clip.
    """
    if name not in CLIPS:
        raise DataError(f"motion must be one of {', '.join(CLIPS)} or a motion file, got {name!r}")
    return perform(figure, name)


def prepared(recording: Recording, name: str) -> tuple[Recording, list[str]]:
    """A whole recording, mended and at 30 fps.

    Args:
        recording: The motion as it was read.
        name: Name of the motion, for errors.

    Returns:
        The recording, and what was wrong with it and is mended.

    Raises:
        DataError: The skeleton is not that of a person who can be recognised.
    """
    started = drop_fake_start(recording)
    ordered, reordered = mend_root_order(started, name)
    steady, flips = mend_flips(ordered)
    mended = ["a fake first frame is dropped"] if started is not recording else []
    if reordered:
        mended.append("the root's angles are put together in the order that they were meant in")
    if flips:
        mended.append(f"{flips} frames in which the root flips are bridged")
    return resample(steady), mended


def put_on(figure: Figure, recording: Recording, name: str) -> Motion:
    """A prepared recording on a person, stood on the ground.

    Args:
        figure: The person.
        recording: The motion, mended and at 30 fps.
        name: Name of the motion, for errors.

    Returns:
        The motion.

    Raises:
        DataError: The skeleton is not that of a person who can be recognised.
    """
    world, root, planted = ground(figure, *retarget(recording, figure, name))
    local = local_rotations(world)
    local[:, 0] = WORLD_FROM_MODEL @ local[:, 0]
    return Motion(pose=axis_angle(local), trans=root @ WORLD_FROM_MODEL.T, planted=planted)


def cut(motion: Motion, start: int, frames: int, name: str, *, whole: bool) -> Motion:
    """The frames asked for, moved so that the first one stands over the origin.

    Args:
        motion: A motion.
        start: First frame.
        frames: Number of frames.
        name: Name of the motion, for errors.
        whole: Whether all of them must be there; else the motion may end earlier.

    Returns:
        The part of the motion.

    Raises:
        DataError: The motion is too short.
    """
    length = len(motion)
    if start < 0 or frames < 1 or start >= length or (whole and start + frames > length):
        raise DataError(f"{name}: frames {start} to {start + frames - 1} wanted, it has {length}; ask for fewer")
    part = motion.cut(slice(start, start + frames))
    return replace(part, trans=part.trans - [*part.trans[0, :2], 0.0])

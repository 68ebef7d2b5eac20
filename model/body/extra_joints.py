"""From the joints of SMPL-H and SMPL-X to the 24 of SMPL.

SMPL's joints 0 to 21 are the same in all three. Its hands, 22 and 23, are the knuckles of the middle fingers in the
others. The joints that are left out don't move any more, each goes with the nearest joint above it that is kept:

- fingers but thumbs: with the hand; its weights are the sum of theirs;
- thumbs: with the wrist, so that they stay where SMPL's hands bend, as those of the free body do;
- jaw and eyes: with the head.

While the joints left out are at rest, and hands don't turn at their knuckles, the body is the same to the last vertex.
Pose correctives of joints that are left out would be multiplied by 0 and are dropped; those of the hands, too, as the
other models have none for a hand that bends as one.
"""

import numpy as np
from numpy.typing import NDArray

from model.body.refusal import BodyFileError
from model.body.skeleton import JOINT_NAMES, PARENTS

KEPT = {"SMPL": 24, "SMPL-H": 52, "SMPL-X": 55}
"""Number of joints of each model."""

BODY = 22
"""Joints that all three have in common: all but SMPL's hands."""

FINGERS = ("index", "middle", "pinky", "ring", "thumb")
"""Order of a hand's fingers, three joints each, in SMPL-H and SMPL-X."""

_HEAD, _WRISTS, _HANDS = 15, (20, 21), (22, 23)
_ROOTS = (-1.0, 2.0**32 - 1, 2.0**64)
_REMEDY = "name a file of SMPL, SMPL-H or SMPL-X"


def tree_of(table: NDArray[np.float64]) -> NDArray[np.int64]:
    """The kinematic tree of a file.

    Args:
        table: `kintree_table`: parents above joints, shape [2, K]; the root's parent is -1, or 4294967295 or
            18446744073709551615, the same number without a sign.

    Returns:
        Parent of each joint in the order of the columns, -1 for the root, shape [K].

    Raises:
        BodyFileError: It isn't a tree, or none of SMPL, SMPL-H and SMPL-X.
    """
    above, below = table
    count = len(below)
    if count not in KEPT.values():
        known = ", ".join(f"{number} ({name})" for name, number in KEPT.items())
        raise BodyFileError(f"kintree_table has {count} joints, must be {known}; {_REMEDY}")
    column = {float(joint): k for k, joint in enumerate(below)}
    if len(column) != count:
        raise BodyFileError(f"kintree_table names {len(column)} joints in {count} columns; {_REMEDY}")
    roots = np.flatnonzero(np.isin(above, _ROOTS))
    if len(roots) != 1:
        raise BodyFileError(f"kintree_table has {len(roots)} roots, must be one (parent -1 or 4294967295); {_REMEDY}")
    parents = np.full(count, -1, np.int64)
    for k in range(count):
        if k != roots[0]:
            if float(above[k]) not in column:
                raise BodyFileError(f"kintree_table: joint {k} hangs on {above[k]:g}, which is no joint; {_REMEDY}")
            parents[k] = column[float(above[k])]
    for k in range(count):
        joint, steps = k, 0
        while joint >= 0:
            joint, steps = int(parents[joint]), steps + 1
            if steps > count:
                raise BodyFileError(f"kintree_table has a cycle: joint {k} never reaches the root; {_REMEDY}")
    expected = _expected(count)
    if (parents != expected).any():
        k = int((parents != expected).argmax())
        name = JOINT_NAMES[k] if k < BODY else "an extra joint"
        raise BodyFileError(
            f"kintree_table: joint {k} ({name}) hangs on {parents[k]}, in such a model on {expected[k]}; {_REMEDY}"
        )
    return parents


def kept_joints(count: int) -> NDArray[np.int64]:
    """The joint that stands for each of SMPL's 24, in a model of `count` joints."""
    if count == len(PARENTS):
        return np.arange(count)
    knuckles = [_first_finger(count) + 15 * side + 3 * FINGERS.index("middle") for side in (0, 1)]
    return np.array([*range(BODY), *knuckles])


def fold_weights(weights: NDArray[np.float64], parents: NDArray[np.int64]) -> NDArray[np.float64]:
    """Skinning weights [V, 24] from weights [V, K]: those of the joints left out go to the joint they go with."""
    count = len(parents)
    if count == len(PARENTS):
        return weights
    folded = np.zeros((len(weights), len(PARENTS)))
    for joint, kept in enumerate(_carriers(count)):
        folded[:, kept] += weights[:, joint]
    return folded


def fold_correctives(posedirs: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Pose correctives [V, 3, 207] from those of `count` joints, [V, 3, 9 (count - 1)]."""
    if count == len(PARENTS):
        return posedirs
    features = 9 * (len(PARENTS) - 1)
    folded = np.zeros((*posedirs.shape[:2], features))
    folded[..., : 9 * (BODY - 1)] = posedirs[..., : 9 * (BODY - 1)]
    return folded


def _first_finger(count: int) -> int:
    """The first joint of the left hand."""
    return count - 2 * 3 * len(FINGERS)


def _carriers(count: int) -> list[int]:
    """The joint of SMPL's that each joint goes with."""
    face = _first_finger(count) - BODY
    hands = [
        _WRISTS[side] if finger == "thumb" else _HANDS[side] for side in (0, 1) for finger in FINGERS for _ in range(3)
    ]
    return [*range(BODY), *[_HEAD] * face, *hands]


def _expected(count: int) -> NDArray[np.int64]:
    """Parents of a model of `count` joints."""
    if count == len(PARENTS):
        return PARENTS.astype(np.int64)
    first = _first_finger(count)
    parents = [*PARENTS[:BODY].tolist(), *[_HEAD] * (first - BODY)]
    for side in (0, 1):
        for finger in range(len(FINGERS)):
            start = first + 15 * side + 3 * finger
            parents += [_WRISTS[side], start, start + 1]
    return np.array(parents)

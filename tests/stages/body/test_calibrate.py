"""Skeletons whose rest pose is no person's, such as LAFAN1's, move the body as the same motion with a T-pose does."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.body import BodyModel
from stages.body.fidelity import compare
from stages.body.figure import Figure
from stages.body.readers import read_motion
from stages.body.recording import Recording
from stages.body.retarget import axes_of, joint_positions, retarget
from stages.body.sequence import prepared, put_on
from tests.stages.body.test_root_order import as_recording

Person = tuple[BodyModel, np.ndarray, Figure]


def disguised(recording: Recording, own: np.ndarray) -> Recording:
    """The same motion with other axes in each joint: G_j Q_j in place of G_j, shape of `own` [J, 3, 3]."""
    before = [np.eye(3) if p < 0 else own[p] for p in recording.parents]
    undo = np.swapaxes(np.stack(before), -1, -2)
    first = recording.parents < 0
    moved = np.einsum("jab,fjb->fja", undo, recording.translations)
    return replace(
        recording,
        rotations=undo @ recording.rotations @ own,
        translations=np.where(first[None, :, None], recording.translations, moved),
        offsets=np.where(first[:, None], recording.offsets, np.einsum("jab,jb->ja", undo, recording.offsets)),
    )


def along_x(recording: Recording) -> np.ndarray:
    """Axes as LAFAN1 has them: each bone points along its joint's x."""
    out = np.broadcast_to(np.eye(3), (len(recording.names), 3, 3)).copy()
    for j in range(len(recording.names)):
        children = [k for k, parent in enumerate(recording.parents) if parent == j]
        if children and j:
            bone = recording.offsets[children[0]] / np.linalg.norm(recording.offsets[children[0]])
            out[j] = Rotation.align_vectors(bone[None], [[1.0, 0.0, 0.0]])[0].as_matrix()
    return out


@pytest.mark.parametrize("kind", ["at random", "along x"])
@pytest.mark.parametrize("clip", ["walk", "dance"])
def test_axes_are_found_in_the_motion(kind: str, clip: str, woman: Person) -> None:
    _, _, figure = woman
    plain = as_recording(figure, clip, 0.6)
    own = Rotation.random(24, random_state=3).as_matrix() if kind == "at random" else along_x(plain)
    hidden = disguised(plain, own)
    np.testing.assert_allclose(hidden.forward()[1], plain.forward()[1], atol=1e-9)
    wanted, found = retarget(plain, figure, "plain"), retarget(hidden, figure, "hidden")
    # Which way the person looked at first is no matter; here both have the same axes up.
    turn = axes_of(hidden, "hidden") @ axes_of(plain, "plain").T
    off = np.swapaxes(turn @ wanted[0], -1, -2) @ found[0]
    angles = np.degrees(Rotation.from_matrix(off.reshape(-1, 3, 3)).magnitude()).reshape(-1, 24)
    assert angles[:, 0].max() < 1.0
    # Positions follow exactly along the limbs; how a joint lies about its own bone is known from its bends.
    ours = joint_positions(figure, *found)
    theirs = joint_positions(figure, turn @ wanted[0], wanted[1] @ turn.T)
    for joint in (4, 5, 7, 8, 18, 19, 20, 21):
        assert np.linalg.norm(ours[:, joint] - theirs[:, joint], axis=-1).max() < 0.02
    assert angles[:, [1, 2, 4, 5, 16, 17, 18, 19]].mean(axis=0).max() < 1.5
    assert angles[:, [3, 6, 9, 12, 15]].mean(axis=0).max() < 6 and angles[:, [7, 8, 20, 21]].mean(axis=0).max() < 9


def test_a_real_capture_in_other_axes(captures: Path, woman: Person) -> None:
    """A clip of CMU's with bones along x has the same limbs, feet and ground as with its own axes."""
    _, _, figure = woman
    plain = read_motion(captures / "walking_1.bvh")
    own = Rotation.random(len(plain.names), random_state=1).as_matrix()
    at_30, _ = prepared(disguised(plain, own), "walking_1")
    figures = compare(figure, put_on(figure, at_30, "walking_1"), at_30, "walking_1")
    assert figures.direction < 3 and figures.slide < 1 and figures.planted > 0.95

"""The README's picture: who stands where, turned which way."""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from stages.report.gather import Person

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

from showcase import MOMENTS, SPACING, TURNS, figures


def walker(toward):
    """A person of one triangle, whose first corner is ahead of the root, walking along `toward` [rad] for 11 frames."""
    ahead = np.array([np.cos(toward), np.sin(toward), 0.0])
    turn = np.array([0.0, 0.0, toward + 0.5 * np.pi])
    upright = np.array([0.5 * np.pi, 0.0, 0.0])
    pose = np.zeros((11, 24, 3), dtype=np.float32)
    pose[:, 0] = compose(turn, upright)
    vertices = np.tile([ahead, [0, 0, 1], [0, 0, -1]], (11, 1, 1)).astype(np.float32)
    trans = (0.2 * np.arange(11)[:, None] * ahead + [0, 0, 0.9]).astype(np.float32)
    return Person(
        item="w",
        body={},
        outfit={},
        simulation={},
        betas=np.zeros(10),
        pose=pose,
        trans=trans,
        vertices=vertices,
        faces=np.array([[0, 1, 2]], dtype=np.int32),
        garments=[],
    )


def compose(after, before):
    """Rotation vector of `before`, then `after`."""
    return (Rotation.from_rotvec(after) * Rotation.from_rotvec(before)).as_rotvec()


def test_people_stand_in_a_row_and_face_the_camera_whatever_way_they_walk():
    meshes = figures([walker(0.3), walker(2.5)])
    assert len(meshes) == 2 * len(MOMENTS)
    for place, mesh in enumerate(meshes):
        root = np.array([(place - 1.5) * SPACING, 0.0, 0.9])
        nose = np.asarray(mesh.vertices)[0] - root
        angle = -0.5 * np.pi + np.radians(TURNS[place % 2])
        np.testing.assert_allclose(nose, [np.cos(angle), np.sin(angle), 0.0], atol=1e-6)

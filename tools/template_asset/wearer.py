"""The mean body in the rest pose, and the measures that a tailor takes of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model.body import JOINT_NAMES, REST_POSE, BodyModel, joint_positions

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Wearer:
    """A body that stands in the rest frame: z up, facing -y, root joint at the origin."""

    vertices: Array
    """Vertices [m], shape [V, 3]."""
    points: Array
    """Vertices, edge midpoints and face centres of it and of its mirror image [m], shape [n, 3]."""
    joints: Array
    """Joints [m], shape [24, 3]."""

    @classmethod
    def of(cls, model: BodyModel) -> "Wearer":
        """The mean body of a model."""
        betas, origin = np.zeros(model.beta_count), np.zeros((1, 3))
        vertices = model.pose(betas, REST_POSE[None], origin)[0].astype(np.float64)
        joints = joint_positions(model.shape(betas)[1], model.parents, REST_POSE[None], origin)[0]
        corners = vertices[model.faces]
        middles = [(corners + np.roll(corners, 1, axis=1)).reshape(-1, 3) / 2, corners.mean(axis=1)]
        points = np.concatenate([vertices, *middles])
        return cls(vertices, np.concatenate([points, points * [-1, 1, 1]]), joints)

    def joint(self, name: str) -> Array:
        """Position of a joint [m], shape [3]."""
        return self.joints[JOINT_NAMES.index(name)]

    @property
    def crotch(self) -> float:
        """Height where the legs part [m]: the lowest point on the mid-plane."""
        near = self.points[np.abs(self.points[:, 0]) < 0.004]
        return float(near[:, 2].min())

    def girth_height(self, low: float, high: float, narrowest: bool) -> float:
        """Height between `low` and `high` [m] where the trunk is narrowest or widest, seen from the front."""
        heights = np.arange(low, high, 0.005)
        widths = []
        for z in heights:
            ring = self.points[np.abs(self.points[:, 2] - z) < 0.006]
            widths.append(np.ptp(ring[np.abs(ring[:, 0]) < 0.3, 0]))
        return float(heights[int(np.argmin(widths) if narrowest else np.argmax(widths))])

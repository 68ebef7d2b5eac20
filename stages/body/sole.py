"""How a foot stands and rolls on the ground: heel, flat, ball, toes, without sliding and without sinking in.

Pitch is the rotation of the foot about the lateral axis: negative lifts the toes, positive lifts the heel. With the
toes up the foot rolls on the heel: the point of contact of a rolling body is at rest, hence the ankle moves by
dz = h dpitch, where h is its height over the ground. With the heel up the toes stay flat and the foot turns about its
ball.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.figure import SIDES, Figure
from stages.body.turns import rotate, turn

Array = NDArray[np.float64]

STEEPEST_HEEL_STRIKE = np.deg2rad(45.0)
"""Range of the table of the heel's rolling [rad]."""


@dataclass(frozen=True, eq=False)
class Sole:
    """The ground contact of one foot."""

    side: float
    """1 for the left foot, -1 for the right."""
    points: Array
    """Points that can touch the ground, relative to the ankle [m], shape [S, 3]."""
    toe_weights: Array
    """Share of the toe joint in each point's motion, shape [S]."""
    ball: Array
    """Vector from the ankle to the ball [m], shape [3]."""
    pitches: Array
    """Pitches of the table, from most negative to 0 [rad], shape [P]."""
    heights: Array
    """Height of the ankle when the foot touches at that pitch [m], shape [P]."""
    rolled: Array
    """How far the ankle has rolled forward, from flat [m], shape [P]."""

    def lowest(self, pitch: Array, toe: Array) -> Array:
        """Height of the lowest point of the foot relative to the ankle [m], shape [T].

        Args:
            pitch: Pitch of the foot [rad], shape [T].
            toe: Rotation of the toe joint [rad], negative bends the toes up, shape [T].
        """
        bent = rotate(turn("x", toe)[:, None], self.points - self.ball) + self.ball
        w = self.toe_weights[:, None]
        mixed = w * bent + (1 - w) * self.points
        return (np.cos(pitch)[:, None] * mixed[..., 1] - np.sin(pitch)[:, None] * mixed[..., 2]).min(axis=1)

    def standing(self, pitch: Array) -> Array:
        """Ankle of a foot that touches the ground, relative to where it is on the ground when flat.

        Args:
            pitch: Pitch of the foot [rad], shape [T].

        Returns:
            Offsets [m] (x 0, y height over the ground, z forward), shape [T, 3].
        """
        heel = np.minimum(pitch, 0.0)
        out = np.zeros((len(pitch), 3))
        out[:, 1] = np.interp(heel, self.pitches, self.heights)
        out[:, 2] = np.interp(heel, self.pitches, self.rolled)
        lift = rotate(turn("x", np.maximum(pitch, 0.0)), -self.ball) + self.ball
        out[:, 1:] += lift[:, 1:]
        return out


def measure_sole(figure: Figure, side: int) -> Sole:
    """Tabulates how the foot of one side rolls (side 0 is left)."""
    points, ball = figure.soles[side], figure.ball(side)
    pitches = np.linspace(-STEEPEST_HEEL_STRIKE, 0.0, 1801)
    heights = -(np.cos(pitches)[:, None] * points[:, 1] - np.sin(pitches)[:, None] * points[:, 2]).min(axis=1)
    steps = np.diff(pitches) * (heights[1:] + heights[:-1]) / 2
    rolled = -np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
    return Sole(
        side=SIDES[side],
        points=points,
        toe_weights=figure.toe_weights[side],
        ball=ball,
        pitches=pitches,
        heights=heights,
        rolled=rolled,
    )

"""A keyed performance: plants of the feet and curves of the body, put together into a posture."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.footfalls import Plant, Swing, track
from stages.body.clips.footing import ceiling, give_way
from stages.body.clips.keys import ease
from stages.body.figure import Figure
from stages.body.posture import Arm, Posture
from stages.body.sole import measure_sole
from stages.body.turns import turn

Array = NDArray[np.float64]
Keys = Sequence[tuple[float, float]]

SOFT_KNEE = np.deg2rad(9.0)
"""Bend that standing knees keep [rad]."""


@dataclass(kw_only=True)
class ArmKeys:
    """Keys of one arm: (time [s], angle [degrees]); see `stages.body.posture.Arm`."""

    out: Keys
    forward: Keys
    elbow: Keys
    twist: Keys = ((0.0, 8.0),)
    wrist: Keys = ((0.0, 6.0),)

    def at(self, times: Array) -> Arm:
        """The arm at given times [s], shape [T]."""
        names = ("out", "forward", "elbow", "twist", "wrist")
        return Arm(**{name: np.deg2rad(ease(times, getattr(self, name))) for name in names})


@dataclass(kw_only=True)
class Choreography:
    """Everything that a keyed clip says; curves are samples at the clip's times, shape [T], angles in radians."""

    times: Array
    """[s]"""
    plants: tuple[list[Plant], list[Plant]]
    """Plants of the left and right foot."""
    swings: tuple[list[Swing], list[Swing]]
    """The swings between them."""
    root: Array
    """Path of the root joint [m], shape [T, 3]."""
    yaw: Array
    """Heading of the pelvis, positive to the left."""
    tilt: Array
    """Forward tilt of the pelvis."""
    lean: Array
    """Sideways lean of the pelvis, positive to the right."""
    bend: Array
    """Forward bend of the chest relative to the pelvis."""
    twist: Array
    """Turn of the chest relative to the pelvis, positive to the left."""
    side: Array
    """Sideways bend of the chest relative to the pelvis, positive to the right."""
    look: Array
    """Heading of the head, positive to the left."""
    nod: Array
    """Forward tilt of the head."""
    arms: tuple[Arm, Arm]
    """Left and right arm."""
    knees_out: Array | float = field(default=0.1)
    """Heading of the knees away from the pelvis, outward."""

    def stage(self, figure: Figure) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
        """Solves the feet and lowers the pelvis where the legs would not reach.

        Args:
            figure: The person.

        Returns:
            The posture, and when the left and the right foot are on the ground.
        """
        soles = measure_sole(figure, 0), measure_sole(figure, 1)
        pelvis = turn("y", self.yaw) @ turn("z", self.lean) @ turn("x", self.tilt)
        root = self.root.copy()
        limit = ceiling(figure, soles, self.plants, self.times, root, pelvis, SOFT_KNEE)
        root[:, 1] = give_way(root[:, 1], limit, float(self.times[1] - self.times[0]))
        feet = [track(figure, i, self.plants[i], self.swings[i], self.times, root, pelvis, self.yaw) for i in (0, 1)]
        posture = Posture(
            root=root,
            pelvis=pelvis,
            ankles=(feet[0].ankle, feet[1].ankle),
            feet=(feet[0].rotation, feet[1].rotation),
            toes=(feet[0].toe, feet[1].toe),
            knees_out=np.broadcast_to(self.knees_out, self.times.shape),
            trunk=np.stack([self.bend, self.twist, self.side], axis=-1),
            gaze=turn("y", self.look) @ turn("x", self.nod),
            arms=self.arms,
        )
        return posture, (feet[0].planted, feet[1].planted)


def standing_height(figure: Figure, depth: float = 0.0) -> float:
    """Height of the root joint over flat feet with soft knees [m], lowered by `depth` leg lengths."""
    drop = figure.joints[0, 1] - figure.joints[1, 1]
    longest = figure.leg_length * np.cos(SOFT_KNEE / 2)
    return float(np.mean(figure.ankle_heights) + drop + longest - depth * figure.leg_length)

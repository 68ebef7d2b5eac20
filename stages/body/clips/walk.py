"""A relaxed walk along a gentle curve."""

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.footfalls import Swing
from stages.body.clips.gait import Gait, go
from stages.body.figure import Figure
from stages.body.posture import Posture

SECONDS = 12.0
"""Length of the clip [s]."""

WALK = Gait(
    speed=1.38,
    cycle=1.17,
    duty=0.605,
    strike=np.deg2rad(-20),
    settle=0.18,
    leave=np.deg2rad(50),
    peel=0.42,
    ahead=-0.115,
    narrowing=1.0,
    bounce=0.027,
    crouch=0.0,
    swing=Swing(
        forward=((0.5, 0.02), (0.8, 0.345)),
        height=((0.22, 0.15), (0.55, 0.065), (0.80, 0.045)),
        pitch=((0.16, np.deg2rad(64)), (0.55, np.deg2rad(6)), (0.80, np.deg2rad(-14))),
    ),
    sway=0.022,
    pelvis=(np.deg2rad(2), np.deg2rad(5), np.deg2rad(4)),
    chest=(np.deg2rad(2), np.deg2rad(9), np.deg2rad(4)),
    toe_out=np.deg2rad(5),
    arm_out=np.deg2rad(15),
    arm_swing=(np.deg2rad(2), np.deg2rad(21)),
    elbow=(np.deg2rad(26), np.deg2rad(13)),
    arm_twist=np.deg2rad(16),
)


def walk(figure: Figure, times: NDArray[np.float64]) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """The posture of a walk, and when each foot is on the ground; `times` [s], shape [T]."""
    return go(figure, WALK, times, lambda t: 0.30 * np.sin(2 * np.pi * t / SECONDS))

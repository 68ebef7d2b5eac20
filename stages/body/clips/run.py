"""An easy run: a phase of flight in every step, forefoot and heel rolling through."""

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.footfalls import Swing
from stages.body.clips.gait import Gait, go
from stages.body.figure import Figure
from stages.body.posture import Posture

SECONDS = 10.0
"""Length of the clip [s]."""

RUN = Gait(
    speed=3.05,
    cycle=0.78,
    duty=0.335,
    strike=np.deg2rad(-8),
    settle=0.15,
    leave=np.deg2rad(52),
    peel=0.48,
    ahead=-0.19,
    narrowing=0.85,
    bounce=0.0,
    crouch=0.016,
    swing=Swing(
        height=((0.30, 0.32), (0.55, 0.24), (0.80, 0.10)),
        forward=((0.30, -0.42), (0.55, 0.0), (0.82, 0.26)),
        pitch=((0.25, np.deg2rad(88)), (0.55, np.deg2rad(48)), (0.82, np.deg2rad(-4))),
    ),
    sway=0.008,
    pelvis=(np.deg2rad(5), np.deg2rad(7), np.deg2rad(4)),
    chest=(np.deg2rad(8), np.deg2rad(18), np.deg2rad(4)),
    toe_out=np.deg2rad(4),
    arm_out=np.deg2rad(20),
    arm_swing=(np.deg2rad(-6), np.deg2rad(34)),
    elbow=(np.deg2rad(84), np.deg2rad(12)),
    arm_twist=np.deg2rad(8),
)


def run(figure: Figure, times: NDArray[np.float64]) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """The posture of a run, and when each foot is on the ground; `times` [s], shape [T]."""
    return go(figure, RUN, times, lambda t: 0.35 * np.sin(2 * np.pi * t / SECONDS))

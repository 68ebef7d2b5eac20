"""Hand-made skeletons and motions, written as BVH text."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Made:
    """A skeleton with the angles of its motion."""

    names: list[str]
    parents: list[int]
    offsets: Array
    orders: list[str]
    """Order of the Euler channels of each joint, outermost first, such as "ZYX"."""
    angles: Array
    """Angle of each channel [degrees], shape [F, J, 3]."""
    root: Array
    """Root positions, shape [F, 3]."""
    frame_time: float

    def text(self) -> str:
        """The BVH file."""
        lines = ["HIERARCHY"]
        self._joint(0, lines, 0)
        lines += ["MOTION", f"Frames: {len(self.root)}", f"Frame Time: {self.frame_time:.7f}"]
        order = self._depth_first(0)
        for frame in range(len(self.root)):
            values = [*self.root[frame], *(a for j in order for a in self.angles[frame, j])]
            lines.append(" ".join(f"{v:.9g}" for v in values))
        return "\n".join(lines) + "\n"

    def _children(self, joint: int) -> list[int]:
        return [k for k, parent in enumerate(self.parents) if parent == joint]

    def _depth_first(self, joint: int) -> list[int]:
        return [joint, *(d for child in self._children(joint) for d in self._depth_first(child))]

    def _joint(self, joint: int, lines: list[str], depth: int) -> None:
        pad = "\t" * depth
        lines += [f"{pad}{'JOINT' if depth else 'ROOT'} {self.names[joint]}", f"{pad}{{"]
        offset = " ".join(f"{v:.9g}" for v in self.offsets[joint])
        channels = [f"{axis}rotation" for axis in self.orders[joint]]
        if not depth:
            channels = ["Xposition", "Yposition", "Zposition", *channels]
        lines += [f"{pad}\tOFFSET {offset}", f"{pad}\tCHANNELS {len(channels)} {' '.join(channels)}"]
        for child in self._children(joint):
            self._joint(child, lines, depth + 1)
        if not self._children(joint):
            lines += [f"{pad}\tEnd Site", f"{pad}\t{{", f"{pad}\t\tOFFSET 0 0 1", f"{pad}\t}}"]
        lines.append(f"{pad}}}")

    def positions(self) -> Array:
        """Joint positions by plain scalar formulas, frame by frame, shape [F, J, 3]."""
        out = np.zeros((len(self.root), len(self.names), 3))
        for frame in range(len(self.root)):
            turned: list[Array] = []
            for j, parent in enumerate(self.parents):
                local = np.eye(3)
                for axis, angle in zip(self.orders[j], self.angles[frame, j], strict=True):
                    local = local @ about(axis, float(angle))
                turned.append(local if parent < 0 else turned[parent] @ local)
                out[frame, j] = (
                    self.root[frame] if parent < 0 else out[frame, parent] + turned[parent] @ self.offsets[j]
                )
        return out


def about(axis: str, degrees: float) -> Array:
    """Turn about one axis, shape [3, 3]."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return {
        "X": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "Y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "Z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]),
    }[axis]


ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")

PERSON: Sequence[tuple[str, str, tuple[float, float, float]]] = (
    ("Hips", "", (0, 0, 0)),
    ("LHipJoint", "Hips", (0, 0, 0)),
    ("LeftUpLeg", "LHipJoint", (1.6, -1.8, 0.6)),
    ("LeftLeg", "LeftUpLeg", (2.6, -7.1, 0)),
    ("LeftFoot", "LeftLeg", (2.5, -6.8, 0)),
    ("LeftToeBase", "LeftFoot", (0.2, -0.5, 2.1)),
    ("RightUpLeg", "Hips", (-1.6, -1.8, 0.6)),
    ("RightLeg", "RightUpLeg", (-2.6, -7.1, 0)),
    ("RightFoot", "RightLeg", (-2.5, -6.8, 0)),
    ("RightToeBase", "RightFoot", (-0.2, -0.5, 2.1)),
    ("LowerBack", "Hips", (0, 0, 0)),
    ("Spine", "LowerBack", (0, 2.0, -0.1)),
    ("Spine1", "Spine", (0, 2.0, -0.1)),
    ("Neck", "Spine1", (0, 0.1, 0)),
    ("Head", "Neck", (0, 3.0, 0)),
    ("LeftShoulder", "Spine1", (0, 0, 0)),
    ("LeftArm", "LeftShoulder", (3.5, 0.9, -0.2)),
    ("LeftForeArm", "LeftArm", (4.9, 0, 0)),
    ("LeftHand", "LeftForeArm", (3.4, 0, 0)),
    ("LThumb", "LeftHand", (0.5, 0, 0.5)),
    ("RightShoulder", "Spine1", (0, 0, 0)),
    ("RightArm", "RightShoulder", (-3.5, 0.9, -0.2)),
    ("RightForeArm", "RightArm", (-4.9, 0, 0)),
    ("RightHand", "RightForeArm", (-3.4, 0, 0)),
)
"""A skeleton with CMU's names, legs splayed in rest: name, parent, offset."""


def person(angles: Array, root: Array, frame_time: float, order: str = "ZYX") -> Made:
    """A motion of `PERSON`; angles [F, 24, 3] in degrees."""
    names = [row[0] for row in PERSON]
    return Made(
        names=names,
        parents=[names.index(row[1]) if row[1] else -1 for row in PERSON],
        offsets=np.array([row[2] for row in PERSON], dtype=float),
        orders=[order] * len(names),
        angles=angles,
        root=root,
        frame_time=frame_time,
    )

"""Hand-made skeletons and motions, written as ASF and AMC text."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.stages.body.skeletons import about

Array = NDArray[np.float64]

INCH = 0.0254


@dataclass(frozen=True)
class Bone:
    """A bone, in the file's units and degrees."""

    name: str
    parent: str
    direction: tuple[float, float, float]
    length: float
    axis: tuple[float, float, float] = (0, 0, 0)
    order: str = "XYZ"
    dof: tuple[str, ...] = ()


@dataclass(frozen=True)
class Made:
    """A skeleton with its motion."""

    bones: Sequence[Bone]
    values: list[dict[str, list[float]]]
    """For each frame the numbers of each bone and of the root [degrees, file units]."""
    unit: float = 0.45
    radians: bool = False
    root_order: tuple[str, ...] = ("TX", "TY", "TZ", "RX", "RY", "RZ")
    position: tuple[float, float, float] = (0, 0, 0)

    def asf(self) -> str:
        """The skeleton's file."""
        kind = "rad" if self.radians else "deg"
        lines = ["# made by hand", ":version 1.10", ":name VICON", ":units", " mass 1.0", f" length {self.unit}"]
        lines += [
            f" angle {kind}",
            ":documentation",
            " begin of nothing",
            ":root",
            f" order {' '.join(self.root_order)}",
        ]
        lines += [" axis XYZ", " position " + " ".join(map(repr, self.position)), " orientation 0 0 0", ":bonedata"]
        for i, bone in enumerate(self.bones):
            axis = " ".join(repr(self._angle(a)) for a in bone.axis)
            direction = " ".join(map(repr, bone.direction))
            lines += [" begin", f"  id {i + 1}", f"  name {bone.name}", f"  direction {direction}"]
            lines += [f"  length {bone.length!r}", f"  axis {axis} {bone.order}"]
            if bone.dof:
                limits = [f"         ({-180 - k} 180.0)" for k in range(len(bone.dof))]
                lines += [f"  dof {' '.join(bone.dof)}", "  limits" + limits[0][8:], *limits[1:]]
            lines.append(" end")
        lines += [":hierarchy", " begin"]
        for parent in ("root", *(bone.name for bone in self.bones)):
            children = [bone.name for bone in self.bones if bone.parent == parent]
            if children:
                lines.append(f"  {parent} {' '.join(children)}")
        return "\n".join([*lines, " end"]) + "\n"

    def amc(self) -> str:
        """The motion's file."""
        lines = ["#!OML:ASF made by hand", ":FULLY-SPECIFIED", ":RADIANS" if self.radians else ":DEGREES"]
        for number, frame in enumerate(self.values, start=1):
            lines.append(str(number))
            for name, numbers in frame.items():
                freedoms = self._freedoms(name)
                shown = [
                    repr(v if f.upper().startswith("T") else self._angle(v))
                    for f, v in zip(freedoms, numbers, strict=True)
                ]
                lines.append(" ".join([name, *shown]))
        return "\n".join(lines) + "\n"

    def starts(self) -> list[dict[str, Array]]:
        """Where each bone starts [m], frame by frame, by plain formulas: C M C^-1 down the tree."""
        metre = INCH / self.unit
        out = []
        for frame in self.values:
            turned: dict[str, Array] = {"root": self._motion("root", frame["root"])}
            shift = dict(zip((f.upper() for f in self.root_order), frame["root"], strict=True))
            root = np.array([shift.get(f"T{axis}", 0.0) for axis in "XYZ"]) + self.position
            ends, starts = {"root": root * metre}, {"root": root * metre}
            waiting = list(self.bones)
            while waiting:
                bone = next(b for b in waiting if b.parent in turned)
                waiting.remove(bone)
                own = in_order(bone.order, bone.axis)
                turned[bone.name] = (
                    turned[bone.parent] @ own @ self._motion(bone.name, frame.get(bone.name, [])) @ own.T
                )
                starts[bone.name] = ends[bone.parent]
                along = np.array(bone.direction) / np.linalg.norm(bone.direction) * bone.length * metre
                ends[bone.name] = starts[bone.name] + turned[bone.name] @ along
            out.append(starts)
        return out

    def _freedoms(self, name: str) -> tuple[str, ...]:
        return self.root_order if name == "root" else next(bone.dof for bone in self.bones if bone.name == name)

    def _motion(self, name: str, numbers: list[float]) -> Array:
        pairs = [(f.upper(), v) for f, v in zip(self._freedoms(name), numbers, strict=True)]
        turns = [(f[1], v) for f, v in pairs if f.startswith("R")]
        return in_order("".join(axis for axis, _ in turns), [v for _, v in turns])

    def _angle(self, degrees: float) -> float:
        return float(np.radians(degrees)) if self.radians else float(degrees)


def in_order(order: str, degrees: Sequence[float]) -> Array:
    """Turns about fixed axes one after the other: "XYZ" is Rz Ry Rx."""
    out = np.eye(3)
    for axis, angle in zip(order, degrees, strict=True):
        out = about(axis, float(angle)) @ out
    return out


def _pair(
    name: str, parent: str, direction: tuple[float, float, float], length: float, axis: float, *dof: str
) -> list[Bone]:
    """A bone of the left side and its mirror image; `axis` is its turn about z."""
    x, y, z = direction
    return [
        Bone(f"{s}{name}", parent.replace("*", s), (k * x, y, z), length, (0, 0, k * axis), "XYZ", dof)
        for s, k in (("l", 1), ("r", -1))
    ]


CMU: Sequence[Bone] = (
    *_pair("hipjoint", "root", (0.66, -0.71, 0.25), 2.4, 0),
    *_pair("femur", "*hipjoint", (0.342, -0.94, 0), 7.2, 20, "rx", "ry", "rz"),
    *_pair("tibia", "*femur", (0.342, -0.94, 0), 7.5, 20, "rx"),
    *_pair("foot", "*tibia", (0.07, -0.25, 0.97), 2.1, 20, "rx", "rz"),
    *_pair("toes", "*foot", (0, 0, 1), 1.1, 20, "rx"),
    Bone("lowerback", "root", (0.01, 0.998, -0.05), 2.0, dof=("rx", "ry", "rz")),
    Bone("upperback", "lowerback", (0, 0.999, -0.02), 2.0, dof=("rx", "ry", "rz")),
    Bone("thorax", "upperback", (0, 0.999, 0.01), 2.0, dof=("rx", "ry", "rz")),
    Bone("lowerneck", "thorax", (0, 0.998, 0.05), 1.7, dof=("rx", "ry", "rz")),
    Bone("upperneck", "lowerneck", (0, 0.99, 0.1), 1.7, dof=("rx", "ry", "rz")),
    Bone("head", "upperneck", (0, 0.999, -0.01), 1.7, dof=("rx", "ry", "rz")),
    *_pair("clavicle", "thorax", (0.92, 0.38, -0.06), 3.7, 0, "ry", "rz"),
    *_pair("humerus", "*clavicle", (1, 0, 0), 5.0, 90, "rx", "ry", "rz"),
    *_pair("radius", "*humerus", (1, 0, 0), 3.4, 90, "rx"),
    *_pair("wrist", "*radius", (1, 0, 0), 1.7, 90, "ry"),
    *_pair("hand", "*wrist", (1, 0, 0), 0.7, 90, "rz", "rx"),
    *_pair("fingers", "*hand", (1, 0, 0), 0.5, 90, "rx"),
    *_pair("thumb", "*wrist", (0.7, 0, 0.7), 0.8, 45, "rx", "rz"),
)
"""A skeleton such as CMU's: its names, the order of its axes, legs splayed by 20 degrees at rest."""


def cmu_person(frames: int, rng: np.random.Generator, swing: float = 20.0) -> Made:
    """Somebody of CMU's who stands and swings everything a little."""
    phase = {(b.name, f): rng.uniform(0, 2 * np.pi) for b in CMU for f in b.dof}
    values = []
    for t in range(frames):
        frame = {"root": [0.01 * t, 17.0, 0.02 * t, 2.0, 0.2 * t, -1.0]}
        for bone in CMU:
            if bone.dof:
                frame[bone.name] = [swing * float(np.sin(t / 20 + phase[bone.name, f])) for f in bone.dof]
        values.append(frame)
    return Made(CMU, values)

"""Reader of Acclaim skeletons (ASF), as the CMU database has them.

A bone points from its joint along `direction`, in the axes of the whole skeleton at rest. Its motion is given in axes
of its own, C, turned from those by `axis`; a joint that is turned by M in these is turned by C M C^-1 in the
skeleton's (Acclaim ASF/AMC file specification; M. Schafer, J. Lander). Angles in the order listed are applied one
after the other about fixed axes: "XYZ" is Rz Ry Rx. `length 0.45` of the units says that a length of 0.45 is one inch.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.body.readers.text import Lines, shown

Array = NDArray[np.float64]

INCH = 0.0254
"""[m]."""

FREEDOMS = ("tx", "ty", "tz", "rx", "ry", "rz")
"""What a joint can do: shifts and turns; `l`, a change of length, no recording of a person has."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Bone:
    """One bone, or the root."""

    name: str
    """Its name."""
    tip: Array
    """From its joint to its end, in the skeleton's axes [m], shape [3]."""
    axes: Array
    """Turn from the skeleton's axes to those of its motion, shape [3, 3]."""
    freedoms: tuple[str, ...]
    """What the numbers of a frame mean, in their order."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Skeleton:
    """A skeleton at rest."""

    bones: tuple[Bone, ...]
    """The root, then the bones, parents first."""
    parents: tuple[int, ...]
    """Parent of each, -1 for the root."""
    start: Array
    """Position of the root at rest [m], shape [3]."""
    scale: float
    """Metres of one unit of length."""
    degrees: bool
    """Whether angles are in degrees, else in radians."""


def read_asf(path: Path) -> Skeleton:
    """Reads a skeleton.

    Args:
        path: The file.

    Returns:
        The skeleton.

    Raises:
        DataError: The file is missing, empty, truncated, no ASF, or what it says contradicts itself.
    """
    return _Parser(Lines(path, "ASF", comment="#")).skeleton()


class _Parser:
    """Sections of an ASF file, one method each."""

    def __init__(self, lines: Lines) -> None:
        self.lines = lines
        self.scale, self.degrees = INCH, True
        self.root: Bone | None = None
        self.start = np.zeros(3)
        self.bones: dict[str, Bone] = {}
        self.children: dict[str, list[str]] = {}

    def skeleton(self) -> Skeleton:
        lines = self.lines
        if lines.peek()[0].lower() != ":version":
            raise lines.fault(f"an ASF file starts with ':version', got {shown(lines.peek())}; name an ASF file", 1)
        sections = {":units": self._units, ":root": self._root, ":bonedata": self._bones, ":hierarchy": self._tree}
        while lines.more():
            section = sections.pop(lines.next("a section")[0].lower(), None)
            if section is not None:
                section()
            else:
                self._skip()
        if self.root is None or not self.bones or ":hierarchy" in sections:
            lost = ":root" if self.root is None else ":bonedata" if not self.bones else ":hierarchy"
            raise lines.fault(f"the file has no section {lost!r}; it is truncated, or no ASF file")
        return self._ordered(self.root)

    def _rows(self) -> list[list[str]]:
        """Lines up to the next section."""
        rows = []
        while self.lines.more() and not self.lines.peek()[0].startswith(":"):
            rows.append(self.lines.next("a line"))
        return rows

    def _skip(self) -> None:
        self._rows()

    def _units(self) -> None:
        while self.lines.more() and not self.lines.peek()[0].startswith(":"):
            words = self.lines.next("a unit")
            if words[0] == "length":
                length = self._numbers(words, 1)[0]
                if not 1e-6 <= length <= 1e6:
                    raise self.lines.fault(f"the unit of length must be > 0, got {length:g}; CMU's is 0.45")
                self.scale = INCH / length
            elif words[0] == "angle":
                if words[1:] not in (["deg"], ["rad"]):
                    raise self.lines.fault(f"the unit of angles must be deg or rad, got {shown(words[1:])}")
                self.degrees = words[1] == "deg"

    def _root(self) -> None:
        order: list[str] = ["tx", "ty", "tz", "rx", "ry", "rz"]
        axis, turn, start = "XYZ", [0.0] * 3, [0.0] * 3
        while self.lines.more() and not self.lines.peek()[0].startswith(":"):
            words = self.lines.next("a line of the root")
            if words[0] == "order":
                order = self._freedoms(words[1:])
            elif words[0] == "axis":
                axis = self._axis(words[1:])
            elif words[0] == "position":
                start = self._numbers(words, 3)
            elif words[0] == "orientation":
                turn = self._numbers(words, 3)
        self.start = np.array(start) * self.scale
        self.root = Bone(name="root", tip=np.zeros(3), axes=self._turn(axis, turn), freedoms=tuple(order))

    def _bones(self) -> None:
        while self.lines.more() and not self.lines.peek()[0].startswith(":"):
            words = self.lines.next("a bone")
            if words != ["begin"]:
                raise self.lines.fault(f"expected 'begin' of a bone, got {shown(words)}; export the skeleton again")
            self._bone()

    def _bone(self) -> None:
        name, direction, length, freedoms = "", [0.0] * 3, 0.0, []
        axis, turn = "XYZ", [0.0] * 3
        while (words := self.lines.next("'end' of a bone")) != ["end"]:
            if words[0] == "begin" or words[0].startswith(":"):
                raise self.lines.fault(f"expected 'end' of a bone, got {shown(words)}; export the skeleton again")
            if words[0] == "name":
                name = " ".join(words[1:])
            elif words[0] == "direction":
                direction = self._numbers(words, 3)
            elif words[0] == "length":
                length = self._numbers(words, 1)[0]
            elif words[0] == "axis":
                turn, axis = self._numbers(words[:4], 3), self._axis(words[4:] or ["XYZ"])
            elif words[0] == "dof":
                freedoms = self._freedoms(words[1:])
        if not name or name == "root" or name in self.bones:
            raise self.lines.fault(f"bones must have names, each its own, got {name!r}; rename the bone")
        size = float(np.linalg.norm(direction))
        if length < 0 or (length > 0 and not size > 1e-9):
            raise self.lines.fault(f"bone {name!r} must have a direction and a length, got {size:g} and {length:g}")
        tip = np.array(direction) * (length * self.scale / size if length else 0.0)
        self.bones[name] = Bone(name=name, tip=tip, axes=self._turn(axis, turn), freedoms=tuple(freedoms))

    def _tree(self) -> None:
        rows = self._rows()
        if rows[:1] != [["begin"]] or rows[-1] != ["end"] or len(rows) < 3:
            raise self.lines.fault("the hierarchy must stand between 'begin' and 'end'; the file is truncated")
        parented: set[str] = set()
        for parent, *children in rows[1:-1]:
            for name in (parent, *children):
                if name != "root" and name not in self.bones:
                    raise self.lines.fault(f"the hierarchy names {name[:40]!r}, which is no bone; export it again")
            for child in children:
                if child in parented or child == "root":
                    raise self.lines.fault(f"{child!r} hangs on two bones, or on itself; export the skeleton again")
                parented.add(child)
            self.children.setdefault(parent, []).extend(children)

    def _ordered(self, root: Bone) -> Skeleton:
        order, parents = ["root"], [-1]
        for at, name in enumerate(order):  # the list grows while it is walked: breadth first, parents first
            for child in self.children.get(name, []):
                order.append(child)
                parents.append(at)
        lost = sorted(set(self.bones) - set(order))
        if lost:
            raise self.lines.fault(f"{len(lost)} bones hang on nothing, such as {lost[0]!r}; mend the hierarchy")
        return Skeleton(
            bones=(root, *(self.bones[name] for name in order[1:])),
            parents=tuple(parents),
            start=self.start,
            scale=self.scale,
            degrees=self.degrees,
        )

    def _numbers(self, words: list[str], count: int) -> list[float]:
        if len(words) != count + 1:
            raise self.lines.fault(f"{words[0]!r} must be followed by {count} numbers, got {len(words) - 1}")
        return self.lines.numbers(words[1:], repr(words[0]))

    def _axis(self, words: list[str]) -> str:
        if len(words) != 1 or sorted(words[0].upper()) != ["X", "Y", "Z"]:
            raise self.lines.fault(f"an axis order must be of X, Y and Z, got {shown(words)}")
        return words[0].upper()

    def _freedoms(self, words: list[str]) -> list[str]:
        freedoms = [word.lower() for word in words]
        for word in freedoms:
            if word not in FREEDOMS:
                raise self.lines.fault(f"degrees of freedom must be among {', '.join(FREEDOMS)}, got {word[:20]!r}")
        if len(set(freedoms)) != len(freedoms):
            raise self.lines.fault("a bone names the same degree of freedom twice; export the skeleton again")
        return freedoms

    def _turn(self, axis: str, angles: list[float]) -> Array:
        return np.asarray(Rotation.from_euler(axis.lower(), angles, degrees=self.degrees).as_matrix())

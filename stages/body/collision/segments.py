"""The body cut into segments by the joints that move it, and the pairs of segments that may run into each other."""

from collections.abc import Collection
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from model.body import BodyModel

JOINTS = {
    "torso": (0, 3, 6, 9, 13, 14),
    "neck": (12,),
    "head": (15,),
    "left_upper_arm": (16,),
    "right_upper_arm": (17,),
    "left_forearm": (18,),
    "right_forearm": (19,),
    "left_hand": (20, 22),
    "right_hand": (21, 23),
    "left_thigh": (1,),
    "right_thigh": (2,),
    "left_shank": (4,),
    "right_shank": (5,),
    "left_foot": (7, 10),
    "right_foot": (8, 11),
}
"""SMPL's joints of each segment."""

NAMES = tuple(JOINTS)

ARMS = tuple(
    tuple(NAMES.index(f"{side}_{part}") for part in ("upper_arm", "forearm", "hand")) for side in ("left", "right")
)
"""Segments of each arm, from the shoulder to the hand."""

LIMBS = (
    ("neck", "head"),
    *(tuple(f"{s}_{p}" for p in ("upper_arm", "forearm", "hand")) for s in ("left", "right")),
    *(tuple(f"{s}_{p}" for p in ("thigh", "shank", "foot")) for s in ("left", "right")),
)
"""Segments from the torso outwards."""

SHARES = {"upper_arm": 0.6, "thigh": 0.6, "neck": 0.6, "head": 0.6}
"""Skin is a limb's if what hangs there moves it by more than this share, by default a half: that is where skinning
folds it. The torso is several joints, and gives way; its folds lie farther out."""


STIFF = (("forearm", "hand"), ("shank", "foot"))
"""Neighbours that don't fold onto each other: wrists and ankles."""

CARRIERS = {
    "torso": 9,
    "neck": 12,
    "head": 15,
    "upper_arm": 16,
    "forearm": 18,
    "hand": 20,
    "thigh": 1,
    "shank": 4,
    "foot": 7,
}
"""Joint of the left side in whose axes a segment hardly turns."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Segments:
    """One person's segments."""

    rest: NDArray[np.float64]
    """Vertices in the T-pose [m], shape [V, 3]."""
    faces: NDArray[np.int32]
    """Triangles, shape [F, 3]."""
    label: NDArray[np.int64]
    """Segment of each vertex, row of `NAMES`, shape [V]."""
    face_label: NDArray[np.int64]
    """Segment of each face: that of most of its corners, shape [F]."""
    mean: sp.csr_array
    """Takes values at vertices to the mean of each vertex's neighbours, shape [V, V]."""
    pairs: tuple[tuple[int, int], ...]
    """Segments that are kept apart from each other, rows of `NAMES`."""

    def members(self, segment: int) -> NDArray[np.int64]:
        """Vertices of a segment."""
        return np.flatnonzero(self.label == segment)


def segment(model: BodyModel, betas: ArrayLike, left_out: Collection[int] = ()) -> Segments:
    """Cuts one person into segments.

    Args:
        model: The body, with SMPL's 24 joints.
        betas: Shape coefficients, shape [B].
        left_out: Segments that cloth doesn't collide with, rows of `NAMES`: nothing is kept apart from them.

    Returns:
        The segments.
    """
    vertices, _ = model.shape(betas)
    count, faces = len(vertices), model.faces
    label = _labels(model.weights)
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    low, high = np.divmod(np.unique(ends[:, 0].astype(np.int64) * count + ends[:, 1]), count)
    i, j = np.concatenate([low, high]), np.concatenate([high, low])
    degree = np.bincount(i, minlength=count)
    return Segments(
        rest=vertices.astype(np.float64),
        faces=faces,
        label=label,
        face_label=np.sort(label[faces], axis=1)[:, 1],
        mean=sp.csr_array((1.0 / degree[i], (i, j)), shape=(count, count), dtype=np.float32),
        pairs=tuple(p for p in combinations(range(len(NAMES)), 2) if not _stiff(*p) and not set(p) & set(left_out)),
    )


def pair_name(pair: tuple[int, int]) -> str:
    """How a pair of segments is called in records and messages."""
    return " / ".join(NAMES[segment] for segment in pair)


def carrier(pair: tuple[int, int]) -> int:
    """Joint in whose axes the plane between two segments turns least: of the one nearer to the root."""
    names = [NAMES[segment] for segment in pair]
    if all("thigh" in name for name in names) or (names[0] == "torso" and "thigh" in names[1]):
        return 0
    name = names[0]
    return CARRIERS[name.removeprefix("left_").removeprefix("right_")] + name.startswith("right_")


def _labels(weights: NDArray[np.float32]) -> NDArray[np.int64]:
    """Segment of each vertex: down each limb as long as what hangs there moves it by more than its `SHARES`."""
    moved = np.stack([weights[:, list(joints)].sum(axis=1) for joints in JOINTS.values()], axis=1)
    label = np.zeros(len(weights), np.int64)
    for limb in LIMBS:
        rows = [NAMES.index(name) for name in limb]
        beyond = np.cumsum(moved[:, rows[::-1]], axis=1)[:, ::-1]
        inside = np.ones(len(weights), bool)
        for k, row in enumerate(rows):
            inside &= beyond[:, k] > SHARES.get(NAMES[row].split("_", 1)[-1], 0.5)
            label[inside] = row
    return label


def _stiff(a: int, b: int) -> bool:
    one, other = NAMES[a].split("_", 1), NAMES[b].split("_", 1)
    return len(one) == len(other) == 2 and one[0] == other[0] and (one[1], other[1]) in STIFF

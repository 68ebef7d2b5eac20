"""Where an own garment lies on the body that its file names; a wrong unit, axis or origin is found and said."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import igl
import numpy as np
from numpy.typing import NDArray

from model.body import JOINT_NAMES, load_free_body
from stages.outfit.kinds import LOWER
from stages.outfit.obstacle import Obstacle
from stages.outfit.own.settings import ORIGINS, UNITS, UPS, OwnGarment
from stages.outfit.template import rest_body, rest_joints
from stages.spec import DataError

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

NEAR, NEAR_SHARE = 0.35, 0.9
"""Nine tenths of a garment's vertices are nearer to the body than this [m]; the hem of a wide skirt may not be."""

FARTHEST = 1.0
"""None is further away than this [m]."""

AROUND = 0.15
"""Solid angle, as a share of the whole, that a garment takes up as seen from a bone that it is around; a belt 5 cm wide
takes up 0.16 of it."""

BONES = {
    "upper": (("spine1",), ("spine2",), ("spine3",), ("spine1", "spine2"), ("spine2", "spine3")),
    "lower": (
        ("pelvis",),
        ("left_hip",),
        ("right_hip",),
        ("left_hip", "left_knee"),
        ("right_hip", "right_knee"),
    ),
}
"""Joints, and middles between two, of which a garment must be around one: above the waist, or below it."""

DEEP, DEEP_SHARE = 0.015, 0.02
"""Share of the vertices that may lie deeper inside the body than this [m]; what is less deep is pushed out."""

SAMPLE = 1500
"""Vertices that are looked at to tell how a garment is meant."""


@dataclass(frozen=True, eq=False)
class Wearer:
    """The body that a garment is placed on."""

    skin: Obstacle
    """Its surface in the rest frame."""
    joints: Array
    """Its joints in the rest frame [m], shape [24, 3]."""

    def bones(self, type_: str) -> Array:
        """Points inside the body of which a type of garment is around one at least [m], shape [K, 3]."""
        places = BONES["lower" if type_ in LOWER else "upper"]
        return np.array([self.joints[[JOINT_NAMES.index(name) for name in names]].mean(axis=0) for names in places])

    @property
    def floor(self) -> float:
        """Height of the soles [m]."""
        return float(self.skin.vertices[:, 2].min())


@lru_cache(maxsize=4)
def wearer(gender: str, betas: tuple[float, ...]) -> Wearer:
    """The free body of a gender and shape in the rest pose, once per process."""
    model = load_free_body(gender)
    shape = np.zeros(model.beta_count)
    shape[: len(betas)] = betas
    skin = Obstacle(rest_body(model, shape), model.faces.astype(np.int64), 0.0)
    return Wearer(skin, rest_joints(model, shape))


def to_rest(vertices: Array, unit: str, up: str, origin: str, floor: float) -> Array:
    """A file's positions in the rest frame [m]: root joint at the origin, z up, facing -y, shape [N, 3]."""
    points = vertices * UNITS[unit]
    if up == "y":
        points = np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
    return points + np.array([0.0, 0.0, floor if origin == "floor" else 0.0])


def from_rest(points: Array, unit: str, up: str, origin: str, floor: float) -> Array:
    """Positions in the rest frame as a file has them: the inverse of `to_rest`."""
    points = points - np.array([0.0, 0.0, floor if origin == "floor" else 0.0])
    if up == "y":
        points = np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1)
    return points / UNITS[unit]


@dataclass(frozen=True)
class Fit:
    """How a garment lies on a body.

    Attributes:
        near: Share of its vertices within `NEAR` of the skin.
        farthest: Largest distance of a vertex from the skin [m].
        deep: Share of its vertices deeper inside than `DEEP`.
        deepest: Largest depth [m].
        around: Solid angle that it takes up as seen from inside the body, as a share of the whole; negative if its
            faces look inwards.
    """

    near: float
    farthest: float
    deep: float
    deepest: float
    around: float

    @property
    def placed(self) -> bool:
        """Whether it lies near the body."""
        return self.near >= NEAR_SHARE and self.farthest <= FARTHEST

    @property
    def good(self) -> bool:
        """Whether it can be worn as it lies."""
        return self.placed and abs(self.around) >= AROUND and self.deep <= DEEP_SHARE


def measure(points: Array, faces: Faces, type_: str, body: Wearer, some: Faces | None = None) -> Fit:
    """How a garment of some type lies on a body, by its vertices `some`, or all."""
    distance = body.skin.distance(points if some is None else points[some])[0]
    winding = igl.winding_number(np.ascontiguousarray(points), np.ascontiguousarray(faces), body.bones(type_))
    return Fit(
        near=float((distance < NEAR).mean()),
        farthest=float(distance.max()),
        deep=float((distance < -DEEP).mean()),
        deepest=float(max(0.0, -distance.min())),
        around=float(winding[np.abs(winding).argmax()]),
    )


def place(vertices: Array, faces: Faces, own: OwnGarment, file: str) -> tuple[Array, Faces]:
    """Puts a garment on the body that its file was made on.

    Args:
        vertices: Positions as in the file, shape [N, 3].
        faces: Triangles, oriented alike, shape [F, 3].
        own: What the recipe says of it.
        file: Name of the file, for messages.

    Returns:
        Positions in the rest frame [m], shape [N, 3]; faces that look outwards, turned over if they did not.

    Raises:
        DataError: It does not lie on that body: in which unit, up axis and origin it would, or what is wrong; one line.
    """
    body = wearer(own.gender, own.betas)
    told = (own.unit, own.up, own.origin)
    points = to_rest(vertices, *told, body.floor)
    fit = measure(points, faces, own.type, body)
    if not fit.good:
        _explain(vertices, faces, own, body, fit, file)
    return points, faces if fit.around > 0 else np.ascontiguousarray(faces[:, ::-1])


def _explain(vertices: Array, faces: Faces, own: OwnGarment, body: Wearer, fit: Fit, file: str) -> None:
    told = (own.unit, own.up, own.origin)
    some = np.unique(np.linspace(0, len(vertices) - 1, SAMPLE).astype(np.int64))
    found: list[tuple[float, tuple[str, str, str]]] = []
    for other in product(UNITS, UPS, ORIGINS):
        points = to_rest(vertices, *other, body.floor)
        # The size alone rules most units out.
        if other != told and 0.05 < np.ptp(points, axis=0).max() < 3.0:
            tried = measure(points, faces, own.type, body, some)
            if tried.good:
                # Few changes first: of two that fit, the recipe's own words are likelier to be right.
                changes = sum(a != b for a, b in zip(told, other))
                found.append((changes + tried.farthest + 10 * tried.deep, other))
    size = " x ".join(f"{side:.3g}" for side in np.ptp(to_rest(vertices, *told, body.floor), axis=0))
    as_told = f"with unit = {own.unit!r}, up = {own.up!r} and origin = {own.origin!r} it is {size} m"
    who = f"the {own.gender} body"
    if found:
        other = min(found)[1]
        names = ("unit", "up", "origin")
        remedy = " and ".join(f'{n} = "{new}"' for n, old, new in zip(names, told, other) if new != old)
        raise DataError(f"{file}: does not lie on {who}: {as_told}; it would fit with {remedy}: say so in the recipe")
    if not fit.placed:
        raise DataError(
            f"{file}: there is no body around it: {as_told} and up to {fit.farthest:.3g} m from {who}, "
            f"{1 - fit.near:.0%} of it further than {NEAR} m; place it on the body that `python -m stages.outfit body` "
            "writes"
        )
    if abs(fit.around) < AROUND:
        raise DataError(
            f"{file}: there is no body inside it: it takes up {abs(fit.around):.2f} of what is seen from the "
            f"{'hips' if own.type in LOWER else 'spine'} of {who}, must be >= {AROUND}; place it around the body that "
            "`python -m stages.outfit body` writes, or correct its type"
        )
    raise DataError(
        f"{file}: {fit.deep:.1%} of its vertices lie more than {DEEP * 1e3:g} mm inside {who}, at most "
        f"{DEEP_SHARE:.0%} may, the deepest {fit.deepest * 1e3:.0f} mm; make it wider, or give the betas of the body "
        "that it was made on"
    )

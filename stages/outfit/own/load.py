"""An own garment from its file: read, checked, placed, and ready to be resized to any body."""

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from model.body import BodyModel
from model.mesh.geometry import edge_lengths
from model.mesh.topology import edge_list
from stages.outfit.borders import Border, name_borders
from stages.outfit.coordinates import Axes
from stages.outfit.own.obj import read_obj
from stages.outfit.own.placement import place, wearer
from stages.outfit.own.settings import OwnGarment
from stages.outfit.own.soundness import sound_topology, sound_triangles
from stages.outfit.resizing import averaging_matrix, smooth_field
from stages.outfit.template import rest_body
from stages.settings import suggestion
from stages.spec import DataError

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class OwnMesh:
    """An own garment on the body that it was made on."""

    settings: OwnGarment
    """What the recipe says of it."""
    vertices: Array
    """Positions in the rest frame [m], in the file's order, shape [N, 3]."""
    faces: Faces
    """Triangles, counter-clockwise seen from outside, shape [F, 3]."""
    borders: list[Border]
    """Its borders, each with a name of its own."""
    unused_vertices: int
    """Vertices of the file that no face uses, and that were left out."""
    sha256: str
    """Hash of the file's content, in hex."""

    def attrs(self) -> dict[str, Any]:
        """What a shard says of where it comes from, as JSON values."""
        frame = {name: getattr(self.settings, name) for name in ("unit", "up", "origin", "gender")}
        return {
            "file": Path(self.settings.file).name,
            "sha256": self.sha256,
            **frame,
            "betas": list(self.settings.betas),
            "unused_vertices": self.unused_vertices,
        }

    @cached_property
    def edge(self) -> float:
        """Mean edge length [m]."""
        return float(edge_lengths(self.vertices, edge_list(self.faces)).mean())

    @cached_property
    def _nearest(self) -> tuple[Faces, Array]:
        """For each vertex the nearest point of the body: its face [N] and barycentric weights [N, 3]."""
        skin = wearer(self.settings.gender, self.settings.betas).skin
        body, faces = np.ascontiguousarray(skin.vertices), np.ascontiguousarray(skin.faces)
        _, face, foot = igl.point_mesh_squared_distance(np.ascontiguousarray(self.vertices), body, faces)
        corners = [np.ascontiguousarray(body[faces[face, k]]) for k in range(3)]
        weights = igl.barycentric_coordinates(np.ascontiguousarray(foot), *corners)
        return face, np.clip(weights, 0.0, 1.0)

    def displacement(self, model: BodyModel, betas: Array, width: float) -> Array:
        """How the garment moves when it goes from the body that it was made on to another: see `resizing`.

        Args:
            model: The free body of either gender; both have the same faces.
            betas: Shape to go to, shape [B].
            width: Standard deviation of the smoothing along the cloth [m].

        Returns:
            Displacements in the rest frame [m], shape [N, 3].
        """
        skin = wearer(self.settings.gender, self.settings.betas).skin
        moved = rest_body(model, betas) - skin.vertices
        face, weights = self._nearest
        field = np.einsum("nk,nkd->nd", weights, moved[skin.faces[face]])
        steps = round(4.0 * (width / self.edge) ** 2)
        return smooth_field(field, averaging_matrix(self.faces, len(field)), steps)


def load_own(content: bytes, settings: OwnGarment, file: str) -> OwnMesh:
    """Reads and checks an own garment.

    Args:
        content: Its OBJ file's bytes.
        settings: What the recipe says of it.
        file: Name of the file, for messages.

    Returns:
        The garment.

    Raises:
        DataError: It cannot be worn: what, where, the limit and the remedy, in one line.
    """
    read = read_obj(content, file)
    mesh = sound_topology(read, file)
    points, faces = place(mesh.vertices, mesh.faces, settings, file)
    sound_triangles(points, mesh, file)
    axes = Axes.of(wearer(settings.gender, settings.betas).joints)
    borders = _unlike(name_borders(settings.type, points, faces, axes))
    for end in settings.elastics:
        if not any(_is_at(border.name, end) for border in borders):
            names = [border.name for border in borders]
            raise DataError(
                f"{file}: has no border {end!r} for an elastic; {suggestion(end, names)}, its borders are "
                f"{', '.join(names)}"
            )
    if settings.banded and not any(border.name == "waist" for border in borders):
        raise DataError(
            f"{file}: has no border at the waist for a waistband; its borders are "
            f"{', '.join(border.name for border in borders)}: set waistband = false, or type to what it is"
        )
    unused = len(read.vertices) - len(points)
    return OwnMesh(settings, points, faces, borders, unused, hashlib.sha256(content).hexdigest())


def _is_at(border: str, end: str) -> bool:
    """Whether an elastic's end, such as `sleeve` or `left_sleeve`, means a border."""
    return border == end or border.endswith(f"_{end}")


def _unlike(borders: list[Border]) -> list[Border]:
    """The borders with a number after every name that another one has already."""
    seen: dict[str, int] = {}
    out = []
    for border in borders:
        seen[border.name] = count = seen.get(border.name, 0) + 1
        out.append(border if count == 1 else replace(border, name=f"{border.name}_{count}"))
    return out

"""Finishes a fitted garment: marks its elastics and waistband, and writes down all that is to be known of it."""

from dataclasses import dataclass
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from model.mesh.geometry import edge_lengths, face_areas
from model.mesh.topology import edge_list
from stages.fabrics import Fabric, sheet_stiffness
from stages.outfit.blank import Blank
from stages.outfit.borders import CHEST_SNUGNESS, ELASTIC_RINGS, FASTENING, WAISTBAND_WIDTH, loop_length, tape_girth
from stages.outfit.flattening import Flat, flatten
from stages.outfit.panels import Panels
from stages.outfit.plan import GarmentPlan
from stages.outfit.surface import grown

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Pattern:
    """What a garment would be sewn from."""

    panels: Panels
    """Its panels and their seams."""
    flat: Flat
    """The panels laid flat."""

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Its datasets by name, see `store.schema`."""
        seams = self.panels.seams.values()
        return {
            "panel": self.panels.of_face.astype(np.int8),
            "uv": self.flat.points,
            "uv_faces": self.flat.faces,
            "seam_edges": self.panels.cut_edges(),
            "seam": np.repeat(np.arange(1, len(seams) + 1), [len(edges) for edges in seams]).astype(np.int8),
        }


@dataclass(frozen=True, eq=False)
class Garment:
    """One finished garment in the rest frame."""

    plan: GarmentPlan
    """What it was made from."""
    vertices: Array
    """Positions [m], shape [N, 3]."""
    faces: Faces
    """Triangles, shape [F, 3]."""
    elastic: NDArray[np.int8]
    """0, or the number of the elastic that each vertex belongs to, shape [N]."""
    waistband: NDArray[np.bool_]
    """Vertices of the band that holds the garment up, shape [N]."""
    border: NDArray[np.int8]
    """0, or the number of the border that each vertex lies on, shape [N]."""
    pattern: Pattern | None
    """Its panels laid flat; none if it is one's own."""
    attrs: dict[str, Any]
    """What the shard says about it, as JSON values."""


@dataclass(frozen=True, eq=False)
class Wearing:
    """Whom a garment is finished for."""

    body: Array
    """The wearer in the rest frame [m], shape [V, 3]."""
    tight_body: Array
    """The body of betas less tightness that the garment was fitted to [m], shape [V, 3]."""
    faces: Faces
    """Triangles of both, shape [F, 3]."""
    tightness: tuple[float, float]
    """Offsets subtracted from the first two betas [1]."""


def finish(blank: Blank, points: Array, wearing: Wearing, fabric: Fabric) -> Garment:
    """Marks elastics and waistband, and collects what the shard says about a garment.

    Args:
        blank: The garment.
        points: Its vertices as fitted [m], shape [N, 3].
        wearing: Whom it was fitted to.
        fabric: What it is made of.

    Returns:
        The garment.
    """
    plan, faces = blank.plan, blank.surface.faces
    seams = {"waist": seam_loop(blank.seam, faces)} if blank.seam.any() else {}
    elastic, elastics = _elastics(blank, points, seams, fabric)
    waistband, band = _waistband(blank, points, wearing, fabric)
    area = float(face_areas(points, faces).sum())
    attrs: dict[str, Any] = {
        "type": plan.type,
        "fabric": fabric.as_attrs(),
        "tightness": list(wearing.tightness),
        "parameters": {piece.template: dict(piece.parameters) for piece in plan.pieces},
        "cuts": {piece.template: list(piece.cuts) for piece in plan.pieces},
        "elastics": elastics,
        "waistband": band,
        "fastenings": _fastenings(blank, points),
        "borders": {
            b.name: {
                "number": number,
                "vertex": int(b.loop[0]),
                "vertices": len(b.loop),
                "length_m": b.length(points),
            }
            for number, b in enumerate(blank.borders, start=1)
        },
        "seams": {
            name: {"vertices": loop.tolist(), "length_m": loop_length(points, loop)} for name, loop in seams.items()
        },
        "edge_m": float(edge_lengths(points, edge_list(faces)).mean()),
        "area_m2": area,
        "mass_kg": area * fabric.density,
    }
    border = np.zeros(len(points), dtype=np.int8)
    for number, line in enumerate(blank.borders, start=1):
        border[line.loop] = number
    pattern = None
    if blank.own is not None:
        attrs["own"] = blank.own.attrs()
    if blank.panels is not None:
        panels = blank.panels
        sleeves = [number for number, name in enumerate(panels.names) if name.endswith("sleeve")]
        pattern = Pattern(panels, flatten(points, faces, panels.of_face, panels.cut_edges(), sleeves))
        attrs["panels"] = panels.names
        attrs["panel_seams"] = {
            name: {"number": number, "edges": len(edges), "length_m": float(edge_lengths(points, edges).sum())}
            for number, (name, edges) in enumerate(panels.seams.items(), start=1)
        }
    return Garment(plan, points, faces, elastic, waistband, border, pattern, attrs)


def seam_loop(seam: NDArray[np.bool_], faces: Faces) -> Faces:
    """The vertices of a seam in their order around the garment.

    Args:
        seam: Vertices on the seam, shape [N].
        faces: Triangles, shape [F, 3].

    Returns:
        The loop from its smallest vertex on, towards the smaller of that one's two neighbours, shape [n].

    Raises:
        ValueError: The seam is not one closed line.
    """
    edges = edge_list(faces)
    beside: dict[int, list[int]] = {}
    for a, b in edges[seam[edges].all(axis=1)].tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    loop = [min(beside)]
    after = min(beside[loop[0]])
    while after != loop[0] and len(loop) <= len(beside):
        onwards = [v for v in beside[after] if v != loop[-1]]
        loop.append(after)
        after = onwards[0] if len(onwards) == 1 else -1
        if after < 0:
            break
    if after != loop[0] or len(loop) != int(seam.sum()):
        raise ValueError(f"the seam of {int(seam.sum())} vertices must be one closed line")
    return np.array(loop, dtype=np.int64)


def _elastics(
    blank: Blank, points: Array, seams: dict[str, Faces], fabric: Fabric
) -> tuple[NDArray[np.int8], dict[str, dict[str, Any]]]:
    """Number of the elastic of each vertex, 0 for none, shape [N]; number -> what is to be known of it.

    `tension_n` is about the force [N] with which an elastic pulls that is drawn out to the cloth's length: its springs
    are as stiff as the cloth's, and shorter. Those of 0.8 of the length pull up to a fifth harder, as they turn.
    """
    faces = blank.surface.faces
    elastic = np.zeros(len(points), dtype=np.int8)
    elastics: dict[str, dict[str, Any]] = {}
    areas = face_areas(points, faces)
    for end, ratio in blank.plan.elastics.items():
        lines = {b.name: b.loop for b in blank.borders if b.name == end or b.name.endswith(f"_{end}")}
        for name, loop in {**lines, **{seam: loop for seam, loop in seams.items() if seam == end}}.items():
            number = len(elastics) + 1
            marked = grown(_marked(loop, len(points)), faces, ELASTIC_RINGS)
            elastic[marked] = number
            length = loop_length(points, loop)
            width = float(areas[marked[faces].all(axis=1)].sum()) / length
            elastics[str(number)] = {
                "kind": name,
                "rest_ratio": ratio,
                "length_m": length,
                "rest_length_m": ratio * length,
                "width_m": width,
                "tension_n": sheet_stiffness(fabric.stretch_stiffness, fabric.shear_stiffness) * width * (1 - ratio),
            }
    return elastic, elastics


def _waistband(
    blank: Blank, points: Array, wearing: Wearing, fabric: Fabric
) -> tuple[NDArray[np.bool_], dict[str, float] | None]:
    """Vertices of the band that holds a garment up, shape [N], and its girth and rest ratio; None without one."""
    band = np.zeros(len(points), dtype=bool)
    border = next((b for b in blank.borders if b.name in ("waist", "chest")), None)
    if border is None or (blank.own is not None and not blank.own.settings.banded):
        return band, None
    near = cKDTree(blank.surface.vertices[border.loop]).query(blank.surface.vertices, workers=1)[0]
    band = near < WAISTBAND_WIDTH
    worn = _carried(points[border.loop], wearing.tight_body, wearing.body, wearing.faces)
    girth = tape_girth(worn) + 2 * np.pi * fabric.thickness
    if border.name == "chest":
        girth *= CHEST_SNUGNESS
    return band, {"girth_m": girth, "rest_ratio": girth / loop_length(points, border.loop)}


def _fastenings(blank: Blank, points: Array) -> dict[str, dict[str, Any]]:
    """What keeps the sides of an open front together where they are nearest to each other: cords as long as the gap.

    `cords` are pairs of vertices, `length_m` how far apart they can be.
    """
    lines = {b.name: b.loop for b in blank.borders}
    if "left_front_opening" not in lines:
        return {}
    left, right = lines["left_front_opening"], lines["right_front_opening"]
    at = blank.surface.vertices
    apart, opposite = cKDTree(at[right]).query(at[left], workers=1)
    held = np.linalg.norm(at[left] - at[left[np.argmin(apart)]], axis=1) < FASTENING / 2
    cords = np.column_stack([left[held], right[opposite[held]]])
    length = np.linalg.norm(points[cords[:, 0]] - points[cords[:, 1]], axis=1)
    return {"front": {"cords": cords.tolist(), "length_m": length.tolist()}}


def _marked(loop: Faces, count: int) -> NDArray[np.bool_]:
    marked = np.zeros(count, dtype=bool)
    marked[loop] = True
    return marked


def _carried(points: Array, start: Array, end: Array, faces: Faces) -> Array:
    """Nearest points of one body to some points, carried over to another shape of it [m], shape [n, 3]."""
    _, face, foot = igl.point_mesh_squared_distance(np.ascontiguousarray(points), start, faces)
    weights = igl.barycentric_coordinates(foot, *[np.ascontiguousarray(start[faces[face, k]]) for k in range(3)])
    return np.einsum("nk,nkd->nd", weights, end[faces[face]])

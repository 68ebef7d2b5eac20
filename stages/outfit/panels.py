"""Which panel of a sewing pattern each triangle belongs to, and what the seams between them are called.

A template's panels are told by smooth fields on its vertices: how far in front of the side seam, how far down the
sleeve from the armhole. The fields go with the vertices through cutting and sewing, so that panels are known on
whatever triangles come out; seams run along edges.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model.mesh.topology import component_labels
from stages.outfit.coordinates import Axes
from stages.outfit.surface import Surface
from stages.outfit.template import Template

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

ARMHOLE_OUT, ARMHOLE_UP, ARMHOLE_SLOPE = 0.005, 0.06, 0.25
"""The armhole is a plane through a point so far outside of and above the shoulder joint [m], leaning outwards."""

ARM_DEPTH = 0.14
"""What is further below the shoulder joint than this is no sleeve [m]."""

STRAY = 0.02
"""A part of a panel that hangs together and has fewer than this share of its triangles goes to its neighbours [1]."""

TEETH = 4
"""Rounds in which triangles with two neighbours in one other panel go over to it: seams without teeth."""

HALVES = {"left_sleeve_front": "left_sleeve", "left_sleeve_back": "left_sleeve",
          "right_sleeve_front": "right_sleeve", "right_sleeve_back": "right_sleeve"}  # fmt: skip
"""Parts that are one panel: a sleeve is cut open below the arm."""


@dataclass(frozen=True, eq=False)
class Panels:
    """The panels of a garment."""

    names: list[str]
    """Their names; a sewn garment's begin with the piece that they belong to."""
    of_face: NDArray[np.int64]
    """Number of each triangle's panel in `names`, shape [F]."""
    seams: dict[str, Faces]
    """Edges of each seam, smaller vertex first, shape [S, 2]."""

    def cut_edges(self) -> Faces:
        """Edges of all seams, shape [S, 2]."""
        return np.concatenate([np.empty((0, 2), dtype=np.int64), *self.seams.values()])


def cut_out(
    templates: Sequence[Template], surface: Surface, waist: NDArray[np.bool_], *, sleeveless: bool = False
) -> Panels:
    """Tells a garment's panels apart.

    Args:
        templates: What it was cut from, from top to bottom.
        surface: The garment on the mean body, its rows over all templates in that order.
        waist: Vertices on the seam between two of them, shape [N].
        sleeveless: Whether the sleeves of the t-shirt that it was cut from are gone.

    Returns:
        The panels and their seams.
    """
    names: list[str] = []
    label = np.empty(len(surface.faces), dtype=np.int64)
    pairs, edges = _neighbours(surface.faces)
    sewn = waist[edges].all(axis=1)
    piece = _piece_of_faces(templates, surface, pairs[~sewn])
    start = 0
    for number, template in enumerate(templates):
        rows = surface.rows[:, start : start + len(template.vertices)]
        start += len(template.vertices)
        mine = np.flatnonzero(piece == number)
        # Beside a seam a vertex stems in part from the other piece.
        share = np.maximum(np.asarray(rows.sum(axis=1)), 1e-9)
        points = (rows @ template.vertices) / share
        prefix = f"{template.garment}_" if len(templates) > 1 else ""
        pattern = "top" if sleeveless and template.garment == "tshirt" else template.garment
        own, number_of = _parts(pattern, points[surface.faces[mine]].mean(axis=1), template.axes)
        label[mine] = len(names) + number_of
        names += [prefix + name for name in own]
    label = _tidied(label, pairs[~sewn], len(names))
    whole = [_whole(name) for name in names]
    seams = _seams(names, label, pairs, edges, surface.vertices, templates[0].axes)
    panels = list(dict.fromkeys(whole))
    of_face = np.array([panels.index(name) for name in whole])[label]
    return Panels(panels, of_face, seams)


def _piece_of_faces(templates: Sequence[Template], surface: Surface, pairs: Faces) -> Faces:
    """Number of the template that the faces come from which hang together through pairs of neighbours, shape [F]."""
    bounds = np.cumsum([0, *(len(t.vertices) for t in templates)])
    share = np.concatenate(
        [np.asarray(surface.rows[:, a:b].sum(axis=1)) for a, b in itertools.pairwise(bounds)], axis=1
    )
    together = component_labels(pairs, len(surface.faces))
    total = [np.bincount(together, share[surface.faces, k].sum(axis=1)) for k in range(len(templates))]
    piece: Faces = np.argmax(total, axis=0)[together]
    return piece


def _parts(garment: str, centres: Array, axes: Axes) -> tuple[list[str], Faces]:
    """Names of a template's parts, and the part that each point on it [n, 3] belongs to, shape [n]."""
    x, y, z = centres.T
    left, front = x > 0, y < _side_line(garment, centres, axes)
    if garment == "trousers":
        return ["left_front", "left_back", "right_front", "right_back"], 2 * ~left + ~front
    if garment != "tshirt":
        return ["front", "back"], (~front).astype(np.int64)
    armhole = axes.shoulder[0] + ARMHOLE_OUT + ARMHOLE_SLOPE * (axes.shoulder[2] + ARMHOLE_UP - z)
    sleeve = (np.abs(x) > armhole) & (z > axes.shoulder[2] - ARM_DEPTH)
    names = ["front", "back", "left_sleeve_front", "left_sleeve_back", "right_sleeve_front", "right_sleeve_back"]
    return names, np.where(sleeve, 2 + 2 * ~left, 0) + ~front


def _side_line(garment: str, points: Array, axes: Axes) -> Array:
    """Where the front ends and the back begins at each point: y [m], shape [n]."""
    if garment == "trousers":
        centre: Array = axes.leg_centre(points)[:, 1]
        return centre
    if garment == "skirt":
        return np.full(len(points), axes.hip[1])
    return np.interp(points[:, 2], [axes.hip[2], axes.shoulder[2]], [axes.hip[1], axes.shoulder[1]])


def _whole(name: str) -> str:
    for part, panel in HALVES.items():
        if name.endswith(part):
            return name[: -len(part)] + panel
    return name


def _neighbours(faces: Faces) -> tuple[Faces, Faces]:
    """Pairs of faces that share an edge, shape [P, 2], and these edges, smaller vertex first, shape [P, 2]."""
    half = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((owner, half[:, 1], half[:, 0]))
    half, owner = half[order], owner[order]
    same = np.flatnonzero((half[1:] == half[:-1]).all(axis=1))
    return np.stack([owner[same], owner[same + 1]], axis=1), half[same]


def _tidied(label: Faces, pairs: Faces, count: int) -> Faces:
    """The parts without teeth along their seams and without strays."""
    label = label.copy()
    both = np.concatenate([pairs, pairs[:, ::-1]])
    for round_ in range(TEETH):
        votes = np.zeros((len(label), count), dtype=np.int64)
        np.add.at(votes, (both[:, 0], label[both[:, 1]]), 1)
        over = (votes.max(axis=1) >= 2) & (votes[np.arange(len(label)), label] <= 1)
        # Faces of one part at a time, in turn: two neighbours would swap for ever.
        over &= label % 2 == round_ % 2
        label[over] = votes[over].argmax(axis=1)
    for _ in range(count):
        together = component_labels(pairs[label[pairs[:, 0]] == label[pairs[:, 1]]], len(label))
        size, total = np.bincount(together), np.bincount(label, minlength=count)
        stray = size[together] < STRAY * total[label]
        if not stray.any():
            break
        votes = np.zeros((len(label), count), dtype=np.int64)
        beside = both[stray[both[:, 0]] & (together[both[:, 0]] != together[both[:, 1]])]
        np.add.at(votes, (together[beside[:, 0]], label[beside[:, 1]]), 1)
        label[stray] = np.where(votes.max(axis=1) > 0, votes.argmax(axis=1), -1)[together[stray]]
    return label


def _seams(names: list[str], label: Faces, pairs: Faces, edges: Faces, points: Array, axes: Axes) -> dict[str, Faces]:
    """Edges between two parts by the name of the seam; the upper half of a sleeve's tube has none."""
    apart = label[pairs[:, 0]] != label[pairs[:, 1]]
    middle = points[edges[apart]].mean(axis=1)
    found: dict[str, list[Faces]] = {}
    for pair, edge, at in zip(label[pairs[apart]].tolist(), edges[apart], middle):
        name = _seam_name(names[pair[0]], names[pair[1]], at, axes)
        if name:
            found.setdefault(name, []).append(edge)
    return {name: np.stack(found[name]) for name in sorted(found)}


def _seam_name(one: str, other: str, at: Array, axes: Axes) -> str:
    """Name of the seam between two parts at a point [m], shape [3]; empty where none is sewn."""
    side = "left" if at[0] > 0 else "right"
    pieces = {name.split("_")[0] for name in (one, other)} & {"tshirt", "top", "trousers", "skirt"}
    if len(pieces) == 2:
        return "waist"
    sleeves = ("sleeve" in one) + ("sleeve" in other)
    if sleeves == 2:
        return f"{side}_underarm" if at[2] < axes.shoulder[2] else ""
    if sleeves == 1:
        return f"{side}_armhole"
    prefix = "skirt_" if pieces == {"skirt"} else ""
    if ("left_" in one) != ("left_" in other):
        return "front_rise" if "front" in one and "front" in other else "back_rise"
    if "left_" in one or "right_" in one:
        inner = abs(at[0]) < abs(float(axes.leg_centre(at[None])[0, 0]))
        return f"{side}_{'inseam' if inner else 'outseam'}"
    if at[2] > axes.shoulder[2] and not prefix:
        return f"{side}_shoulder"
    return f"{prefix}{side}_side"

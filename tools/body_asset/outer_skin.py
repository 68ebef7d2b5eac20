"""The outer skin: the body surface with the cavities behind the eyelids and the lips closed."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from tools.body_asset.source import BaseMesh

RIMS: dict[str, tuple[int, ...]] = {
    "right eye": (
        4865,
        4866,
        4867,
        4872,
        4868,
        4869,
        4870,
        4871,
        4864,
        5128,
        4863,
        4862,
        4861,
        4860,
        4859,
        4858,
        4857,
        5127,
        4856,
        4855,
        4854,
        4853,
        4852,
        4851,
        4850,
        4849,
        4848,
        4847,
    ),
    "left eye": (
        11485,
        11484,
        11483,
        11465,
        11466,
        11467,
        11468,
        11469,
        11470,
        11471,
        11472,
        11473,
        11474,
        11742,
        11475,
        11476,
        11477,
        11478,
        11479,
        11480,
        11481,
        11743,
        11482,
        11489,
        11488,
        11487,
        11486,
        11490,
    ),
    "mouth": (
        462,
        465,
        468,
        7224,
        7221,
        7218,
        7213,
        11955,
        7209,
        7177,
        7176,
        7190,
        10401,
        7188,
        7189,
        10374,
        7203,
        7198,
        7231,
        7237,
        7243,
        494,
        488,
        482,
        476,
        438,
        443,
        3706,
        429,
        428,
        3733,
        430,
        416,
        417,
        449,
        5353,
        453,
        459,
    ),
}
"""Vertex loops of the base mesh where the skin turns inside, in order along the loop.

Behind them lie the eye sockets and the mouth, 1,278 vertices folded inside the head, which no cloth can touch and which
make inside and outside ambiguous. The base mesh's vertex numbers never change between releases of the data.
"""


def triangulate(quads: NDArray[np.int32]) -> NDArray[np.int32]:
    """Splits quads [Q, 4] along their first diagonal into triangles [F, 3]; a repeated corner gives one triangle."""
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


def outer_skin(base: BaseMesh) -> NDArray[np.int32]:
    """The closed outer surface of the body.

    The cavities are cut off at their rims, and each rim is closed by a strip between its upper and its lower lip.

    Args:
        base: The base mesh.

    Returns:
        Triangles over the base mesh's vertices, counter-clockwise seen from outside, shape [F, 3].

    Raises:
        ValueError: The rims do not bound the cavities, which means that the base mesh is another one.
    """
    outside = _cut(triangulate(base.groups["body"]), [np.array(rim) for rim in RIMS.values()])
    directed = set(map(tuple, _directed_edges(outside).tolist()))
    caps = []
    for name, numbers in RIMS.items():
        rim = np.array(numbers, dtype=np.int32)
        ahead = {(a, b) in directed for a, b in zip(rim.tolist(), np.roll(rim, -1).tolist())}
        if len(ahead) != 1:
            raise ValueError(f"the rim of the {name} is not a boundary of the outer skin")
        # The cap runs along each rim edge against the skin's direction.
        caps.append(_strip(base.vertices, rim[::-1] if ahead.pop() else rim))
    return np.concatenate([outside, *caps]).astype(np.int32)


def _cut(faces: NDArray[np.int32], rims: list[NDArray[np.int64]]) -> NDArray[np.int32]:
    """The largest part of a surface after cutting it along closed vertex loops."""
    rim_edges = np.concatenate([np.stack([rim, np.roll(rim, -1)], axis=1) for rim in rims])
    span = int(faces.max()) + 1
    edges = np.sort(_directed_edges(faces).astype(np.int64), axis=1) @ np.array([span, 1])
    blocked = np.sort(rim_edges, axis=1) @ np.array([span, 1])
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.argsort(edges, kind="stable")
    pairs = owner[order].reshape(-1, 2)[~np.isin(edges[order][::2], blocked)]
    graph = sp.coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(faces), len(faces)))
    _, part = connected_components(graph, directed=False)
    return faces[part == np.bincount(part).argmax()]


def _strip(vertices: NDArray[np.float64], rim: NDArray[np.int32]) -> NDArray[np.int32]:
    """Closes an even loop by a strip across its shorter width: triangles [len(rim) - 2, 3] that run along the loop."""
    half = len(rim) // 2
    width = [np.linalg.norm(np.diff(vertices[_sides(rim, start)], axis=0), axis=-1).sum() for start in range(half)]
    one, other = _sides(rim, int(np.argmin(width)))
    quads = np.stack([one[:-1], one[1:], other[1:], other[:-1]], axis=1)
    return triangulate(quads)


def _sides(rim: NDArray[np.int32], start: int) -> NDArray[np.int32]:
    """Both ways round a loop [n] from one corner to the one opposite, shape [2, n / 2 + 1]."""
    forth = np.roll(rim, -start)
    half = len(rim) // 2
    steps = np.arange(half + 1)
    return np.stack([forth[steps], forth[-steps]])


def _directed_edges(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """Half-edges of triangles, first all edges 0-1, then 1-2, then 2-0, shape [3 F, 2]."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])

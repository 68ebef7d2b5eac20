"""Parts the segments of a moving body, pair by pair, until no edge goes through a face.

The paper's step (CLOTH3D, supplement, "Self-collision"): the collided vertices of two segments are moved to their sides
of a plane through the contact. Here contacts are found before skin meets skin; each cluster of them has its own plane,
which glides in time and bends with the contact; and movements run out over the skin and in time, so that nothing pops.
Then all edges are tested against all faces of the other segments, exactly, in the positions that will be stored. What
is left, mostly skin that skinning crumples at the bottom of a fold, is smoothed in every second round, and parted again
in the others.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from stages.body.collision.contacts import APART, Contact, Normals, pierced, touch
from stages.body.collision.fairing import fair
from stages.body.collision.field import envelope, spread
from stages.body.collision.intersect import Crossings, Intersector
from stages.body.collision.patches import Nearby
from stages.body.collision.planes import glide, heights, middles
from stages.body.collision.segments import NAMES, Segments, carrier
from stages.body.collision.vectors import dot, squares
from store.schema import POSITION_QUANTUM

Frames = NDArray[np.float32]
Pair = tuple[int, int]
Contacts = dict[int, Contact]
Track = tuple[cKDTree, NDArray[np.float64]]
"""Where in the T-pose a cluster of contacts lies, and the normals of its planes, shape [T, 3]."""

ROUNDS = 8
"""Most rounds of finding and parting."""

AT_ONCE = 16
"""Frames that are looked at together."""

ABOUT = 0.02
"""Vertices nearer than this to a contact must be on their side of the plane too [m]."""

LINK = 0.04
"""Contacts nearer than this in the T-pose are one cluster [m]."""

MOVED = 1e-4
"""Vertices that moved less than this don't count as moved [m]."""


@dataclass(eq=False)
class Parting:
    """What was done to one pair of segments."""

    depth: NDArray[np.float32]
    """How deep they were in each other, before; 0 where they only came too near [m], shape [T]."""
    moved: NDArray[np.float32]
    """Farthest that a vertex was moved [m], shape [T]."""
    vertices: NDArray[np.int32]
    """Number of vertices moved, shape [T]."""
    skin: NDArray[np.bool_]
    """Vertices that were moved in any frame, shape [V]."""

    @classmethod
    def nothing(cls, frames: int, vertices: int) -> "Parting":
        """Nothing done in so many frames, to so many vertices."""
        none = np.zeros(frames, np.float32)
        return cls(none.copy(), none.copy(), none.astype(np.int32), np.zeros(vertices, bool))

    def measure(self, before: Frames, after: Frames) -> None:
        """Fills in how far its skin was moved from vertices `before` to `after` [m], shape [T, V, 3]."""
        rows = np.flatnonzero(self.skin)
        apart = after[:, rows] - before[:, rows]
        far = np.sqrt(dot(apart, apart))
        self.moved = far.max(axis=1, initial=0.0)
        self.vertices = np.count_nonzero(far > MOVED, axis=1).astype(np.int32)


@dataclass(eq=False)
class Solution:
    """The parted body."""

    vertices: Frames
    """Vertices [m], shape [T, V, 3]."""
    partings: dict[Pair, Parting] = field(default_factory=dict)
    """What was done, for each pair of segments that anything was done to."""
    left: dict[Pair, NDArray[np.int32]] = field(default_factory=dict)
    """Number of crossings left in each frame, shape [T], for each pair that has any."""
    rounds: int = 0
    """Rounds it took."""


def part_segments(
    segments: Segments,
    x: Frames,
    axes: NDArray[np.float64],
    gap: float,
    limit: Mapping[Pair, float] | None = None,
    tell: Callable[[str], object] = lambda label: None,
) -> Solution:
    """Parts the pairs of segments of a body in motion.

    Args:
        segments: The person's segments, with the pairs to part.
        x: Vertices [m], shape [T, V, 3].
        axes: World rotation of each joint, shape [T, 24, 3, 3].
        gap: Free space wanted where skin would touch skin [m].
        limit: No more is tried once skin of a pair has moved farther than this [m].
        tell: Told before every round what is being done.

    Returns:
        The parted body, what was done, and what could not be done.
    """
    nearby = Nearby(segments.rest, segments.label, segments.pairs, APART / 2)
    tester = Intersector(segments)
    normals = Normals(segments.faces, x.shape[1])
    out = Solution(x.copy())
    stale, moved = np.ones(len(x), bool), np.zeros(x.shape[1], bool)
    crossings: list[Crossings] = [Crossings(np.zeros((0, 2), np.int64), np.zeros((0, 3)))] * len(x)
    tracks: dict[Pair, list[Track]] = {}
    for out.rounds in range(ROUNDS + 1):
        tell(f"parting, round {out.rounds + 1}")
        if out.rounds:
            if limit and any(parting.moved.max() > limit[pair] for pair, parting in out.partings.items()):
                break
            looked = np.flatnonzero(stale)
            for some in np.split(looked, range(AT_ONCE, len(looked), AT_ONCE)):
                known = [crossings[t] for t in some] if out.rounds > 1 else None
                for t, those in zip(some, tester.crossings(as_stored(out.vertices[some]), known, moved)):
                    crossings[t] = those
            out.left = _count(segments, crossings)
            if not out.left or out.rounds == ROUNDS:
                break
        found: dict[Pair, Contacts] = {}
        if out.rounds == 0:
            for start in range(0, len(x), AT_ONCE):
                bodies = x[start : start + AT_ONCE]
                for k, pair, contact in touch(segments, normals, bodies, nearby.find(bodies, gap), gap):
                    found.setdefault(pair, {})[start + k] = contact
        for pair, count in out.left.items():
            for t in np.flatnonzero(count).tolist():
                contact = pierced(segments, normals, out.vertices[t], crossings[t], pair, gap)
                found.setdefault(pair, {})[t] = contact
        stale[:], moved[:] = False, False
        for pair in sorted(found):
            for contacts in _clusters(segments, found[pair]):
                if out.rounds % 2:
                    changed, skin = fair(segments, contacts, out.vertices)
                    out.partings.setdefault(pair, Parting.nothing(*x.shape[:2])).skin[skin] = True
                else:
                    normals_of = _normals(segments, pair, contacts, tracks.setdefault(pair, []), axes, out.vertices)
                    changed, skin = _part(segments, pair, contacts, normals_of, gap, out)
                stale |= changed
                moved[skin] = True
        for parting in out.partings.values():
            parting.measure(x, out.vertices)
    return out


def _clusters(segments: Segments, contacts: Contacts) -> list[Contacts]:
    """The contacts of a pair, those of all frames together, apart by where on the second segment they lie."""
    where = np.unique(np.concatenate([c.b for c in contacts.values()]))
    i, j = cKDTree(segments.rest[where]).query_pairs(LINK, output_type="ndarray").T
    links = sp.coo_array((np.ones(len(i), bool), (i, j)), shape=(len(where),) * 2)
    number, cluster = connected_components(links, directed=False)
    out: list[Contacts] = [{} for _ in range(number)]
    for t, contact in contacts.items():
        mine = cluster[np.searchsorted(where, contact.b)]
        for k in np.unique(mine):
            out[k][t] = contact.only(mine == k)
    return out


def _normals(
    segments: Segments, pair: Pair, contacts: Contacts, tracks: list[Track], axes: NDArray[np.float64], x: Frames
) -> NDArray[np.float64]:
    """Normals of a cluster's planes, shape [T, 3]: those of an earlier cluster in the same place, if there is one."""
    where = segments.rest[np.unique(np.concatenate([c.b for c in contacts.values()]))]
    for tree, normals in tracks:
        if np.isfinite(tree.query(where, distance_upper_bound=LINK)[0]).any():
            return normals
    normals = glide(contacts, x, axes[:, carrier(pair)])
    tracks.append((cKDTree(where), normals))
    return normals


def as_stored(x: Frames) -> Frames:
    """Vertices [m] as the shard keeps them, in fixed point: what is tested must be what is read."""
    return (np.rint(x.astype(np.float64) / POSITION_QUANTUM) * POSITION_QUANTUM).astype(np.float32)


def _part(
    segments: Segments, pair: Pair, contacts: Contacts, normals: NDArray[np.float64], gap: float, out: Solution
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Moves both segments to their sides of the surface between them.

    Returns:
        Frames that changed, shape [T], and vertices that were moved.
    """
    frames = len(out.vertices)
    rows = np.concatenate([segments.members(pair[0]), segments.members(pair[1])])
    side = np.where(segments.label[rows] == pair[0], 1.0, -1.0)
    need = np.zeros((frames, len(rows)), np.float32)
    for t, contact in contacts.items():
        x = out.vertices[t]
        skin, mine = x[np.unique(np.concatenate([contact.a, contact.b]))], x[rows]
        about = (mine > skin.min(axis=0) - ABOUT) & (mine < skin.max(axis=0) + ABOUT)
        near = np.flatnonzero(about[:, 0] & about[:, 1] & about[:, 2])
        near = near[squares(mine[near], skin).min(axis=1) < ABOUT**2]
        height = heights(mine[near].astype(np.float64), middles(contact, x), normals[t])
        need[t, near] = np.clip(gap / 2 - side[near] * height, 0.0, None)
    used = np.flatnonzero(need.any(axis=0))
    if not len(used):
        return np.zeros(frames, bool), used
    smooth = envelope(need[:, used])
    during = np.flatnonzero(smooth.any(axis=1))
    region, u = spread(segments, pair, smooth[during], rows[used])
    out.vertices[np.ix_(during, region)] += u[:, :, None] * normals[during, None].astype(np.float32)
    record = out.partings.setdefault(pair, Parting.nothing(*out.vertices.shape[:2]))
    if out.rounds == 0:
        for t, contact in contacts.items():
            record.depth[t] = max(0.0, contact.weights.max() - gap)
    skin = region[np.abs(u).max(axis=0) > 0]
    record.skin[skin] = True
    changed = np.zeros(frames, bool)
    changed[during] = True
    return changed, skin


def _count(segments: Segments, crossings: list[Crossings]) -> dict[Pair, NDArray[np.int32]]:
    """Number of crossings of each pair of segments in each frame, shape [T]."""
    count = np.zeros((len(NAMES), len(NAMES), len(crossings)), np.int32)
    for t, found in enumerate(crossings):
        a, b = np.sort(segments.face_label[found.faces], axis=1).T
        np.add.at(count, (a, b, t), 1)
    return {(int(a), int(b)): count[a, b] for a, b in np.argwhere(count.any(axis=2))}

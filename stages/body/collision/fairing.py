"""Smooths skin that is still tangled, most of it at the bottom of folds, where skinning crumples it."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stages.body.collision.contacts import Contact
from stages.body.collision.field import envelope
from stages.body.collision.segments import Segments

RADIUS = 0.03
"""How far about tangled skin it is smoothed [m]."""

SWEEPS = 12
"""Sweeps of smoothing."""

STEP = 0.9
"""Share of the way to the mean of its neighbours that a vertex goes in a sweep, in the middle of the tangle."""


def fair(
    segments: Segments, contacts: dict[int, Contact], x: NDArray[np.float32]
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Smooths the skin about some contacts, fading in and out in space and time.

    Args:
        segments: The person's segments.
        contacts: Frame -> vertices of tangled faces.
        x: Vertices [m], shape [T, V, 3]; they are moved in place.

    Returns:
        Frames that changed, shape [T], and vertices that were moved.
    """
    rest, frames = segments.rest, len(x)
    rows = np.unique(np.concatenate([np.concatenate([c.a, c.b]) for c in contacts.values()]))
    tangled = np.zeros((frames, len(rows)), np.float32)
    for t, contact in contacts.items():
        tangled[t, np.searchsorted(rows, np.concatenate([contact.a, contact.b]))] = 1.0
    tangled = envelope(tangled)
    during = np.flatnonzero(tangled.any(axis=1))
    near = cKDTree(rest[rows]).query(rest, distance_upper_bound=RADIUS)[0]
    region = np.flatnonzero(np.isfinite(near))
    apart = np.linalg.norm(rest[region, None] - rest[None, rows], axis=2)
    share = np.clip(1.0 - apart / RADIUS, 0.0, 1.0)
    share = share * share * (3.0 - 2.0 * share)
    weight = np.zeros((len(region), len(during)), np.float32)
    for k in range(len(rows)):
        weight = np.maximum(weight, share[:, k, None] * tangled[during, k])
    mean = segments.mean[region]
    used = np.unique(mean.indices)
    place = np.searchsorted(used, region)
    mean = sp.csr_array(mean[:, used])
    moving = x[np.ix_(during, used)].transpose(1, 0, 2).copy()
    for _ in range(SWEEPS):
        goal = (mean @ moving.reshape(len(used), -1)).reshape(len(region), len(during), 3)
        moving[place] += STEP * weight[:, :, None] * (goal - moving[place])
    x[np.ix_(during, region)] = moving[place].transpose(1, 0, 2)
    changed = np.zeros(frames, bool)
    changed[during] = True
    return changed, region

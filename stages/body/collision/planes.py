"""The surface between two segments: a plane's normal that glides in time, and heights that follow the contact."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from stages.body.collision.contacts import Contact

Array = NDArray[np.float64]

GLIDE = 2.0
"""Standard deviation in time of a plane's turning [frames]."""

TRUST = 0.02
"""The contact's own shape decides the plane's normal where it is wider than this, the skin's normals where it is less
[m]."""

BEND = 0.015
"""The surface follows the contact over this distance: standard deviation of a Gaussian [m]."""


def fit(contact: Contact, x: NDArray[np.float32]) -> Array:
    """Normal of the plane through a contact.

    It minimises sum w ((n . q)^2 - TRUST^2 (n . n0)^2), where q are the midpoints between the two skins about their
    centre, w the weights, and n0 the way out that the skins' normals tell: the least squares plane where the contact is
    wide, and a defined one where it is a line or a point.

    Args:
        contact: Vertices that touch.
        x: Vertices of the body [m], shape [V, 3].

    Returns:
        Unit normal towards the first segment, shape [3].
    """
    middle = middles(contact, x)
    share = contact.weights / contact.weights.sum()
    offset = middle - share @ middle
    scatter = (offset * share[:, None]).T @ offset - TRUST**2 * np.outer(contact.normal, contact.normal)
    normal: Array = np.linalg.eigh(scatter)[1][:, 0]
    return normal if normal @ contact.normal >= 0 else -normal


def middles(contact: Contact, x: NDArray[np.float32]) -> Array:
    """Points half way between the two skins [m], shape [N, 3]."""
    return (x[contact.a].astype(np.float64) + x[contact.b]) / 2


def glide(contacts: Mapping[int, Contact], x: NDArray[np.float32], axes: Array) -> Array:
    """Normals of all frames, from those of the frames that have a contact.

    Args:
        contacts: Frame -> contact, at least one.
        x: Vertices of the body [m], shape [T, V, 3].
        axes: Axes in which the plane turns little, as columns, shape [T, 3, 3].

    Returns:
        Unit normals, shape [T, 3]; of use near frames that have a contact.
    """
    frames = np.array(sorted(contacts))
    local = np.stack([fit(contacts[t], x[t]) @ axes[t] for t in frames])
    weight = np.array([contacts[t].weights.sum() for t in frames])
    # Between contacts the plane keeps that of the nearest one.
    every = np.arange(len(x))
    after = np.searchsorted(frames, every).clip(0, len(frames) - 1)
    before = (after - 1).clip(0)
    nearest = np.where(np.abs(every - frames[before]) <= np.abs(frames[after] - every), before, after)
    inside = np.where(np.isin(every, frames), 1.0, 1e-3)
    weights = weight[nearest] * inside
    mean = gaussian_filter1d(local[nearest] * weights[:, None], GLIDE, axis=0, mode="nearest")
    normals = np.einsum("tij,tj->ti", axes, mean)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30))


def heights(points: Array, middle: Array, normal: Array) -> Array:
    """Height of points over the surface between two segments.

    The surface is a graph over the plane: its height is the mean of that of the contact's midpoints, weighted by a
    Gaussian of their distance along the plane. Whatever lies above one graph can't cross what lies below it.

    Args:
        points: Points [m], shape [N, 3].
        middle: Midpoints of the contact [m], shape [M, 3].
        normal: Unit normal of the plane, shape [3].

    Returns:
        Heights [m], shape [N].
    """
    up, base = points @ normal, middle @ normal
    flat, foot = points - up[:, None] * normal, middle - base[:, None] * normal
    squared = (flat**2).sum(axis=1)[:, None] + (foot**2).sum(axis=1) - 2 * flat @ foot.T
    squared -= squared.min(axis=1, keepdims=True)
    weight = np.exp(-0.5 * squared / BEND**2)
    return np.asarray(up - weight @ base / weight.sum(axis=1))

"""Register one garment: the stage's core, arrays in and arrays out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.body.layer import TOPOLOGY, GarmentLayer
from model.mesh.barycentric import carry
from stages.register.config import RegisterConfig
from stages.register.cover import Cover, cover
from stages.register.fit import Gate, fit
from stages.register.quality import Quality, measure
from stages.register.source import source_surface
from stages.register.target import Target

FLARED = ("skirt", "dress")
"""Types that may stand far off the body."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Registration:
    """A garment in the layer's topology.

    Attributes:
        cover: Correspondences and mask.
        registered: Registered vertices in the rest frame [m], 0 outside the mask, shape [N, 3].
        quality: Errors.
    """

    cover: Cover
    registered: NDArray[np.float64]
    quality: Quality


def register_garment(
    vertices: ArrayLike,
    faces: ArrayLike,
    layer: GarmentLayer,
    betas: ArrayLike,
    kind: str,
    config: RegisterConfig,
    rng: np.random.Generator,
) -> Registration:
    """Fits the layer to a garment in rest pose and reads off where each vertex lies on it.

    Args:
        vertices: Garment in the rest frame [m], shape [M, 3].
        faces: Triangles, counter-clockwise seen from outside, shape [G, 3].
        layer: The layer of the wearer's body model.
        betas: Shape of the body that the garment was resized to, shape [b]. Not the wearer's own: on the body it was
            made for, a garment lies at an even distance and its borders lie where they were cut, so that the mask tells
            the cut alone, whatever the tightness, and long legs of a large garment do not end beyond the layer.
        kind: Type of the garment, a key of `TOPOLOGY`.
        config: Settings.
        rng: For the points at which the error is measured.

    Returns:
        The registration.
    """
    topology = TOPOLOGY[kind]
    layer_faces = layer.faces(topology)
    target = Target(vertices, faces, config.flange, config.normal_scale)
    gate = Gate(reach=config.skirt_reach if kind in FLARED else config.reach, turn=config.turn)
    fitted = fit(source_surface(layer, betas, topology), layer_faces, target, gate, config.coarse, config.fine)
    found = cover(fitted, layer_faces, target, config.tolerance)
    registered = carry(vertices, faces, found.face, found.barycentric)
    quality = measure(vertices, faces, registered, layer_faces, found.mask, found.face, rng, config.samples)
    return Registration(cover=found, registered=registered, quality=quality)

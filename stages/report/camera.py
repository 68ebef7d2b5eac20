"""A perspective camera in the world frame (z up)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# A short portrait lens: 85 mm over the 36 mm long side of a full frame. Wider lenses fatten whatever is near.
FIELD_OF_VIEW = 2.0 * np.arctan(0.5 * 36.0 / 85.0)


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole camera that looks from `position` to `target` with z up in the picture.

    Attributes:
        position: Centre of projection [m].
        target: World point shown in the middle of the picture [m].
        field_of_view: Angle between the top and the bottom of the picture [rad].
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    field_of_view: float = FIELD_OF_VIEW

    @classmethod
    def around(cls, target: Array, azimuth: float, *, height: float = 2.1, elevation: float = 0.10) -> Camera:
        """A camera on a circle around `target`.

        Args:
            target: World point in the middle of the picture [m], shape [3].
            azimuth: Direction from the target to the camera, counter-clockwise from +x seen from above [rad];
                -pi/2 looks at the front of a person who faces -y.
            height: What the picture's height covers at the target's distance [m].
            elevation: Angle of the camera above the target's horizon [rad].
        """
        distance = 0.5 * height / np.tan(0.5 * FIELD_OF_VIEW)
        flat = np.cos(elevation)
        away = np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
        x, y, z = np.asarray(target, dtype=float)
        px, py, pz = np.array([x, y, z]) + distance * away
        return cls(position=(float(px), float(py), float(pz)), target=(float(x), float(y), float(z)))

    def axes(self) -> Array:
        """Unit vectors right, up and forward as rows, shape [3, 3]."""
        forward = np.subtract(self.target, self.position)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right = right / np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward), forward])

    def directions(self, pixels: ArrayLike, width: int, height: int) -> NDArray[np.float32]:
        """Unit directions through points of the picture.

        Args:
            pixels: Columns (rightwards) and rows (downwards) [px], shape [N, 2]; a pixel's centre is at +0.5.
            width: Width of the picture [px].
            height: Height of the picture [px].

        Returns:
            Directions from `position`, shape [N, 3].
        """
        at = np.asarray(pixels, dtype=float)
        right, up, forward = self.axes().astype(np.float32)
        scale = 2.0 * np.tan(0.5 * self.field_of_view) / height
        across = ((at[:, 0] - 0.5 * width) * scale).astype(np.float32)
        rise = ((0.5 * height - at[:, 1]) * scale).astype(np.float32)
        inverse = 1.0 / np.sqrt(1.0 + across * across + rise * rise)
        columns = [(across * right[k] + rise * up[k] + forward[k]) * inverse for k in range(3)]
        return np.stack(columns, axis=1)

    def project(self, points: Array, width: int, height: int) -> Array:
        """Where points of the world [m], shape [N, 3], fall in the picture [px], shape [N, 2]."""
        local = (points - np.asarray(self.position)) @ self.axes().T
        scale = height / (2.0 * np.tan(0.5 * self.field_of_view))
        return np.stack(
            [0.5 * width + scale * local[:, 0] / local[:, 2], 0.5 * height - scale * local[:, 1] / local[:, 2]], axis=1
        )

"""Energies of a cloth [J], in plain NumPy: what the solver's cannot exceed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.simulate.make_stepper import joined, per_vertex
from stages.simulate.scene import Scene
from stages.simulate.springs import Springs, bending_length, bending_rows


@dataclass(frozen=True)
class Energy:
    """Energies of one state [J]: of motion, height, stretch and bending."""

    kinetic: float
    height: float
    stretch: float
    bending: float

    @property
    def total(self) -> float:
        """Their sum."""
        return self.free + self.stretch + self.bending

    @property
    def free(self) -> float:
        """That of motion and height."""
        return self.kinetic + self.height


class EnergyMeter:
    """Tells the energy of any state of a scene's cloth.

    The energy stored in contacts isn't counted: it was cloth's before and comes back at most, so that the sum without
    it never exceeds the start's either.
    """

    def __init__(self, scene: Scene, springs: Springs, gravity: float) -> None:
        vertices, faces, _, _ = joined(scene)
        self.springs, self.gravity = springs, gravity
        rigidity = per_vertex(scene, "bend_stiffness")
        length = bending_length(rigidity, per_vertex(scene, "density"))
        self.rows, self.bend = bending_rows(vertices, faces, rigidity, length)

    def __call__(self, x: np.ndarray, v: np.ndarray) -> Energy:
        """Energy at positions x [m] and velocities v [m/s], shape [N, 3]."""
        s = self.springs
        length = np.linalg.norm(x[s.edges[:, 0]] - x[s.edges[:, 1]], axis=1)
        beyond = np.maximum(length - s.rest_length * (1 + s.limit), 0.0)
        stretch = 0.5 * s.stiffness * ((length - s.rest_length) ** 2 + (s.stiffening - 1) * beyond**2)
        apart = ((x[self.rows[:, 0]] - x[self.rows[:, 1]]) ** 2).sum(1)
        return Energy(
            kinetic=float(0.5 * (s.mass * (v**2).sum(1)).sum()),
            height=float(-self.gravity * (s.mass * x[:, 2]).sum()),
            stretch=float(stretch.sum()),
            bending=float(-0.5 * (self.bend * apart).sum()),
        )

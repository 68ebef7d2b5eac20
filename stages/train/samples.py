"""What a network is trained on and scored on: garments bound to bodies, as tables that samples point into."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """S samples over N layer vertices, in the rest frame; tables are shared by the samples that point into them.

    SVAE's sample is a garment: `target` is its offsets from the body at rest. DVAE's is a garment in one frame:
    `target` is what posing the garment at rest by the skin weights lacks, turned back into the rest frame, and `worn`
    the offsets at rest.

    Attributes:
        names: item/garment, and /frame for DVAE.
        types: Garment type of each sample.
        skirt: Whether the skirt topology applies, shape (S,).
        train: Whether the sample is in the training split, shape (S,).
        target: Offsets to predict [m], continued outside the garment, shape (S, N, 3).
        cvar: Conditions, shape (S, C).
        garment: Row in `mask` and `worn`, shape (S,).
        wearer: Row in `body` and `normals`, shape (S,).
        mask: Which vertices the garment covers, shape (G, N).
        worn: Offsets that `target` is added to [m], shape (G, N, 3), or None if it is added to the body.
        body: Layer vertices at rest [m], shape (W, N, 3).
        normals: Their unit normals, shape (W, N, 3).
        frame: Row in `posed`, shape (S,), or None.
        posed: Layer vertices in each frame, relative to the root joint [m], shape (P, N, 3), or None.
    """

    names: tuple[str, ...]
    types: tuple[str, ...]
    skirt: NDArray[np.bool_]
    train: NDArray[np.bool_]
    target: NDArray[np.float32]
    cvar: NDArray[np.float32]
    garment: NDArray[np.int64]
    wearer: NDArray[np.int64]
    mask: NDArray[np.bool_]
    worn: NDArray[np.float32] | None
    body: NDArray[np.float32]
    normals: NDArray[np.float32]
    frame: NDArray[np.int64] | None = None
    posed: NDArray[np.float32] | None = None

    def __len__(self) -> int:
        return len(self.names)

    @property
    def masks(self) -> NDArray[np.bool_]:
        """Mask of each sample, shape (S, N)."""
        return self.mask[self.garment]

    def base(self, rows: NDArray[np.int64]) -> NDArray[np.float32]:
        """What the offsets of `rows` are added to [m], shape (B, N, 3)."""
        bodies = self.body[self.wearer[rows]]
        return bodies if self.worn is None else bodies + self.worn[self.garment[rows]]

    def select(self, rows: NDArray[np.int64]) -> Samples:
        """The samples `rows`, over the same tables."""
        return replace(
            self,
            names=tuple(self.names[k] for k in rows),
            types=tuple(self.types[k] for k in rows),
            skirt=self.skirt[rows],
            train=self.train[rows],
            target=self.target[rows],
            cvar=self.cvar[rows],
            garment=self.garment[rows],
            wearer=self.wearer[rows],
            frame=None if self.frame is None else self.frame[rows],
        )


def micro_batches(skirt: NDArray[np.bool_], size: int, rng: np.random.Generator) -> list[NDArray[np.int64]]:
    """All samples in random order, cut into batches of at most `size` that each have one topology.

    Args:
        skirt: Which samples have the skirt topology, shape (S,).
        size: Samples of a micro-batch.
        rng: Source of the order.
    """
    batches: list[NDArray[np.int64]] = []
    for wanted in (False, True):
        rows = rng.permutation(np.flatnonzero(skirt == wanted))
        batches += [rows[k : k + size] for k in range(0, len(rows), size)]
    return [batches[k] for k in rng.permutation(len(batches))]

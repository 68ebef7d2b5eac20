"""The body that a preview shows: freed from itself as the stage does it, or marked where it would be rejected."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model.body import BodyModel
from stages.body.config import Config
from stages.body.figure import Figure, measure
from stages.body.freeing import UnsolvableError, free_body
from stages.body.motion import Motion
from stages.report.palette import Colour
from stages.report.scene import Surface

Array = NDArray[np.float64]

LEFT_OUT: Colour = (0.62, 0.62, 0.62)
AT_FAULT: Colour = (0.85, 0.2, 0.13)


@dataclass(frozen=True, kw_only=True, eq=False)
class Solved:
    """A body that moves: freed from itself, or what stands in the way."""

    motion: Motion
    """Its motion."""
    surfaces: list[Surface]
    """The body, perhaps in parts of their own colours."""
    at_fault: frozenset[int] = frozenset()
    """Frames for which the body would be rejected."""
    told: str = ""
    """What was done to it."""

    @classmethod
    def raw(cls, model: BodyModel, betas: Array, motion: Motion) -> Solved:
        """A body as its model has it."""
        vertices = model.pose(betas, motion.pose, motion.trans).astype(np.float64)
        return cls(motion=motion, surfaces=[Surface(vertices=vertices, faces=model.faces)])

    @classmethod
    def of(cls, model: BodyModel, betas: Array, move: Callable[[Figure], Motion], name: str) -> Solved:
        """A body as the stage makes it, in the frames that `move` gives."""
        try:
            freed = free_body(model, np.asarray(betas, np.float32), move, Config(), name)
        except UnsolvableError as error:
            plain = cls.raw(model, betas, move(measure(model, betas)))
            marked = error.marked[model.faces].any(axis=1)
            whole = plain.surfaces[0]
            return replace(
                plain,
                surfaces=[replace(whole, faces=model.faces[~marked]), _part(whole, model.faces[marked], AT_FAULT)],
                at_fault=frozenset(error.frames),
                told=f"would be rejected: {error}",
            )
        vertices = freed.vertices + freed.motion.trans[:, None]
        whole = Surface(vertices=vertices.astype(np.float64), faces=model.faces[freed.face_kept])
        surfaces = [whole]
        if not freed.face_kept.all():
            surfaces.append(_part(whole, model.faces[~freed.face_kept], LEFT_OUT))
        moved = max((float(values.max()) for key, values in freed.moved.items() if key == "moved"), default=0.0)
        left_out, steps = freed.record["left_out"], freed.record["thinner"]
        told = f"self-collision: {freed.record['case']}, skin moved by {1e3 * moved:.0f} mm at most"
        told += f", without {', '.join(left_out)} for the cloth" if left_out else ""
        told += f", thinner by {steps} of {Config().thinner_tries} steps" if steps else ""
        return cls(motion=freed.motion, surfaces=surfaces, told=told)


def _part(whole: Surface, faces: NDArray[np.int32], colour: Colour) -> Surface:
    return Surface(vertices=whole.vertices, faces=faces, cloth=colour)

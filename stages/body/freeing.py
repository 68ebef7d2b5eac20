"""From a person and a motion to a body that can be dressed: limbs opened, skin parted; or why not.

The paper's cases (CLOTH3D, "Self-collision"), decided in this order: solved; solved with a thinner body; special, with
hands, forearms or arms left out of what cloth collides with; rejected.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.body import BodyModel, joint_transforms
from stages.body.collision.segments import ARMS, JOINTS, NAMES, pair_name, segment
from stages.body.collision.solve import MOVED, Solution, part_segments
from stages.body.collision.thinner import thinner
from stages.body.collision.verdict import Fault, limits, opening_faults, parting_faults
from stages.body.config import LEAVE_OUT, Config
from stages.body.figure import Figure, measure
from stages.body.hygiene import Opening, open_limbs
from stages.body.motion import Motion
from stages.body.parts import divide
from stages.spec import DataError

Betas = NDArray[np.float32]
Tell = Callable[[str], object]

PROBE = 10
"""Frames before and after the worst one of the body tried last, on which another is tried first."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Freed:
    """A body that can be dressed."""

    betas: Betas
    """Shape coefficients, perhaps of a thinner person than the one that was drawn, shape [B]."""
    motion: Motion
    """The motion with free limbs."""
    vertices: NDArray[np.float32]
    """The parted skin, the root joint at the origin [m], shape [T, V, 3]."""
    face_kept: NDArray[np.bool_]
    """Whether cloth collides with each face, shape [F]."""
    opening: dict[str, float]
    """How far limbs were opened, largest and smallest figures over all frames, SI units."""
    record: dict[str, Any]
    """What was decided and why, and the names of the pairs in `moved`."""
    moved: dict[str, NDArray[np.generic]]
    """For each frame and pair of segments: how deep, how far moved [m], how many vertices, shape [T, P] each."""


class UnsolvableError(DataError):
    """A body whose collisions can't be solved; carries what a picture of it needs."""

    def __init__(
        self, cause: str, frame: int, vertices: NDArray[np.float32], marked: NDArray[np.bool_], frames: set[int]
    ) -> None:
        """The cause on one line.

        Args:
            cause: What, where, the value, the limit and the remedy.
            frame: The worst frame.
            vertices: The body there [m], shape [V, 3].
            marked: Vertices at fault, shape [V].
            frames: All frames in which something is at fault.
        """
        super().__init__(cause)
        self.frame, self.vertices, self.marked, self.frames = frame, vertices, marked, frames


@dataclass(frozen=True, eq=False)
class _Attempt:
    """One body tried."""

    betas: Betas
    thinner: int
    left_out: tuple[int, ...]
    motion: Motion
    opening: Opening | None
    before: NDArray[np.float32]
    solution: Solution
    label: NDArray[np.int64]
    face_label: NDArray[np.int64]
    faults: list[Fault]


def free_body(
    model: BodyModel,
    betas: Betas,
    move: Callable[[Figure], Motion],
    config: Config,
    name: str,
    *,
    still: bool = False,
    tell: Tell = lambda label: None,
) -> Freed:
    """Opens limbs and parts skin, with a thinner body or without arms if it must be.

    Args:
        model: The body.
        betas: Shape coefficients drawn, shape [B].
        move: Puts the motion on a person.
        config: Gaps and limits.
        name: Name of the item, for errors.
        still: Whether the pose must stay as it is, as that of a person at rest.
        tell: Told what is being done.

    Returns:
        The body.

    Raises:
        UnsolvableError: None of what may be tried solves the collisions.
        DataError: The motion can't be put on this person.
    """

    def attempt(shape: Betas, steps: int, left_out: tuple[int, ...], part: slice = slice(None)) -> _Attempt:
        def moved(figure: Figure) -> Motion:
            return move(figure).cut(part)

        return _try(model, shape, steps, left_out, moved, config, still, tell)

    first = attempt(betas, 0, ())
    if not first.faults:
        return _freed(first, None, betas)
    frame = first.faults[0].frame
    # A foot is held where it is throughout a contact: how far it must be moved is not told by a few frames.
    feet = first.opening is not None and first.opening.foot_shift.max() > config.largest_shift
    worth = not feet and len(first.motion) > 2 * (2 * PROBE + 1)
    for shape, steps, left_out in _choices(model, betas, config, first.faults):
        # What doesn't help where the last one failed worst needn't be tried on the whole sequence.
        about = slice(max(0, frame - PROBE), frame + PROBE + 1)
        if worth and attempt(shape, steps, left_out, about).faults:
            continue
        other = attempt(shape, steps, left_out)
        if not other.faults:
            return _freed(other, first, betas)
        frame = other.faults[0].frame
    worst = first.faults[0]
    marked = np.isin(first.label, worst.segments)
    tried = f"{config.thinner_tries} thinner bodies and leaving out up to {config.leave_out}"
    cause = f"{name}: {worst.cause}; {tried} didn't help; choose another motion or a thinner body"
    frames = {frame for fault in first.faults for frame in fault.frames}
    raise UnsolvableError(cause, worst.frame, first.before[worst.frame], marked, frames)


def _choices(
    model: BodyModel, betas: Betas, config: Config, faults: list[Fault]
) -> Iterator[tuple[Betas, int, tuple[int, ...]]]:
    """What else to try in turn: betas, how many times thinner, segments left out."""
    shape = betas
    for step in range(config.thinner_tries):
        slim = thinner(model, shape, config.thinner_step)
        if np.array_equal(slim, shape):
            break
        shape = slim
        yield shape, step + 1, ()
    seen: set[tuple[int, ...]] = {()}
    for level in range(1, LEAVE_OUT.index(config.leave_out) + 1):
        left_out = _arms_at_fault(faults, len(LEAVE_OUT) - 1 - level)
        if left_out not in seen:
            seen.add(left_out)
            yield betas, 0, left_out


def _arms_at_fault(faults: list[Fault], innermost: int) -> tuple[int, ...]:
    """Segments of the arms at fault, from the `innermost` (0 is the upper arm) out; none if a fault isn't an arm's."""
    out: set[int] = set()
    for fault in faults:
        mine = [arm for arm in ARMS if set(arm) & set(fault.segments)]
        if not mine:
            return ()
        for arm in mine:
            out |= set(arm[innermost:])
    return tuple(sorted(out))


def _try(
    model: BodyModel,
    betas: Betas,
    steps: int,
    left_out: tuple[int, ...],
    move: Callable[[Figure], Motion],
    config: Config,
    still: bool,
    tell: Tell,
) -> _Attempt:
    figure = measure(model, betas)
    motion, opening, faults = move(figure), None, []
    if not still:
        joints = {joint for row in left_out for joint in JOINTS[NAMES[row]]}
        gaps, most = (config.arm_gap, config.leg_gap), (config.largest_turn, config.largest_shift)
        motion, opening = open_limbs(figure, divide(model, betas, joints), motion, gaps, tell, most)
        faults = opening_faults(opening, *most)
    vertices = model.pose(betas, motion.pose, np.zeros_like(motion.trans))
    solution, segments = Solution(vertices), segment(model, betas, left_out)
    if not faults:
        axes = joint_transforms(figure.joints, model.parents, motion.pose)[..., :3]
        limit = limits(segments, config.largest_move)
        solution = part_segments(segments, vertices, axes, config.separation, limit, tell)
        faults = parting_faults(solution, limit)
    return _Attempt(
        betas, steps, left_out, motion, opening, vertices, solution, segments.label, segments.face_label, faults
    )


def _freed(attempt: _Attempt, first: _Attempt | None, drawn: Betas) -> Freed:
    partings = attempt.solution.partings
    pairs = [pair for pair in sorted(partings) if partings[pair].moved.max() > MOVED]
    case = "free" if not pairs else "solved"
    if attempt.thinner:
        case = "thinner"
    if attempt.left_out:
        case = "special"
    record: dict[str, Any] = {
        "case": case,
        "why": [] if first is None else [fault.cause for fault in first.faults],
        "betas_drawn": [float(beta) for beta in drawn],
        "thinner": attempt.thinner,
        "left_out": [NAMES[row] for row in attempt.left_out],
        "rounds": attempt.solution.rounds,
        "pairs": [pair_name(pair) for pair in pairs],
    }
    return Freed(
        betas=attempt.betas,
        motion=attempt.motion,
        vertices=attempt.solution.vertices,
        face_kept=~np.isin(attempt.face_label, attempt.left_out),
        opening=_figures(attempt.opening),
        record=record,
        moved={
            name: np.stack([getattr(partings[pair], name) for pair in pairs], axis=1)
            for name in ("depth", "moved", "vertices")
            if pairs
        },
    )


def _figures(opening: Opening | None) -> dict[str, float]:
    """Largest and smallest figures over all frames."""
    if opening is None:
        return {}
    return {key: float(np.min(v) if "distance" in key else np.max(v)) for key, v in asdict(opening).items()}

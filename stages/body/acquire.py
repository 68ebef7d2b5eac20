"""The motion that an item asks for: an embedded clip by name, or a file, read once for all the bodies tried."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from stages.body.actions import action_of
from stages.body.figure import Figure
from stages.body.motion import Motion
from stages.body.readers import fingerprint, read_motion, split_name, title
from stages.body.sequence import cut, embedded, prepared, put_on
from stages.spec import DataError


@dataclass(frozen=True, kw_only=True)
class Performance:
    """The frames that an item asks for, on nobody yet."""

    motion: str
    """Name of the motion."""
    action: str
    """What is done in it."""
    mended: str
    """What was wrong with its recording and is mended."""
    on: Callable[[Figure], Motion]
    """Puts it on a person; raises a DataError if the person can't be moved by it, or it is too short."""


def acquire(params: Mapping[str, Any], joints: Mapping[str, str], rate: float) -> Performance:
    """The frames that an item asks for.

    Args:
        params: motion, motion_sha256, start and frames, and action if a list of labels told it.
        joints: Which joint of a file moves which joint of the body, where the names don't tell.
        rate: Frames per second of files that don't tell theirs.

    Returns:
        The motion, to be put on a person.

    Raises:
        DataError: There is no such motion, it can't be used, or it has changed since the run was planned.
    """
    motion, start, frames = (params[name] for name in ("motion", "start", "frames"))
    path, _ = split_name(motion)
    if path.name == motion and not path.suffix:

        def clip(figure: Figure) -> Motion:
            return cut(embedded(figure, motion), start, frames, motion, whole=True)

        return Performance(motion=motion, action=action_of(motion), mended="", on=clip)
    wanted = params["motion_sha256"]
    if wanted and fingerprint(motion) != wanted:
        raise DataError(f"{path.name}: the file has changed since the run was planned; plan again")
    name = title(motion)
    recording, mended = prepared(read_motion(motion, joints=joints, rate=rate), path.name)

    def recorded(figure: Figure) -> Motion:
        return cut(put_on(figure, recording, path.name), start, frames, path.name, whole=False)

    action = params.get("action", "") or action_of(name)
    return Performance(motion=name, action=action, mended="; ".join(mended), on=recorded)

"""The motion that an item asks for, on its person: an embedded clip by name, or a file."""

from collections.abc import Mapping
from typing import Any

from stages.body.actions import action_of
from stages.body.figure import Figure
from stages.body.motion import Motion
from stages.body.readers import fingerprint, read_motion, split_name, title
from stages.body.sequence import cut, embedded, prepared, put_on
from stages.spec import DataError


def acquire(
    figure: Figure, params: Mapping[str, Any], joints: Mapping[str, str], rate: float
) -> tuple[Motion, str, str, str]:
    """The frames that an item asks for.

    Args:
        figure: The person.
        params: motion, motion_sha256, start and frames, and action if a list of labels told it.
        joints: Which joint of a file moves which joint of the body, where the names don't tell.
        rate: Frames per second of files that don't tell theirs.

    Returns:
        The motion, its name and its action, and what was wrong with its recording and is mended.

    Raises:
        DataError: There is no such motion, it can't be used, or it has changed since the run was planned.
    """
    motion, start, frames = (params[name] for name in ("motion", "start", "frames"))
    path, _ = split_name(motion)
    if path.name == motion and not path.suffix:
        return cut(embedded(figure, motion), start, frames, motion, whole=True), motion, action_of(motion), ""
    wanted = params["motion_sha256"]
    if wanted and fingerprint(motion) != wanted:
        raise DataError(f"{path.name}: the file has changed since the run was planned; plan again")
    name = title(motion)
    recording, mended = prepared(read_motion(motion, joints=joints, rate=rate), path.name)
    part = cut(put_on(figure, recording, path.name), start, frames, path.name, whole=False)
    return part, name, params.get("action", "") or action_of(name), "; ".join(mended)

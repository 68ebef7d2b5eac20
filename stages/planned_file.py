"""A file that a recipe names, read by a stage only if it is still the one that was planned with."""

import hashlib
from pathlib import Path

from store import ShardError


def planned_content(path: str, sha256: str, what: str) -> bytes:
    """The content of a file whose hash the plan wrote into the task.

    Args:
        path: The file.
        sha256: Hash of its content when the run was planned, in hex.
        what: What it is, for messages.

    Raises:
        ShardError: It isn't there any more, or has changed.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise ShardError(path, f"{what} can't be read ({error.strerror})", "put it back or plan again") from None
    if hashlib.sha256(content).hexdigest() != sha256:
        raise ShardError(path, f"{what} has changed since the run was planned", "plan again")
    return content

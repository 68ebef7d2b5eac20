"""The store's errors: one line that says what, where, the value found and the remedy."""

from __future__ import annotations

import errno
from pathlib import Path

# A full disk, a full quota and a file-size limit call for the same remedy: room.
NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})


class ShardError(Exception):
    """A shard that can't be published or must not be used.

    Attributes:
        path: The shard.
        problem: What was found there, in one line.
        remedy: What to do about it.
    """

    def __init__(self, path: Path | str, problem: str, remedy: str) -> None:
        self.path = Path(path)
        self.problem = " ".join(problem.split())
        self.remedy = remedy
        super().__init__(f"{self.path}: {self.problem}; {remedy}")

    def __reduce__(self) -> tuple[type[ShardError], tuple[Path, str, str]]:
        return type(self), (self.path, self.problem, self.remedy)


class NoSpaceError(ShardError):
    """The file system has no room for the shard; nothing of it was left behind."""


def no_space(path: Path, error: OSError) -> NoSpaceError:
    """The `NoSpaceError` for an `OSError` whose `errno` is one of `NO_ROOM`."""
    return NoSpaceError(path, f"no room to write it ({error.strerror})", "free some space there and run again")

"""Publishing by rename: a reader sees the whole file or none, whatever was killed or full."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from store.errors import NO_ROOM, no_space

_SUFFIX = ".tmp"


def temporary_name(path: Path) -> Path:
    """A hidden name beside `path`, this process's own; `remove_orphans` knows it by its ending."""
    return path.with_name(f".{path.name}.{os.getpid()}{_SUFFIX}")


def replace_file(path: Path, content: bytes | memoryview) -> None:
    """Make `path` hold `content`: temporary file, fsync, rename, fsync of the folder.

    Raises:
        NoSpaceError: No room; the temporary file is removed and `path` is as it was.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_name(path)
    with removed_on_failure(path, temporary):
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
        fsync_folder(path.parent)


@contextmanager
def removed_on_failure(path: Path, temporary: Path) -> Iterator[None]:
    """Remove `temporary` if the body fails, and name a full disk for what it is."""
    try:
        yield
    except BaseException as error:
        if temporary.is_dir():
            shutil.rmtree(temporary, ignore_errors=True)
        else:
            temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno in NO_ROOM:
            raise no_space(path, error) from error
        raise


def fsync_folder(folder: Path) -> None:
    """Make a rename in `folder` survive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def remove_orphans(folder: Path) -> list[Path]:
    """Remove what killed publishers left under `folder`; call it only when no publisher can be alive there."""
    orphans = sorted(folder.rglob(f".*{_SUFFIX}"))
    for orphan in orphans:
        if orphan.is_dir():
            shutil.rmtree(orphan, ignore_errors=True)
        else:
            orphan.unlink(missing_ok=True)
    return orphans

"""Deep verification of anything published: a shard file or a folder."""

from __future__ import annotations

from pathlib import Path

from store.folder import read_folder
from store.shard import Header, read, read_header


def check(path: Path | str, schema: str | None = None, key: str | None = None) -> Header:
    """Verify all of `path`, to the last byte, and return what it says of itself.

    Raises:
        ShardError: The first fault found; one line.
    """
    path = Path(path)
    return read_folder(path, key) if path.is_dir() else read(path, schema, key).header


def peek(path: Path | str, schema: str | None = None, key: str | None = None) -> Header:
    """Verify what `path` says of itself, without reading its data."""
    path = Path(path)
    return read_folder(path, key, deep=False) if path.is_dir() else read_header(path, schema, key)

"""Files that a recipe names, each checked once: sizes, times and hashes are kept in a cache file between runs."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from pathlib import Path

from store.atomic import replace_file


class CheckedFiles:
    """Hashes of files that were found usable.

    Args:
        cache: The cache file; one that is missing or can't be read is written anew.
    """

    def __init__(self, cache: Path) -> None:
        self._cache = cache
        self._known: dict[str, list[int | str]] = {}
        with contextlib.suppress(OSError, ValueError):  # nothing is known yet
            self._known = json.loads(cache.read_text())

    def sha256(self, path: Path, use: str, check: Callable[[], str]) -> str:
        """Hash of the file's content, in hex.

        Args:
            path: The file.
            use: What it is checked for; checked for something else, it is read again.
            check: Reads it, raises if it can't be used, and returns the hash. What it raises is passed on.
        """
        try:
            about = path.stat()
            stamp = [about.st_size, about.st_mtime_ns]
        except OSError:
            stamp = []  # reading it says why
        said = f"{path} {use}"
        entry = self._known.get(said)
        if entry is None or entry[:2] != stamp:
            self._known[said] = entry = [*stamp, check()]
        return str(entry[-1])

    def save(self) -> None:
        """Write the cache."""
        replace_file(self._cache, json.dumps(self._known).encode())

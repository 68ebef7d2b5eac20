"""Publishing a folder of files, such as the report, with a `key.json` that lists them and their checksums."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path

from store.atomic import fsync_folder, removed_on_failure, temporary_name
from store.content import schema_named
from store.errors import ShardError
from store.shard import Header

KEY_FILE = "key.json"


def publish_folder(path: Path | str, key: str, build: Callable[[Path], None], schema: str = "report") -> None:
    """Let `build` fill a new folder, then put it at `path`; an older folder there is replaced.

    A folder can't be replaced in one step: a kill between the two renames leaves none at `path`, never half of one.

    Raises:
        NoSpaceError: No room; nothing is left behind and an older folder stays as it was.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_name(path)
    shutil.rmtree(temporary, ignore_errors=True)
    with removed_on_failure(path, temporary):
        temporary.mkdir()
        build(temporary)
        header = {"schema": schema, "schema_version": schema_named(schema).version, "key": key}
        (temporary / KEY_FILE).write_text(json.dumps({**header, "files": _digests(temporary)}, indent=1))
        _fsync_tree(temporary)
        if path.exists():
            aside = temporary_name(path.with_name(path.name + ".old"))
            path.replace(aside)
            temporary.replace(path)
            shutil.rmtree(aside)
        else:
            temporary.replace(path)
        fsync_folder(path.parent)


def read_folder(path: Path | str, key: str | None = None, deep: bool = True) -> Header:
    """What the folder's `key.json` says, verified against its files: by checksum if `deep`, else by presence.

    Raises:
        ShardError: No folder, no key file, another key, or files that are missing or changed; one line.
    """
    path = Path(path)
    remedy = "remove it and make it again"
    try:
        said = json.loads((path / KEY_FILE).read_text())
        header = Header(said["schema"], said["schema_version"], said["key"], _digest_of(said["files"]), {})
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ShardError(path, f"its {KEY_FILE} can't be read ({error})", remedy) from None
    version = schema_named(header.schema).version
    if header.schema_version != version:
        problem = f"schema {header.schema} v{header.schema_version} where this program reads v{version}"
        raise ShardError(path, problem, remedy)
    if key is not None and header.key != key:
        raise ShardError(path, f"it has key {header.key[:12]}, not {key[:12]}: it's out of date", remedy)
    for name, digest in said["files"].items():
        file = path / name
        if not file.is_file() or (deep and _sha256(file) != digest):
            raise ShardError(file, "changed since it was published" if file.is_file() else "missing", remedy)
    return header


def _digests(folder: Path) -> dict[str, str]:
    files = sorted(file for file in folder.rglob("*") if file.is_file() and file.name != KEY_FILE)
    return {file.relative_to(folder).as_posix(): _sha256(file) for file in files}


def _digest_of(files: dict[str, str]) -> str:
    return hashlib.sha256(json.dumps(files, sort_keys=True).encode()).hexdigest()


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _fsync_tree(folder: Path) -> None:
    for entry in [folder, *folder.rglob("*")]:
        fsync_folder(entry)

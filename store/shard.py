"""Reading a shard: verified first, decoded when asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from store import codec, content
from store.errors import ShardError
from store.schema import SCHEMAS

_REMAKE = "remove it and make it again"


@dataclass(frozen=True)
class Header:
    """What a shard says of itself.

    Attributes:
        schema: Name of its schema.
        schema_version: Version of that schema when it was written.
        key: Key of the task that published it.
        checksum: sha256 of its content, in hex.
        attrs: Its JSON attributes.
    """

    schema: str
    schema_version: int
    key: str
    checksum: str
    attrs: dict[str, Any]


class Shard:
    """A shard's arrays by name, decoded on access, and its `attrs`.

    `shard["garments/tshirt/vertices"]` is float32 in the schema's units, or the exact type for indices and masks.
    """

    def __init__(self, path: Path, header: Header, stored: Mapping[str, Any], quanta: Mapping[str, float]) -> None:
        self.path = path
        self.header = header
        self.attrs = header.attrs
        self._stored = stored
        self._quanta = quanta

    def __getitem__(self, name: str) -> np.ndarray:
        return self._decoded(name, ())

    def __contains__(self, name: object) -> bool:
        return name in self._stored

    def __iter__(self) -> Iterator[str]:
        return iter(self._stored)

    def frame(self, name: str, index: int) -> np.ndarray:
        """Frame `index` of dataset `name` with axes (T, ...), without decoding the others."""
        return self._decoded(name, index)

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of dataset `name`."""
        return tuple(self._entry(name).shape)

    def groups(self, prefix: str) -> list[str]:
        """Sorted names of the groups in group `prefix`, as the garments in "garments"."""
        start = prefix.rstrip("/") + "/"
        return sorted({name[len(start) :].split("/")[0] for name in self._stored if name.startswith(start)})

    def _decoded(self, name: str, index: int | tuple[()]) -> np.ndarray:
        entry = self._entry(name)
        with _named_damage(self.path, f" in dataset {name!r}"):
            stored = np.asarray(entry[index])
        return codec.decode(stored, self._quanta[name])

    def _entry(self, name: str) -> Any:
        try:
            return self._stored[name]
        except KeyError:
            have = ", ".join(self._stored)
            raise ShardError(self.path, f"no dataset {name!r}; it has {have}", "ask for one of these") from None


def read(path: Path | str, schema: str | None = None, key: str | None = None) -> Shard:
    """Read a whole shard into memory, still encoded, and verify all of it.

    Args:
        path: The shard.
        schema: Schema that it must follow; None allows any known one.
        key: Key that it must carry; None allows any.

    Raises:
        ShardError: Missing, not HDF5, truncated, damaged, or of another schema, version or key; one line.
    """
    path = Path(path)
    with _open(path) as file, _named_damage(path):
        header = _header(path, file, schema, key)
        stored, about = _load(path, file)
    raw = {name: getattr(header, name) for name in ("schema", "schema_version", "key")}
    raw["attrs"] = json.dumps(header.attrs, sort_keys=True, separators=(",", ":"))
    found = content.checksum(raw, {name: (values, about[name]) for name, values in stored.items()})
    if found != header.checksum:
        problem = f"damaged: its content has checksum {found[:12]}, it says {header.checksum[:12]}"
        raise ShardError(path, problem, _REMAKE)
    return Shard(path, header, stored, {name: float(about[name]["quantum"]) for name in stored})


@contextmanager
def open_shard(path: Path | str, schema: str | None = None, key: str | None = None) -> Iterator[Shard]:
    """Open a shard to read some of its frames: header verified; each chunk is verified by its own checksum when read.

    Raises:
        ShardError: As `read`, but damage to data shows only when the damaged frame is read.
    """
    path = Path(path)
    with _open(path) as file:
        with _named_damage(path):
            header = _header(path, file, schema, key)
            stored = dict(_datasets(file))
            quanta = {name: float(entry.attrs["quantum"]) for name, entry in stored.items()}
        yield Shard(path, header, stored, quanta)


def read_header(path: Path | str, schema: str | None = None, key: str | None = None) -> Header:
    """What the shard says of itself, verified against `schema` and `key`; its data isn't read."""
    path = Path(path)
    with _open(path) as file, _named_damage(path):
        return _header(path, file, schema, key)


def _open(path: Path) -> h5py.File:
    if not path.is_file():
        raise ShardError(path, "no such shard" if not path.exists() else "not a file", "make it first")
    size = path.stat().st_size
    try:
        # Without locks: published shards never change, and locks hang on some network file systems.
        return h5py.File(path, "r", locking=False)
    except Exception as error:
        problem = "empty" if size == 0 else f"not a readable HDF5 file of {size} bytes ({_short(error)})"
        raise ShardError(path, problem, _REMAKE) from None


@contextmanager
def _named_damage(path: Path, where: str = "") -> Iterator[None]:
    """Name the shard when HDF5 fails in the body; what HDF5 raises depends on which byte is damaged."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise ShardError(path, f"damaged{where} ({_short(error)})", _REMAKE) from None


def _header(path: Path, file: h5py.File, schema: str | None, key: str | None) -> Header:
    missing = [name for name in ("schema", "schema_version", "key", "checksum", "attrs") if name not in file.attrs]
    if missing:
        raise ShardError(path, f"not a shard: it has no attribute {missing[0]!r}", _REMAKE)
    header = Header(
        schema=str(file.attrs["schema"]),
        schema_version=int(file.attrs["schema_version"]),
        key=str(file.attrs["key"]),
        checksum=str(file.attrs["checksum"]),
        attrs=json.loads(file.attrs["attrs"]),
    )
    wanted = schema if schema is not None else header.schema
    if header.schema != wanted or wanted not in SCHEMAS:
        raise ShardError(path, f"it follows schema {header.schema!r}, not {wanted!r}", "name the right shard")
    version = SCHEMAS[wanted].version
    if header.schema_version != version:
        problem = f"schema {wanted} v{header.schema_version} where this program reads v{version}"
        older = header.schema_version < version
        raise ShardError(path, problem, _REMAKE if older else "use the newer program that wrote it, or " + _REMAKE)
    if key is not None and header.key != key:
        raise ShardError(path, f"it has key {header.key[:12]}, not {key[:12]}: it's out of date", _REMAKE)
    return header


def _load(path: Path, file: h5py.File) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
    stored: dict[str, np.ndarray] = {}
    about: dict[str, dict[str, Any]] = {}
    for name, entry in _datasets(file):
        with _named_damage(path, f" in dataset {name!r}"):
            stored[name] = np.asarray(entry[()])
        about[name] = {label: _plain(value) for label, value in entry.attrs.items()}
    return stored, about


def _datasets(file: h5py.File) -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []

    def visit(name: str, entry: object) -> None:
        if isinstance(entry, h5py.Dataset):
            found.append((name, entry))

    file.visititems(visit)
    return sorted(found, key=lambda pair: pair[0])


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _short(error: BaseException) -> str:
    return " ".join(str(error).split())[:160]

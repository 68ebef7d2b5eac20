"""Checks that a shard's content follows its schema, and the checksum over that content."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from store import codec
from store.schema import SCHEMAS, SHARED_AXES, Dataset, Schema


def schema_named(name: str) -> Schema:
    """The schema called `name`.

    Raises:
        ValueError: There is none; one line.
    """
    if name not in SCHEMAS:
        raise ValueError(f"schema must be one of {', '.join(sorted(SCHEMAS))}, got {name!r}")
    return SCHEMAS[name]


def encode_all(schema: Schema, arrays: Mapping[str, np.ndarray]) -> dict[str, tuple[np.ndarray, Dataset]]:
    """Encode every array as `schema` says, sorted by name.

    Raises:
        ValueError: An unknown or missing dataset, a wrong shape, or a value that can't be stored; one line.
    """
    encoded: dict[str, tuple[np.ndarray, Dataset]] = {}
    sizes: dict[tuple[str, str], tuple[int, str]] = {}
    for name in sorted(arrays):
        pattern = schema.match(name)
        if pattern is None:
            raise ValueError(f"dataset {name!r} isn't in schema {schema.name} v{schema.version}")
        dataset = schema.datasets[pattern]
        values = np.asarray(arrays[name])
        _check_shape(name, values.shape, dataset, sizes)
        try:
            encoded[name] = (codec.encode(values, dataset.dtype, dataset.quantum), dataset)
        except ValueError as error:
            raise ValueError(f"dataset {name!r} [{dataset.units}]: {error}") from None
    _check_complete(schema, encoded)
    return encoded


def encode_attrs(schema: Schema, attrs: Mapping[str, Any]) -> str:
    """Canonical JSON of `attrs`; NumPy scalars and arrays become numbers and lists.

    Raises:
        ValueError: A required attribute is missing, or a value isn't JSON or isn't finite; one line.
    """
    missing = [name for name in schema.attrs if name not in attrs]
    if missing:
        raise ValueError(f"attribute {missing[0]!r} of schema {schema.name} v{schema.version} is missing")
    for name, value in attrs.items():
        try:
            json.dumps(value, default=_plain, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise ValueError(f"attribute {name!r} must be finite JSON: {error}") from None
    return json.dumps(attrs, default=_plain, allow_nan=False, sort_keys=True, separators=(",", ":"))


def checksum(header: Mapping[str, Any], stored: Mapping[str, tuple[np.ndarray, Mapping[str, Any]]]) -> str:
    """sha256 [hex] over the header, and over every dataset's name, type, shape, attributes and bytes."""
    digest = hashlib.sha256(json.dumps(header, sort_keys=True).encode())
    for name in sorted(stored):
        values, about = stored[name]
        line = [name, values.dtype.newbyteorder("<").str, list(values.shape), dict(about)]
        digest.update(json.dumps(line, sort_keys=True).encode())
        digest.update(np.ascontiguousarray(values).data)
    return digest.hexdigest()


def _check_shape(name: str, shape: tuple[int, ...], dataset: Dataset, sizes: dict[tuple[str, str], Any]) -> None:
    if dataset.axes == "...":
        return
    axes = dataset.axes.split()
    if len(axes) != len(shape):
        raise ValueError(f"dataset {name!r}: shape must be ({', '.join(axes)}), got {shape}")
    for axis, size in zip(axes, shape):
        scope = ("" if axis in SHARED_AXES else name.rpartition("/")[0], axis)
        wanted, source = (int(axis), "the schema") if axis.isdigit() else sizes.setdefault(scope, (size, name))
        if size != wanted:
            raise ValueError(f"dataset {name!r}: axis {axis} must be {wanted} as in {source}, got shape {shape}")


def _check_complete(schema: Schema, encoded: Mapping[str, Any]) -> None:
    groups = sorted({name.rpartition("/")[0] for name in encoded if "/" in name})
    for pattern, dataset in schema.datasets.items():
        if dataset.optional or pattern.endswith("**"):
            continue
        parent, _, leaf = pattern.rpartition("/")
        if "*" in parent:
            wanted = [f"{group}/{leaf}" for group in groups if schema.match(f"{group}/{leaf}") == pattern]
        else:
            wanted = [pattern]
        for name in wanted:
            if name not in encoded:
                raise ValueError(f"dataset {name!r} of schema {schema.name} v{schema.version} is missing")


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} isn't JSON")

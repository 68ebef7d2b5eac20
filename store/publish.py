"""Publishing a shard: equal content gives equal bytes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from store import content
from store.atomic import replace_file
from store.errors import ShardError
from store.schema import Dataset

_GZIP_LEVEL = 4  # gzip is in every HDF5 build: a shard opens anywhere without a plugin
_CORE_BLOCK = 1 << 20  # [bytes] growth step of the image in memory


def publish(
    path: Path | str, schema: str, key: str, arrays: Mapping[str, np.ndarray], attrs: Mapping[str, Any]
) -> None:
    """Publish a shard at `path`, atomically; an older one there is replaced.

    Args:
        path: Final path; its folder is made if need be.
        schema: Name in `store.schema.SCHEMAS`.
        key: Key of the task, sha256 in hex.
        arrays: Dataset name -> values, in the schema's units and axes.
        attrs: JSON values.

    Raises:
        ShardError: The content doesn't follow the schema, or has a NaN, an infinity or a value out of range.
        NoSpaceError: No room; nothing is left behind and an older shard stays as it was.
    """
    path = Path(path)
    try:
        kind = content.schema_named(schema)
        encoded = content.encode_all(kind, arrays)
        header = {"schema": kind.name, "schema_version": kind.version, "key": key}
        header["attrs"] = content.encode_attrs(kind, attrs)
    except ValueError as error:
        raise ShardError(path, str(error), "not published; correct the stage that makes it") from None
    # Made in memory, then written by plain calls: HDF5 can't recover from a disk that fills under it.
    replace_file(path, _image(header, encoded))


def about(dataset: Dataset) -> dict[str, Any]:
    """The attributes that a dataset carries in the file."""
    return {"units": dataset.units, "axes": dataset.axes, "quantum": dataset.quantum, "origin": dataset.origin}


def _image(header: Mapping[str, Any], encoded: Mapping[str, tuple[np.ndarray, Dataset]]) -> bytes:
    # The v110 format has a checksum on every piece of metadata and no limit of 64 KiB on an attribute.
    with h5py.File(
        "shard", "w", driver="core", backing_store=False, block_size=_CORE_BLOCK, libver=("v110", "v110")
    ) as file:
        for name, value in header.items():
            file.attrs[name] = value
        file.attrs["checksum"] = content.checksum(
            header, {name: (values, about(dataset)) for name, (values, dataset) in encoded.items()}
        )
        for name, (values, dataset) in encoded.items():
            # HDF5 stamps new groups and datasets with the clock unless told not to.
            made = file.create_dataset(name, data=values, track_times=False, **_storage(values, dataset))
            for label, value in about(dataset).items():
                made.attrs[label] = value
        file.flush()
        image: bytes = file.id.get_file_image()
    return image


def _storage(values: np.ndarray, dataset: Dataset) -> dict[str, Any]:
    if values.size == 0 or values.ndim == 0:
        return {}  # HDF5 has no chunks of no elements
    chunks = (1, *values.shape[1:]) if dataset.axes.startswith("T ") else values.shape
    return {
        "chunks": chunks,
        "compression": "gzip",
        "compression_opts": _GZIP_LEVEL,
        "shuffle": True,
        "fletcher32": True,
    }

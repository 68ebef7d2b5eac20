"""A published shard to read and to damage."""

import sys
from pathlib import Path

import pytest

import store

sys.path.insert(0, str(Path(__file__).parent))

from shards import KEY, body_arrays, body_attrs


@pytest.fixture
def shard(tmp_path: Path) -> Path:
    """A valid shard of schema "body" under `KEY`."""
    path = tmp_path / "walk.h5"
    store.publish(path, "body", KEY, body_arrays(), body_attrs())
    return path

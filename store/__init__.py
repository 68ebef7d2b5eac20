"""Bytes and schemas: what a shard holds, how it is published and read. Knows shapes, not physics."""

from store.errors import NoSpaceError, ShardError
from store.folder import publish_folder
from store.publish import publish
from store.shard import Header, Shard, open_shard, read, read_header

__all__ = [
    "Header",
    "NoSpaceError",
    "Shard",
    "ShardError",
    "open_shard",
    "publish",
    "publish_folder",
    "read",
    "read_header",
]

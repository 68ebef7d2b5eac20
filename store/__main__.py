"""Command line of the store: `python -m store inspect SHARD` and `python -m store check SHARD ...`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from store import ShardError
from store.check import check
from store.inspect import describe


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; 0, or 1 with one line on stderr for each shard at fault."""
    parser = argparse.ArgumentParser(prog="python -m store", description="Look into shards and verify them.")
    commands = parser.add_subparsers(dest="command", required=True)
    inspect = commands.add_parser("inspect", help="show a shard's header, datasets, units, ranges and attributes")
    inspect.add_argument("shard")
    checking = commands.add_parser("check", help="verify shards to the last byte")
    checking.add_argument("shards", nargs="+")
    given = parser.parse_args(arguments)
    if given.command == "inspect":
        try:
            print("\n".join(describe(given.shard)))
        except ShardError as error:
            print(error, file=sys.stderr)
            return 1
        return 0
    failed = 0
    for path in given.shards:
        try:
            header = check(path)
            print(f"{path}: ok, {header.schema} v{header.schema_version}, key {header.key[:12]}")
        except ShardError as error:
            print(error, file=sys.stderr)
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())

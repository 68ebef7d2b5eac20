"""What the people of a dataset do: the table of statistics per action label, from the shards of bodies.

As in CLOTH3D's table, labels are grouped into broad actions; see `stages.body.actions`.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from stages.body.actions import count_actions
from store import ShardError, open_shard


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the table of the dataset that the command line names; 0, or 1 with one line on stderr."""
    parser = argparse.ArgumentParser(
        prog="python -m stages.body statistics", description="Count what the people of a dataset do."
    )
    parser.add_argument("dataset", type=Path, metavar="FOLDER", help="a dataset's folder, or its folder of bodies")
    given = parser.parse_args(arguments)
    folder = given.dataset / "body" if (given.dataset / "body").is_dir() else given.dataset
    try:
        labels = read_labels(folder)
    except ShardError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        return 1
    if not labels:
        print(f"{folder}: there are no bodies in motion; name a dataset's folder", file=sys.stderr)
        return 1
    print(table(labels))
    return 0


def read_labels(folder: Path) -> list[tuple[str, int]]:
    """Label and number of frames of each sequence of a folder of shards.

    Raises:
        ShardError: A shard can't be read.
    """
    labels = []
    for path in sorted(folder.glob("*.h5")):
        with open_shard(path, "body") as shard:
            if shard.attrs["kind"] == "sequence":
                labels.append((str(shard.attrs["action"]), shard.shape("trans")[0]))
    return labels


def table(labels: Sequence[tuple[str, int]]) -> str:
    """The table: broad action, sequences, frames and share of the frames."""
    rows = count_actions(labels)
    sequences, frames = sum(row[1] for row in rows), sum(row[2] for row in rows)
    lines = [f"{'action':<10} {'sequences':>9} {'frames':>9} {'share':>8}"]
    lines += [f"{name:<10} {count:>9} {length:>9} {length / frames:>8.2%}" for name, count, length in rows]
    return "\n".join([*lines, f"{'all':<10} {sequences:>9} {frames:>9} {1:>8.2%}"])


if __name__ == "__main__":
    sys.exit(main())

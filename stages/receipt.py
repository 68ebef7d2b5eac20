"""Receipts: a small JSON beside a shard that says what it was made from, and what making it cost.

A receipt lies at `<stage's folder>/receipts/<item>.json` and is published after the shard. Wall time, memory and
figures stand here and never in the shard, so that equal tasks give equal shards.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stages.settings import plain
from store.atomic import replace_file
from store.folder import KEY_FILE

PUBLISHED = "published"
REJECTED = "rejected"


@dataclass(frozen=True, kw_only=True)
class Receipt:
    """What is known of one task that ended.

    Attributes:
        stage, item, key: The task.
        status: "published", or "rejected" if its input is at fault: it is then not tried again under this key.
        document: Key document; see `stages.key.key_document`.
        cause: Why it was rejected, one line.
        size: Size of what was published [bytes].
        mtime_ns: Its time of change [ns]: if size and time are as here, it wasn't touched since.
        sha256: Hash of the file, or of the folder's key file.
        wall_s: Time it took [s].
        peak_bytes: Peak memory of its process meanwhile [bytes].
        figures: What the stage reported.
    """

    stage: str
    item: str
    key: str
    status: str
    document: dict[str, Any]
    cause: str = ""
    size: int = 0
    mtime_ns: int = 0
    sha256: str = ""
    wall_s: float = 0.0
    peak_bytes: int = 0
    figures: dict[str, Any] = field(default_factory=dict)


def receipt_path(output: Path, item: str) -> Path:
    """Where the receipt of the task that publishes `output` lies."""
    return output.parent / "receipts" / f"{item}.json"


def write(output: Path, receipt: Receipt) -> None:
    """Publish `receipt` for `output`, by rename."""
    text = json.dumps(plain(receipt), indent=1, sort_keys=True, default=lambda value: value.tolist())
    replace_file(receipt_path(output, receipt.item), text.encode())


def load(path: Path) -> Receipt | None:
    """The receipt at `path`; None if there is none or it can't be read: it can be made again from the shard."""
    try:
        said = json.loads(path.read_text())
        names = {field.name for field in dataclasses.fields(Receipt)}
        return Receipt(**{name: value for name, value in said.items() if name in names})
    except (OSError, ValueError, TypeError, AttributeError):
        return None


def fingerprint(output: Path) -> tuple[int, int]:
    """Size [bytes] and time of change [ns] of what was published at `output`; of a folder, its key file's.

    Raises:
        FileNotFoundError: Nothing is there.
    """
    about = (output / KEY_FILE if output.is_dir() else output).stat()
    return about.st_size, about.st_mtime_ns


def file_sha256(output: Path) -> str:
    """Hash [hex] of the file published at `output`; of a folder, its key file's, which lists the others' hashes."""
    with (output / KEY_FILE if output.is_dir() else output).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()

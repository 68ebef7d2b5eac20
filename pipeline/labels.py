"""Action labels of motions, from a list such as the index of the CMU database."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.errors import PipelineError

# A motion's name and its label: "01_01<TAB>playground - forward jumps, turn around", or "walk_3,walk slowly".
LINE = re.compile(r"^\s*([A-Za-z0-9]+(?:[_-][A-Za-z0-9]+)+)\s*[\t ,;:]\s*(\S.*?)\s*$")


@dataclass(frozen=True)
class Labels:
    """Labels by the names of motions."""

    known: Mapping[str, str] = field(default_factory=dict)

    def of(self, motion: str) -> str:
        """Label of a motion file, or of one of many in a file; "" if the list hasn't got it."""
        if not self.known:
            return ""
        from stages.body.readers.survey import title

        return self.known.get(title(motion), "")


def read_labels(path: str, where: str) -> Labels:
    """Read a list of labels; lines of another kind, such as headings, are passed over. No path, no labels.

    Raises:
        PipelineError: It can't be read, or has no line with a motion's name and a label.
    """
    if not path:
        return Labels()
    try:
        text = Path(path).expanduser().read_bytes().decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise PipelineError(f"{where}: labels = {path!r}: {error.strerror}; name an existing file") from None
    known = {found[1]: found[2] for line in text.splitlines() if (found := LINE.match(line))}
    if not known:
        raise PipelineError(
            f"{where}: labels = {path!r} has no label; lines must have a motion's name, such as 01_01, and its label"
        )
    return Labels(known)

"""Action labels of motions, from a list such as the index of the CMU database."""

from __future__ import annotations

import codecs
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.errors import PipelineError

# A motion's name and its label: "01_01<TAB>playground - forward jumps, turn around", "walk_3.bvh,walk slowly", or any
# name if a tab, a comma or a semicolon follows it: "Take 7;walk". Tables may have either between quotes.
KIND = r"\.(?:bvh|amc|npz|txt)"
NAME = rf"(?P<name>[^\W_]+(?:[_-][^\W_]+)+(?:{KIND})?)"
LINE = re.compile(rf'\s*"?(?:{NAME}"?\s*[\t ,;:]|(?P<other>[^\t,;"]+?)"?\s*[\t,;])\s*"?(?P<label>\S.*?)"?\s*', re.I)


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
        text = _text(Path(path).expanduser().read_bytes())
    except OSError as error:
        raise PipelineError(f"{where}: labels = {path!r}: {error.strerror}; name an existing file") from None
    lines = [found for line in text.splitlines() if (found := LINE.fullmatch(line))]
    known = {_name(line["name"] or line["other"]): line["label"] for line in lines}
    if not known:
        raise PipelineError(
            f"{where}: labels = {path!r} has no label; lines must have a motion's name, such as 01_01, and its label"
        )
    return Labels(known)


def _text(content: bytes) -> str:
    """The text of a list: UTF-8, UTF-16 as Windows' programs mark it, else their one-byte encoding."""
    if content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def _name(told: str) -> str:
    """A motion's name as `title` gives it, from a file's name or from the name itself."""
    from stages.body.readers.survey import title

    return title(told) if re.search(rf"{KIND}$", told, re.I) else told

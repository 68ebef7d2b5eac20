"""Text files of motion, line by line, with errors that name the file, the line, the value and the remedy."""

import re
from pathlib import Path

from stages.spec import DataError

LARGEST = 1e6
"""No offset, position or angle of a person is larger, in any unit."""

TEXT_BYTES = frozenset({*b"\t\n\v\f\r", *range(32, 256)})
"""Bytes that a text in any one-byte encoding may hold."""

LINE_END = re.compile(r"\r\n|\r|\n")
"""Windows', old Macs', Unix'. No others: in other encodings joints' names may have the bytes that Unicode has more."""


def read_bytes(path: Path) -> bytes:
    """The bytes of a motion file.

    Raises:
        DataError: It is not there, or can't be read.
    """
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise DataError(f"{path}: there is no such motion file; check the path of `motion`") from None
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); check the path of `motion`") from None


class Lines:
    """The lines of a file that say something, with their numbers, and errors that name them.

    Args:
        path: The file.
        kind: What it should be, for errors, such as "BVH".
        comment: Lines that start so are left out.
        braces: Whether a brace stands for a line of its own, wherever it is.

    Raises:
        DataError: The file can't be read, is empty or is no text.
    """

    def __init__(self, path: Path, kind: str, *, comment: str = "", braces: bool = False) -> None:
        self.name = path.name
        self.at = 0
        self.rows: list[tuple[int, str]] = []  # words take ten times as much memory, and files may be large
        for number, row in enumerate(LINE_END.split(_text(path, kind)), start=1):
            line = row.replace("{", " \n{\n ").replace("}", " \n}\n ") if braces else row
            for part in line.split("\n"):
                said = part.strip()
                if said and not (comment and said.startswith(comment)):
                    self.rows.append((number, said))
        if not self.rows:
            raise DataError(f"{self.name}: the file is empty; export the motion again")

    def fault(self, what: str, line: int | None = None) -> DataError:
        """An error at a line, by default at the one read last."""
        number = line if line is not None else self.rows[max(0, min(self.at, len(self.rows)) - 1)][0]
        return DataError(f"{self.name}, line {number}: {what}")

    def more(self) -> bool:
        """Whether there is another line."""
        return self.at < len(self.rows)

    def peek(self) -> list[str]:
        """The words of the next line, none at the end of the file."""
        return self.rows[self.at][1].split() if self.more() else []

    def next(self, wanted: str) -> list[str]:
        """The words of the next line."""
        if not self.more():
            raise self.fault(f"the file ends where {wanted} should follow; export the motion again")
        self.at += 1
        return self.rows[self.at - 1][1].split()

    def numbers(self, words: list[str], what: str) -> list[float]:
        """Finite numbers of a size that a motion can have."""
        try:
            values = [float(word) for word in words]
        except ValueError:
            bad = next(word for word in words if not _is_number(word))
            raise self.fault(f"{what} must be numbers, got {bad[:40]!r}; export the motion again") from None
        for value in values:
            if not abs(value) <= LARGEST:
                raise self.fault(f"{what} must be finite and within +-{LARGEST:g}, got {value:g}; repair the motion")
        return values


def shown(words: list[str]) -> str:
    """The start of a line, for messages."""
    return repr(" ".join(words)[:40])


def is_count(word: str) -> bool:
    """Whether a word is a whole number that a count in a motion file may be."""
    return word.isascii() and word.isdecimal() and len(word) < 10


def _text(path: Path, kind: str) -> str:
    content = read_bytes(path).rstrip(b"\x1a")  # DOS's end of a text
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise DataError(f"{path.name}: is written in UTF-16; save it as UTF-8 text")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # joints may have names with accents
    if not TEXT_BYTES.issuperset(content):
        raise DataError(f"{path.name}: is not a {kind} text file (it holds binary data); name a whole {kind} file")
    return text


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True

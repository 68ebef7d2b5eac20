"""Reads the arrays of an npz file from a stranger: no pickles, and no more memory than the file may take.

`np.load` makes room for whatever a header announces, and lists whatever the archive announces. Here sizes are held
against each other first. Format: PKWARE's APPNOTE (zip), `numpy.lib.format` (npy).
"""

import io
import math
import re
import struct
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.body.refusal import BodyFileError

MOST_BYTES = 2**30
"""Bytes that the arrays of one file may take in memory [bytes]: those of SMPL-X take a quarter of it."""

MOST_DIRECTORY = 2**20
"""Bytes of an archive's directory [bytes]: some 10,000 entries, where a model has 20."""

MOST_HEADER = 10_000
"""Bytes of an array's header [bytes], numpy's own limit."""

_REMEDY = "get the file anew from where it is published"
_END = struct.Struct("<4s4H2LH")
_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError, struct.error)


class NpzArrays:
    """The arrays of an npz file, read when they are asked for."""

    def __init__(self, content: bytes) -> None:
        """Opens the archive.

        Args:
            content: The file.

        Raises:
            BodyFileError: It is truncated, damaged or has too many entries.
        """
        self._left = MOST_BYTES
        _check_directory(content)
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(content))
        except (*_DAMAGE, ValueError, UnicodeError) as error:
            raise BodyFileError(f"truncated or damaged: no npz archive ({_short(error)}); {_REMEDY}") from None
        self._entries = {info.filename.removesuffix(".npy"): info for info in self._archive.infolist()}

    def __contains__(self, name: str) -> bool:
        return name in self._entries

    def __iter__(self) -> Any:
        return iter(self._entries)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The array of that name; it is read-only.

        Raises:
            BodyFileError: It is damaged, isn't of numbers, or announces more than there is.
        """
        info = self._entries[name]
        self._left -= info.file_size
        if self._left < 0:
            raise BodyFileError(f"announces {info.file_size} bytes, the arrays of a file have {MOST_BYTES} at most")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise BodyFileError("is compressed in another way than numpy does it")
        try:
            with self._archive.open(info) as file:
                content = file.read(info.file_size + 1)
        except (*_DAMAGE, ValueError, UnicodeError) as error:
            raise BodyFileError(f"is damaged ({_short(error)})") from None
        return _parse(content)


def _check_directory(content: bytes) -> None:
    """Refuse an archive whose list of entries alone would take long to read."""
    place = content.rfind(b"PK\5\6", max(0, len(content) - _END.size - 2**16))
    if place < 0 or place + _END.size > len(content):
        raise BodyFileError(f"truncated: the npz archive has no end; {_REMEDY}")
    size = _END.unpack_from(content, place)[5]
    if size > MOST_DIRECTORY or content[max(0, place - 20) : place].startswith(b"PK\6\7"):
        raise BodyFileError(f"the npz archive has too many entries: their list must have <= {MOST_DIRECTORY} bytes")


def _parse(content: bytes) -> NDArray[Any]:
    """An npy file's array."""
    file = io.BytesIO(content)
    try:
        version = np.lib.format.read_magic(file)
        read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}[version]
        shape, fortran, dtype = read(file, max_header_size=MOST_HEADER)
    except (ValueError, KeyError, TypeError, SyntaxError, RecursionError, MemoryError, OverflowError) as error:
        raise BodyFileError(f"is no array of numpy ({_short(error)})") from None
    if not re.fullmatch(r"[<>|](b1|[iu][1248]|f[248])", dtype.str):
        kind = "an array of Python objects, which aren't read" if dtype.hasobject else f"an array of type {dtype.str!r}"
        raise BodyFileError(f"is {kind}; only numbers are")
    raw = content[file.tell() :]
    if len(shape) > 4 or any(size < 0 for size in shape) or math.prod(shape) * dtype.itemsize != len(raw):
        raise BodyFileError(f"announces the shape {str(shape)[:80]} of {dtype}, but has {len(raw)} bytes")
    array = np.frombuffer(raw, dtype)
    return array.reshape(shape[::-1]).T if fortran else array.reshape(shape)


def _short(error: BaseException) -> str:
    return " ".join(str(error).split())[:80] or type(error).__name__

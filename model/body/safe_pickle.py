"""Reads the arrays out of a pickle without running anything: a pickle is a program, and here it calls nothing.

Files of SMPL are pickles of arrays, often of Python 2 and wrapped in objects of chumpy, which no longer imports. So
whatever a file names becomes a `Held`, which keeps what the file gives it and does nothing; it must be in `_ADMITTED`
or chumpy's even so. `pickled_arrays` makes arrays from these where they are asked for.

The opcodes are carried out by Python's own unpickler, the one written in Python: unlike that in C it takes no room for
a place in its memo that a file merely names. It is held back where a small file could take much of it: sizes against
the file, keys that aren't texts (nested tuples are hashed without end), what is called, and the number of steps.
"""

import io
import pickle
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from model.body.refusal import BodyFileError

MOST_OPCODES = 500_000
"""Opcodes and their arguments; a model of SMPL has a few thousand. It bounds the time to about a second."""

LONGEST_NAME = 100
"""Signs of a name: those of chumpy have 30. A longer one could be made again and again until memory is full."""

_REMEDY = "get the file anew from where it is published"

_ADMITTED = {
    *(f"numpy.{name}" for name in ("ndarray", "matrix", "matrixlib.defmatrix.matrix", "dtype")),
    *(
        f"numpy.{core}.{name}"
        for core in ("core", "_core")
        for name in ("multiarray._reconstruct", "multiarray.scalar", "numeric._frombuffer")
    ),
    *(
        f"scipy.sparse.{folder}{form}.{form}_{kind}"
        for folder in ("", "_")
        for form in ("csc", "csr")
        for kind in ("matrix", "array")
    ),
    *(f"{name}.{kind}" for name in ("__builtin__", "builtins") for kind in ("set", "frozenset", "bytes", "object")),
    *("copy_reg._reconstructor", "copyreg._reconstructor", "_codecs.encode"),
}
"""Names that a file may use: how numpy and scipy pickle arrays, and how Python 2 and 3 pickle around them."""

_REFUSED = (
    *(pickle.EXT1, pickle.EXT2, pickle.EXT4, pickle.PERSID, pickle.BINPERSID),
    *(pickle.NEXT_BUFFER, pickle.READONLY_BUFFER, pickle.NEWOBJ_EX, pickle.LONG4),
)
"""Opcodes that stand in no file of arrays: what stands outside the file, keyword arguments, endless whole numbers."""


@dataclass(eq=False, slots=True)
class Held:
    """Something that a file names, or would make of it, as the name, what it would be made from, and its state."""

    path: str
    arguments: tuple[Any, ...] = ()
    state: Any = None

    @property
    def name(self) -> str:
        """The name without its module."""
        return self.path.rpartition(".")[2]

    @property
    def is_chumpy(self) -> bool:
        """Whether it is one of chumpy's."""
        return self.path.startswith("chumpy.")


def read_pickle(content: bytes) -> dict[str, Any]:
    """The dictionary that a pickle holds; values are plain, or `Held`. Texts of Python 2 are read as Latin-1.

    Args:
        content: The file.

    Returns:
        Its entries whose keys are texts.

    Raises:
        BodyFileError: It is truncated or too long, asks for a name that isn't admitted, or isn't a dictionary.
    """
    file = _File(content)
    try:
        found = _Unpickler(file, encoding="latin1").load()
    except BodyFileError:
        raise
    except EOFError:
        raise BodyFileError(f"truncated: the pickle goes on after its {len(content)} bytes; {_REMEDY}") from None
    except KeyError:  # of the opcodes: nothing else is looked up by what a file says
        place = file.place - 1
        where = f"byte {place} is {content[place : place + 1]!r}"
        raise BodyFileError(f"not a pickle of arrays: {where}, which none has; {_REMEDY}") from None
    except (pickle.UnpicklingError, AttributeError, IndexError, TypeError, ValueError):
        where = f"makes no sense at byte {file.place}"
        raise BodyFileError(f"truncated or damaged: the pickle {where}; {_REMEDY}") from None
    if not isinstance(found, dict):
        raise BodyFileError(f"the pickle holds {described(found)}, not a dictionary of arrays; {_REMEDY}")
    return found


def described(value: Any) -> str:
    """What a value is, in a word, for errors."""
    match value:
        case Held():
            return value.path[:80]
        case str() | bytes():
            return "a text"
        case list() | tuple():
            return "a list"
        case dict():
            return "a dictionary"
        case int() | float():
            return "a number"
    return "nothing"


class _File:
    """A file of which no more is read than there is, and that not without end."""

    def __init__(self, content: bytes) -> None:
        self._file = io.BytesIO(content)
        self._reads = 0

    @property
    def place(self) -> int:
        return self._file.tell()

    def read(self, count: int) -> bytes:
        self._reads += 1
        if self._reads > MOST_OPCODES:
            limit = f"more than {MOST_OPCODES} opcodes and arguments"
            raise BodyFileError(f"the pickle has {limit}, a body has a few thousand; {_REMEDY}")
        found = self._file.read(count)
        if len(found) < count:
            raise EOFError
        return found

    def readline(self) -> bytes:
        line = self._file.readline()
        if not line.endswith(b"\n"):
            raise EOFError
        return line


class _Texts(dict[str, Any]):
    """A dictionary that leaves out keys which aren't texts: none of them names an array."""

    __slots__ = ()

    def __setitem__(self, key: Any, value: Any) -> None:
        if isinstance(key, str):
            super().__setitem__(key, value)


_PYTHONS: dict[int, Callable[[Any], None]] = {
    code: step for code, step in pickle._Unpickler.dispatch.items() if bytes([code]) not in _REFUSED
}


class _Unpickler(pickle._Unpickler):
    """Python's unpickler, for which names are names only."""

    stack: list[Any]
    append: Callable[[Any], None]
    pop_mark: Callable[[], list[Any]]

    def find_class(self, module: str, name: str) -> Held:
        asked = Held(f"{module}.{name}")
        if asked.path not in _ADMITTED and not (asked.is_chumpy and len(asked.path) <= LONGEST_NAME):
            raise BodyFileError(
                f"the pickle asks for {asked.path[:80]!r}, which no array of numpy, scipy or chumpy needs: it may be "
                f"meant to run code and isn't read; {_REMEDY}"
            )
        return asked

    def _instantiate(self, kind: Any, arguments: list[Any] | tuple[Any, ...]) -> None:
        if not isinstance(kind, Held):
            raise pickle.UnpicklingError
        match kind.name, arguments:
            case "_reconstructor", (Held() as made, _, _):
                self.append(Held(made.path))
            case "encode", (str() as letters, "latin1"):  # bytes that Python 3 wrote for Python 2
                self.append(letters)
            case "bytes", ():
                self.append(b"")
            case _:
                self.append(Held(kind.path, tuple(arguments)))

    def _reduce(self) -> None:
        arguments, kind = self.stack.pop(), self.stack.pop()
        if not isinstance(arguments, tuple):  # it is kept as it stands: a copy for each call could fill memory
            raise pickle.UnpicklingError
        self._instantiate(kind, arguments)

    def _build(self) -> None:
        state, target = self.stack.pop(), self.stack[-1]
        if not isinstance(target, Held) or target.state is not None:
            raise pickle.UnpicklingError
        target.state = state

    def _dictionary(self) -> None:
        items = self.pop_mark()
        self.append(_Texts())
        for key, value in zip(items[::2], items[1::2], strict=True):
            self.stack[-1][key] = value

    dispatch: ClassVar[dict[int, Callable[[Any], None]]] = _PYTHONS | {
        pickle.REDUCE[0]: _reduce,
        pickle.NEWOBJ[0]: _reduce,
        pickle.BUILD[0]: _build,
        pickle.DICT[0]: _dictionary,
        pickle.EMPTY_DICT[0]: lambda self: self.append(_Texts()),
        # Sets are lists here: their elements would be hashed.
        pickle.EMPTY_SET[0]: lambda self: self.append([]),
        pickle.ADDITEMS[0]: _PYTHONS[pickle.APPENDS[0]],
        pickle.FROZENSET[0]: _PYTHONS[pickle.TUPLE[0]],
        # As bytes, for which no room is taken before they are there.
        pickle.BYTEARRAY8[0]: _PYTHONS[pickle.BINBYTES8[0]],
        # How far to read ahead, which needn't be done.
        pickle.FRAME[0]: lambda self: self.read(8),
    }

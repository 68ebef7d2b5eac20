"""Reads the arrays out of a pickle without running anything: a pickle is a program, and here nothing can execute it.

`pickle.load` calls whatever the file names. Files of SMPL are pickles of arrays, often of Python 2 and wrapped in
objects of chumpy, which no longer imports. So the opcodes are carried out here on a stack of plain values. What the
file names must be in `_ADMITTED` or a class of chumpy; even then nothing of numpy, scipy or chumpy is called: arguments
and states are kept as they stand, and `pickled_arrays` makes arrays from them where they are asked for.

Opcodes: Python's `pickletools`.
"""

import codecs
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from model.body.refusal import BodyFileError

MOST_OPCODES = 500_000
"""Longest program; a model of SMPL has a few thousand. It bounds the time to about a second."""

MOST_BYTES = 2**30
"""Bytes that a file may hold, or make by decoding [bytes]: SMPL-X, the largest model, has half of that."""

_WORDS: dict[type, str] = {
    str: "a text",
    bytes: "a text",
    list: "a list",
    tuple: "a list",
    dict: "a dictionary",
    bool: "a number",
    int: "a number",
    float: "a number",
}

_REMEDY = "get the file anew from where it is published"

_ARRAY_BASES = {("numpy", "ndarray"), ("numpy", "matrix"), ("numpy.matrixlib.defmatrix", "matrix")}
SPARSE = {
    (f"scipy.sparse.{folder}", f"{kind}_{form}")
    for kind in ("csc", "csr")
    for folder in (kind, f"_{kind}")
    for form in ("matrix", "array")
}
ARRAY = {(f"numpy.{core}.multiarray", "_reconstruct") for core in ("core", "_core")}
_SCALAR = {(f"numpy.{core}.multiarray", "scalar") for core in ("core", "_core")}
FROM_BUFFER = {(f"numpy.{core}.numeric", "_frombuffer") for core in ("core", "_core")}
_SETS = {(builtins, name) for builtins in ("__builtin__", "builtins") for name in ("set", "frozenset")}
_NO_BYTES = {("__builtin__", "bytes"), ("builtins", "bytes")}
_OBJECTS = {("__builtin__", "object"), ("builtins", "object")}
_RECONSTRUCTOR = {("copy_reg", "_reconstructor"), ("copyreg", "_reconstructor")}
DTYPE = {("numpy", "dtype")}
_ENCODE = {("_codecs", "encode")}
_ADMITTED = (
    _ARRAY_BASES | SPARSE | ARRAY | _SCALAR | FROM_BUFFER | _SETS | _NO_BYTES | _OBJECTS | _RECONSTRUCTOR
    | DTYPE | _ENCODE
)  # fmt: skip
"""Names that a file may use: how numpy and scipy pickle arrays, and how Python 2 and 3 pickle around them."""


@dataclass(frozen=True)
class Name:
    """Something that the file asks for, as a name only."""

    module: str
    name: str

    @property
    def pair(self) -> tuple[str, str]:
        """Module and name."""
        return self.module, self.name

    def __str__(self) -> str:
        return f"{self.module}.{self.name}"


@dataclass(eq=False)
class Held:
    """An object of the file that isn't made: its class, what it would be made from, and its state."""

    kind: Name
    arguments: tuple[Any, ...] = ()
    state: Any = field(default=None)


def read_pickle(content: bytes) -> dict[str, Any]:
    """The dictionary that a pickle holds; values are plain, or `Held`.

    Args:
        content: The file.

    Returns:
        Its entries whose keys are texts.

    Raises:
        BodyFileError: It is truncated or too long, asks for a name that isn't admitted, or isn't a dictionary.
    """
    found = _Machine(content).run()
    if not isinstance(found, dict):
        raise BodyFileError(f"the pickle holds {described(found)}, not a dictionary of arrays; {_REMEDY}")
    return {key: value for key, value in found.items() if isinstance(key, str)}


def is_chumpy(kind: Name) -> bool:
    """Whether a name is one of chumpy's."""
    return kind.module == "chumpy" or kind.module.startswith("chumpy.")


def described(value: Any) -> str:
    """What a value is, in a word, for errors."""
    if isinstance(value, Held | Name):
        return str(value.kind if isinstance(value, Held) else value)[:80]
    return _WORDS.get(type(value), "nothing")


def text(value: Any) -> str:
    """A text of Python 3, or of Python 2, whose texts are bytes."""
    return value.decode("latin1") if isinstance(value, bytes) else value if isinstance(value, str) else ""


# The machine that carries the opcodes out.


class _Mark:
    """Where a group of values begins on the stack."""


_MARK = _Mark()


class _Machine:
    """Stack, memo and place of a pickle's program."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._place = 0
        self._made = 0
        self._stack: list[Any] = []
        self._memo: dict[int, Any] = {}

    def run(self) -> Any:
        for _ in range(MOST_OPCODES):
            code = self._take(1)
            if code == b".":
                return self._pop()
            step = _STEPS.get(code)
            if step is None:
                where = f"byte {self._place - 1} is {code!r}"
                raise BodyFileError(f"not a pickle of arrays: {where}, which none has; {_REMEDY}")
            step(self)
        raise BodyFileError(f"the pickle has more than {MOST_OPCODES} opcodes, a body has a few thousand; {_REMEDY}")

    def _take(self, count: int) -> bytes:
        start, self._place = self._place, self._place + count
        if self._place > len(self._content):
            raise BodyFileError(f"truncated: the pickle goes on after its {len(self._content)} bytes; {_REMEDY}")
        return self._content[start : self._place]

    def _line(self) -> bytes:
        end = self._content.find(b"\n", self._place)
        if end < 0:
            raise BodyFileError(f"truncated: the pickle goes on after its {len(self._content)} bytes; {_REMEDY}")
        return self._take(end + 1 - self._place)[:-1]

    def _number(self, layout: str) -> Any:
        return struct.unpack(layout, self._take(struct.calcsize(layout)))[0]

    def _sized(self, layout: str) -> bytes:
        return self._take(self._number(layout))

    def _push(self, value: Any) -> None:
        self._stack.append(value)

    def _pop(self, kind: type | tuple[type, ...] = object) -> Any:
        if not self._stack or self._stack[-1] is _MARK or not isinstance(self._stack[-1], kind):
            raise self._damaged()
        return self._stack.pop()

    def _pop_to_mark(self) -> list[Any]:
        for place in range(len(self._stack) - 1, -1, -1):
            if self._stack[place] is _MARK:
                group = self._stack[place + 1 :]
                del self._stack[place:]
                return group
        raise self._damaged()

    def _damaged(self) -> BodyFileError:
        return BodyFileError(f"damaged: the pickle makes no sense at byte {self._place}; {_REMEDY}")

    def _parsed(self, made_of: Callable[[], Any]) -> Any:
        try:
            return made_of()
        except (ValueError, UnicodeError):
            raise self._damaged() from None

    # What opcodes do, where it takes more than a line.

    def _name(self, module: str, name: str) -> None:
        asked = Name(module, name)
        if asked.pair not in _ADMITTED and not is_chumpy(asked):
            raise BodyFileError(
                f"the pickle asks for {str(asked)[:80]!r}, which no array of numpy, scipy or chumpy needs: it may be "
                f"meant to run code and isn't read; {_REMEDY}"
            )
        self._push(asked)

    def _stack_name(self) -> None:
        name, module = self._pop(str), self._pop(str)
        self._name(module, name)

    def _line_name(self) -> None:
        module, name = self._line(), self._line()
        self._name(module.decode("latin1"), name.decode("latin1"))

    def _instance(self) -> None:
        self._line_name()
        kind = self._pop(Name)
        self._make(kind, tuple(self._pop_to_mark()))

    def _object(self) -> None:
        kind, *arguments = self._pop_to_mark() or [None]
        self._make(kind, tuple(arguments))

    def _reduce(self) -> None:
        arguments, kind = self._pop(tuple), self._pop(Name)
        self._make(kind, arguments)

    def _new(self, *, keywords: bool) -> None:
        if keywords and self._pop(dict):
            raise self._damaged()
        self._reduce()

    def _make(self, kind: Any, arguments: tuple[Any, ...]) -> None:
        if not isinstance(kind, Name):
            raise self._damaged()
        if kind.pair in _SETS:
            self._push(arguments[0] if arguments else [])  # not as a set: its elements would be hashed
        elif kind.pair in _NO_BYTES and not arguments:
            self._push(b"")
        elif kind.pair in _ENCODE:
            self._push(self._encoded(arguments))
        elif kind.pair in _RECONSTRUCTOR:
            if len(arguments) != 3 or not isinstance(arguments[0], Name):
                raise self._damaged()
            self._push(Held(arguments[0]))
        else:
            self._push(Held(kind, arguments))

    def _encoded(self, arguments: tuple[Any, ...]) -> bytes:
        """Bytes that Python 3 wrote for Python 2: as a text in which each letter is a byte."""
        if len(arguments) != 2 or not isinstance(arguments[0], str) or text(arguments[1]) != "latin1":
            raise self._damaged()
        self._made += len(arguments[0])
        if self._made > MOST_BYTES:
            raise BodyFileError(f"the pickle unfolds to more than {MOST_BYTES >> 20} MiB; {_REMEDY}")
        return bytes(self._parsed(lambda: arguments[0].encode("latin1")))

    def _build(self) -> None:
        state = self._pop()
        target = self._pop(Held)
        if target.state is not None:
            raise self._damaged()
        target.state = state
        self._push(target)

    def _append(self, values: list[Any]) -> None:
        target = self._pop(list)
        target.extend(values)
        self._push(target)

    def _set_items(self, values: list[Any]) -> None:
        target = self._pop(dict)
        if len(values) % 2:
            raise self._damaged()
        for key, value in zip(values[::2], values[1::2]):
            if isinstance(key, str | bytes):  # others would be hashed, and none of them names an array
                target[text(key)] = value
        self._push(target)

    def _dictionary(self) -> None:
        group = self._pop_to_mark()
        self._push({})
        self._set_items(group)

    def _tuple(self, count: int) -> None:
        values = [self._pop() for _ in range(count)]
        self._push(tuple(values[::-1]))

    def _put(self, place: int) -> None:
        value = self._pop()
        self._memo[place] = value
        self._push(value)

    def _get(self, place: int) -> None:
        if place not in self._memo:
            raise self._damaged()
        self._push(self._memo[place])

    def _line_integer(self) -> Any:
        line = self._line().rstrip(b"L")
        return {b"00": False, b"01": True}.get(line) if line in (b"00", b"01") else self._parsed(lambda: int(line))

    def _line_string(self) -> bytes:
        line = self._line().strip()
        if len(line) < 2 or line[:1] != line[-1:] or line[:1] not in (b"'", b'"'):
            raise self._damaged()
        return bytes(self._parsed(lambda: codecs.escape_decode(line[1:-1])[0]))

    def _duplicate(self) -> None:
        value = self._pop()
        self._push(value)
        self._push(value)

    def _drop(self) -> None:
        if not self._stack:
            raise self._damaged()
        self._stack.pop()

    def _text8(self, raw: bytes) -> str:
        return str(self._parsed(lambda: raw.decode("utf-8", "surrogatepass")))


def _pair(machine: _Machine) -> list[Any]:
    value, key = machine._pop(), machine._pop()
    return [key, value]


_STEPS: dict[bytes, Callable[[_Machine], Any]] = {
    b"\x80": lambda m: m._take(1),  # protocol
    b"\x95": lambda m: m._take(8),  # frame: how far to read ahead
    b"(": lambda m: m._push(_MARK),
    b"0": _Machine._drop,
    b"1": _Machine._pop_to_mark,
    b"2": _Machine._duplicate,
    b"N": lambda m: m._push(None),
    b"\x88": lambda m: m._push(True),
    b"\x89": lambda m: m._push(False),
    b"I": lambda m: m._push(m._line_integer()),
    b"L": lambda m: m._push(m._line_integer()),
    b"J": lambda m: m._push(m._number("<i")),
    b"K": lambda m: m._push(m._number("<B")),
    b"M": lambda m: m._push(m._number("<H")),
    b"\x8a": lambda m: m._push(int.from_bytes(m._sized("<B"), "little", signed=True)),
    b"F": lambda m: m._push(m._parsed(lambda: float(m._line()))),
    b"G": lambda m: m._push(m._number(">d")),
    b"S": lambda m: m._push(m._line_string()),
    b"T": lambda m: m._push(m._sized("<I")),
    b"U": lambda m: m._push(m._sized("<B")),
    b"B": lambda m: m._push(m._sized("<I")),
    b"C": lambda m: m._push(m._sized("<B")),
    b"\x8e": lambda m: m._push(m._sized("<Q")),
    b"\x96": lambda m: m._push(m._sized("<Q")),
    b"V": lambda m: m._push(m._parsed(lambda: m._line().decode("raw-unicode-escape"))),
    b"X": lambda m: m._push(m._text8(m._sized("<I"))),
    b"\x8c": lambda m: m._push(m._text8(m._sized("<B"))),
    b"\x8d": lambda m: m._push(m._text8(m._sized("<Q"))),
    b")": lambda m: m._push(()),
    b"\x85": lambda m: m._tuple(1),
    b"\x86": lambda m: m._tuple(2),
    b"\x87": lambda m: m._tuple(3),
    b"t": lambda m: m._push(tuple(m._pop_to_mark())),
    b"]": lambda m: m._push([]),
    b"l": lambda m: m._push(m._pop_to_mark()),
    b"a": lambda m: m._append([m._pop()]),
    b"e": lambda m: m._append(m._pop_to_mark()),
    b"\x8f": lambda m: m._push([]),  # a set; it is kept as a list
    b"\x90": lambda m: m._append(m._pop_to_mark()),
    b"\x91": lambda m: m._push(tuple(m._pop_to_mark())),
    b"}": lambda m: m._push({}),
    b"d": _Machine._dictionary,
    b"s": lambda m: m._set_items(_pair(m)),
    b"u": lambda m: m._set_items(m._pop_to_mark()),
    b"p": lambda m: m._put(m._parsed(lambda: int(m._line()))),
    b"q": lambda m: m._put(m._number("<B")),
    b"r": lambda m: m._put(m._number("<I")),
    b"\x94": lambda m: m._put(len(m._memo)),
    b"g": lambda m: m._get(m._parsed(lambda: int(m._line()))),
    b"h": lambda m: m._get(m._number("<B")),
    b"j": lambda m: m._get(m._number("<I")),
    b"c": _Machine._line_name,
    b"\x93": _Machine._stack_name,
    b"i": _Machine._instance,
    b"o": _Machine._object,
    b"R": _Machine._reduce,
    b"\x81": lambda m: m._new(keywords=False),
    b"\x92": lambda m: m._new(keywords=True),
    b"b": _Machine._build,
}
"""What each opcode does. Those that aren't here - registered extensions, persistent ids, buffers outside the file,
whole numbers of more than 255 bytes - stand in no file of arrays."""

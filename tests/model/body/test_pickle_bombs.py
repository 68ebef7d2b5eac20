"""Small pickles that would take much memory or time in Python's own unpickler: here they take little of both."""

import copyreg
import pickle
import pickletools
import struct
import time
import tracemalloc

import pytest

from model.body import BodyFileError
from model.body.safe_pickle import _Unpickler, read_pickle

MIB = 2**20
TEXT = b"X" + struct.pack("<I", MIB) + b"chumpy." + b"a" * (MIB - 7) + b"q\x00"
"""A text of 1 MiB, which the first place of the memo keeps."""

AGAIN = b"c_codecs\nencode\nh\x00X\x06\x00\x00\x00latin1\x86R"

TUPLE = b"(" + b"N" * (MIB // 8) + b"tq\x00"
"""A tuple of 1 MiB, likewise."""

TWICE = b"\x80\x02)" + b"2\x86" * 31
"""A tuple of two tuples of two tuples ..., each pair the same object: its hash takes 2^31 steps."""

BOMBS = {
    "a text decoded again": (TEXT + b"(" + AGAIN * 100 + b"t.", "holds a list, not"),
    "a name made again": (TEXT + b"(" + b"h\x00h\x00\x93" * 100 + b"t.", "asks for 'chumpy.aaaa"),
    "arguments given again": (TUPLE + b"(" + b"cchumpy\nCh\nh\x00R" * 100 + b"t.", "holds a list, not"),
    "arguments in a list": (b"]q\x00(" + b"N" * 9 + b"ecchumpy\nCh\nh\x00R.", "damaged"),
    "an announced array of bytes": (b"\x80\x05\x96" + struct.pack("<Q", 2**40) + b"x.", "truncated"),
    "an announced frame": (b"\x80\x04\x95" + struct.pack("<Q", 2**40) + b"].", "holds a list, not"),
    "a place in a memo of 32 GiB": (b"\x80\x02]r\xff\xff\xff\xff.", "holds a list, not"),
    "a number of a million digits": (b"(I" + b"9" * MIB + b"\n.", "damaged"),
    "a key": (b"}" + TWICE + b"Ns\x85.", "holds a list, not"),
    "keys": (TWICE + b"q\x000}(h\x00Nu" + b"\x85.", "holds a list, not"),
    "a key of a dictionary at once": (TWICE + b"q\x000(h\x00Nd" + b"\x85.", "holds a list, not"),
    "an element of a set": (TWICE + b"q\x000\x8f(h\x00\x90.", "holds a list, not"),
    "a frozen set": (TWICE + b"q\x000(h\x00\x91.", "holds a list, not"),
    "a set by its name": (TWICE + b"q\x000c__builtin__\nset\n](h\x00e\x85R.", "holds __builtin__.set, not"),
    "deep objects": (b"cchumpy\nCh\nq\x000" + b"h\x00" * 80_000 + b"N" + b"\x85R" * 80_000 + b".", "holds chumpy.Ch"),
    "deep dictionaries": (b"}U\x01aq\x000" + b"}h\x00" * 80_000 + b"N" + b"s" * 80_000 + b"t.", "damaged"),
}  # fmt: skip


@pytest.mark.parametrize("case", BOMBS)
def test_little_memory_and_time(case: str) -> None:
    """At most 60 bytes of memory for each of the file, and 8 MiB more; unfolded, they would take 100 MiB or more."""
    content, expected = BOMBS[case]
    tracemalloc.start()
    start = time.process_time()
    try:
        with pytest.raises(BodyFileError) as caught:
            read_pickle(content)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert expected in str(caught.value)
    assert peak < 8 * MIB + 60 * len(content)
    assert time.process_time() - start < 5.0


def test_a_registered_extension_is_not_asked_for() -> None:
    """Python's unpickler hands out what another pickle's extension brought, without asking for its name."""
    copyreg.add_extension("os", "system", 240)
    try:
        assert pickle.loads(b"\x80\x02\x82\xf0.").__name__ == "system"  # it keeps it from now on
        with pytest.raises(BodyFileError, match=r"byte 2 is b'\\x82', which none has"):
            read_pickle(b"\x80\x02\x82\xf0.")
    finally:
        copyreg.remove_extension("os", "system", 240)


def test_opcodes_are_those_that_were_thought_of() -> None:
    """An opcode that a later Python adds is to be looked at first."""
    known = {ord(opcode.code) for opcode in pickletools.opcodes if opcode.proto <= 5}
    refused = {ord(code) for code in "\x82\x83\x84PQ\x97\x98\x92\x8b"}
    assert set(_Unpickler.dispatch) == known - refused

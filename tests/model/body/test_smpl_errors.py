"""A corpus of files that aren't whole, aren't bodies or are up to no good: one clear line each, and nothing runs."""

import io
import pickle
import pickletools
import re
import struct
import time
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from model.body import BodyFileError, BodyModel, read_smpl
from model.body.smpl_file import parse_smpl
from tests.model.body.smpl_files import Arrays, as_npz, as_pickle, as_python2, fake_chumpy, random_model, with_chumpy

MADE = random_model()
WRITERS = {"npz": as_npz, "pickle": as_pickle, "python 2": as_python2}


def refuse(content: bytes) -> str:
    """The error's text, once it is known to be one line, soon."""
    start = time.process_time()
    with pytest.raises(BodyFileError) as caught:
        parse_smpl(content, "body.pkl", "female")
    assert time.process_time() - start < 5.0
    text = str(caught.value)
    assert text.startswith("body.pkl: ") and "\n" not in text and len(text) < 400, text
    return text


def altered(name: str, change: Callable[[np.ndarray], Any]) -> Arrays:
    """The model with one array changed in place, or replaced by what `change` returns."""
    array = MADE[name].copy()
    result = change(array)
    return MADE | {name: array if result is None else result}


def at(place: Any, value: float) -> Callable[[np.ndarray], None]:
    """A change of one place."""
    return lambda array: array.__setitem__(place, value)


def without(name: str) -> Arrays:
    """The model without one array."""
    return {key: value for key, value in MADE.items() if key != name}


def loop(table: np.ndarray) -> None:
    """Chest and neck hang on each other."""
    table[0, 9], table[0, 12] = 12, 9


def folded_face(faces: np.ndarray) -> None:
    """A face with one corner twice."""
    faces[7, 1] = faces[7, 0]


ARRAYS: dict[str, tuple[Arrays, str]] = {
    **{
        f"without {name}": (without(name), rf"{name} is missing, there is .*v_template|v_template is missing")
        for name in ("v_template", "shapedirs", "J_regressor", "weights", "kintree_table", "f")
    },
    "no vertices": (altered("v_template", lambda a: a[:0]), r"v_template must have shape \(V, 3\), got \(0, 3\)"),
    "flat vertices": (
        altered("v_template", lambda a: a[:, :2]),
        r"must have shape \(V, 3\), got \(144, 2\)",
    ),
    "a vertex too few": (altered("weights", lambda a: a[1:]), r"weights must have shape \(144, 24\), got \(143, 24\)"),
    "a joint too few": (altered("weights", lambda a: a[:, 1:]), r"weights must have shape \(144, 24\)"),
    "turned weights": (altered("weights", lambda a: a.T), r"weights must have shape \(144, 24\), got \(24, 144\)"),
    "flat shapedirs": (altered("shapedirs", lambda a: a[..., 0]), r"shapedirs must have shape \(144, 3, betas\)"),
    "no betas": (altered("shapedirs", lambda a: a[..., :0]), r"shapedirs must have shape .*, got \(144, 3, 0\)"),
    "short posedirs": (altered("posedirs", lambda a: a[..., :-9]), r"posedirs must have shape \(144, 3, 207\)"),
    "posedirs as smplx keeps them": (altered("posedirs", lambda a: a.reshape(-1, 207).T), r"posedirs must have shape"),
    "short regressor": (altered("J_regressor", lambda a: a[:, 1:]), r"J_regressor must have shape \(24, 144\)"),
    "quads": (altered("f", lambda a: a.reshape(-1, 4)), r"f must have shape \(F, 3\)"),
    "no faces": (altered("f", lambda a: a[:0]), r"f must have shape \(F, 3\), got \(0, 3\)"),
    "NaN in the template": (
        altered("v_template", at((5, 1), np.nan)),
        r"v_template\[5, 1\] is nan, all must be",
    ),
    "infinite shape": (altered("shapedirs", at((5, 1, 2), np.inf)), r"shapedirs\[5, 1, 2\] is inf"),
    "NaN in posedirs": (altered("posedirs", at((0, 0, 206), np.nan)), r"posedirs\[0, 0, 206\] is nan"),
    "NaN in weights": (altered("weights", at((143, 23), np.nan)), r"weights\[143, 23\] is nan"),
    "NaN in the regressor": (altered("J_regressor", at((0, 0), np.nan)), r"J_regressor\[0, 0\] is nan"),
    "NaN in the faces": (MADE | {"f": MADE["f"] * np.nan}, r"f\[0, 0\] is nan"),
    "centimetres": (altered("v_template", lambda a: 100 * a), r"m high \(y\).* give it in metres, y up"),
    "a far vertex": (altered("v_template", at((0, 0), 1e30)), r"reaches 1e\+30 m from the origin"),
    "huge shapes": (altered("shapedirs", at((0, 0, 0), 1e300)), r"shapedirs reaches 1e\+300 m, must be <= 1 m"),
    "huge correctives": (altered("posedirs", at((0, 0, 0), -1e30)), r"posedirs reaches 1e\+30 m, must be <= 1 m"),
    "huge regressor": (altered("J_regressor", at((0, 0), 1e300)), r"J_regressor reaches 1e\+300, must be <= 5"),
    "huge weights": (altered("weights", at((0, 0), 1e300)), r"weights of vertex 0 sum to 1e\+300, must be 1"),
    "zero template": (altered("v_template", lambda a: 0 * a), r"v_template is 0 m high"),
    "zero shapes": (altered("shapedirs", lambda a: 0 * a), r"shapedirs is 0 everywhere"),
    "zero weights": (altered("weights", lambda a: 0 * a), r"weights of vertex 0 sum to 0, must be 1"),
    "zero regressor": (altered("J_regressor", lambda a: 0 * a), r"J_regressor of joint 0 sums to 0, must be 1"),
    "zero faces": (altered("f", lambda a: 0 * a), r"face 0 has corners \[0, 0, 0\], they must be three"),
    "zero tree": (altered("kintree_table", lambda a: 0 * a), r"kintree_table names 1 joints in 24 columns"),
    "weights that sum to more": (altered("weights", at((9, 3), 0.5)), r"weights of vertex 9 sum to .*must be 1 within"),
    "negative weights": (
        altered("weights", lambda a: a + np.eye(144, 24) @ (np.eye(24) - np.roll(np.eye(24), 1, axis=1))),
        r"weights of vertex \d+ reach -1, must be >= 0",
    ),
    "a face out of range": (altered("f", at((3, 2), 144)), r"face 3 has corners .*144.*, there are vertices 0 to 143"),
    "a face from the end": (
        MADE | {"f": np.where(np.arange(576).reshape(-1, 3) == 4, -1, MADE["f"].astype(int))},
        r"face 1 has corners \[.*-1.*\], there are vertices 0 to 143",
    ),
    "half a corner": (MADE | {"f": MADE["f"] + 0.5}, r"face 0 has corners"),
    "a folded face": (altered("f", folded_face), r"face 7 has corners .*they must be three"),
    "inside out": (altered("f", lambda a: a[:, ::-1]), r"enclose -.* m\^3, must be > 0"),
    "a cycle": (altered("kintree_table", loop), r"kintree_table has a cycle: joint 9 never reaches the root"),
    "a joint on itself": (altered("kintree_table", at((0, 4), 4)), r"kintree_table has a cycle: joint 4"),
    "two roots": (altered("kintree_table", at((0, 4), 2**32 - 1)), r"kintree_table has 2 roots, must be one"),
    "no root": (altered("kintree_table", at((0, 0), 3)), r"kintree_table has 0 roots, must be one"),
    "a parent that isn't there": (altered("kintree_table", at((0, 4), 77)), r"joint 4 hangs on 77, which is no joint"),
    "another tree": (
        altered("kintree_table", at((0, 4), 2)),
        r"joint 4 \(left_knee\) hangs on 2, in such a model",
    ),
    "half a tree": (altered("kintree_table", lambda a: a[:1]), r"kintree_table must have shape \(2, joints\)"),
    "a hand's joints": (altered("kintree_table", lambda a: a[:, :16]), r"has 16 joints, must be 24 \(SMPL\), 52"),
    "mirrored": (altered("v_template", lambda a: a * [-1, 1, 1]) | {"f": MADE["f"][:, ::-1]}, r"to the right of"),
    "z up": (altered("v_template", lambda a: a[:, [1, 2, 0]]), r"metres, y up|stand upright along y"),
    "upside down": (altered("v_template", lambda a: a * [-1, -1, 1]), r"below neck; the body must stand upright"),
    "joints from elsewhere": (
        altered("J_regressor", at((20, [0, 50]), [3.0, -3.0])),
        r"J_regressor puts joint 20 \(left_wrist\) .* m out of the body",
    ),
    "texts": (
        MADE | {"weights": np.full((144, 24), "x")},
        r"weights is an array of type .*U1.*not of num|only num",
    ),
    "complex numbers": (altered("v_template", lambda a: a + 0j), r"v_template is an array of type .*c16"),
    "records": (
        MADE | {"v_template": np.zeros(3, [("x", "f8"), ("y", "i4")])},
        r"v_template is an array of type",
    ),
    "Python objects": (
        MADE | {"v_template": np.full((144, 3), None)},
        r"v_template is an array of (Python objects|type .*O)",
    ),
    "a motion": (
        {"poses": np.zeros((3, 72)), "trans": np.zeros((3, 3))},
        r"v_template is missing, there is poses",
    ),
    "odd names": ({"a\nb": MADE["f"], "c" * 999: MADE["f"]}, r"v_template is missing, there is a\?b, c{40};"),
    "nothing": ({}, r"v_template is missing, there is nothing"),
}


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("case", ARRAYS)
def test_arrays_that_are_no_body(case: str, writer: str) -> None:
    arrays, expected = ARRAYS[case]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        content = WRITERS[writer](arrays)
        text = refuse(content)
    assert re.search(expected, text), text


# Pickles that aren't whole, or aren't of arrays.

PICKLES: dict[str, tuple[bytes, str]] = {
    "empty": (b"", "the file is empty"),
    "a page of the web": (b"<!DOCTYPE html><html>", "neither a pickle nor an npz archive: it begins with b'<!DOCTYPE"),
    "a list": (as_pickle([1, 2]), "holds a list, not a dictionary"),
    "a number": (as_pickle(3), "holds a number, not a dictionary"),
    "one array": (as_pickle(np.zeros(3)), "holds numpy._core.multiarray._reconstruct, not a dictionary"),
    "a list as an array": (as_pickle(MADE | {"weights": [[1.0]]}), "weights is a list, not an array"),
    "a number as an array": (as_pickle(MADE | {"weights": 3}), "weights is a number, not an array"),
    "only a name": (b"\x80\x02}U\nv_templatecnumpy\nndarray\ns.", "v_template is numpy.ndarray, not an array"),
    "no end": (as_pickle(MADE)[:-1], "truncated: the pickle goes on after its"),
    "half": (as_pickle(MADE)[:100_000], "truncated: the pickle goes on after its 100000 bytes"),
    "the first byte": (b"\x80", "truncated"),
    "an announced terabyte": (b"\x80\x04\x8e" + struct.pack("<Q", 2**40) + b"x.", "truncated"),
    "an announced text": (b"\x80\x04\x8d" + struct.pack("<Q", 2**63) + b"x.", "truncated"),
    "a place in a memo of 32 GiB": (b"\x80\x02]r\xff\xff\xff\xff.", "holds a list, not"),
    "an unknown opcode": (b"\x80\x02\xf0.", r"byte 2 is b'\xf0', which none has"),
    "an extension": (b"\x80\x02\x82\x01.", r"byte 2 is b'\x82', which none has"),
    "a persistent id": (b"\x80\x02U\x01xQ.", "byte 5 is b'Q', which none has"),
    "a buffer outside": (b"\x80\x05\x97.", r"byte 2 is b'\x97', which none has"),
    "a huge number": (b"\x80\x02\x8b\xff\xff\xff\x7f.", r"byte 2 is b'\x8b', which none has"),
    "a number of 100,000 digits": (b"(I" + b"9" * 100_000 + b"\n.", "damaged: the pickle makes no sense at byte 100"),
    "an empty stack": (b"\x80\x02.", "damaged"),
    "no mark": (b"\x80\x02]u.", "damaged"),
    "a tuple of nothing": (b"\x80\x02\x87.", "damaged"),
    "items of a list": (b"\x80\x02]NNs.", "damaged"),
    "a state of a list": (b"\x80\x02]Nb.", "damaged"),
    "half an item": (b"\x80\x02}(Nu.", "damaged"),
    "nothing remembered": (b"\x80\x02h\x07.", "damaged"),
    "a call of a text": (b"\x80\x02U\x01x)R.", "damaged"),
    "a text that isn't UTF-8": (b"\x80\x02X\x01\x00\x00\x00\xff.", "damaged"),
    "endless": (b"\x80\x02" + b"N0" * 250_000 + b".", "more than 500000 opcodes"),
    "deep": (b"\x80\x02" + b"N" + b"\x85" * 190_000 + b".", "holds a list, not"),
    "a deep key": (b"\x80\x02}N" + b"\x85" * 190_000 + b"Ns.", "v_template is missing, there is nothing"),
    "a list in itself": (b"\x80\x02}U\nv_template]q\x00h\x00as.", "v_template is a list, not"),
}  # fmt: skip


@pytest.mark.parametrize("case", PICKLES)
def test_pickles_that_are_not_whole(case: str) -> None:
    content, expected = PICKLES[case]
    assert expected in refuse(content)


# Pickles that want something run.


class _Calls:
    """Pickles as a call of something."""

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        self._call = function, arguments

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._call


def gadgets(victim: Path) -> dict[str, tuple[bytes, str]]:
    """Programs that would create `victim`, were they run, and the name that each is to be refused by."""
    import builtins
    import functools
    import importlib
    import os
    import runpy
    import subprocess

    order = f"touch {victim}"
    script = f"open({str(victim)!r}, 'w').close()"
    whole = f"__import__('os').system({order!r})"
    shell = order.encode()
    return {
        "os.system": (as_pickle(MADE | {"x": _Calls(os.system, order)}), "posix.system"),
        "os.system, Python 2": (as_python2(MADE | {"x": _Calls(os.system, order)}), "posix.system"),
        "os.system, protocol 4": (as_pickle(MADE | {"x": _Calls(os.system, order)}, 4), "posix.system"),
        "in place of an array": (as_pickle(MADE | {"weights": _Calls(os.system, order)}), "posix.system"),
        "eval": (as_pickle(_Calls(builtins.eval, whole)), "__builtin__.eval"),
        "exec": (as_pickle(_Calls(builtins.exec, script), 4), "builtins.exec"),
        "open": (as_pickle(_Calls(open, str(victim), "w")), "io.open"),
        "getattr": (as_pickle(_Calls(getattr, "", "x")), "__builtin__.getattr"),
        "import": (as_pickle(_Calls(importlib.import_module, "os")), "importlib.import_module"),
        "partial": (as_pickle(_Calls(functools.partial, os.system, order)), "functools.partial"),
        "reduce": (as_pickle(_Calls(functools.reduce, os.system, [order])), "__builtin__.reduce"),
        "run": (as_pickle(_Calls(subprocess.Popen, ["touch", str(victim)]), 4), "subprocess.Popen"),
        "a module's code": (as_pickle(_Calls(runpy.run_path, str(victim))), "runpy.run_path"),
        "numpy.load": (as_pickle(_Calls(np.load, str(victim), None, True)), "numpy.load"),
        "numpy.save": (as_pickle(_Calls(np.save, str(victim), np.zeros(3))), "numpy.save"),
        "numpy.fromfile": (b"cnumpy\nfromfile\n.", "numpy.fromfile"),
        "numpy's own eval": (b"cnumpy.testing._private.utils\nrunstring\n.", "numpy.testing._private.utils.runstring"),
        "scipy's file reader": (b"cscipy.io\nloadmat\n.", "scipy.io.loadmat"),
        "pickle again": (as_pickle(_Calls(pickle.loads, b"")), "pickle.loads"),
        "first protocol": (b"cos\nsystem\n(S'" + shell + b"'\ntR.", "os.system"),
        "INST": (b"(S'" + shell + b"'\nios\nsystem\n.", "os.system"),
        "INST in a dictionary": (b"}(S'" + shell + b"'\nios\nsystem\n.", "os.system"),
        "OBJ": (b"\x80\x02(cos\nsystem\nU" + bytes([len(shell)]) + shell + b"o.", "os.system"),
        "NEWOBJ": (b"\x80\x02csubprocess\nPopen\nU" + bytes([len(shell)]) + shell + b"\x85\x81.", "subprocess.Popen"),
        "NEWOBJ_EX": (b"\x80\x04\x8c\x02os\x8c\x06system\x93)}\x92.", "os.system"),
        "a name with dots": (b"\x80\x04\x8c\x05numpy\x8c\x09os.system\x93.", "numpy.os.system"),
        "another's chumpy": (b"cchumpy_\nCh\n.", "chumpy_.Ch"),
        "a class of ours": (b"cmodel.body.model\nBodyModel\n.", "model.body.model.BodyModel"),
    }


@pytest.mark.parametrize("case", gadgets(Path("x")))
def test_nothing_is_run(case: str, tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    content, name = gadgets(victim)[case]
    text = refuse(content)
    assert f"asks for {name!r}" in text and "may be meant to run code" in text, text
    assert not victim.exists()


def test_the_gadgets_would_run_elsewhere(tmp_path: Path) -> None:
    """The corpus is worth something: Python's own reader runs it."""
    content, _ = gadgets(tmp_path / "victim")["os.system"]
    pickle.loads(content)
    assert (tmp_path / "victim").exists()


def test_names_below_chumpy_are_names_only(tmp_path: Path) -> None:
    """`chumpy.ch` imports os; a file may say chumpy.ch.os.system, and gets nothing but a name for it."""
    order = f"touch {tmp_path / 'victim'}".encode()
    call = b"\x8c\x09chumpy.ch\x8c\x09os.system\x93\x8c" + bytes([len(order)]) + order + b"\x85R"
    head = as_pickle(MADE, 4).removesuffix(b"u.")
    assert isinstance(parse_smpl(head + b"\x8c\x01x" + call + b"u.", "", "female"), BodyModel)
    text = refuse(head + b"\x8c\x07weights" + call + b"u.")
    assert "weights is chumpy.ch.os.system, which is no stored array" in text
    assert not (tmp_path / "victim").exists()


# Objects of numpy, scipy and chumpy that aren't whole.


def pickled(**state: Any) -> bytes:
    """The model, its regressor a sparse matrix whose parts are `state`."""
    matrix = sp.csc_matrix(MADE["J_regressor"])
    matrix.__dict__.update(state)
    return as_pickle(MADE | {"J_regressor": matrix})


SPARSE = {
    "a part less": ({"data": np.ones(3)}, "parts don't belong together"),
    "an index out of range": ({"indices": np.full(144, 99)}, "an index out of its 24 places"),
    "a negative index": ({"indices": np.full(144, -1)}, "an index out of its 24 places"),
    "starts that go back": ({"indptr": np.arange(145)[::-1]}, "parts don't belong together"),
    "starts beyond the end": ({"indptr": np.arange(145) * 2**40}, "parts don't belong together"),
    "a huge shape": ({"_shape": (24, 2**39)}, "has more than 8388608 entries"),
    "a shape of texts": ({"_shape": ("a", "b")}, "whole numbers"),
    "no shape": ({"_shape": ()}, "without its shape"),
    "a data of texts": ({"data": np.array(["x"] * 144)}, "not of numbers"),
    "NaN": ({"data": np.full(144, np.nan)}, "J_regressor[0, 0] is nan"),
    "another size": ({"_shape": (24, 145), "indptr": np.append(np.arange(145), 144)}, "must have shape (24, 144)"),
}


@pytest.mark.parametrize("case", SPARSE)
def test_sparse_matrices_that_are_not_whole(case: str) -> None:
    state, expected = SPARSE[case]
    assert expected in refuse(pickled(**state))


CHUMPY: dict[str, tuple[Callable[[Any], Any], str]] = {
    "nothing in it": (lambda ch: ch.Ch(), "weights is chumpy.ch.Ch without 'x'"),
    "a text in it": (lambda ch: ch.Ch(x="text"), "weights is a text, not an array"),
    "a choice out of range": (lambda ch: ch.Select(a=ch.Ch(x=np.zeros(3)), idxs=np.array([3])), "out of its 3 places"),
    "a choice from the end": (lambda ch: ch.Select(a=ch.Ch(x=np.zeros(3)), idxs=np.array([-1])), "out of its 3 places"),
    "another shape": (lambda ch: ch.Reshape(a=ch.Ch(x=np.zeros(6)), newshape=(4, 2)), "which can't be had as (4, 2)"),
    "no shape": (lambda ch: ch.Reshape(a=ch.Ch(x=np.zeros(6)), newshape="six"), "a shape that isn't one"),
    "axes too many": (lambda ch: ch.transpose(a=ch.Ch(x=np.zeros(6)), axes=(1, 0)), "axes that aren't the array's"),
    "an operation": (
        lambda ch: ch.Tile(a=ch.Ch(x=np.zeros(6)), reps=10**9),
        "Tile, which is no stored array",
    ),
}


@pytest.mark.parametrize("case", CHUMPY)
def test_objects_of_chumpy_that_are_not_whole(case: str) -> None:
    make, expected = CHUMPY[case]
    with fake_chumpy() as ch:
        content = as_python2(MADE | {"weights": make(ch)})
    assert expected in refuse(content)


def test_chumpy_in_itself() -> None:
    """An object around itself has no end."""
    with fake_chumpy() as ch:
        inner = ch.Ch(x=None)
        inner.x = inner
        content = as_pickle(MADE | {"weights": inner})
    assert "more than 8 deep" in refuse(content)


def test_arrays_whose_bytes_do_not_fit() -> None:
    """A shape is held against the bytes that are there before anything is made."""
    content = as_pickle({"v_template": np.zeros((5, 3))}, 3)
    large = content.replace(b"K\x05K\x03\x86", b"M\xff\xffM\xff\xff\x86")
    assert large != content
    assert "v_template is an array of shape (65535, 65535), 34358689800 bytes, but 120 bytes are there" in refuse(large)


# Archives that aren't whole.


def archive(entries: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """A zip of these files."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as made:
        for name, content in entries.items():
            made.writestr(name, content)
    return file.getvalue()


def npy(shape: str, content: bytes = b"", kind: str = "<f8") -> bytes:
    """An npy file whose header says what it wants."""
    header = f"{{'descr': {kind!r}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + content


def announcing(size: int) -> bytes:
    """An archive that says its first array has `size` bytes."""
    content = bytearray(archive({"v_template.npy": npy("(5, 3)", bytes(120))}))
    place = content.rfind(b"PK\x01\x02")
    content[place + 24 : place + 28] = struct.pack("<I", size)
    return bytes(content)


NPZ: dict[str, tuple[bytes, str]] = {
    "half": (as_npz(MADE)[:50_000], "truncated: the npz archive has no end"),
    "its first bytes": (b"PK\x03\x04", "truncated: the npz archive has no end"),
    "its end alone": (as_npz(MADE)[-22:], "truncated or damaged: no npz archive"),
    "no beginning": (b"PK" + as_npz(MADE)[5000:], "damaged"),
    "a changed byte": (as_npz(MADE)[:3000] + b"\x55\xaa" + as_npz(MADE)[3002:], "is damaged"),
    "no array": (archive({"v_template.npy": b"text"}), "v_template is no array of numpy"),
    "an empty array file": (archive({"v_template.npy": b""}), "v_template is no array of numpy"),
    "an array of a terabyte": (
        archive({"v_template.npy": npy("(99999999999, 3)")}),
        "announces the shape (9999999",
    ),
    "a shape below zero": (archive({"v_template.npy": npy("(-1, 3)")}), "announces the shape (-1, 3)"),
    "a shape without end": (
        archive({"v_template.npy": npy("(" + "1," * 20 + ")", bytes(8))}),
        "announces the shape (1",
    ),
    "a header that is code": (archive({"v_template.npy": npy("__import__('os').getcwd()")}), "is no array of numpy"),
    "a header in a header": (archive({"v_template.npy": npy("(" * 4000 + ")" * 4000)}), "is no array of numpy"),
    "a pickle in it": (
        archive({"v_template.npy": npy("(1,)", as_pickle(_Calls(print, "run")), "|O")}),
        "v_template is an array of Python objects, which aren't read",
    ),
    "an announced bomb": (announcing(2**32 - 2), "announces 4294967294 bytes, the arrays of a file have 1073741824"),
    "more than there is": (announcing(2**20), "v_template is damaged|v_template is 0 m high"),
    "less than there is": (announcing(100), "v_template is damaged|announces the shape"),
    "ten thousand entries": (archive({f"{'x' * 80}{k}": b"" for k in range(10_000)}, 0), "has too many entries"),
    "another compression": (archive({"v_template.npy": npy("(0,)")}, zipfile.ZIP_LZMA), "compressed in another way"),
}


@pytest.mark.parametrize("case", NPZ)
def test_archives_that_are_not_whole(case: str) -> None:
    content, expected = NPZ[case]
    text = refuse(content)
    assert any(part in text for part in expected.split("|")), text


def test_a_bomb_of_zeros() -> None:
    """A million vertices in a small file: refused by what a model is, having taken the memory of the array alone."""
    shape = (2**20, 3)
    content = archive({"v_template.npy": npy(str(shape), bytes(2**20 * 24))})
    assert len(content) < 10**5
    assert "v_template is 0 m high" in refuse(content)


@pytest.mark.parametrize("writer", ["npz", "pickle", "chumpy", "python 2", "protocol 0"])
def test_changed_bytes_never_crash(writer: str) -> None:
    """400 files each with a changed, left out or doubled piece of their framework: refused, or a body all the same."""
    small = {name: value for name, value in MADE.items() if name != "posedirs"}
    write: dict[str, Callable[[], bytes]] = {
        "npz": lambda: as_npz(small),
        "pickle": lambda: as_pickle(small, 4),
        "chumpy": lambda: with_chumpy(MADE | {"posedirs": np.zeros((144, 3, 207))}),
        "python 2": lambda: as_python2(small),
        "protocol 0": lambda: as_python2(small, 0),
    }
    content = write[writer]()
    if writer == "npz":
        edges = [m for m in range(len(content) - 1) if content[m : m + 2] == b"PK"]
        places = np.concatenate([np.arange(edge, min(edge + 120, len(content))) for edge in edges])
    else:
        # The opcodes and the first bytes behind them; arrays' contents are numbers, whatever stands there.
        starts = [place for _, _, place in _opcodes(content)]
        places = np.concatenate([np.arange(start, min(start + 4, len(content))) for start in starts])
    rng = np.random.default_rng(len(writer))
    refused = 0
    for k in range(400):
        place, length = int(rng.choice(places)), int(rng.integers(1, 4))
        piece = [rng.bytes(length), b"", content[place : place + length] * 2][k % 3]
        mutant = content[:place] + piece + content[place + length :]
        try:
            assert isinstance(parse_smpl(mutant, "mutant", "female"), BodyModel)
        except BodyFileError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused > 100, "most of them matter"


def _opcodes(content: bytes) -> list[Any]:
    """Where the opcodes stand; `pickletools` does not read texts of bytes in protocol 0."""
    if content[:1] == b"(":
        return [(None, None, m) for m in range(len(content)) if m == 0 or content[m - 1 : m] == b"\n"]
    return list(pickletools.genops(content))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(BodyFileError, match=r"none\.pkl: No such file or directory; name a body model's file"):
        read_smpl(tmp_path / "none.pkl", "female")
    with pytest.raises(BodyFileError, match="Is a directory; name a body model's file"):
        read_smpl(tmp_path, "female")
    with (tmp_path / "large.pkl").open("wb") as file:
        file.truncate(2**30 + 1)
    with pytest.raises(BodyFileError, match=r"large\.pkl: has 1073741825 bytes, a body model has 1073741824 at most"):
        read_smpl(tmp_path / "large.pkl", "female")


def test_too_few_betas() -> None:
    made = random_model(betas=4)
    with pytest.raises(BodyFileError, match="shapedirs has 4 betas, 10 are needed"):
        parse_smpl(as_npz(made), "few", "female", 10)

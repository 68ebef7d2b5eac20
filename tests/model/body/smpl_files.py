"""Small body models of SMPL's schema made of random numbers, and every way in which such files are written."""

import io
import pickle
import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from typing import Any, ClassVar

import igl
import numpy as np
import scipy.sparse as sp

from model.body import PARENTS, BodyModel, joint_positions, load_free_body

Arrays = dict[str, Any]

OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
"""Counter-clockwise seen from outside."""


def tree(count: int) -> np.ndarray:
    """Parents of SMPL (24), SMPL-H (52) or SMPL-X (55), written down without the code under test."""
    if count == 24:
        return PARENTS.astype(np.int64)
    face = [15, 15, 15] if count == 55 else []
    parents = [*PARENTS[:22].tolist(), *face]
    for wrist in (20, 21):
        for _ in range(5):
            first = len(parents)
            parents += [wrist, first, first + 1]
    return np.array(parents)


def random_model(count: int = 24, betas: int = 10, seed: int = 0, size: int = 6) -> Arrays:
    """A body of one small octahedron a joint, in the layout and the types of SMPL's own files.

    Args:
        count: Joints: 24, 52 or 55.
        betas: Directions of shape.
        seed: Of every number.
        size: Vertices a joint; those beyond six belong to no face.
    """
    rng = np.random.default_rng(seed)
    parents = tree(count)
    joints = np.empty((count, 3))
    joints[:22] = load_free_body("female").joint_template[:22]
    for k in range(22, count):
        joints[k] = joints[parents[k]] + rng.normal(0.0, 0.01, 3) + [0.02 * np.sign(joints[parents[k], 0]), 0, 0]
    corners = np.concatenate([OCTAHEDRON, rng.normal(0.0, 0.5, (size - 6, 3))])
    template = (joints[:, None] + 0.05 * corners + rng.normal(0.0, 0.005, (count, size, 3))).reshape(-1, 3)
    vertices = len(template)
    own = np.repeat(np.arange(count), size)
    weights = np.zeros((vertices, count))
    weights[np.arange(vertices), own] = rng.uniform(0.5, 1.0, vertices)
    other = np.where(parents[own] < 0, rng.integers(0, count, vertices), parents[own])
    weights[np.arange(vertices), other] += rng.uniform(0.0, 0.5, vertices)
    weights /= weights.sum(axis=1, keepdims=True)
    regressor = np.zeros((count, vertices))
    for k in range(count):
        regressor[k, size * k : size * (k + 1)] = rng.dirichlet(np.ones(size))
    return {
        "v_template": template,
        "shapedirs": rng.normal(0.0, 0.01, (vertices, 3, betas)),
        "posedirs": rng.normal(0.0, 0.002, (vertices, 3, 9 * (count - 1))),
        "J_regressor": regressor,
        "weights": weights,
        "kintree_table": np.stack([np.where(parents < 0, 2**32 - 1, parents), np.arange(count)]).astype(np.uint32),
        "f": (FACES[None] + size * np.arange(count)[:, None, None]).reshape(-1, 3).astype(np.uint32),
    }


def as_npz(arrays: Arrays) -> bytes:
    """An archive, as SMPL-X's files."""
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def as_pickle(arrays: Any, protocol: int = 2) -> bytes:
    """A pickle of Python 3."""
    return pickle.dumps(arrays, protocol)


class _Python2(pickle._Pickler):
    """Writes texts as Python 2 does: as strings of bytes."""

    # dill, which taichi imports, adds types of its own to the stock pickler.
    dispatch: ClassVar[dict[Any, Any]] = {
        kind: save for kind, save in pickle._Pickler.dispatch.items() if not save.__module__.startswith("dill")
    }

    def _save_string(self, value: str | bytes) -> None:
        raw = value if isinstance(value, bytes) else value.encode("latin1")
        if not self.bin:
            self.write(b"S" + repr(raw)[1:].encode() + b"\n")
        elif len(raw) < 256:
            self.write(b"U" + bytes([len(raw)]) + raw)
        else:
            self.write(b"T" + len(raw).to_bytes(4, "little") + raw)
        self.memoize(value)

    dispatch[str] = _save_string
    dispatch[bytes] = _save_string


def as_python2(arrays: Any, protocol: int = 2) -> bytes:
    """A pickle as Python 2 with the numpy and scipy of its days wrote it."""
    file = io.BytesIO()
    _Python2(file, protocol, fix_imports=True).dump(arrays)
    content = file.getvalue()
    for new, old in ((b"cnumpy._core.", b"cnumpy.core."), (b"cscipy.sparse._cs", b"cscipy.sparse.cs")):
        content = content.replace(new, old)
    return content


@contextmanager
def fake_chumpy() -> Iterator[types.SimpleNamespace]:
    """Modules of chumpy's names whose objects pickle as chumpy's do; chumpy itself imports on no current numpy."""

    def state(self: Any) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key not in ("_parents", "_cache")}

    def start(self: Any, **terms: Any) -> None:
        self.__dict__.update(_dirty_vars={"x"}, _itr=None, _depends_on_deps={}, _parents={}, _cache={}, **terms)

    classes = {}
    for module, names in (("chumpy.ch", ("Ch",)), ("chumpy.reordering", ("Select", "Reshape", "transpose", "Tile"))):
        for name in names:
            classes[name] = type(name, (), {"__module__": module, "__getstate__": state, "__init__": start})
    modules = {"chumpy": types.ModuleType("chumpy")}
    for kind in classes.values():
        modules.setdefault(kind.__module__, types.ModuleType(kind.__module__)).__dict__[kind.__name__] = kind
    sys.modules.update(modules)
    try:
        yield types.SimpleNamespace(**classes)
    finally:
        for name in modules:
            del sys.modules[name]


def with_chumpy(arrays: Arrays, python2: bool = True, protocol: int = 2) -> bytes:
    """Shape directions and correctives as objects of chumpy, the regressor sparse: SMPL 1.0 and 1.1."""
    with fake_chumpy() as ch:
        shapes, poses = arrays["shapedirs"], arrays["posedirs"]
        flat = np.concatenate([np.zeros(7), shapes.reshape(-1)])
        changed = arrays | {
            "shapedirs": ch.Select(
                a=ch.Ch(x=flat), idxs=np.arange(7, len(flat)), preferred_shape=tuple(int(n) for n in shapes.shape)
            ),
            "posedirs": ch.Reshape(a=ch.Ch(x=poses.reshape(-1)), newshape=tuple(int(n) for n in poses.shape)),
            "v_template": ch.Ch(x=arrays["v_template"]),
            "weights": ch.transpose(a=ch.Ch(x=np.ascontiguousarray(arrays["weights"].T)), axes=None),
            "J_regressor": sp.csc_matrix(arrays["J_regressor"]),
            "bs_type": "lrotmin",
            "J": ch.Ch(x=np.zeros((24, 3))),
        }
        return (as_python2 if python2 else as_pickle)(changed, protocol)


@lru_cache(maxsize=2)
def human_model(gender: str = "female", vertices: int = 6890) -> Arrays:
    """The free body on fewer vertices, as a file of SMPL would hold it: another topology, and correctives of its own.

    Joints come from a regressor, as in SMPL: that of each joint is the least one on the skin around it which gives its
    place. The correctives are random and small.
    """
    return _as_file(load_free_body(gender), vertices)


@lru_cache(maxsize=2)
def stranger_model(gender: str = "female", vertices: int = 6890) -> Arrays:
    """A person of other build than the free body's, as a file of SMPL would hold it.

    It stands in a T-pose of its own, arms and legs lowered and apart by some degrees. Its first beta makes it fatter
    and its second smaller if it is female, thinner and larger if it is male: other order and other signs.
    """
    body = load_free_body(gender)
    betas = [0.8, -1.0, 0.5, 1.0, -1.0, 0.5, -0.5, 1.0, 0.5, -0.5]
    pose = np.zeros((1, 24, 3))
    pose[0, [16, 17, 1, 2], 2] = np.deg2rad([-5.0, 5.0, 3.0, -3.0])
    joints = joint_positions(body.shape(betas)[1], body.parents, pose)[0]
    order, sign = [1, 0, *range(2, 10)], np.ones(10)
    sign[0 if gender == "male" else 1] = -1.0
    other = replace(
        body,
        v_template=body.pose(betas, pose)[0] - joints[0].astype(np.float32),
        shapedirs=(body.shapedirs[..., order] * sign).astype(np.float32),
        joint_template=joints - joints[0],
    )
    return _as_file(other, vertices)


def _as_file(body: BodyModel, vertices: int) -> Arrays:
    """A body on fewer vertices, in the layout of SMPL's own files."""
    v, f = body.v_template.astype(np.float64), body.faces.astype(np.int64)
    _, faces, _, kept = igl.decimate(v, f, 2 * vertices - 4)[-4:]
    template = v[kept]
    regressor = np.zeros((24, len(kept)))
    for k, joint in enumerate(body.joint_template):
        near = np.argsort(((template - joint) ** 2).sum(axis=1))[:200]
        places = np.concatenate([template[near].T, np.ones((1, 200))])
        regressor[k, near] = np.linalg.lstsq(places, [*joint, 1.0], rcond=None)[0]
    rng = np.random.default_rng(9)
    return {
        "v_template": template,
        "shapedirs": body.shapedirs[kept].astype(np.float64),
        "posedirs": rng.normal(0.0, 1e-4, (len(kept), 3, 207)),
        "J_regressor": sp.csc_matrix(regressor),
        "weights": body.weights[kept].astype(np.float64),
        "kintree_table": np.stack([np.where(PARENTS < 0, 2**32 - 1, PARENTS), np.arange(24)]).astype(np.uint32),
        "f": faces.astype(np.uint32),
    }

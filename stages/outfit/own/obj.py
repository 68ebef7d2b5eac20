"""Reads the mesh of a Wavefront OBJ file: its vertices in their order, its polygons as triangles.

The common readers lose what is needed here: trimesh renumbers vertices that no face uses or that lie on a seam of the
texture, and takes negative indices for what they were before; meshio and libigl fail on vertices with colours; none of
them says in which line something is wrong.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.spec import DataError

KNOWN = re.compile(
    r"v[tnp]?|[flpgos]|mg|usemtl|mtllib|lod|[dc]_interp|bevel|(shadow|trace)_obj|(map|tex)lib|usemap|cs?type|deg|bmat|"
    r"step|curv2?|surf|parm|trim|hole|scrv|sp|end|con|call|csh|[cs]tech"
)
"""Keywords of the format; all but `v` and `f` say nothing of the mesh."""

LARGEST = 200_000_000
"""Size of the largest file that is read [bytes]."""


@dataclass(frozen=True, eq=False)
class ObjMesh:
    """A mesh as it stands in the file."""

    vertices: NDArray[np.float64]
    """Positions in the file's unit and axes, in its order, shape [N, 3]."""
    faces: NDArray[np.int64]
    """Triangles, shape [F, 3]."""
    vertex_lines: NDArray[np.int64]
    """Line of each vertex, from 1, shape [N]."""
    face_lines: NDArray[np.int64]
    """Line of the polygon that each triangle is part of, from 1, shape [F]."""


def read_obj(content: bytes, file: str) -> ObjMesh:
    """The mesh in an OBJ file's content.

    Args:
        content: The file's bytes.
        file: Its name, for messages.

    Returns:
        The mesh. Quadrilaterals are split along their shorter diagonal, larger polygons into fans.

    Raises:
        DataError: It is no OBJ file, has no vertices or faces, or a line cannot be understood; one line.

    Source: Wavefront, Object Files (.obj), version 3.0, sections "Vertex data" and "Elements".
    """
    if len(content) > LARGEST:
        raise DataError(f"{file}: {len(content) / 1e6:.0f} MB, at most {LARGEST / 1e6:.0f} are read; simplify the mesh")
    if b"\0" in content[:4096]:
        raise DataError(f"{file}: not a text file; export it as a Wavefront OBJ")
    points: list[list[float]] = []
    vertex_lines: list[int] = []
    polygons: list[list[int]] = []
    lines: list[int] = []
    for number, words in _lines(content.decode("utf-8-sig", errors="replace")):
        if words[0] == "v":
            points.append(_position(words, f"{file}: line {number}"))
            vertex_lines.append(number)
        elif words[0] == "f":
            polygons.append(_corners(words, len(points), f"{file}: line {number}"))
            lines.append(number)
        elif not KNOWN.fullmatch(words[0]):
            raise DataError(f"{file}: line {number}: not of an OBJ file: {words[0][:20]!r}; export a Wavefront OBJ")
    if not points or not polygons:
        what = "vertices" if not points else "faces"
        raise DataError(f"{file}: is empty: it has no {what}; export the garment's mesh with its faces")
    vertices = np.array(points)
    faces, owners = _triangles(vertices, polygons, lines, file)
    return ObjMesh(vertices, faces, np.array(vertex_lines), owners)


def _lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Number and words of every line that is not a comment; a line that ends with a backslash goes on in the next."""
    held: list[str] = []
    first = 0
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#", 1)[0].rstrip()
        first = first or number
        if words.endswith("\\"):
            held += words[:-1].split()
            continue
        held += words.split()
        if held:
            yield first, held
        held, first = [], 0
    if held:
        yield first, held


def _position(words: list[str], where: str) -> list[float]:
    """A vertex; a weight or colours may follow its three numbers."""
    try:
        position = [float(word) for word in words[1:4]]
    except ValueError:
        position = []
    if len(position) < 3:
        raise DataError(f"{where}: a vertex must have three numbers, got {' '.join(words[:5])!r}; export it again")
    return position


def _corners(words: list[str], count: int, where: str) -> list[int]:
    """A polygon's vertices, from 0; negative indices count back from the last vertex so far."""
    corners = []
    for word in words[1:]:
        try:
            index = int(word.split("/", 1)[0])
        except ValueError:
            raise DataError(
                f"{where}: a face must name vertices by number, got {word[:20]!r}; export it again"
            ) from None
        if index == 0:
            raise DataError(f"{where}: vertices are counted from 1, got 0; export it again")
        corners.append(index - 1 if index > 0 else count + index)
        if corners[-1] < 0:
            raise DataError(f"{where}: vertex {index} is before the first; export it again")
    if len(corners) < 3:
        raise DataError(f"{where}: a face must have three vertices at least, got {len(corners)}; export it again")
    return corners


def _triangles(
    vertices: NDArray[np.float64], polygons: list[list[int]], lines: list[int], file: str
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles [F, 3] of the polygons, and the line of each [F]."""
    out: list[tuple[int, int, int]] = []
    owners: list[int] = []
    for polygon, line in zip(polygons, lines):
        if max(polygon) >= len(vertices):
            raise DataError(
                f"{file}: line {line}: a face names vertex {max(polygon) + 1}, the file has {len(vertices)}; it may be "
                "cut short, export it again"
            )
        if len(polygon) == 4:
            a, b, c, d = vertices[polygon]
            with np.errstate(all="ignore"):  # what is not finite is found later, and told with its line
                if ((b - d) ** 2).sum() < ((a - c) ** 2).sum():
                    polygon = polygon[1:] + polygon[:1]
        new = [(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, len(polygon) - 1)]
        out += new
        owners += [line] * len(new)
    return np.array(out, dtype=np.int64), np.array(owners, dtype=np.int64)

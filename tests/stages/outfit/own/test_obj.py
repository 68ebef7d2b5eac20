"""OBJ files as programs write them: order kept, polygons split, and what is wrong named with its line."""

import io

import numpy as np
import pytest
import trimesh

from stages.outfit.own.obj import read_obj
from stages.spec import DataError
from tests.stages.outfit.own.garments import as_obj, kilt

SQUARE = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n"


def test_order_and_numbers_are_those_of_another_reader() -> None:
    text = as_obj(*kilt(0.05))
    mesh = read_obj(text.encode(), "k.obj")
    other = trimesh.load(io.StringIO(text), file_type="obj", process=False, maintain_order=True)
    np.testing.assert_array_equal(mesh.vertices, other.vertices)
    np.testing.assert_array_equal(mesh.faces, other.faces)


def test_what_other_programs_add_is_passed_over() -> None:
    """Textures with seams, colours, weights, negative indices, groups, lines, comments, breaks within a line."""
    text = (
        "\ufeff# by hand\r\nmtllib a.mtl\no thing\nv 9 9 9\nv 0 0 0 0.5 0.5 0.5\nv 2 0 0 1.0\nv 2e0 1 0\nv +0 1 -0.0\n"
        "vt 0 0\nvt 1 0\nvn 0 0 1\ng part\ns off\nusemtl red#1\nl 1 2\nf 2/1/1 3//1 \\\n 4/2 # a corner\nf -1 -4 -2\n"
    )
    mesh = read_obj(text.encode(), "t.obj")
    assert mesh.vertices.tolist() == [[9, 9, 9], [0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]
    assert mesh.faces.tolist() == [[1, 2, 3], [4, 1, 3]]
    assert mesh.face_lines.tolist() == [16, 18]
    assert mesh.vertex_lines.tolist() == [4, 5, 6, 7, 8]


def test_quadrilaterals_are_split_along_the_shorter_diagonal() -> None:
    skewed = "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 1 1 0\nf 1 2 3 4\n"
    assert read_obj(skewed.encode(), "q.obj").faces.tolist() == [[1, 2, 3], [1, 3, 0]]
    other = "v 1 0 0\nv 3 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n"
    assert read_obj(other.encode(), "q.obj").faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    pentagon = SQUARE + "v -1 0.5 0\nf 1 2 3 4 5\n"
    assert read_obj(pentagon.encode(), "q.obj").faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "k.obj: is empty: it has no vertices; export the garment's mesh with its faces"),
        (b"# nothing\n", "k.obj: is empty: it has no vertices"),
        (SQUARE.encode(), "k.obj: is empty: it has no faces"),
        (b"solid ascii\nfacet normal 0 0 1\n", "k.obj: line 1: not of an OBJ file: 'solid'"),
        (b"glTF\x02\0\0\0", "k.obj: not a text file; export it as a Wavefront OBJ"),
        (b"v 0 0\n", "k.obj: line 1: a vertex must have three numbers, got 'v 0 0'"),
        (b"v 0,5 1 2\n", "k.obj: line 1: a vertex must have three numbers, got 'v 0,5 1 2'"),
        ((SQUARE + "f 1 2 x\n").encode(), "k.obj: line 5: a face must name vertices by number, got 'x'"),
        ((SQUARE + "f 0 1 2\n").encode(), "k.obj: line 5: vertices are counted from 1, got 0"),
        ((SQUARE + "f 1 2 -9\n").encode(), "k.obj: line 5: vertex -9 is before the first"),
        ((SQUARE + "f 1 2\n").encode(), "k.obj: line 5: a face must have three vertices at least, got 2"),
        (
            (SQUARE + "f 1 2 3\nf 1 2 7\n").encode(),
            "k.obj: line 6: a face names vertex 7, the file has 4; it may be cut",
        ),
    ],
)
def test_what_is_no_mesh_is_refused(content: bytes, message: str) -> None:
    with pytest.raises(DataError) as caught:
        read_obj(content, "k.obj")
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)

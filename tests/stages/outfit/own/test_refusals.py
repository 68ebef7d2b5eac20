"""A corpus of spoilt garments: each is refused in one line that says what, where and what to do."""

import re
from collections.abc import Callable

import numpy as np
import pytest

from stages.outfit.own.load import load_own
from stages.outfit.own.settings import OwnGarment
from stages.settings import SettingsError, build
from stages.spec import DataError
from tests.stages.outfit.own.garments import as_obj, kilt, kilt_settings

Mesh = tuple[np.ndarray, np.ndarray]


def refusal(text: str, settings: OwnGarment | None = None) -> str:
    """What is said of a file."""
    with pytest.raises(DataError) as caught:
        load_own(text.encode(), settings or kilt_settings(), "kilt.obj")
    message = str(caught.value)
    assert "\n" not in message and message.startswith("kilt.obj: ")
    return message


def spoilt(change: Callable[[np.ndarray, np.ndarray], Mesh]) -> str:
    """The kilt's file after a change."""
    vertices, faces = kilt()
    return as_obj(*change(vertices.copy(), faces.copy()))


def third_face(v: np.ndarray, f: np.ndarray) -> Mesh:
    a, b, _ = f[100]
    return np.vstack([v, v[a] * 1.1]), np.vstack([f, [a, b, len(v)]])


def turned_face(v: np.ndarray, f: np.ndarray) -> Mesh:
    f[100] = f[100, ::-1]
    return v, f


def bow_tie(v: np.ndarray, f: np.ndarray) -> Mesh:
    """A triangle that hangs on one vertex of the hem alone."""
    far = v[5] - [0, 0, 0.03]
    return np.vstack([v, far, far + np.array([0.01, 0, 0])]), np.vstack([f, [5, len(v), len(v) + 1]])


def pinched(v: np.ndarray, f: np.ndarray) -> Mesh:
    """Two vertices from opposite sides of the kilt become one: no border touches, but the surface is none there."""
    middle = len(v) // 2
    one, other = middle, middle + 20
    f[f == other] = one
    return v, f


def two_pieces(v: np.ndarray, f: np.ndarray) -> Mesh:
    return np.vstack([v, 1.2 * v]), np.vstack([f, f + len(v)])


def unwelded(v: np.ndarray, f: np.ndarray) -> Mesh:
    """Cut in two along a line and not sewn: the vertices there are doubled."""
    upper = v[f].mean(axis=1)[:, 2] > v[:, 2].mean()
    again = f.copy()
    again[upper] += len(v)
    return np.vstack([v, v]), again


def closed(v: np.ndarray, f: np.ndarray) -> Mesh:
    """Both openings filled by a fan."""
    around = int((v[:, 2] == v[0, 2]).sum())
    ends = [np.arange(around), np.arange(len(v) - around, len(v))]
    middles = np.array([v[end].mean(axis=0) for end in ends])
    low = [[ends[0][k], len(v), ends[0][(k + 1) % around]] for k in range(around)]
    high = [[ends[1][(k + 1) % around], len(v) + 1, ends[1][k]] for k in range(around)]
    return np.vstack([v, middles]), np.vstack([f, low, high])


def sliver(v: np.ndarray, f: np.ndarray) -> Mesh:
    a, b, c = f[100]
    v[c] = 0.5 * (v[a] + v[b])
    return v, f


def collapsed(v: np.ndarray, f: np.ndarray) -> Mesh:
    f[100, 2] = f[100, 0]
    return v, f


def pierced(v: np.ndarray, f: np.ndarray) -> Mesh:
    """One vertex of the front is drawn out behind the back."""
    front = np.abs(v - [0.0, v[:, 1].min(), v[:, 2].mean()]).sum(axis=1).argmin()
    v[front, 1] = v[:, 1].max() + 0.05
    return v, f


def nowhere(v: np.ndarray, f: np.ndarray) -> Mesh:
    v[7, 1] = np.nan
    return v, f


def endless(v: np.ndarray, f: np.ndarray) -> Mesh:
    v[7, 1] = np.inf
    return v, f


def beside(v: np.ndarray, f: np.ndarray) -> Mesh:
    """Hung up flat in front of the body."""
    return v * [1, 0.15, 1] - np.array([0, 0.25, 0]), f


def far_away(v: np.ndarray, f: np.ndarray) -> Mesh:
    return v + np.array([0, 4.0, 0]), f


def too_small(v: np.ndarray, f: np.ndarray) -> Mesh:
    return v * [0.6, 0.6, 1], f


CORPUS = [
    (
        third_face,
        r"not manifold: 3 faces meet at the edge from line \d+ to \d+, at most 2 can; 1 edges are so: separate",
    ),
    (turned_face, r"not oriented: the faces of lines \d+ and \d+ look to opposite sides; 3 edges are so: recalculate"),
    (bow_tie, r"not manifold: 2 parts of the surface touch in the single vertex 6, line 6; 1 vertices are so"),
    (pinched, r"not manifold: 2 parts of the surface touch in the single vertex"),
    (two_pieces, r"2 separate pieces, of (\d+), \1 vertices, a garment must be one; join them, or keep the largest"),
    (
        unwelded,
        r"2 separate pieces, of \d+, \d+ vertices, a garment must be one; \d+ vertices lie exactly on others: merge",
    ),
    (closed, r"the surface is closed, it has no opening for the body; .* delete the inner or outer shell"),
    (
        sliver,
        r"line \d+: a degenerate triangle, its smallest angle is 0(\.\d+)? degrees, must be >= 1; 1 of \d+ triangles",
    ),
    (collapsed, r"line \d+: a degenerate face, it names a vertex twice; 1 triangles are so: remove them"),
    (
        pierced,
        r"the garment passes through itself at \d+ pairs of triangles, first at lines \d+ and \d+; pull the layers",
    ),
    (nowhere, r"line 8: vertex 8 is \(.*, nan, .*\), must be finite; 1 of \d+ vertices are not: export it again"),
    (endless, r"line 8: vertex 8 is \(.*, inf, .*\), must be finite"),
    (
        beside,
        r"there is no body inside it: it takes up 0.\d+ of what is seen from the hips of the female body, must be",
    ),
    (
        far_away,
        r"there is no body around it: .* and up to 4\.\d+ m from the female body, 100% of it further than 0.35 m",
    ),
    (
        too_small,
        r"\d+\.\d% of its vertices lie more than 15 mm inside the female body, at most 2% may, the deepest \d+ mm",
    ),
]


@pytest.mark.parametrize(("change", "message"), CORPUS, ids=[change.__name__ for change, _ in CORPUS])
def test_a_spoilt_garment_is_refused(change: Callable[[np.ndarray, np.ndarray], Mesh], message: str) -> None:
    said = refusal(spoilt(change))
    assert re.match(rf"kilt\.obj: {message}", said), said


@pytest.mark.parametrize(
    ("frame", "remedy"),
    [
        ({"unit": "cm"}, 'unit = "cm"'),
        ({"unit": "in"}, 'unit = "in"'),
        ({"unit": "mm"}, 'unit = "mm"'),
        ({"unit": "ft"}, 'unit = "ft"'),
        ({"up": "y"}, 'up = "y"'),
        ({"unit": "cm", "up": "y"}, 'unit = "cm" and up = "y"'),
        ({"origin": "floor"}, 'origin = "floor"'),
        ({"unit": "in", "up": "y", "origin": "floor"}, 'unit = "in" and up = "y" and origin = "floor"'),
    ],
)
def test_another_unit_axis_or_origin_is_told_with_its_remedy(frame: dict[str, str], remedy: str) -> None:
    text = as_obj(*kilt(), **frame)
    assert refusal(text).endswith(f"it would fit with {remedy}: say so in the recipe")
    put_right = load_own(text.encode(), kilt_settings(**frame), "kilt.obj")
    np.testing.assert_allclose(put_right.vertices, kilt()[0], atol=2e-6)
    np.testing.assert_array_equal(put_right.faces, kilt()[1])


def test_a_recipe_that_says_too_much_is_told_so_too() -> None:
    said = refusal(as_obj(*kilt()), kilt_settings(unit="cm", up="y"))
    assert said.endswith('it would fit with unit = "m" and up = "z": say so in the recipe')


def test_a_mesh_too_coarse_to_be_cloth_is_refused() -> None:
    said = refusal(as_obj(*kilt(0.09)))
    assert said.endswith("mm long in the mean, must be from 1 to 60 mm; subdivide or remesh the mesh to about 10 mm")
    assert 85 < float(said.split()[3]) < 110


def test_faces_that_all_look_inwards_are_turned_and_unused_vertices_left_out() -> None:
    vertices, faces = kilt()
    stray = np.vstack([[[0.0, 0.0, 9.0]], vertices])
    mesh = load_own(as_obj(stray, faces[:, ::-1] + 1).encode(), kilt_settings(), "kilt.obj")
    assert mesh.unused_vertices == 1
    np.testing.assert_allclose(mesh.vertices, vertices, atol=2e-6)
    np.testing.assert_array_equal(mesh.faces, faces)
    assert [border.name for border in mesh.borders] == ["waist", "hem"]


def test_elastics_and_waistbands_need_their_borders() -> None:
    text = as_obj(*kilt())
    said = refusal(text, kilt_settings(elastics={"hemm": 0.8}))
    assert said == "kilt.obj: has no border 'hemm' for an elastic; did you mean 'hem'?, its borders are waist, hem"
    said = refusal(text, kilt_settings(elastics={"sleeve": 0.8}))
    assert said.endswith("its borders are waist, hem")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "my kilt"}, "name must be of letters, digits, '_' and '-', and not that of an embedded garment"),
        ({"name": "dress"}, "name must be of letters"),
        ({"file": "kilt.fbx"}, r"file must be an OBJ file \(.obj\), got 'kilt.fbx'"),
        ({"type": "kilt"}, "type must be one of tshirt, top, trousers, skirt, jumpsuit, dress, got 'kilt'"),
        ({"unit": "inch"}, "unit must be one of m, dm, cm, mm, in, ft, got 'inch'"),
        ({"up": "x"}, "up must be one of z, y, got 'x'"),
        ({"betas": [0.0] * 11}, "betas must have at most 10 values, got 11"),
        ({"betas": [9.0]}, "betas must be <= 5.0"),
        ({"elastics": {"hem": 0.2}}, "elastics.hem must be > 0.3 and <= 1 of the cloth's length, got 0.2"),
        ({"elastics": {"hem": "tight"}}, "elastics must be"),
        ({"colour": "red"}, "unknown key 'colour'"),
    ],
)
def test_bad_settings_are_refused(changes: dict[str, object], message: str) -> None:
    given = {"name": "kilt", "file": "kilt.obj", "type": "skirt", "gender": "female"} | changes
    with pytest.raises(SettingsError, match=message):
        build(OwnGarment, given)

"""Triangles that pass through each other are found, and no others."""

import numpy as np

from model.mesh.intersection import intersecting_faces, self_crossings, self_intersecting_faces

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
ONE = np.array([[0, 1, 2]])


def test_a_triangle_through_another_is_found_from_either_side() -> None:
    needle = np.array([[0.2, 0.2, -1.0], [0.2, 0.2, 1.0], [0.9, 0.9, 1.0]])
    assert intersecting_faces(TRIANGLE, ONE, needle, ONE).tolist() == [[0, 0]]
    assert intersecting_faces(needle, ONE, TRIANGLE, ONE).tolist() == [[0, 0]]


def test_a_triangle_beside_or_above_another_is_not_found() -> None:
    beside = np.array([[0.8, 0.8, -1.0], [0.8, 0.8, 1.0], [1.9, 1.9, 1.0]])
    assert len(intersecting_faces(TRIANGLE, ONE, beside, ONE)) == 0
    assert len(intersecting_faces(TRIANGLE, ONE, TRIANGLE + np.array([0.0, 0.0, 1e-6]), ONE)) == 0


def test_against_every_pair_tested_one_by_one() -> None:
    rng = np.random.default_rng(1)
    faces = np.arange(90).reshape(30, 3)
    a, b = (rng.normal(scale=0.4, size=(90, 3)) for _ in range(2))
    wanted = [[i, j] for i in range(30) for j in range(30) if _meet(a[faces[i]], b[faces[j]])]
    found = intersecting_faces(a, faces, b, faces)
    assert len(wanted) > 10
    assert sorted(found.tolist()) == wanted


def test_a_folded_strip_meets_itself_and_a_flat_one_does_not() -> None:
    x = np.linspace(0.0, 1.0, 11)
    points = np.array([[u, v, 0.0] for u in x for v in (0.0, 0.1)])
    faces = np.array([t for k in range(10) for t in ([2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3])])
    assert len(self_intersecting_faces(points, faces)) == 0
    points[-2:] = [[0.32, 0.03, -0.2], [0.32, 0.05, 0.2]]
    assert len(self_intersecting_faces(points, faces)) > 0


def test_the_faster_search_finds_the_same_pairs() -> None:
    """On sheets from flat to crumpled."""
    rng = np.random.default_rng(5)
    count = 16
    i, j = (k.ravel() for k in np.mgrid[:count, :count])
    corner = np.flatnonzero((i < count - 1) & (j < count - 1))
    faces = (corner[:, None, None] + np.array([[0, count, count + 1], [0, count + 1, 1]])).reshape(-1, 3)
    found = []
    for scale in (0.0, 0.002, 0.01, 0.03):
        points = 0.01 * np.stack([i, j, 0 * i], axis=1) + scale * rng.standard_normal((count**2, 3))
        pairs = self_crossings(points, faces)
        assert pairs.shape == (len(pairs), 2) and (pairs[:, 0] < pairs[:, 1]).all()
        assert sorted(pairs.tolist()) == sorted(self_intersecting_faces(points, faces).tolist())
        found.append(len(pairs))
    assert found[0] == 0 and found[-1] > 100


def _meet(p: np.ndarray, q: np.ndarray) -> bool:
    """Whether an edge of one triangle passes through the other, by solving for the crossing point."""
    for first, second in ((p, q), (q, p)):
        for k in range(3):
            start, way = first[k], first[(k + 1) % 3] - first[k]
            matrix = np.stack([second[1] - second[0], second[2] - second[0], -way], axis=1)
            u, v, t = np.linalg.solve(matrix, start - second[0])
            if u > 0 and v > 0 and u + v < 1 and 0 < t < 1:
                return True
    return False

"""How near parts come to each other, against all distances of all points."""

from itertools import pairwise

import numpy as np
import pytest

from model.body import REST_POSE, BodyModel
from stages.body.collision.vectors import squares
from stages.body.figure import Figure
from stages.body.overlap import FAR, INWARD, STRAY, TANGENT, Approach, Posed
from stages.body.parts import Parts, divide

Person = tuple[BodyModel, np.ndarray, Figure]
GAP = 0.012


def least(one: Posed, other: Posed, k: int) -> float:
    """Smallest signed distance of the points of one part to the other in frame k, from all pairs of points [m]."""
    a, b = one.points[k].astype(np.float64), other.points[k].astype(np.float64)
    normals = other.part.normals_in(other.transforms[k], np.arange(len(b)))
    apart = np.linalg.norm(a[:, None] - b, axis=2)
    nearest = apart.argmin(axis=1)
    apart = apart.min(axis=1)
    height = ((a - b[nearest]) * normals[nearest]).sum(axis=1)
    distance = np.where((apart < TANGENT) | (height < -INWARD * apart), height, apart)
    return float(distance[apart < FAR].min(initial=FAR))


def posed(parts: Parts, spread: np.ndarray, k: int) -> list[Posed]:
    """Both legs, turned outwards by angles `spread` [T, rad], one knee ever more bent with the number `k` of looks."""
    pose = np.repeat(REST_POSE[None], len(spread), axis=0)
    pose[:, 1, 2], pose[:, 2, 2] = spread, -spread
    pose[:, 4, 0] = 0.005 * k
    transforms = parts.transforms(pose)
    return [Posed.of(leg, transforms) for leg in parts.legs]


def test_what_is_not_looked_at_again_is_far(woman: Person) -> None:
    """Legs that close step by step are measured as if all their points were looked at each time."""
    model, betas, _ = woman
    parts, frames = divide(model, betas), np.arange(8)
    approach = Approach(len(frames), *parts.legs, GAP)
    spread, seen, full = np.linspace(-0.08, 0.3, 8), np.zeros(2, int), []
    for k in range(6):
        legs = posed(parts, spread - 0.004 * k, k)
        found = {row: near for row, *near in approach.look(frames, *legs)}
        full.append(approach.then.copy())
        for row in frames:
            true = [least(legs[side], legs[1 - side], row) for side in (0, 1)]
            seen += [row in found, min(true) < GAP]
            if row not in found:
                assert min(true) >= max(GAP, TANGENT)
                continue
            for side in (0, 1):
                if min(true[side], found[row][side].least()) < FAR - STRAY:
                    assert found[row][side].least() == pytest.approx(true[side], abs=1e-5)
    assert 5 < seen[1] < seen[0] < 6 * len(frames) - 4, "some are near, some needn't be looked at again"
    again = sum(np.any(one != other, axis=(1, 2)).sum() for one, other in pairwise(full))
    assert 0 < again < 20, "rows are found anew, but seldom"


def test_squared_distances() -> None:
    rng = np.random.default_rng(3)
    a, b = (rng.uniform(-1, 1, (n, 3)).astype(np.float32) for n in (70, 40))
    np.testing.assert_allclose(squares(a, b), ((a[:, None].astype(float) - b) ** 2).sum(axis=2), atol=2e-6)

"""Encoding one garment: rigid motion, numbering, and rows that do not fit."""

import numpy as np
import pytest

from stages.encode.garment import Rows, encode_garment

FACES = np.array([[0, 1, 2], [0, 2, 3]])
FACE = np.array([0, -1, 1, 1])
WEIGHTS = np.array([[0.2, 0.3, 0.5], [0, 0, 0], [1, 0, 0], [0.25, 0.25, 0.5]])
GARMENT = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0.2]])
LAYER = np.array([[0.7, 0.4, -0.1], [5, 5, 5], [0.1, 0, 0], [0.3, 0.7, 0.2]])


def rows(**changed: np.ndarray) -> Rows:
    return Rows(**{"faces": FACES, "face": FACE, "barycentric": WEIGHTS, "mask": FACE >= 0, **changed})


def test_offsets_by_hand() -> None:
    offsets = encode_garment(GARMENT, LAYER, rows())
    expected = [[0.8 - 0.7, 0.5 - 0.4, 0.25 + 0.1], [0, 0, 0], [-0.1, 0, 0], [0.25 - 0.3, 0.75 - 0.7, 0.225 - 0.2]]
    np.testing.assert_allclose(offsets, expected, atol=1e-6)


def test_rigid_motion_turns_the_offsets() -> None:
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    move = np.array([3.0, -1, 2])
    before = encode_garment(GARMENT, LAYER, rows())
    after = encode_garment(GARMENT @ turn.T + move, LAYER @ turn.T + move, rows())
    np.testing.assert_allclose(after, before @ turn.T, atol=1e-6)


def test_numbering_of_garment_and_layer_does_not_matter() -> None:
    order, place = np.array([2, 0, 3, 1]), np.array([1, 3, 0, 2])
    before = encode_garment(GARMENT, LAYER, rows())
    np.testing.assert_array_equal(encode_garment(GARMENT[order], LAYER, rows(faces=place[FACES])), before)
    relabelled = rows(face=FACE[order], barycentric=WEIGHTS[order], mask=FACE[order] >= 0)
    np.testing.assert_array_equal(encode_garment(GARMENT, LAYER[order], relabelled), before[order])


def test_frames_are_encoded_one_by_one() -> None:
    moving = np.stack([GARMENT, GARMENT + 0.1, 2 * GARMENT])
    posed = np.stack([LAYER, LAYER - 0.2, LAYER])
    together = encode_garment(moving, posed, rows())
    for t in range(3):
        np.testing.assert_array_equal(together[t], encode_garment(moving[t], posed[t], rows()))


def test_rows_must_fit() -> None:
    with pytest.raises(ValueError, match="face must be < 1, the garment's faces, got 1"):
        rows(faces=FACES[:1])
    with pytest.raises(ValueError, match="mask must hold exactly"):
        rows(mask=np.ones(4, dtype=bool))
    with pytest.raises(ValueError, match="more than 3 vertices, got 3"):
        encode_garment(GARMENT[:3], LAYER, rows())
    with pytest.raises(ValueError, match=r"as many frames as the poses, \(2,\), got \(3,\)"):
        encode_garment(np.stack([GARMENT] * 3), np.stack([LAYER] * 2), rows())

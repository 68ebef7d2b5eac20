"""What cloth collides with: closed again without a forearm; who covers it is refused."""

import numpy as np
import pytest

from model.body import REST_POSE, load_free_body
from stages.simulate.collider import closed, refuse_covered
from stages.spec import DataError


def test_a_body_without_a_forearm_is_closed() -> None:
    model = load_free_body("female")
    rest = model.pose(np.zeros(10), REST_POSE[None], np.zeros((1, 3)))[0]
    kept = ~(rest[model.faces][:, :, 0] > 0.45).all(axis=1)
    assert 0 < np.count_nonzero(~kept) < len(kept) / 4
    faces = closed(model.faces, kept)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    np.testing.assert_array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))
    np.testing.assert_array_equal(closed(model.faces, np.ones(len(kept), bool)), model.faces)
    sleeve, top = rest[rest[:, 0] > 0.5][::3] * 1.01, rest[np.abs(rest[:, 0]) < 0.15][::3] * 1.01
    refuse_covered(["left_forearm"], {"top": top}, rest, model.faces, kept)
    with pytest.raises(DataError, match=r"shirt: covers left_forearm with \d+\.\d% of its vertices"):
        refuse_covered(["left_forearm"], {"top": top, "shirt": np.concatenate([top, sleeve])}, rest, model.faces, kept)

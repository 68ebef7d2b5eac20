"""The embedded free body: a closed, plausible human at every beta it promises."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from model.body import GENDERS, JOINT_NAMES, BodyModel, load_free_body
from model.body.asset import ASSET_FOLDER

STATURE = {"female": (1.58, 1.68), "male": (1.70, 1.80)}
"""Adult means that a reader would accept [m]."""


@pytest.fixture(params=GENDERS)
def body(request: pytest.FixtureRequest) -> BodyModel:
    """The embedded body of each gender."""
    return load_free_body(request.param)


def _stature(body: BodyModel, betas: list[float]) -> float:
    """Height of the standing body [m]."""
    return float(np.ptp(body.shape(betas)[0][:, 1]))


def _waist(body: BodyModel, betas: list[float]) -> float:
    """Length of the torso's outline at the height of the second spine joint [m]."""
    vertices, joints = body.shape(betas)
    section = trimesh.Trimesh(vertices, body.faces, process=False).section([0.0, 1.0, 0.0], joints[6])
    assert section is not None
    return float(section.length)


def _volume(body: BodyModel, betas: list[float]) -> float:
    """Volume enclosed [m^3]."""
    return float(trimesh.Trimesh(body.shape(betas)[0], body.faces, process=False).volume)


def test_closed_and_wound_outwards(body: BodyModel) -> None:
    """One watertight piece without handles, of a human volume."""
    mesh = trimesh.Trimesh(body.v_template, body.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.euler_number == 2
    assert 0.05 < mesh.volume < 0.09
    assert np.array_equal(np.unique(body.faces), np.arange(body.vertex_count)), "every vertex is used"


def test_weights_are_convex(body: BodyModel) -> None:
    """Rows sum to 1 and nothing is negative; every joint moves something."""
    np.testing.assert_allclose(body.weights.sum(axis=1), 1.0, atol=1e-6)
    assert body.weights.min() >= 0.0
    assert (body.weights.max(axis=0) > 0.4).all()


def test_both_genders_share_the_topology() -> None:
    """Garments and layers rely on the same faces for both."""
    female, male = (load_free_body(gender) for gender in GENDERS)
    np.testing.assert_array_equal(female.faces, male.faces)
    np.testing.assert_array_equal(female.parents, male.parents)


def test_beta_1_is_stature(body: BodyModel) -> None:
    """Taller with every step, human at both ends, and as fat as before."""
    low, high = STATURE[body.gender]
    assert low < _stature(body, [0.0]) < high
    statures = [_stature(body, [b]) for b in (-3, -2, -1, 0, 1, 2, 3)]
    assert (np.diff(statures) > 0.05).all()
    assert statures[0] > 1.35
    assert statures[-1] < 2.05
    mean, tall = (1000.0 * _volume(body, [b]) / _stature(body, [b]) ** 2 for b in (0.0, 3.0))
    assert abs(tall - mean) < 1.0, "body mass index [kg/m^2]"


def test_beta_2_is_fatness(body: BodyModel) -> None:
    """A larger waist and a heavier body with every step, within human limits, at the same stature."""
    waists = [_waist(body, [0.0, b]) for b in (-3, -2, -1, 0, 1, 2, 3)]
    assert (np.diff(waists) > 0.01).all()
    stature = _stature(body, [0.0, 0.0])
    indices = [1000.0 * _volume(body, [0.0, b]) / stature**2 for b in (-3, 0, 3)]
    assert 16.0 < indices[0] < 19.0
    assert 21.0 < indices[1] < 25.0
    assert 27.0 < indices[2] < 33.0
    assert abs(_stature(body, [0.0, 3.0]) - stature) < 0.02


@pytest.mark.parametrize("beta", range(10))
def test_the_ends_of_each_axis_do_not_fold_the_clothed_skin(body: BodyModel, beta: int) -> None:
    """No triangle between ankles, wrists and neck turns by more than a right angle at beta = +-3."""
    top, bottom, reach = (body.joint_template[JOINT_NAMES.index(j)] for j in ("neck", "left_ankle", "left_wrist"))
    x, y, _ = body.v_template[body.faces].mean(axis=1).T
    clothed = body.faces[(y < top[1]) & (y > bottom[1]) & (np.abs(x) < reach[0])]

    def normals(vertices: np.ndarray) -> np.ndarray:
        a, b, c = (vertices[clothed[:, i]].astype(np.float64) for i in range(3))
        return np.cross(b - a, c - a)

    mean = normals(body.v_template)
    for end in (-3.0, 3.0):
        betas = np.zeros(10)
        betas[beta] = end
        assert ((normals(body.shape(betas)[0]) * mean).sum(axis=1) > 0).all()


def test_pelvis_is_the_origin_for_every_shape(body: BodyModel) -> None:
    """So `trans` alone says where a person is."""
    np.testing.assert_allclose(body.shape([2.0, -1.0, 1.0, 1.0])[1][0], 0.0, atol=1e-6)


def test_left_and_right_are_alike(body: BodyModel) -> None:
    """The person's left is +x; joints and skin mirror within a few millimetres."""
    vertices, joints = body.v_template, body.joint_template
    for k, name in enumerate(JOINT_NAMES):
        if name.startswith("left_"):
            other = JOINT_NAMES.index(name.replace("left", "right"))
            assert joints[k, 0] > 0.01
            np.testing.assert_allclose(joints[k] * [-1, 1, 1], joints[other], atol=2e-3)
    distance, _ = cKDTree(vertices).query(vertices * [-1, 1, 1])
    assert distance.max() < 5e-3
    left_heavy = body.weights[:, [k for k, n in enumerate(JOINT_NAMES) if n.startswith("left_")]].sum(axis=1) > 0.9
    assert vertices[left_heavy, 0].min() > 0.0


@pytest.mark.parametrize("betas", [[0.0], [2.0], [-2.0], [0.0, 2.0], [0.0, -2.0]])
def test_both_feet_stand_on_the_ground(body: BodyModel, betas: list[float]) -> None:
    """The soles are level with each other, and heel and ball of each foot with the ground."""
    vertices, joints = body.shape(betas)
    ground = vertices[:, 1].min()
    for side in (1.0, -1.0):
        foot = vertices[(side * vertices[:, 0] > 0) & (vertices[:, 1] < joints[7, 1])]
        heel = foot[foot[:, 2] < joints[7, 2]]
        ball = foot[foot[:, 2] > joints[10, 2]]
        assert heel[:, 1].min() - ground < 0.012
        assert ball[:, 1].min() - ground < 0.012


def test_t_pose(body: BodyModel) -> None:
    """Arm joints on one horizontal line, facing +z."""
    joints = body.joint_template
    arm = joints[[16, 18, 20, 22]]
    np.testing.assert_allclose(arm[:, 1:], np.broadcast_to(arm[0, 1:], (4, 2)), atol=1e-3)
    assert (np.diff(arm[:, 0]) > 0.02).all()
    assert joints[10, 2] > joints[7, 2] + 0.05, "toes in front of the ankle"


def test_arrays_are_shared_and_read_only() -> None:
    """A caller cannot spoil the body for the next one."""
    body = load_free_body("female")
    assert load_free_body("female") is body
    with pytest.raises(ValueError, match="read-only"):
        body.v_template[0] = 0.0
    with pytest.raises(ValueError, match="one of female, male, got 'Female'"):
        load_free_body("Female")


def test_assets_are_small_and_say_where_they_come_from() -> None:
    """The repository stays light, and the licence travels with the data."""
    assert sum(file.stat().st_size for file in ASSET_FOLDER.iterdir()) < 6e6
    text = (ASSET_FOLDER / "PROVENANCE.md").read_text()
    assert "CC0" in text
    assert "sha256" in text

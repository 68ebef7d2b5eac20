"""Loss terms: closed forms, zeros where they must be, and gradients against finite differences."""

import math

import numpy as np
import pytest
import torch

from model.gcvae import losses


def test_divergence_equals_an_integral() -> None:
    mean, log_variance = 0.7, -0.9
    sigma = math.exp(0.5 * log_variance)
    x = np.linspace(mean - 12 * sigma, mean + 12 * sigma, 200_001)
    density = np.exp(-0.5 * ((x - mean) / sigma) ** 2) / (sigma * math.sqrt(2 * math.pi))
    log_ratio = -0.5 * ((x - mean) / sigma) ** 2 - math.log(sigma) + 0.5 * x**2
    expected = np.trapezoid(density * log_ratio, x)
    actual = losses.kl_divergence(torch.tensor([[mean]]), torch.tensor([[log_variance]]))
    assert float(actual) == pytest.approx(expected, abs=1e-5)
    assert float(losses.kl_divergence(torch.zeros(1, 1), torch.zeros(1, 1))) == 0.0


def test_face_normals_and_their_loss(sphere: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = sphere
    face_normals = losses.FaceNormals(faces, len(vertices))
    positions = torch.from_numpy(vertices).float()[:, None, :]
    normals = face_normals(positions)
    # On a sphere the normal of a face is the direction of its centre.
    centre = torch.from_numpy(vertices[faces].mean(axis=1)).float()
    assert ((normals[:, 0] * torch.nn.functional.normalize(centre, dim=1)).sum(1) > 0.99).all()
    inside = torch.ones(len(faces), 1, dtype=torch.bool)
    assert float(losses.normals_loss(normals, normals, inside)) == 0.0
    assert float(losses.normals_loss(normals, face_normals(3.0 * positions), inside)) < 1e-5
    flipped = torch.tensor([-1.0, 1.0, 1.0]) * normals
    assert float(losses.normals_loss(flipped, normals, inside)) == pytest.approx(
        2 * float(normals[:, 0, 0].abs().mean()), rel=1e-5
    )


def test_only_faces_wholly_inside_count(sphere: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = sphere
    mask = torch.zeros(len(vertices), 1, dtype=torch.bool)
    mask[faces[0], 0] = True
    inside = losses.FaceNormals(faces, len(vertices)).inside(mask)
    assert inside[0, 0] and inside.sum() == 1


def test_offsets_count_fully_inside_and_lightly_outside() -> None:
    predicted = torch.zeros(4, 1, 3)
    target = torch.tensor([3.0, 3.0, 1.0, 1.0])[:, None, None].expand(4, 1, 3)
    mask = torch.tensor([[True], [True], [False], [False]])
    assert float(losses.offsets_loss(predicted, target, mask)) == pytest.approx(3.0 + losses.OUTSIDE_WEIGHT)


def test_mask_losses() -> None:
    logits, mask = torch.tensor([[0.0], [2.0]]), torch.tensor([[True], [False]])
    assert float(losses.mask_loss(logits, mask, "bce")) == pytest.approx(
        0.5 * (math.log(2) + math.log(1 + math.e**2)), rel=1e-5
    )
    assert float(losses.mask_loss(logits, mask, "l1")) == pytest.approx(0.5 * (0.5 + 1 / (1 + math.e**-2)), rel=1e-5)


def test_collision_is_the_mean_depth_in_metres() -> None:
    normals = torch.tensor([[0.0, 0.0, 1.0]]).expand(3, 1, 3)
    offsets = torch.tensor([[0.5, 0.0, -0.004], [0.0, 0.0, 0.01], [0.0, 0.0, -1.0]])[:, None, :]
    mask = torch.tensor([[True], [True], [False]])
    assert float(losses.collision_loss(offsets, normals, mask)) == pytest.approx(0.002)


def test_gradients_equal_finite_differences(sphere: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = sphere
    rng = np.random.default_rng(0)
    face_normals = losses.FaceNormals(faces, len(vertices))
    mask = torch.from_numpy(vertices[:, 2:] > 0.0)
    inside = face_normals.inside(mask)
    body = torch.from_numpy(vertices).float()[:, None, :]
    target = torch.from_numpy(0.1 * rng.standard_normal((len(vertices), 1, 3))).float()
    offsets = torch.from_numpy(0.1 * rng.standard_normal((len(vertices), 1, 3))).float()
    truth = face_normals(body + target)

    def total(x: torch.Tensor) -> torch.Tensor:
        return (
            losses.offsets_loss(x, target, mask)
            + losses.normals_loss(face_normals(body + x), truth, inside)
            + 10 * losses.collision_loss(x, body, mask)
        ).sum()

    x = offsets.clone().requires_grad_(True)
    (gradient,) = torch.autograd.grad(total(x), x)
    for _ in range(4):
        direction = torch.from_numpy(rng.standard_normal(offsets.shape)).float() + 5 * gradient.sign()
        step = 2e-5
        slope = (total(offsets + step * direction) - total(offsets - step * direction)) / (2 * step)
        expected = (gradient * direction).sum()
        assert expected.abs() > 1.0
        assert float(slope) == pytest.approx(float(expected), rel=0.02)

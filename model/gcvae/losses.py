"""The terms of the networks' loss (CLOTH3D, Loss), each a mean over the batch in units of order one."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import torch
from torch import Tensor
from torch.nn import functional

from model.gcvae.graphs import SparseProduct, csr_tensor

# Outside the garment the target is the fill by diffusion: followed loosely, so that the border is well defined.
OUTSIDE_WEIGHT = 0.05


class FaceNormals:
    """Unit face normals of node-major positions; edge vectors are sparse products, whose gradients need no scatter."""

    def __init__(self, faces: np.ndarray, count: int, device: str = "cpu") -> None:
        self.faces = torch.from_numpy(faces.astype(np.int64)).to(device)
        rows = np.repeat(np.arange(len(faces)), 2)
        self.edges = []
        for k in (1, 2):
            columns = np.stack([faces[:, 0], faces[:, k]], axis=1).ravel()
            values = np.tile([-1.0, 1.0], len(faces))
            matrix = sp.csr_matrix((values, (rows, columns)), shape=(len(faces), count))
            self.edges.append((csr_tensor(matrix, device), csr_tensor(matrix.T.tocsr(), device)))

    def __call__(self, positions: Tensor) -> Tensor:
        """Normals (F, B, 3) of positions (N, B, 3) [any length unit]."""
        flat = positions.reshape(positions.shape[0], -1)
        first, second = (SparseProduct.apply(flat, *pair).view(-1, *positions.shape[1:]) for pair in self.edges)
        return functional.normalize(torch.linalg.cross(first, second), dim=2, eps=1e-12)

    def inside(self, mask: Tensor) -> Tensor:
        """Which faces (F, B) have all three vertices in the mask (N, B)."""
        return mask[self.faces].all(dim=1)


def per_sample_mean(values: Tensor, weight: Tensor) -> Tensor:
    """Mean over the first axis of values (N, B) under weights (N, B), shape (B,); zero where nothing has weight."""
    return (values * weight).sum(0) / weight.sum(0).clamp_min(1e-6)


def offsets_loss(predicted: Tensor, target: Tensor, mask: Tensor) -> Tensor:
    """L_o: absolute error of normalised offsets (N, B, 3) over the mask (N, B) and, lightly, outside it; (B,)."""
    error = (predicted - target).abs().mean(2)
    inside = mask.to(error.dtype)
    return per_sample_mean(error, inside) + OUTSIDE_WEIGHT * per_sample_mean(error, 1.0 - inside)


def normals_loss(predicted: Tensor, target: Tensor, inside: Tensor) -> Tensor:
    """L_n: absolute error of unit face normals (F, B, 3) over the faces inside the garment (F, B); shape (B,)."""
    return per_sample_mean((predicted - target).abs().sum(2), inside.to(predicted.dtype))


def mask_loss(logits: Tensor, mask: Tensor, kind: str) -> Tensor:
    """L_m of logits (N, B), shape (B,): "bce", or the paper's "l1" between mask and sigmoid."""
    target = mask.to(logits.dtype)
    if kind == "l1":
        return (torch.sigmoid(logits) - target).abs().mean(0)
    return functional.binary_cross_entropy_with_logits(logits, target, reduction="none").mean(0)


def collision_loss(offsets: Tensor, normals: Tensor, mask: Tensor) -> Tensor:
    """L_c = max(0, -o . V_N) [m] with the posed body's vertex normals (N, B, 3), mean over the mask; shape (B,).

    It tests the half-space behind each vertex's tangent plane; whether cloth is inside the body, only a signed
    distance says.
    """
    depth = functional.relu(-(offsets * normals).sum(2))
    return per_sample_mean(depth, mask.to(depth.dtype))


def kl_divergence(mean: Tensor, log_variance: Tensor) -> Tensor:
    """KL(N(mean, exp(log_variance)) || N(0, I)) of each dimension, shape (B, Z); the loss takes its sum over Z."""
    return 0.5 * (mean.square() + log_variance.exp() - 1.0 - log_variance)

"""The hierarchy as torch operators: products with the Laplacian, pooling and unpooling, on node-major tensors."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import scipy.sparse as sp
import torch
from torch import Tensor

from model.gcvae import TOPOLOGIES
from model.gcvae.hierarchy import Hierarchy


class SparseProduct(torch.autograd.Function):
    """A @ x for a constant sparse A; its transpose is kept, because building it anew in every backward pass is slow."""

    @staticmethod
    def forward(ctx: Any, x: Tensor, matrix: Tensor, transpose: Tensor) -> Tensor:
        """Product with `matrix` (R, C) of x (C, F), shape (R, F)."""
        ctx.transpose = transpose
        return matrix @ x

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None, None]:
        """Product of the transpose with the gradient."""
        return ctx.transpose @ grad.contiguous(), None, None


class MaxPool(torch.autograd.Function):
    """Maximum over each cluster; children that tie share the gradient."""

    @staticmethod
    def forward(ctx: Any, x: Tensor, clusters: Tensor, sums: Tensor) -> Tensor:
        """Maxima (M, F) over the clusters (N,) of x (N, F); `sums` (M, N) adds up the members of each cluster."""
        index = clusters[:, None].expand(-1, x.shape[1])
        pooled = x.new_full((sums.shape[0], x.shape[1]), -torch.inf).scatter_reduce_(0, index, x, "amax")
        ctx.save_for_backward(x, pooled)
        ctx.clusters, ctx.sums = clusters, sums
        return pooled

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None, None]:
        """The gradient to the maximal child of each cluster."""
        x, pooled = ctx.saved_tensors
        winner = (x == pooled[ctx.clusters]).to(x.dtype)
        share = grad / (ctx.sums @ winner)
        return winner * share[ctx.clusters], None, None


class MeshGraphs:
    """Laplacians of both topologies, pooling and unpooling at every level; constants of the networks.

    Features are node-major, (N, B, F): a product with an (N, N) sparse matrix then reads whole rows of B x F numbers,
    which is several times faster on a CPU than one product a sample.
    """

    def __init__(self, hierarchy: Hierarchy, device: str = "cpu") -> None:
        self.sizes = hierarchy.sizes
        self.device = device
        self.laplacians = {
            topology: [csr_tensor(hierarchy.laplacian(topology, level), device) for level in range(len(self.sizes))]
            for topology in TOPOLOGIES
        }
        self.clusters = [torch.from_numpy(array.astype(np.int64)).to(device) for array in hierarchy.maps]
        copies = [copy_matrix(array, size) for array, size in zip(hierarchy.maps, self.sizes[1:])]
        self.copies = [csr_tensor(matrix, device) for matrix in copies]
        self.sums = [csr_tensor(matrix.T.tocsr(), device) for matrix in copies]

    def laplace(self, x: Tensor, topology: str, level: int) -> Tensor:
        """The rescaled Laplacian of one level times x (N, B, F)."""
        matrix = self.laplacians[topology][level]
        product: Tensor = SparseProduct.apply(x.reshape(x.shape[0], -1), matrix, matrix)
        return product.view_as(x)

    def pool(self, x: Tensor, level: int) -> Tensor:
        """Max-pooling from `level` (N, B, F) to the next coarser one (M, B, F)."""
        flat = x.reshape(x.shape[0], -1)
        pooled: Tensor = MaxPool.apply(flat, self.clusters[level], self.sums[level])
        return pooled.view(-1, *x.shape[1:])

    def unpool(self, x: Tensor, level: int) -> Tensor:
        """Copies each vertex of the level below (M, B, F) to its members at `level` (N, B, F)."""
        flat: Tensor = SparseProduct.apply(x.reshape(x.shape[0], -1), self.copies[level], self.sums[level])
        return flat.view(-1, *x.shape[1:])


def copy_matrix(clusters: np.ndarray, coarse: int) -> sp.csr_matrix:
    """Matrix (N, coarse) with a single one a row: the coarse vertex of each fine vertex."""
    count = len(clusters)
    return sp.csr_matrix((np.ones(count), clusters, np.arange(count + 1)), shape=(count, coarse))


def csr_tensor(matrix: sp.csr_matrix, device: str = "cpu") -> Tensor:
    """A scipy CSR matrix as a float32 torch CSR tensor with 32-bit indices, which MKL takes as they are."""
    matrix = matrix.tocsr()
    matrix.sort_indices()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Sparse CSR tensor support is in beta")
        warnings.filterwarnings("ignore", message="Sparse invariant checks are implicitly disabled")
        return torch.sparse_csr_tensor(
            torch.from_numpy(matrix.indptr.astype(np.int32)),
            torch.from_numpy(matrix.indices.astype(np.int32)),
            torch.from_numpy(matrix.data.astype(np.float32)),
            matrix.shape,
            device=device,
        )

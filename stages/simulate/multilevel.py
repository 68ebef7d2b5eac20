"""Coarse levels of the linear solve: what a block-Jacobi sweep can't see, stretch and sway over many edges.

Vertices are gathered into aggregates by pyamg on the rest mesh, aggregates into larger ones, and interpolation between
the levels is smoothed once (Vanek et al. 1996; for cloth Tamstorf et al. 2015). The levels are used additively: each
contributes its own correction to the same residual (Bramble, Pasciak and Xu 1990). All lists are built once a scene.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pyamg
from scipy import sparse

from stages.simulate.multilevel_kernels import coarse_inverses, galerkin_blocks, galerkin_springs, invert_coarsest

LEVELS = 3
"""Coarse levels below the mesh itself."""
COARSEST = 40
"""Most aggregates of the last level, whose matrix is inverted whole; fewer levels if reached sooner."""


class Gather:
    """A sparse matrix as gather lists: row r sums weight[k] * value[index[k]] over k in start[r]:start[r + 1]."""

    def __init__(self, matrix: sparse.csr_matrix, dtype: Any) -> None:
        matrix = sparse.csr_matrix(matrix)
        matrix.sort_indices()
        self.start = matrix.indptr.astype(np.int32)
        self.index = _filled(matrix.indices.astype(np.int32))
        self.weight = _filled(matrix.data.astype(dtype))


class Multilevel:
    """Interpolation P1, P2, P3 between the mesh and three coarse levels, and the levels' Galerkin matrices.

    Attributes:
        at [9]: Where in `first` the lists of P1, P2, P3 and of their transposes begin, then the levels' sizes.
        first, index, weight: The six gather lists, one behind the other.
        coarse [.., 3]: Vectors of the coarse levels: r1, r2, r3, z1, z2.
        inverse [n1 + n2, 6]: Inverse diagonal blocks of the first two levels.
        coarsest [3 n3, 3 n3]: Inverse of the matrix of the last one.
    """

    def __init__(self, edges: np.ndarray, stiffness: np.ndarray, fixed: np.ndarray, dtype: Any) -> None:
        """Levels for a mesh of `edges` (E, 2) with `stiffness` (E,) and N vertices of which `fixed` (N,) don't move."""
        n = len(fixed)
        edges = edges.astype(np.int64)
        operator = _laplacian(edges, stiffness, n)
        ps: list[sparse.csr_matrix] = []
        for level in range(LEVELS):
            p = _interpolation(operator)
            if level == 0:
                p = (sparse.diags((fixed == 0).astype(np.float64)) @ p).tocsr()
            ps.append(p)
            operator = (p.T @ operator @ p).tocsr()
        sizes = [p.shape[1] for p in ps]
        lists = [Gather(m, dtype) for m in (*ps, *(p.T for p in ps))]
        entries = np.cumsum([0, *(len(g.index) for g in lists)])
        self.first = np.concatenate([g.start + e for g, e in zip(lists, entries)]).astype(np.int32)
        self.at = np.array([*np.cumsum([0, *(len(g.start) for g in lists[:-1])]), *sizes], np.int32)
        self.index = np.concatenate([g.index for g in lists])
        self.weight = np.concatenate([g.weight for g in lists])
        self.coarse = np.zeros((2 * sizes[0] + 2 * sizes[1] + sizes[2], 3), dtype)
        self.inverse = np.zeros((sizes[0] + sizes[1], 6), dtype)
        self.coarsest, self.work = (np.zeros((3 * sizes[2], 3 * sizes[2]), t) for t in (dtype, np.float64))

        self.spring_count = len(edges)
        pairs, self.from_springs = _products_of_rows(
            sparse.vstack([ps[0][edges[:, 0]] - ps[0][edges[:, 1]], ps[0]]).tocsr(), dtype
        )
        every, self.steps = [pairs], []
        for p in ps[1:]:
            pairs, gather = _products_of_pairs(pairs, p, dtype)
            every.append(pairs)
            self.steps.append(gather)
        self.blocks = [np.zeros((len(pairs), 6), dtype) for pairs in every]
        self.places = [_diagonal_places(pairs, size) for pairs, size in zip(every[:2], sizes)]
        self.coarsest_pairs = every[-1].astype(np.int32)

    def rebuild(self, spring_block: np.ndarray, own_block: np.ndarray) -> None:
        """Galerkin matrices of springs [E, 4] (a I + w w^T) and the vertices' own blocks [N, 6], and inverses."""
        g = self.from_springs
        galerkin_springs(g.start, g.index, g.weight, self.spring_count, spring_block, own_block, self.blocks[0])
        for g, fine, coarse in zip(self.steps, self.blocks, self.blocks[1:]):
            galerkin_blocks(g.start, g.index, g.weight, fine, coarse)
        coarse_inverses(self.places[0], self.blocks[0], 0, self.inverse)
        coarse_inverses(self.places[1], self.blocks[1], len(self.places[0]), self.inverse)
        invert_coarsest(self.coarsest_pairs, self.blocks[-1], self.work, self.coarsest)


def _filled(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(values) if len(values) else np.zeros(1, values.dtype)


def _laplacian(edges: np.ndarray, stiffness: np.ndarray, n: int) -> sparse.csr_matrix:
    i, j = edges[:, 0], edges[:, 1]
    off = sparse.coo_matrix((-stiffness, (i, j)), shape=(n, n))
    off = (off + off.T).tocsr()
    return (off + sparse.diags(-np.asarray(off.sum(1)).ravel())).tocsr()


def _interpolation(operator: sparse.csr_matrix) -> sparse.csr_matrix:
    """Aggregates of `operator`'s graph and one damped Jacobi step on their indicator functions; rows sum to 1."""
    n = operator.shape[0]
    if n <= COARSEST:
        return sparse.identity(n, format="csr")
    p = pyamg.aggregation.standard_aggregation(operator)[0].astype(np.float64)
    lonely = np.flatnonzero(np.asarray(p.sum(1)).ravel() == 0)
    if len(lonely):  # vertices without a neighbour
        extra = sparse.coo_matrix((np.ones(len(lonely)), (lonely, np.arange(len(lonely)))), shape=(n, len(lonely)))
        p = sparse.hstack([p, extra])
    p = sparse.csr_matrix(p)
    inverse = sparse.diags(1.0 / np.maximum(operator.diagonal(), 1e-12))
    # 2/3 over the greatest eigenvalue of D^-1 A, which is at most 2 and on such meshes close to 1.5.
    p = (p - (2 / 3 / 1.5) * (inverse @ (operator @ p))).tocsr()
    p.data[np.abs(p.data) < 0.02] = 0.0
    p.eliminate_zeros()
    return (sparse.diags(1.0 / np.asarray(p.sum(1)).ravel()) @ p).tocsr()


def _expand(rows: sparse.csr_matrix) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All pairs of entries of the same row: row, first place, second place in the data, for column a <= column b."""
    rows.sort_indices()
    count = np.diff(rows.indptr)
    repeats = np.repeat(count, count)  # for each entry how many partners
    first = np.repeat(np.arange(rows.nnz), repeats)
    begin = np.repeat(rows.indptr[:-1], count)
    offset = np.arange(len(first)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    second = np.repeat(begin, repeats) + offset
    keep = rows.indices[first] <= rows.indices[second]
    row = np.repeat(np.repeat(np.arange(rows.shape[0]), count), repeats)
    return row[keep], first[keep], second[keep]


def _gathered(pairs: np.ndarray, source: np.ndarray, weight: np.ndarray, dtype: Any) -> tuple[np.ndarray, Gather]:
    """Sums by pair: the distinct `pairs` (P, 2) and lists of (source, weight) for each."""
    wide = int(pairs.max()) + 1
    key, place = np.unique(pairs[:, 0] * wide + pairs[:, 1], return_inverse=True)
    matrix = sparse.coo_matrix((weight, (place.ravel(), source)), shape=(len(key), int(source.max()) + 1)).tocsr()
    matrix.sum_duplicates()
    return np.column_stack([key // wide, key % wide]), Gather(matrix, dtype)


def _products_of_rows(rows: sparse.csr_matrix, dtype: Any) -> tuple[np.ndarray, Gather]:
    """sum_r rows[r, a] rows[r, b] B_r for every pair a <= b: pairs, and lists over r."""
    rows.data[np.abs(rows.data) < 1e-9] = 0.0
    rows.eliminate_zeros()
    row, first, second = _expand(rows)
    pairs = np.column_stack([rows.indices[first], rows.indices[second]]).astype(np.int64)
    return _gathered(pairs, row, rows.data[first] * rows.data[second], dtype)


def _products_of_pairs(pairs: np.ndarray, p: sparse.csr_matrix, dtype: Any) -> tuple[np.ndarray, Gather]:
    """P^T A P for symmetric A given by its blocks at `pairs` (a <= b): coarse pairs and lists over the fine ones."""
    p.sort_indices()
    count = np.diff(p.indptr)
    na, nb = count[pairs[:, 0]], count[pairs[:, 1]]
    total = na * nb
    source = np.repeat(np.arange(len(pairs)), total)
    offset = np.arange(len(source)) - np.repeat(np.cumsum(total) - total, total)
    ka = p.indptr[pairs[source, 0]] + offset // nb[source]
    kb = p.indptr[pairs[source, 1]] + offset % nb[source]
    c, d, weight = p.indices[ka].astype(np.int64), p.indices[kb].astype(np.int64), p.data[ka] * p.data[kb]
    off = pairs[source, 0] != pairs[source, 1]
    # A block off the diagonal stands for (a, b) and (b, a): both give to (c, d), twice so where c = d.
    weight = np.where(off & (c == d), 2 * weight, weight)
    keep = off | (c <= d)
    coarse = np.column_stack([np.minimum(c, d), np.maximum(c, d)])
    return _gathered(coarse[keep], source[keep], weight[keep], dtype)


def _diagonal_places(pairs: np.ndarray, size: int) -> np.ndarray:
    """Where among `pairs` the diagonal blocks are, -1 for a row that has none, shape [size]."""
    place = np.full(size, -1, np.int32)
    own = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
    place[pairs[own, 0]] = own
    return place

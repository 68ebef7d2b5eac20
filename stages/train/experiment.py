"""One network from samples to scores: fit, encode, compare with the baselines."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from model.body.layer import GarmentLayer
from model.gcvae import TOPOLOGIES
from model.gcvae.graphs import MeshGraphs
from model.gcvae.hierarchy import Hierarchy
from model.gcvae.losses import FaceNormals
from model.gcvae.network import Architecture, GarmentVae
from model.gcvae.normalise import Normaliser
from stages.train import evaluate
from stages.train.baselines import Components, TypeMeans
from stages.train.config import NetworkConfig, TrainConfig
from stages.train.evaluate import Codes, Predictor
from stages.train.fit import built, fit_conditioning, fit_network
from stages.train.objective import TERMS, Objective, input_channels
from stages.train.samples import Samples

# Scores of modes that hardly varied in training are not blown up to unit variance; share of the first mode's deviation.
SMALLEST_SCORE = 0.02


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """What the networks know of the layer.

    Attributes:
        hierarchy: Clusters and edges.
        graphs: The same as torch operators.
        faces: Faces of each topology.
        normals: Their normals as torch operators.
    """

    hierarchy: Hierarchy
    graphs: MeshGraphs
    faces: Mapping[str, NDArray[np.int32]]
    normals: Mapping[str, FaceNormals]

    @classmethod
    def of(cls, layer: GarmentLayer, hierarchy: Hierarchy) -> Mesh:
        """Operators of a layer."""
        faces = {topology: layer.faces(topology) for topology in TOPOLOGIES}
        return cls(
            hierarchy=hierarchy,
            graphs=MeshGraphs(hierarchy),
            faces=faces,
            normals={topology: FaceNormals(array, layer.vertex_count) for topology, array in faces.items()},
        )


@dataclass(frozen=True, kw_only=True)
class Trained:
    """A trained network and all that is needed to use and to judge it.

    Attributes:
        network: Encoder, Gamma and decoder.
        scales: Its units.
        means: Baseline of the mean garment.
        components: Baseline of principal components.
        history: Mean loss terms of each epoch, term -> (epochs,).
        conditioning_error: Gamma's last L1 error, in standard deviations.
    """

    network: GarmentVae
    scales: Normaliser
    means: TypeMeans
    components: Components
    history: dict[str, NDArray[np.float32]]
    conditioning_error: float


def train(
    samples: Samples,
    mesh: Mesh,
    settings: NetworkConfig,
    config: TrainConfig,
    rng: np.random.Generator,
    threads: int,
    report: Callable[[int, int], None],
) -> Trained:
    """Fit one network to `samples`, which are all for training: SVAE if they say nothing of frames, else DVAE."""
    masked = samples.worn is None
    scales = Normaliser.fit(samples.target, samples.masks, samples.body[np.unique(samples.wearer)], samples.cvar)
    most = max(settings.modes, *config.components)
    components = Components.fit(samples, most, scales.offset_scale, masked)
    modes = min(settings.modes, settings.latent, len(components.basis))
    shape = Architecture(
        inputs=input_channels(samples),
        masked=masked,
        conditions=samples.cvar.shape[1],
        middle=settings.middle,
        latent=settings.latent,
        hidden=settings.hidden,
        widths=settings.widths,
        depth=settings.depth,
        node_bias=settings.node_bias,
        modes=modes,
    )
    network = built(lambda: GarmentVae(mesh.graphs, shape), int(rng.integers(2**63)))
    basis = components.per_vertex(components.basis[:modes])
    network.start_from(
        torch.from_numpy(components.per_vertex(components.mean[None])[0]),
        torch.from_numpy(np.ascontiguousarray(np.moveaxis(basis, 0, 2))),
        torch.from_numpy(np.maximum(components.deviation[:modes], SMALLEST_SCORE * components.deviation[0])),
    )
    error = fit_conditioning(
        network.conditioning, torch.from_numpy(scales.conditions(samples.cvar)), config.conditioning_steps
    )
    objective = Objective(samples, scales, config, mesh.normals)
    history = fit_network(network, objective, settings, rng, threads, report)
    total = sum(objective.weights[name] * history[name] for name in TERMS)
    return Trained(
        network=network,
        scales=scales,
        means=TypeMeans.fit(samples),
        components=components,
        history={"total": np.asarray(total, np.float32), **history},
        conditioning_error=error,
    )


def compare(trained: Trained, samples: Samples, codes: Codes, config: TrainConfig, mesh: Mesh) -> dict[str, Any]:
    """Averages of the scores of the network and of every baseline on `samples`; see `metrics.averages`."""
    masked = trained.network.shape.masked
    nothing = "zero offsets" if masked else "zero offsets: the garment at rest, skinned"
    predictors: dict[str, Predictor] = {nothing: evaluate.zero_offset}
    predictors["mean offsets"] = evaluate.mean_offset(trained.means, masked)
    for size in sorted({min(size, len(trained.components.basis)) for size in config.components}):
        predictors[f"PCA ({size})"] = evaluate.projection(trained.components, size)
    predictors["SVAE" if masked else "DVAE"] = evaluate.reconstruct(trained.network, trained.scales, codes)
    return evaluate.compare(samples, predictors, mesh.faces)


def table_rows(scores: Mapping[str, Any], codes: Codes, name: str, held_out: bool, items: int) -> list[dict[str, Any]]:
    """The scores as rows of one table, averaged over samples; the network's row also has its KL divergence."""
    rows = []
    for model, averages in scores.items():
        row = {"model": model, "set": name, "held_out": held_out, "items": items, **averages["samples"]}
        row["surface_mm_by_category"] = averages["categories"]["surface_mm"]
        if model in ("SVAE", "DVAE"):
            divergence = codes.divergence()
            row |= {"kl": float(divergence.mean()), "kl_per_dimension": float(divergence.mean() / codes.mean.shape[1])}
        rows.append(row)
    return rows

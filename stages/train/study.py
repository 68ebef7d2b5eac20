"""The whole of the training: SVAE, then DVAE on its codes, their scores, and new garments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from model.body import REST_POSE, BodyModel
from model.body.layer import GarmentLayer
from model.gcvae import TOPOLOGIES
from model.gcvae.hierarchy import Hierarchy, build_hierarchy
from stages.spec import Progress
from stages.train.assemble import dynamic_samples, static_samples
from stages.train.config import TrainConfig
from stages.train.evaluate import encode
from stages.train.experiment import Mesh, Trained, compare, table_rows, train
from stages.train.fill import Fill
from stages.train.generate import Generated, Model, generate
from stages.train.records import Record
from stages.train.samples import Samples
from stages.train.sampling import CodeSampler


@dataclass(frozen=True, kw_only=True)
class Study:
    """What the stage publishes.

    Attributes:
        hierarchy: Clusters and edges of the networks.
        networks: "svae" and, if anything moves, "dvae".
        rows: One row a method and set, for a table.
        scores: set -> method -> averages over samples, over categories, and of each type.
        generated: New garments.
    """

    hierarchy: Hierarchy
    networks: dict[str, Trained]
    rows: list[dict[str, Any]]
    scores: dict[str, Any]
    generated: list[Generated]


def layer_hierarchy(layer: GarmentLayer) -> Hierarchy:
    """The mesh hierarchy of a layer, built on its mean body in the rest pose."""
    vertices = layer.model.pose(np.zeros(layer.model.beta_count), REST_POSE[None])[0]
    return build_hierarchy(vertices, layer.body_faces, layer.skirt_faces, layer.segments)


def conduct(
    records: Sequence[Record],
    bodies: Mapping[str, BodyModel],
    layers: Mapping[str, GarmentLayer],
    config: TrainConfig,
    rng: np.random.Generator,
    threads: int,
    progress: Progress,
) -> Study:
    """Train and score everything; the same records, settings and generator give the same bits.

    SVAE is trained on every garment at rest, those of sequences included, and scored on static items.

    Raises:
        ValueError: If no garment is in the training split.
    """
    hierarchy = layer_hierarchy(next(iter(layers.values())))
    mesh = Mesh.of(next(iter(layers.values())), hierarchy)
    fills = {topology: Fill(hierarchy, topology) for topology in TOPOLOGIES}
    moving = [record for record in records if record.sequence]
    at_rest = static_samples(records, layers, fills)
    if not at_rest.train.any():
        raise ValueError("train: no item is in the training split; lower test_share or add items")
    # Epochs of DVAE cost more than SVAE's by the number of frames; progress counts samples.
    frames = sum(len(record.frames) * len(record.garments) for record in moving)
    work = [config.static.epochs * int(at_rest.train.sum()), config.dynamic.epochs * frames]

    static = train(
        _chosen(at_rest, at_rest.train), mesh, config.static, config, rng, threads,
        lambda done, epochs: progress(work[0] * done / epochs, sum(work), f"SVAE, epoch {done} of {epochs}"),
    )  # fmt: skip
    networks = {"svae": static}
    rows: list[dict[str, Any]] = []
    scores: dict[str, Any] = {}
    sequence = {record.item for record in moving}
    of_statics = np.array([name.split("/")[0] not in sequence for name in at_rest.names])
    seen = _test_rows(at_rest.train, of_statics if of_statics.any() else ~of_statics)
    rows += _judge(static, _chosen(at_rest, seen), "static", scores, config, mesh)
    models: list[Model | None] = [_model(static, _chosen(at_rest, at_rest.train)), None]

    if moving:
        worn = static_samples(moving, layers, fills)
        codes = encode(static.network, worn, static.scales).mean
        samples = dynamic_samples(moving, layers, fills, worn, codes, config)
        if samples.train.any():
            dynamic = train(
                _chosen(samples, samples.train), mesh, config.dynamic, config, rng, threads,
                lambda done, epochs: progress(
                    work[0] + work[1] * done / epochs, sum(work), f"DVAE, epoch {done} of {epochs}"
                ),
            )  # fmt: skip
            networks["dvae"] = dynamic
            seen = _test_rows(samples.train, np.ones(len(samples), bool))
            by_frame = all(record.train for record in moving)
            name = "sequence, last fifth of the frames" if by_frame else "sequence"
            rows += _judge(dynamic, _chosen(samples, seen), name, scores, config, mesh)
            models[1] = _model(dynamic, _chosen(samples, samples.train))
    people = [record for record in records if record.train]
    assert models[0] is not None
    garments = generate(models[0], models[1], people, bodies, layers, config, rng)
    return Study(hierarchy=hierarchy, networks=networks, rows=rows, scores=scores, generated=garments)


def _chosen(samples: Samples, which: np.ndarray) -> Samples:
    return samples.select(np.flatnonzero(which))


def _test_rows(train: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Wanted samples that are held out, or those of the training split if none is."""
    held_out = ~train & wanted
    return held_out if held_out.any() else train & wanted


def _judge(
    trained: Trained, samples: Samples, name: str, scores: dict[str, Any], config: TrainConfig, mesh: Mesh
) -> list[dict[str, Any]]:
    codes = encode(trained.network, samples, trained.scales)
    scores[name] = compare(trained, samples, codes, config, mesh)
    return table_rows(scores[name], codes, name, not samples.train.any(), len(samples))


def _model(trained: Trained, samples: Samples) -> Model:
    codes = encode(trained.network, samples, trained.scales)
    return Model(trained=trained, sampler=CodeSampler.fit(codes.mean, codes.log_variance, samples.types))

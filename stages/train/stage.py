"""The shell of the stage train: reads what was encoded, trains, publishes networks, scores and new garments."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

import store
from model.body.layer import garment_layer
from stages.body_model import load_body_model
from stages.settings import build
from stages.spec import DataError, Progress, Task
from stages.train import packing
from stages.train.config import TrainConfig
from stages.train.reading import read_records, wearers
from stages.train.study import conduct


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Train on every encoded item and publish the result.

    Returns:
        The networks' scores on held-out garments, for the receipt.

    Raises:
        DataError: If the items cannot be trained on.
    """
    config = build(TrainConfig, task.config)
    bodies = {gender: load_body_model(about) for gender, about in wearers(task).items()}
    layers = {gender: garment_layer(body) for gender, body in bodies.items()}
    count = next(iter(layers.values())).vertex_count
    records = read_records(task, config.frames_per_sequence, count, progress)
    threads = config.threads or len(os.sched_getaffinity(0))
    try:
        study = conduct(records, bodies, layers, config, np.random.default_rng(task.seed), threads, progress)
    except ValueError as error:
        raise DataError(str(error)) from error
    arrays = {f"hierarchy/{name}": array for name, array in study.hierarchy.arrays().items()}
    for name, trained in study.networks.items():
        arrays |= packing.network_arrays(name, trained)
    arrays |= packing.generated_arrays(study.generated)
    attrs = {
        "metrics": study.rows,
        "scores": study.scores,
        "losses": {name: packing.loss_curves(trained.history) for name, trained in study.networks.items()},
        "networks": {name: packing.shape_attrs(trained) for name, trained in study.networks.items()},
        "conditioning_error": {name: trained.conditioning_error for name, trained in study.networks.items()},
        "generated": {f"{k:03d}": garment.about for k, garment in enumerate(study.generated)},
    }
    store.publish(Path(task.output), "train", task.key, arrays, attrs)
    own = [row for row in study.rows if row["model"] in ("SVAE", "DVAE")]
    return {f"{row['model'].lower()}_surface_mm": row["surface_mm"] for row in own}

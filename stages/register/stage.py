"""The shell of the stage register: reads an outfit, registers each of its garments, publishes the correspondences."""

from __future__ import annotations

from typing import Any

import numpy as np

import store
from model.body.layer import TOPOLOGY, garment_layer
from stages.body_model import load_body_model
from stages.register import SPEC
from stages.register.config import RegisterConfig
from stages.register.garment import register_garment
from stages.settings import build
from stages.spec import DataError, Progress, Task


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Registers the garments of one outfit; returns their worst errors.

    Raises:
        DataError: A garment has an unknown type, or too little of it can be registered.
    """
    config = build(RegisterConfig, task.config)
    outfit = store.read(*_input(task, "outfit"))
    body = store.read_header(*_input(task, "body"))
    layer = garment_layer(load_body_model(body.attrs))
    rng = np.random.default_rng(task.seed)
    arrays: dict[str, np.ndarray] = {}
    attrs: dict[str, dict[str, Any]] = {}
    names = sorted(outfit.attrs["garments"])
    for done, name in enumerate(names):
        progress(done, len(names), f"registering {name}")
        kind = outfit.attrs["garments"][name]["type"]
        if kind not in TOPOLOGY:
            raise DataError(f"{outfit.path}: garment {name!r} has type {kind!r}; known are {', '.join(TOPOLOGY)}")
        vertices, faces = outfit[f"garments/{name}/vertices"], outfit[f"garments/{name}/faces"]
        result = register_garment(vertices, faces, layer, outfit["tight_betas"], kind, config, rng)
        quality = result.quality
        if quality.coverage < config.min_coverage:
            raise DataError(
                f"{task.item}: the registered {name} covers {quality.coverage:.3f} of the garment, min_coverage is "
                f"{config.min_coverage}; its faces must turn outwards; raise [register] reach, or leave the outfit out"
            )
        arrays[f"garments/{name}/face"] = result.cover.face
        arrays[f"garments/{name}/barycentric"] = result.cover.barycentric
        arrays[f"garments/{name}/mask"] = result.cover.mask
        arrays[f"garments/{name}/registered"] = result.registered
        attrs[name] = {"type": kind, "topology": TOPOLOGY[kind], **vars(quality)}
    store.publish(task.output, SPEC.schema, task.key, arrays, {"garments": attrs})
    progress(len(names), len(names), "published")
    return {
        "error_mean_m": max(one["error_mean_m"] for one in attrs.values()),
        "error_p95_m": max(one["error_p95_m"] for one in attrs.values()),
        "coverage": min(one["coverage"] for one in attrs.values()),
    }


def _input(task: Task, stage: str) -> tuple[Any, str, str]:
    path, key = task.input(stage)
    return path, stage, key

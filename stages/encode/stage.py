"""The shell of the stage encode: reads what an item's stages made, publishes its garments as offsets."""

from __future__ import annotations

from typing import Any

import numpy as np

import store
from model.body import REST_POSE
from model.body.layer import garment_layer
from stages.body_model import body_model_attrs, load_body_model
from stages.encode import SPEC
from stages.encode.config import EncodeConfig
from stages.encode.garment import Rows, encode_garment
from stages.settings import build
from stages.spec import DataError, Progress, Task


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Encodes the garments of one item, at rest and, for a sequence, in every frame.

    Raises:
        DataError: The shards of the item do not fit each other.
    """
    config = build(EncodeConfig, task.config)
    body, outfit, register = (_read(task, stage) for stage in ("body", "outfit", "register"))
    simulate = _read(task, "simulate") if "simulate" in task.inputs else None
    layer = garment_layer(load_body_model(body.attrs)).model
    betas, still = body["betas"], np.zeros((1, 3))
    frames = slice(0, None, config.every)
    pose, trans = body["pose"][frames], body["trans"][frames]
    rest = layer.pose(betas, REST_POSE[None], still)[0]
    posed = None if simulate is None else layer.pose(betas, pose, np.zeros_like(trans))
    arrays: dict[str, np.ndarray] = {"betas": betas, "pose": pose, "trans": trans}
    attrs: dict[str, dict[str, Any]] = {}
    names = sorted(register.attrs["garments"])
    for done, name in enumerate(names):
        progress(done, len(names), f"encoding {name}")
        group = f"garments/{name}"
        try:
            rows = Rows(
                faces=outfit[f"{group}/faces"],
                face=register[f"{group}/face"],
                barycentric=register[f"{group}/barycentric"],
                mask=register[f"{group}/mask"],
            )
            arrays[f"{group}/mask"] = rows.mask
            arrays[f"{group}/static_offsets"] = encode_garment(outfit[f"{group}/vertices"], rest, rows)
            if simulate is not None and posed is not None:
                moving = simulate[f"{group}/vertices"][frames]
                arrays[f"{group}/offsets"] = encode_garment(moving, posed, rows)
        except ValueError as error:
            raise DataError(f"{task.item}: {name}: {error}; make the item's register and simulate again") from error
        made, found = outfit.attrs["garments"][name], register.attrs["garments"][name]
        attrs[name] = {"type": found["type"], "topology": found["topology"], "fabric": made["fabric"]}
    meta = {"gender": body.attrs["gender"], "tightness": outfit.attrs["tightness"], "garments": attrs}
    meta |= body_model_attrs(body.attrs)
    store.publish(task.output, SPEC.schema, task.key, arrays, {**meta, "fps": float(body.attrs["fps"]) / config.every})
    progress(len(names), len(names), "published")
    return {"frames": len(pose) if simulate is not None else 0, "garments": len(names)}


def _read(task: Task, stage: str) -> store.Shard:
    path, key = task.input(stage)
    return store.read(path, stage, key)

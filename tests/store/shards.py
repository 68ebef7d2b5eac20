"""Small valid shards for the store's tests."""

from typing import Any

import numpy as np

KEY = "ab" * 32


def body_arrays(frames: int = 3, vertices: int = 50, seed: int = 0) -> dict[str, np.ndarray]:
    """Arrays of schema "body"."""
    rng = np.random.default_rng(seed)
    return {
        "betas": rng.normal(size=10),
        "pose": rng.normal(size=(frames, 24, 3)),
        "trans": rng.normal(size=(frames, 3)),
        "rest_pose": np.zeros((24, 3)),
        "faces": rng.integers(0, vertices, (2 * vertices, 3)),
        "vertices": rng.uniform(-1, 1, (frames, vertices, 3)),
        "rest_vertices": rng.uniform(-1, 1, (vertices, 3)),
    }


def body_attrs() -> dict[str, Any]:
    """Attributes of schema "body"."""
    return {"gender": "female", "motion": "walk", "action": "walk", "fps": 30, "kind": "sequence"}

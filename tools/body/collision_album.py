"""Before and after: of some folds the sequence and frame in which skin was moved farthest, from two sides."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from PIL import Image

from model.body import BodyModel
from stages.body.collision.segments import NAMES, segment
from stages.body.freeing import Freed
from stages.report.camera import Camera
from stages.report.render import Mesh, Studio

FOLDS = (
    "torso / left_upper_arm",
    "left_upper_arm / left_forearm",
    "torso / left_thigh",
    "left_thigh / left_shank",
    "neck / head",
)
"""Armpit, elbow, groin, knee, chin."""
SIDE = 320
"""Width and height of a picture [px]."""
HEIGHT = 0.55
"""What its height covers [m]."""
SKIN = (0.85, 0.66, 0.55)


@dataclass
class Album:
    """The worst of each fold."""

    worst: dict[str, tuple[float, list[np.ndarray]]] = field(default_factory=dict)
    """Fold -> how far skin was moved [m], and the rows of its picture."""

    def consider(self, model: BodyModel, before: np.ndarray, freed: Freed) -> None:
        """Takes pictures of a sequence, vertices before shape [T, V, 3], where a fold in it is worse than any yet."""
        label = segment(model, freed.betas).label
        for k, pair in enumerate(freed.record["pairs"]):
            frame = int(freed.moved["moved"][:, k].argmax())
            most = float(freed.moved["moved"][frame, k])
            if pair not in FOLDS or most <= self.worst.get(pair, (0.0, []))[0]:
                continue
            mine = np.isin(label, [NAMES.index(name) for name in pair.split(" / ")])
            far = np.linalg.norm(freed.vertices[frame] - before[frame], axis=1) * mine
            target = before[frame, int(far.argmax())].astype(float)
            out = target - before[frame].mean(axis=0)
            angle = float(np.arctan2(out[1], out[0]))
            rows = []
            for turn in (-0.5, 0.7):
                camera = Camera.around(target, angle + turn, height=HEIGHT)
                pair_of_views = [
                    Studio([Mesh(vertices=x.astype(float), faces=model.faces, colour=SKIN, gloss=0.05)], floor=None)
                    for x in (before[frame], freed.vertices[frame])
                ]
                rows.append(np.concatenate([s.picture(camera, SIDE, SIDE) for s in pair_of_views], axis=1))
            self.worst[pair] = most, rows

    def save(self, path: Path) -> None:
        """Writes one row for each fold: from two sides, each before and after."""
        if self.worst:
            rows = [np.concatenate(self.worst[pair][1], axis=1) for pair in FOLDS if pair in self.worst]
            Image.fromarray(np.concatenate(rows)).convert("P", palette=Image.Palette.ADAPTIVE).save(path, optimize=True)

"""One sequence of the report on self-collision: freed, timed, and judged by an independent library."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path
from typing import Any

import igl.copyleft.cgal as cgal
import numpy as np
from scipy.spatial import cKDTree

from model.body import BodyModel, load_free_body
from stages.body.acquire import acquire
from stages.body.collision.segments import NAMES, Segments, pair_name, segment
from stages.body.collision.solve import as_stored
from stages.body.config import Config
from stages.body.figure import Figure
from stages.body.freeing import Freed, UnsolvableError, free_body
from stages.body.motion import FPS, Motion
from tools.body.collision_album import Album
from tools.body.collision_cast import Member

MOVED = 1e-3
"""Skin counts as moved from here on [m]."""
BESIDE = 0.04
"""Skin that was not moved, as far as this from skin that was, is what that is compared with [m]."""

FIRST = 60
"""First frame taken of an embedded clip."""


class Clock:
    """CPU time [s] spent on opening limbs and on parting skin, told from the labels of the steps."""

    def __init__(self) -> None:
        self.spent = {"opening": 0.0, "parting": 0.0}
        self.part, self.since = "", 0.0

    def start(self, part: str) -> None:
        """From now on time counts for `part`; none if it is empty."""
        now = time.process_time()
        if self.part:
            self.spent[self.part] += now - self.since
        self.part, self.since = part, now

    def tell(self, label: str) -> None:
        """A step is told."""
        if label.startswith("parting") and self.part != "parting":
            self.start("parting")


def trial(member: Member, frames: int, every: int, album: Album) -> dict[str, Any]:
    """Frees one sequence of up to `frames` frames; one in `every` is tested by the independent library."""
    model, betas, clock = load_free_body(member.gender), np.array(member.betas, np.float32), Clock()
    told: dict[str, Any] = {"motion": "", "action": "", "frames": 0}

    def move(figure: Figure) -> Motion:
        clock.start("")
        motion = _middle(figure, member.motion, frames, told)
        clock.start("opening")
        return motion

    out: dict[str, Any] = {"gender": member.gender, "shape": member.shape, "betas": list(member.betas)}
    try:
        freed = free_body(model, betas, move, Config(), "sequence", tell=clock.tell)
    except UnsolvableError as error:
        freed, out["why"] = None, [str(error)]
    clock.start("")
    out |= {"name": told["motion"], "action": told["action"], "frames": told["frames"]}
    out |= {f"{part}_ms_per_frame": 1e3 * spent / told["frames"] for part, spent in clock.spent.items()}
    out["ms_per_frame"] = out["opening_ms_per_frame"] + out["parting_ms_per_frame"]
    if freed is None:
        return out | {"case": "rejected"}
    return out | freed.record | {"opening": freed.opening} | _measured(model, freed, every, album)


def _middle(figure: Figure, motion: str, frames: int, told: dict[str, Any]) -> Motion:
    """Up to `frames` frames from the middle of a clip."""
    embedded = not Path(motion).suffix
    length = FIRST + frames if embedded else 1 << 20
    performance = acquire({"motion": motion, "motion_sha256": "", "start": 0, "frames": length}, {}, 120.0)
    whole, told["motion"], told["action"] = performance.on(figure), performance.motion, performance.action
    start = FIRST if embedded else max(0, (len(whole) - frames) // 2)
    part = whole.cut(slice(start, start + frames))
    told["frames"] = len(part)
    return part


def _measured(model: BodyModel, freed: Freed, every: int, album: Album) -> dict[str, Any]:
    """Intersections before and after, what was moved, and jerk."""
    left_out = [NAMES.index(name) for name in freed.record["left_out"]]
    segments = segment(model, freed.betas, left_out)
    before = model.pose(freed.betas, freed.motion.pose, np.zeros_like(freed.motion.trans))
    after = as_stored(freed.vertices)
    album.consider(model, before, freed)
    found: dict[str, Counter[str]] = {"before": Counter(), "after": Counter()}
    frames = range(0, len(after), every)
    for t in frames:
        for word, x in (("before", before), ("after", after)):
            found[word] += crossing_pairs(segments, x[t])
    treated = {pair_name(pair) for pair in segments.pairs}
    out: dict[str, Any] = {"tested_frames": len(frames)}
    for word, count in found.items():
        out[f"crossings_{word}"] = {pair: n for pair, n in sorted(count.items()) if pair in treated}
        out[f"untreated_{word}"] = {pair: n for pair, n in sorted(count.items()) if pair not in treated}
    if freed.moved:
        out["pair_depth_mm"] = _largest(freed, "depth")
        out["pair_moved_mm"] = _largest(freed, "moved")
        often = np.count_nonzero(freed.moved["moved"].astype(np.float32) > MOVED, axis=0)
        out["pair_frames"] = dict(zip(freed.record["pairs"], map(int, often)))
    return out | jerks(segments, before, freed.vertices)


def crossing_pairs(segments: Segments, x: np.ndarray) -> Counter[str]:
    """Pairs of faces that intersect in vertices x [m], shape [V, 3], by the segments they belong to; CGAL's word."""
    faces = cgal.remesh_self_intersections(x.astype(np.float64), segments.faces.astype(np.int64), True)[2]
    return Counter(pair_name((a, b)) for a, b in np.sort(segments.face_label[faces], axis=1))


def _largest(freed: Freed, what: str) -> dict[str, float]:
    return dict(zip(freed.record["pairs"], (1e3 * freed.moved[what].max(axis=0)).round(1).tolist()))


def jerks(segments: Segments, before: np.ndarray, after: np.ndarray) -> dict[str, float]:
    """Root mean square jerk [m/s^3] of skin that was moved, before and after, and of the skin beside it.

    `jerk_ratio` is that of the moved skin over that of the skin beside it; `jerk_worst` is the largest of any vertex
    and frame over the largest before.
    """
    if len(after) < 4:
        return {}
    moved = np.linalg.norm(after - before, axis=2).max(axis=0)
    mine = np.flatnonzero(moved > MOVED)
    if not len(mine):
        return {}
    near = np.isfinite(cKDTree(segments.rest[mine]).query(segments.rest, distance_upper_bound=BESIDE)[0])
    others = np.flatnonzero(near & (moved < 1e-4))
    size = {}
    for word, x in (("before", before[:, mine]), ("after", after[:, mine]), ("beside", after[:, others])):
        size[word] = np.linalg.norm(np.diff(x.astype(np.float64), 3, axis=0), axis=2) * FPS**3
    rms = {word: float(np.sqrt((values**2).mean())) if values.size else float("nan") for word, values in size.items()}
    return {
        **{f"jerk_{word}": value for word, value in rms.items()},
        "jerk_ratio": rms["after"] / rms["beside"],
        "jerk_ratio_before": rms["before"] / rms["beside"],
        "jerk_worst": float(size["after"].max() / size["before"].max()),
    }


def summary(trials: list[dict[str, Any]]) -> dict[str, Any]:
    """What all sequences say together."""
    cases = Counter(t["case"] for t in trials)
    kept = [t for t in trials if t["case"] != "rejected"]
    frames = sum(t["frames"] for t in trials)
    ratios = [t["jerk_ratio"] / t["jerk_ratio_before"] for t in kept if "jerk_ratio" in t]
    return {
        "sequences": len(trials),
        "cases": dict(sorted(cases.items())),
        "tested_frames": sum(t["tested_frames"] for t in kept),
        "crossings_before": sum(sum(t["crossings_before"].values()) for t in kept),
        "crossings_after": sum(sum(t["crossings_after"].values()) for t in kept),
        "untreated_before": sum(sum(t["untreated_before"].values()) for t in kept),
        "untreated_after": sum(sum(t["untreated_after"].values()) for t in kept),
        "opening_ms_per_frame": sum(t["opening_ms_per_frame"] * t["frames"] for t in trials) / frames,
        "parting_ms_per_frame": sum(t["parting_ms_per_frame"] * t["frames"] for t in trials) / frames,
        "jerk_growth_median": float(np.median(ratios)),
        "jerk_growth_worst": float(np.max(ratios)),
        "jerk_largest_growth": max(t["jerk_worst"] for t in kept if "jerk_worst" in t),
    }

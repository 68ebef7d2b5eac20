"""One outfit of the report: made, timed, measured."""

from __future__ import annotations

import resource
import time
from itertools import combinations
from typing import Any

import numpy as np

from model.body import load_free_body
from stages.fabrics import load_fabrics
from stages.outfit.config import Config
from stages.outfit.making import Garment, make_outfit
from stages.outfit.plan import draw_plan
from stages.outfit.resizing import tight_betas
from stages.outfit.template import rest_body
from stages.spec import DataError
from tools.outfit.measures import crossings, measure
from tools.outfit.quality_cast import Member


def made(member: Member, edge: float) -> tuple[list[Garment], np.ndarray, float]:
    """A member's outfit, the vertices of the body that it is made for [m], and the CPU time spent [s].

    Raises:
        DataError: It was rejected.
    """
    config, model = Config(edge_length=edge), load_free_body(member.gender)
    betas = np.array(member.betas)
    start = time.process_time()
    plan = draw_plan(member.kind, config, np.random.default_rng(member.seed))
    garments = make_outfit(plan, model, betas, config, load_fabrics(), lambda label: None)
    spent = time.process_time() - start
    return garments, rest_body(model, tight_betas(betas, plan.tightness)), spent


def trial(member: Member, edge: float) -> dict[str, Any]:
    """Makes and measures one outfit; `rejected` says why there is none."""
    told: dict[str, Any] = {
        "gender": member.gender,
        "kind": member.kind,
        "betas": list(member.betas),
        "seed": member.seed,
    }
    try:
        garments, body, spent = made(member, edge)
    except DataError as error:
        return told | {"rejected": str(error)}
    faces = load_free_body(member.gender).faces.astype(np.int64)
    told |= {"seconds": spent, "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}
    found = {g.plan.name: measure(g.vertices, g.faces, edge, body, faces) for g in garments}
    cuts = {g.plan.name: [cut for piece in g.plan.pieces for cut in piece.cuts] for g in garments}
    told["garments"] = {name: measures.plain() | {"cuts": cuts[name]} for name, measures in found.items()}
    told["layer_crossings"] = sum(
        crossings(a.vertices, a.faces, b.vertices, b.faces) for a, b in combinations(garments, 2)
    )
    told["faults"] = [f"{name}: {fault}" for name, measures in found.items() for fault in measures.faults()]
    told["faults"] += ["garments meet each other"] * (told["layer_crossings"] > 0)
    return told


def masses(member: Member, edges: tuple[float, ...]) -> dict[str, list[float]]:
    """Mass of each garment of an outfit at several edge lengths [kg]; empty if it was rejected at one of them."""
    found: dict[str, list[float]] = {}
    try:
        for edge in edges:
            for garment in made(member, edge)[0]:
                found.setdefault(garment.plan.name, []).append(garment.attrs["mass_kg"])
    except DataError:
        return {}
    return found

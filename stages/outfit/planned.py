"""What the plan wrote into a task of the outfit stage: garments of one's own, and further fabrics."""

import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from stages.fabrics import Fabric, load_fabrics, parse_fabrics
from stages.key import canonical
from stages.outfit.own.load import OwnMesh, load_own
from stages.outfit.own.settings import OwnGarment
from stages.planned_file import planned_content
from stages.settings import build


def own_garments_of(params: Mapping[str, Any]) -> dict[str, OwnMesh]:
    """Garments of one's own by name."""
    files, hashes = params.get("own_files", {}), params.get("own_files_sha256", {})
    settings = params.get("own_garments", {})
    return {name: _own_garment(files[name], hashes[name], canonical(settings[name])) for name in files}


@lru_cache(maxsize=8)
def _own_garment(path: str, sha256: str, settings: str) -> OwnMesh:
    content = planned_content(path, sha256, "the garment")
    return load_own(content, build(OwnGarment, json.loads(settings) | {"file": path}), Path(path).name)


def fabrics_of(params: Mapping[str, Any]) -> dict[str, Fabric]:
    """The embedded fabrics, and in place of or beside them those of the file that the recipe names."""
    if not params.get("fabrics"):
        return load_fabrics()
    content = planned_content(params["fabrics"], params["fabrics_sha256"], "the file of fabrics")
    return {**load_fabrics(), **parse_fabrics(content, Path(params["fabrics"]).name)}

"""The outfits that a recipe asks for: own garments and fabrics are usable, and their hashes stand in the tasks."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pipeline.checked import CheckedFiles
from pipeline.dataset import Dataset
from pipeline.errors import PipelineError
from pipeline.items import Item
from stages.key import canonical
from stages.outfit.kinds import worn
from stages.outfit.own.settings import OwnGarment
from stages.settings import suggestion
from stages.spec import DataError


def add_outfits(items: Iterable[Item], dataset: Dataset, section: Any, where: str, cache: Path) -> None:
    """Write into every item the own garments that it wears, and the file of fabrics.

    Args:
        items: The items.
        dataset: The recipe's section.
        section: The settings of the stage outfit; None if there is no such stage.
        where: The section's place, for messages.
        cache: File that keeps sizes, times and hashes of garments between runs, so that each is checked once.

    Raises:
        PipelineError: A garment's or the fabrics' file can't be used, or a fabric's name is unknown; one line.
    """
    fabrics = _fabrics(dataset, where)
    _check_names(dataset, section, fabrics.pop("names"), where)
    own = {garment.name: garment for garment in dataset.garment}
    paths = {name: Path(garment.file).expanduser().absolute() for name, garment in own.items()}
    files = CheckedFiles(cache)
    hashes = {n: _sha256(paths[n], g, f"{where} garment {n!r}", files) for n, g in own.items()}
    if own:
        files.save()
    settings = {name: _settings(garment) for name, garment in own.items()}
    for item in items:
        item.params.update(fabrics)
        mine = [name for name in _worn(item.params["outfit"], own) if name in own]
        if mine:
            item.params.update(
                own_garments={name: settings[name] for name in mine},
                own_files={name: str(paths[name]) for name in mine},
                own_files_sha256={name: hashes[name] for name in mine},
            )


def _worn(outfit: str, own: Mapping[str, OwnGarment]) -> list[str]:
    return [] if outfit == "random" else worn(outfit, own)


def _settings(garment: OwnGarment) -> dict[str, Any]:
    """What the recipe says of a garment, without where its file is."""
    return {name: value for name, value in dataclasses.asdict(garment).items() if name != "file"}


def _fabrics(dataset: Dataset, where: str) -> dict[str, Any]:
    """Path and hash of the recipe's file of fabrics as parameters, and under `names` all names of fabrics."""
    from stages.fabrics import load_fabrics, parse_fabrics  # only here: most recipes are planned without

    names = set(load_fabrics())
    if not dataset.fabrics:
        return {"names": names}
    path = Path(dataset.fabrics).expanduser().absolute()
    try:
        content = path.read_bytes()
        names |= set(parse_fabrics(content, str(path)))
    except OSError as error:
        raise PipelineError(f"{where}: fabrics = {str(path)!r}: {error.strerror}; name an existing TOML file") from None
    except DataError as error:
        raise PipelineError(f"{where}: fabrics = {error}") from None
    return {"names": names, "fabrics": str(path), "fabrics_sha256": hashlib.sha256(content).hexdigest()}


def _check_names(dataset: Dataset, section: Any, known: set[str], where: str) -> None:
    """That every fabric that is named is known."""
    outfit = where.replace("[dataset]", "[outfit]")
    named = [(f"{outfit}: {key}", names) for key, names in getattr(section, "fabric_names", {}).items()]
    named += [(f"{where}: garment {garment.name!r}: fabrics", garment.fabrics) for garment in dataset.garment]
    for setting, names in named:
        for name in names:
            if name not in known:
                add = "or add it to a file that `fabrics` in [dataset] names"
                raise PipelineError(f"{setting} has {name!r}, which is no fabric; {suggestion(name, known)} {add}")


def _sha256(path: Path, garment: OwnGarment, where: str, files: CheckedFiles) -> str:
    from stages.outfit.own.load import load_own  # only here: reading meshes takes libraries that planning does without

    def check() -> str:
        content = path.read_bytes()
        load_own(content, garment, str(path))
        return hashlib.sha256(content).hexdigest()

    try:
        return files.sha256(path, canonical(_settings(garment)), check)
    except OSError as error:
        raise PipelineError(f"{where}: {path}: {error.strerror}; name an existing OBJ file") from None
    except DataError as error:
        raise PipelineError(f"{where}: {error}") from None

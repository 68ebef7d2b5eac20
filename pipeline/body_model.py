"""The body models that a recipe names: that they are usable, and their hashes, before anything is made with them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from pipeline.checked import CheckedFiles
from pipeline.dataset import GENDERS, BodyModels
from pipeline.errors import PipelineError
from pipeline.items import Item


def add_body_models(items: Iterable[Item], models: BodyModels, where: str, cache: Path) -> None:
    """Write path and hash of its body model's file into every item whose gender has one.

    Args:
        items: The items.
        models: The files by gender.
        where: The section's place, for messages.
        cache: File that keeps sizes, times and hashes between runs, so that a model is read once.

    Raises:
        PipelineError: A file isn't there or isn't a body model; one line.
    """
    named = {gender: Path(getattr(models, gender)).absolute() for gender in GENDERS if getattr(models, gender)}
    if not named:
        return
    files = CheckedFiles(cache)
    hashes = {gender: _sha256(path, gender, f"{where} body_models.{gender}", files) for gender, path in named.items()}
    files.save()
    for item in items:
        gender = item.params["gender"]
        if gender in named:
            item.params.update(body_model=str(named[gender]), body_model_sha256=hashes[gender])


def _sha256(path: Path, gender: str, where: str, files: CheckedFiles) -> str:
    from model.body import BodyFileError  # only here: most recipes have the free body, and planning them is quick
    from stages.body_model import read_body_file

    try:
        return files.sha256(path, gender, lambda: read_body_file(path, gender))
    except BodyFileError as error:
        raise PipelineError(f"{where}: {error}") from None

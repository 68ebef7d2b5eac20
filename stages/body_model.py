"""The body model of an item: the embedded free body, or a file of SMPL's schema that the recipe names.

The plan writes a file's path and hash into the task of the stage `body`, and that stage into its shard, where every
later stage finds them. Items without them have the free body.
"""

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from model.body import BodyFileError, BodyModel, load_free_body
from model.body.free_twin import free_twin
from model.body.smpl_file import file_content, parse_smpl
from store import ShardError

BETA_COUNT = 10
"""Betas of everybody: as many as shards hold."""

FILE, SHA256 = "body_model", "body_model_sha256"
"""Names of the parameters, and of the shard's attributes: path of the file, and sha256 of its content in hex."""


def load_body_model(about: Mapping[str, Any]) -> BodyModel:
    """The body model that a task or a shard of the stage `body` says.

    Args:
        about: The task's parameters or the shard's attributes: `gender`, and `FILE` and `SHA256` if it isn't the free
            body.

    Returns:
        The model; its arrays are shared between callers and read-only.

    Raises:
        ShardError: The file isn't there, isn't the one that was planned with, or isn't a body model.
        ValueError: There is no such gender.
    """
    if not about.get(FILE):
        return load_free_body(about["gender"])
    return _read(str(about[FILE]), str(about[SHA256]), str(about["gender"]))


def body_model_attrs(about: Mapping[str, Any]) -> dict[str, Any]:
    """What a shard says of its body model, from the parameters or attributes it was made from; nothing of the free."""
    return {name: about[name] for name in (FILE, SHA256) if about.get(FILE)}


def load_wearer(about: Mapping[str, Any]) -> BodyModel:
    """The body model that a task or a shard says, which garments can be made for: see `load_body_model`.

    Raises:
        ShardError: Besides, the body is too unlike the free body, for which garments are cut.
        ValueError: There is no such gender.
    """
    model = load_body_model(about)
    try:
        free_twin(model)
    except BodyFileError as error:
        raise ShardError(str(about[FILE]), str(error), "make none but bodies with it: --until body") from None
    return model


def read_body_file(path: Path, gender: str) -> str:
    """Check that a file is a body model that the stages can use; returns its sha256.

    Raises:
        BodyFileError: It isn't; one line.
    """
    content = file_content(path)
    parse_smpl(content, str(path), gender, BETA_COUNT)
    return hashlib.sha256(content).hexdigest()


@lru_cache(maxsize=4)
def _read(path: str, sha256: str, gender: str) -> BodyModel:
    try:
        content = file_content(Path(path))
        if hashlib.sha256(content).hexdigest() != sha256:
            raise ShardError(path, "the body model has changed since the run was planned", "plan again")
        return parse_smpl(content, path, gender, BETA_COUNT)
    except BodyFileError as error:
        raise ShardError(path, str(error).removeprefix(f"{path}: "), "put it right and plan again") from None

"""TOML -> recipe: one checked, frozen section a stage. The only file that a user edits."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.catalog import Catalog
from pipeline.dataset import Dataset
from pipeline.errors import PipelineError
from stages import settings
from stages.settings import SettingsError, suggestion


@dataclass(frozen=True)
class Recipe:
    """What to make.

    Attributes:
        path: The TOML file.
        dataset: Section `[dataset]`.
        sections: Stage -> its section as the stage's own frozen dataclass.
        output: Folder for everything made.
    """

    path: Path
    dataset: Dataset
    sections: Mapping[str, Any]
    output: Path

    def plain_section(self, stage: str) -> dict[str, Any]:
        """The section of `stage` as plain JSON values."""
        return settings.plain(self.sections[stage])


def load_recipe(path: Path | str, catalog: Catalog, output: Path | str | None = None) -> Recipe:
    """Read and check a recipe.

    Args:
        path: TOML file with `[dataset]` and at most one section a stage; what is left out takes its default.
        catalog: The stages.
        output: Folder that replaces the recipe's own; relative to the current one.

    Raises:
        PipelineError: The file can't be read, or has an unknown section or key, a value of the wrong type or out of
            range; one line.
    """
    path = Path(path)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise PipelineError(f"{path}: no such recipe; see the folder recipes") from None
    except OSError as error:
        raise PipelineError(f"{path}: can't be read ({error.strerror}); name a TOML file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise PipelineError(f"{path}: not valid TOML: {error}; correct it there") from None
    known = ["dataset", *catalog.specs]
    for name, section in document.items():
        if name not in known:
            raise PipelineError(f"{path}: unknown section [{name}]; {suggestion(name, known)}")
        if not isinstance(section, dict):
            raise PipelineError(f"{path}: {name} must be a section [{name}], got {section!r}")
    if "dataset" not in document:
        raise PipelineError(f"{path}: section [dataset] is missing; it says which items to make")
    dataset = _section(path, "dataset", Dataset, document["dataset"])
    sections = {name: _section(path, name, spec.config, document.get(name, {})) for name, spec in catalog.specs.items()}
    return Recipe(path, dataset, sections, Path(output or dataset.output or f"build/{dataset.name}"))


def _section(path: Path, name: str, kind: type, given: Mapping[str, Any]) -> Any:
    try:
        return settings.build(kind, given)
    except SettingsError as error:
        raise PipelineError(f"{path} [{name}]: {error}") from None

"""The stages that there are, in the order in which data crosses them."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.errors import PipelineError
from stages.settings import suggestion
from stages.spec import STAGE_NAMES, StageSpec


@dataclass(frozen=True)
class Catalog:
    """Stage specs by name, every stage after those that it needs.

    Attributes:
        package: Package whose subpackages are the stages.
        specs: Name -> spec.
    """

    package: str
    specs: dict[str, StageSpec] = field(default_factory=dict)

    def __getitem__(self, name: str) -> StageSpec:
        if name not in self.specs:
            raise PipelineError(f"there is no stage {name!r}; {suggestion(name, self.specs)}")
        return self.specs[name]

    def __contains__(self, name: object) -> bool:
        return name in self.specs

    def closure(self, name: str) -> list[str]:
        """Stage `name` and all that it needs, in order."""
        wanted = {name}
        for stage in reversed(self.specs):
            if stage in wanted:
                wanted.update(self[stage].needs)
        self[name]
        return [stage for stage in self.specs if stage in wanted]

    def root(self) -> Path:
        """Folder that holds the package: where `python -m <package>.<stage>` finds it."""
        found = importlib.util.find_spec(self.package)
        if found is None or not found.submodule_search_locations:
            raise PipelineError(f"package {self.package!r} isn't installed; run `make env`")
        return Path(next(iter(found.submodule_search_locations))).parent


def load_catalog(package: str = "stages", names: Sequence[str] = STAGE_NAMES) -> Catalog:
    """Import every stage's `SPEC`, and none of its science.

    Raises:
        PipelineError: A stage needs one that doesn't stand before it.
    """
    specs: dict[str, StageSpec] = {}
    for name in names:
        spec: StageSpec = importlib.import_module(f"{package}.{name}").SPEC
        missing = [need for need in spec.needs if need not in specs]
        if missing:
            raise PipelineError(f"stage {name!r} needs {missing[0]!r}, which doesn't stand before it")
        specs[name] = spec
    return Catalog(package, specs)

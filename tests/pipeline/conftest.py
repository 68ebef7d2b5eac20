"""The toy mill as a fixture."""

import sys
from pathlib import Path

import pytest

from pipeline.catalog import Catalog, load_catalog

sys.path.insert(0, str(Path(__file__).parent))

from mill.bench import Mill


@pytest.fixture(scope="session")
def catalog() -> Catalog:
    """The toy stages."""
    return load_catalog("mill", ("yarn", "weave", "bolt"))


@pytest.fixture
def mill(tmp_path: Path, catalog: Catalog, capsys: pytest.CaptureFixture[str]) -> Mill:
    """A toy mill that has made nothing yet."""

    def read() -> tuple[str, str]:
        captured = capsys.readouterr()
        return captured.out, captured.err

    return Mill(tmp_path, catalog, read)

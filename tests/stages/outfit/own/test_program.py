"""The two commands for people: the body to place a garment on, and whether a garment can be worn."""

from pathlib import Path

import numpy as np
import pytest

from stages.outfit.own.obj import read_obj
from stages.outfit.own.placement import to_rest, wearer
from stages.outfit.own.program import main
from tests.stages.outfit.own.garments import write_kilt


@pytest.mark.parametrize("frame", [("m", "z", "root"), ("cm", "y", "floor"), ("in", "y", "root")])
def test_the_body_is_written_as_garments_are_read(tmp_path: Path, frame: tuple[str, str, str]) -> None:
    unit, up, origin = frame
    path = tmp_path / "body.obj"
    told = ["--unit", unit, "--up", up, "--origin", origin]
    assert main(["body", str(path), "--gender", "male", "--betas", "1.5", "-2", *told]) == 0
    mesh = read_obj(path.read_bytes(), "body.obj")
    body = wearer("male", (1.5, -2.0))
    np.testing.assert_array_equal(mesh.faces, body.skin.faces)
    np.testing.assert_allclose(to_rest(mesh.vertices, *frame, body.floor), body.skin.vertices, atol=1e-5)
    if origin == "floor":
        assert mesh.vertices[:, 1].min() == pytest.approx(0, abs=1e-4)
    if up == "y":
        # Faces look to +z there: the toes are in front of the heels.
        low = mesh.vertices[mesh.vertices[:, 1] < mesh.vertices[:, 1].min() + 0.05 * np.ptp(mesh.vertices[:, 1])]
        assert abs(low[:, 2].max()) > 1.3 * abs(low[:, 2].min())


def test_a_garment_is_described_or_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(write_kilt(tmp_path, unit="cm"))
    assert main(["check", path, "--type", "skirt", "--unit", "cm"]) == 0
    said = capsys.readouterr().out
    assert "can be worn" in said and "borders: waist 1.257 m, hem 1.697 m\ninside the body: nowhere\n" in said
    assert main(["check", path, "--type", "skirt"]) == 65
    caught = capsys.readouterr()
    assert caught.out == "" and caught.err.endswith('it would fit with unit = "cm": say so in the recipe\n')
    assert main(["check", str(tmp_path / "none.obj"), "--type", "skirt"]) == 65
    assert capsys.readouterr().err.endswith("none.obj: No such file or directory; check the path and its rights\n")
    assert main(["body", str(tmp_path / "body.fbx")]) == 65
    assert "file must be an OBJ file (.obj)" in capsys.readouterr().err

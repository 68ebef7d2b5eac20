"""A strip hung by both ends takes the shape of an elastic catenary."""

import numpy as np
import pytest
from scipy.optimize import brentq
from small_scenes import QUASI_STATIC, garment, scene, settle, stepper

from stages.simulate.fabric import Fabric
from stages.simulate.specimens import strip

LENGTH, WIDTH, DENSITY = 0.6, 0.04, 0.2


def _catenary(stiffness: float, span: float, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Places x, z (K,) [m] about the lowest point of unstretched arc lengths s (K,) [m]; the strain there.

    With w = rho g per area, Y the stiffness per width and H the horizontal tension per width:
    x = H s / Y + H / w asinh(w s / H), z = w s^2 / (2 Y) + H / w (sqrt(1 + (w s / H)^2) - 1)
    (Irvine, Cable Structures, 1981, section 1.3); H is such that the ends are `span` apart.
    """
    w = DENSITY * 9.81

    def x(h: float, s: np.ndarray | float) -> np.ndarray | float:
        return h * s / stiffness + h / w * np.arcsinh(w * s / h)

    h = brentq(lambda h: 2 * float(x(h, LENGTH / 2)) - span, 1e-4, 50.0, xtol=1e-12)
    z = w * s**2 / (2 * stiffness) + h / w * (np.sqrt(1 + (w * s / h) ** 2) - 1)
    return np.asarray(x(h, s)), z, h / stiffness


@pytest.mark.parametrize(("stiffness", "span", "strain"), [(400.0, 0.45, 0.0), (15.0, 0.5, 0.02)])
def test_strip_hangs_as_an_elastic_catenary(stiffness: float, span: float, strain: float) -> None:
    # A lattice of equilateral triangles pulled along one axis has the sheet's Young's modulus, and no bending here.
    vertices, faces, _ = strip(LENGTH, WIDTH, 0.02, clamp=0)
    fabric = Fabric(
        density=DENSITY, stretch_stiffness=stiffness, shear_stiffness=stiffness * 3 / 8, bend_stiffness=0.0,
        stretch_limit=10.0, damping=0.0, drag=8 * DENSITY,
    )  # fmt: skip
    assert fabric.sheet_stiffness == pytest.approx(stiffness)
    along = vertices[:, 0] - LENGTH / 2
    x, z, least = _catenary(stiffness, span, along)
    assert least >= strain, "the stretch must be worth accounting for"
    sag = z.max()
    start = vertices.copy()
    # From a parabola of about the right sag: what is tested is where it comes to rest.
    start[:, 0] = along * span / LENGTH
    start[:, 2] = 1.1 * sag * ((along / along.max()) ** 2 - 1)
    ends = np.flatnonzero(np.abs(along) > LENGTH / 2 - 1e-9)
    s = stepper(scene(garment(vertices, faces, fabric), start=start, pins=ends), **QUASI_STATIC)
    settle(s, speed=1e-3)
    error = np.hypot(s.x[:, 0] - x, s.x[:, 2] - (z - sag))
    assert sag > 0.15
    assert error.max() < (0.015 if strain else 0.005) * sag

"""Bodies and figures that many tests share."""

from pathlib import Path

import numpy as np
import pytest

from model.body import BodyModel, load_free_body
from stages.body.figure import Figure, measure

CORNERS = {
    "female": ("female", np.zeros(10)),
    "heavy": ("female", np.array([-1.0, 3.0, 0, 0, 0, 0, 0, 0, 0, 0])),
    "male": ("male", np.array([2.0, -1.5, 1.0, 0, 0, 0, 0, 0, 0, 0])),
}


@pytest.fixture(params=list(CORNERS))
def someone(request: pytest.FixtureRequest) -> tuple[BodyModel, np.ndarray, Figure]:
    """A body, its betas and its figure: mean, short and fat, tall and thin."""
    gender, betas = CORNERS[request.param]
    model = load_free_body(gender)
    return model, betas, measure(model, betas)


@pytest.fixture
def woman() -> tuple[BodyModel, np.ndarray, Figure]:
    """The mean woman."""
    model = load_free_body("female")
    return model, np.zeros(10), measure(model, np.zeros(10))


@pytest.fixture
def captures() -> Path:
    """The folder of real motion capture beside the checkout."""
    folder = Path(__file__).parents[4] / "shared" / "motion"
    if not folder.is_dir():
        pytest.skip("no folder ../shared/motion with real motion capture")
    return folder

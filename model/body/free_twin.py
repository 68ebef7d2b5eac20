"""Any body on the free body's topology: what was made for that, garments and layer, goes where this one's skin goes."""

from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp

from model.body.asset import GENDERS, load_free_body
from model.body.model import BodyModel
from model.body.refusal import BodyFileError
from model.body.skin_fit import SkinFit, fit_skin

MISS_MEAN, MISS = 0.005, 0.03
"""Mean and largest distance that a body's skin may keep from the free body's laid onto it [m]."""

FOLDED = 0.01
"""Share of the free body's faces that may be folded over on it [1]."""

_TWINS: "WeakKeyDictionary[BodyModel, BodyModel]" = WeakKeyDictionary()


def free_twin(model: BodyModel) -> BodyModel:
    """The same body, shaped and moved by the same betas and poses, on the free body's vertices and faces.

    Each vertex of the free body of its gender is laid onto its skin by `fit_skin`, which takes about a second; once per
    process and model. A body that has the free body's faces already is its own twin.

    Args:
        model: A body of SMPL's schema; a neutral one is paired with the free female body.

    Returns:
        The twin; its vertices lie on the body's skin.

    Raises:
        BodyFileError: The two skins do not agree where garments are worn; one line.
    """
    free = load_free_body(model.gender if model.gender in GENDERS else GENDERS[0])
    if np.array_equal(model.faces, free.faces):
        return model
    if model not in _TWINS:
        fit = fit_skin(free, model)
        _refuse_misfit(fit)
        count = len(fit.face)
        entries = (fit.barycentric.reshape(-1), (np.repeat(np.arange(count), 3), model.faces[fit.face].reshape(-1)))
        _TWINS[model] = model.resample(sp.csr_matrix(entries, shape=(count, model.vertex_count)), free.faces)
    return _TWINS[model]


def _refuse_misfit(fit: SkinFit) -> None:
    """Refuse a body on which the free body's skin cannot be laid."""
    for value, limit, unit, what in (
        (fit.miss_mean_m, MISS_MEAN, " m", "the free body's skin laid onto this one misses it by a mean of"),
        (fit.miss_m, MISS, " m", "the free body's skin laid onto this one misses it in places by"),
        (fit.folded, FOLDED, "", "the share of the free body's skin that folds over when it is laid onto this one is"),
    ):
        if not value <= limit:
            raise BodyFileError(
                f"cannot be dressed: {what} {value:.3g}{unit}, must be <= {limit:g}{unit}; name the model of a bare "
                "person in the T-pose, whose joints lie in it as SMPL's do"
            )

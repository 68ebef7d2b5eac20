"""The garment layer: the body without head, hands and feet, on whose vertices every garment is described."""

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from model.body.asset import ASSET_FOLDER
from model.body.free_twin import free_twin
from model.body.model import BodyModel

FREE_LAYER = ASSET_FOLDER / "layer_free.npz"
VERTEX_COUNT = 14_000
"""Number of vertices that a newly built layer aims at."""

TOPOLOGY = {
    "top": "skirt",
    "tshirt": "skirt",
    "trousers": "body",
    "jumpsuit": "body",
    "skirt": "skirt",
    "dress": "skirt",
}
"""Which of the layer's two topologies each type of garment follows.

CLOTH3D (section 4.1) gives the skirt topology to skirts and dresses. Here upper garments have it, too: they hang as one
tube, often to below the crotch, and above it the two topologies have the same faces.
"""


@dataclass(frozen=True, eq=False, kw_only=True)
class LayerTemplate:
    """A layer before it is bound to a body: rows over the body's vertices and the two topologies over the rows.

    Attributes:
        corners: The body's vertices that each layer vertex lies between, shape [N, 3].
        barycentric: Their weights, rows sum to 1, shape [N, 3].
        body_faces: Triangles with both legs closed, shape [F, 3].
        skirt_faces: Triangles with the legs joined into one tube, shape [G, 3].
        segments: Labels from 0 to 20, shape [N].
        inner_leg: Vertices on the inner half of the legs, shape [N].
        body_digest: `faces_digest` of the body that the corners belong to.
    """

    corners: NDArray[np.int32]
    barycentric: NDArray[np.float32]
    body_faces: NDArray[np.int32]
    skirt_faces: NDArray[np.int32]
    segments: NDArray[np.int32]
    inner_leg: NDArray[np.bool_]
    body_digest: str


@dataclass(frozen=True, eq=False, kw_only=True)
class GarmentLayer:
    """The layer of one body model.

    Attributes:
        model: Body model over the layer's vertices; its `faces` are `body_faces`.
        body_faces: Triangles with both legs closed, shape [F, 3]: borders at neck, wrists and ankles.
        skirt_faces: Triangles with the legs joined into one tube, shape [G, 3]: borders at neck, wrists and hem.
        segments: Labels from 0 to 20, each connected under both topologies, shape [N].
        inner_leg: Vertices on the inner half of the legs, shape [N].
    """

    model: BodyModel
    body_faces: NDArray[np.int32]
    skirt_faces: NDArray[np.int32]
    segments: NDArray[np.int32]
    inner_leg: NDArray[np.bool_]

    @property
    def vertex_count(self) -> int:
        """Number of vertices N."""
        return self.model.vertex_count

    def faces(self, topology: str) -> NDArray[np.int32]:
        """The triangles of topology "body" or "skirt"."""
        return {"body": self.body_faces, "skirt": self.skirt_faces}[topology]


_LAYERS: "WeakKeyDictionary[BodyModel, GarmentLayer]" = WeakKeyDictionary()


def garment_layer(model: BodyModel) -> GarmentLayer:
    """The layer of a body model, made once per process and model.

    All bodies share one stored layer, and with it its topologies and segments: it was made for both genders of the free
    body, and any other model wears it where its free twin (`free_twin`) has it. So garments on bodies of all genders
    and files can be described, and learned, together.

    Args:
        model: The body.

    Returns:
        The layer; its arrays are shared between callers.

    Raises:
        BodyFileError: The body is too unlike the free body.
    """
    if model not in _LAYERS:
        _LAYERS[model] = bind(_free_template(), free_twin(model))
    return _LAYERS[model]


def faces_digest(faces: ArrayLike) -> str:
    """sha256 of a body's triangles: tells whether two models share their topology."""
    return hashlib.sha256(np.ascontiguousarray(faces, dtype="<i4").tobytes()).hexdigest()


def bind(template: LayerTemplate, model: BodyModel) -> GarmentLayer:
    """The layer of a body whose topology the template was built for.

    Raises:
        ValueError: It has other faces.
    """
    if template.body_digest != faces_digest(model.faces):
        raise ValueError(f"the layer was built for other faces than those of {model!r}")
    count = len(template.corners)
    weights = template.barycentric.astype(np.float64)
    weights /= weights.sum(axis=1, keepdims=True)
    entries = (weights.reshape(-1), (np.repeat(np.arange(count), 3), template.corners.reshape(-1)))
    rows = sp.csr_matrix(entries, shape=(count, model.vertex_count))
    return GarmentLayer(
        model=model.resample(rows, template.body_faces),
        body_faces=template.body_faces,
        skirt_faces=template.skirt_faces,
        segments=template.segments,
        inner_leg=template.inner_leg,
    )


def build_template(model: BodyModel, reference: ArrayLike, joints: ArrayLike | None = None) -> LayerTemplate:
    """Builds the layer from a body model; `tools/build_layer.py` does it for the free body.

    Args:
        model: The body, for its faces and skinning weights.
        reference: Vertices [m] of the T-pose, shape [V, 3].
        joints: Joints [m] that belong to the reference, shape [24, 3]; the model's own if left out.

    Returns:
        The template.
    """
    from model.body.layer_build import build_layer_mesh
    from model.body.layer_segments import inner_leg_vertices, segment_labels

    points = np.asarray(reference, dtype=np.float64)
    bones = np.asarray(model.joint_template if joints is None else joints, dtype=np.float64)
    mesh = build_layer_mesh(points, model.faces, bones, VERTEX_COUNT)
    layer = np.einsum("nk,nkd->nd", mesh.barycentric, points[mesh.corners])
    weights = np.einsum("nk,nkj->nj", mesh.barycentric, model.weights[mesh.corners])
    return LayerTemplate(
        corners=mesh.corners.astype(np.int32),
        barycentric=mesh.barycentric.astype(np.float32),
        body_faces=mesh.body_faces,
        skirt_faces=mesh.skirt_faces,
        segments=segment_labels(layer, bones, weights, mesh.mirror, mesh.core_faces),
        inner_leg=inner_leg_vertices(layer, bones, mesh.mirror, mesh.crotch),
        body_digest=faces_digest(model.faces),
    )


def save_template(path: Path, template: LayerTemplate) -> None:
    """Writes a template, about 0.4 MB."""
    np.savez_compressed(
        path,
        corners=template.corners,
        barycentric=template.barycentric,
        body_faces=template.body_faces,
        skirt_faces=template.skirt_faces,
        segments=template.segments,
        inner_leg=template.inner_leg,
        body_digest=np.array(template.body_digest),
    )


def load_template(path: Path) -> LayerTemplate:
    """Reads a file of `save_template`; the arrays are read-only."""
    with np.load(path, allow_pickle=False) as data:
        arrays = {name: data[name] for name in data.files if name != "body_digest"}
        digest = str(data["body_digest"])
    for value in arrays.values():
        value.setflags(write=False)
    return LayerTemplate(body_digest=digest, **arrays)


@lru_cache(maxsize=1)
def _free_template() -> LayerTemplate:
    return load_template(FREE_LAYER)

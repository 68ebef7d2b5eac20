"""Template garments: made once for the mean body by `tools/build_templates.py`, loaded once per process.

Those of two edge lengths come with the project; those of any other are remeshed from the nearer one when first asked
for, which takes one to three seconds.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

import igl
import numpy as np
from numpy.typing import NDArray

from model.body import REST_POSE, BodyModel, joint_positions, load_free_body
from stages.outfit.coordinates import Axes
from stages.outfit.resampling import resampled

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

ASSET_FOLDER = Path(__file__).parent / "assets"

GARMENT_TYPES = ("tshirt", "top", "trousers", "skirt")
"""Types that have a template; a jumpsuit and a dress are sewn from two of them."""

EDGE_LENGTHS = (0.010, 0.014)
"""Mean edge lengths of the templates that come with the project [m]."""

FINEST, COARSEST = 0.005, 0.025
"""Edge lengths that a template can have [m]: coarser triangles would not follow a cuff."""

QUANTUM = 4e-5
"""Step of the stored positions [m]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Template:
    """One garment on the mean body of a gender, in the rest frame."""

    garment: str
    """One of `GARMENT_TYPES`."""
    gender: str
    """Gender of the body it was made on."""
    edge: float
    """Mean edge length [m]."""
    vertices: Array
    """Positions [m], shape [N, 3]."""
    faces: Faces
    """Triangles, counter-clockwise seen from outside, shape [F, 3]."""
    axes: Axes
    """Arms and legs of the wearer."""
    top: float
    """Height of the waist border of a lower garment, or of the shoulder joint for an upper one [m]."""
    bottom: float
    """Height of the hem, or of the ankle for trousers [m]."""
    waist: float
    """Height where the wearer's trunk is narrowest [m]."""
    flare: float
    """Growth of the width from waist to hem that a skirt's template already has, as a share of the waist's width."""

    @cached_property
    def crotch_along_leg(self) -> float:
        """Position along the legs' axes where the trouser legs part: 0 at the hip, 1 at the ankle."""
        middle = self.vertices[np.abs(self.vertices[:, 0]) < self.edge]
        lowest = np.array([[0.0, self.axes.hip[1], middle[:, 2].min()]])
        return float(self.axes.along_leg(lowest)[0])


def template_path(garment: str, gender: str, edge: float) -> Path:
    """File of one template."""
    return ASSET_FOLDER / f"{gender}_{garment}_{round(edge * 1000)}mm.npz"


def save_template(path: Path, template: Template) -> None:
    """Writes a template with quantised positions, some 40 to 130 kB.

    Args:
        path: The npz file to write.
        template: What to write.

    Raises:
        ValueError: The mesh is too large for 16 bits.
    """
    steps = np.rint(template.vertices / QUANTUM)
    if np.abs(steps).max() > np.iinfo(np.int16).max or len(steps) > 2**16:
        raise ValueError(f"a template holds at most 65536 vertices within {QUANTUM * 32767:.2f} m of the root joint")
    np.savez_compressed(
        path,
        garment=np.array(template.garment),
        gender=np.array(template.gender),
        edge=np.array(template.edge),
        # Differences of neighbouring numbers are small and compress well.
        vertex_steps=np.diff(steps.astype(np.int32), axis=0, prepend=0).astype(np.int32),
        faces=np.diff(template.faces.astype(np.int32), axis=0, prepend=0).astype(np.int32),
        axes=np.stack([template.axes.shoulder, template.axes.wrist, template.axes.hip, template.axes.ankle]),
        heights=np.array([template.top, template.bottom, template.waist]),
        flare=np.array(template.flare),
    )


@lru_cache(maxsize=32)
def load_template(garment: str, gender: str, edge: float) -> Template:
    """Reads a template, and remeshes it if none of this edge length comes with the project; once per process.

    Args:
        garment: One of `GARMENT_TYPES`.
        gender: `female` or `male`.
        edge: Mean edge length [m], `FINEST` to `COARSEST`.

    Returns:
        The template; its arrays are shared and read-only.

    Raises:
        ValueError: There is no such template.
    """
    if not FINEST <= edge <= COARSEST:
        raise ValueError(f"edge length must be {FINEST:g} to {COARSEST:g} m, got {edge:g}")
    source = min(EDGE_LENGTHS, key=lambda length: abs(np.log(length / edge)))
    template = _read_template(garment, gender, source)
    if edge != source:
        vertices, faces = resampled(template.vertices, template.faces, edge)
        template = replace(template, edge=edge, vertices=vertices, faces=faces)
    template.vertices.setflags(write=False)
    template.faces.setflags(write=False)
    return template


def _read_template(garment: str, gender: str, edge: float) -> Template:
    """Reads a template that comes with the project."""
    path = template_path(garment, gender, edge)
    if not path.is_file():
        raise ValueError(
            f"no template {path.name}: garment must be one of {', '.join(GARMENT_TYPES)}, gender female or male"
        )
    with np.load(path, allow_pickle=False) as data:
        vertices = np.cumsum(data["vertex_steps"], axis=0) * QUANTUM
        faces = np.cumsum(data["faces"], axis=0, dtype=np.int64)
        top, bottom, waist = (float(h) for h in data["heights"])
        axes = Axes(*(row.astype(np.float64) for row in data["axes"]))
        flare = float(data["flare"])
    return Template(
        garment=garment, gender=gender, edge=edge, vertices=vertices, faces=faces, axes=axes,
        top=top, bottom=bottom, waist=waist, flare=flare,
    )  # fmt: skip


def rest_body(model: BodyModel, betas: Array) -> Array:
    """Vertices of a body in the rest frame [m], shape [V, 3]: rest pose, root joint at the origin."""
    return model.pose(betas, REST_POSE[None], np.zeros((1, 3)))[0].astype(np.float64)


def rest_joints(model: BodyModel, betas: Array) -> Array:
    """Joints of a body in the rest frame [m], shape [24, 3]."""
    return joint_positions(model.shape(betas)[1], model.parents, REST_POSE[None], np.zeros((1, 3)))[0]


@lru_cache(maxsize=32)
def nearest_on_body(garment: str, gender: str, edge: float) -> tuple[Faces, Array]:
    """For each template vertex the nearest point of the mean body: its face [N] and barycentric weights [N, 3]."""
    template, model = load_template(garment, gender, edge), load_free_body(gender)
    body = rest_body(model, np.zeros(model.beta_count))
    faces = model.faces.astype(np.int64)
    _, face, foot = igl.point_mesh_squared_distance(np.ascontiguousarray(template.vertices), body, faces)
    corners = [np.ascontiguousarray(body[faces[face, k]]) for k in range(3)]
    weights = igl.barycentric_coordinates(np.ascontiguousarray(foot), *corners)
    return face, np.clip(weights, 0.0, 1.0)

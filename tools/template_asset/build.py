"""From a design to a template: level set, even triangles, openings, and a margin to the skin."""

import numpy as np

from model.body import BodyModel
from model.mesh.geometry import area_vectors
from stages.outfit.clearance import clear
from stages.outfit.coordinates import Axes
from stages.outfit.cutting import cut
from stages.outfit.obstacle import Gauge, Obstacle
from stages.outfit.resampling import sweep_order
from stages.outfit.surface import Surface
from stages.outfit.template import Template
from tools.template_asset.designs import Design
from tools.template_asset.wearer import Wearer

PASSES = 15
"""Rounds of remeshing."""

MARGIN = 0.005
"""Least distance of a template from the mean body's skin [m]."""


def build_template(model: BodyModel, wearer: Wearer, garment: str, design: Design, edge: float) -> Template:
    """One template of one edge length.

    Args:
        model: The body that `wearer` is the mean of.
        wearer: Measures of the mean body.
        garment: Type of the garment.
        design: Its solid and openings.
        edge: Edge length to aim at [m].

    Returns:
        The template.
    """
    import gpytoolbox  # what nothing else needs, so that it need not be installed

    vertices, faces = design.volume.surface()
    vertices, faces = gpytoolbox.remesh_botsch(vertices, faces.astype(np.int32), PASSES, edge, True)
    faces = faces.astype(np.int64)
    surface = Surface.whole(design.volume.project(vertices), _outwards(vertices, faces))
    for opening in design.openings:
        surface = cut(surface, opening(surface.vertices), edge)
    body = Obstacle(wearer.vertices, model.faces.astype(np.int64), MARGIN)
    cleared, _ = clear(surface.vertices, surface.faces, [Gauge(body, surface.vertices)])
    order = sweep_order(cleared)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    faces = rank[surface.faces]
    faces = faces[np.lexsort(faces.T[::-1])]
    return Template(
        garment=garment,
        gender=model.gender,
        edge=edge,
        vertices=cleared[order],
        faces=faces,
        axes=Axes.of(wearer.joints),
        top=design.top,
        bottom=design.bottom,
        waist=wearer.girth_height(0.05, 0.3, narrowest=True),
        flare=design.flare,
    )


def _outwards(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The faces of a closed surface, turned so that they look outwards."""
    volume = (vertices[faces].mean(axis=1) * area_vectors(vertices, faces)).sum()
    return faces if volume > 0 else faces[:, ::-1].copy()

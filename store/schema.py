"""Every shard's datasets, units, axes and version. The world convention stands here, once.

World: z is up; metres, seconds, kilograms, radians; 30 frames per second unless `fps` says otherwise. `trans` is the
world position of the root joint and the root's rotation in `pose` carries the turn from the body model's y-up frame.
The rest frame is the rest pose with the root joint at the origin: z up, the person faces -y, the left arm points to +x.
Datasets with `origin` "trans" are relative to the frame's `trans`, so that fixed point needs few bits.

A version is raised whenever a dataset, an axis, a unit or a quantum changes: older shards are then refused by `read`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

POSITION_QUANTUM = 1e-4  # [m]: an error of 0.05 mm at most, and +-3.27 m in 16 bits around the root joint
OFFSET_QUANTUM = 5e-5  # [m]: an error of 0.025 mm at most, and +-1.63 m in 16 bits around the body


@dataclass(frozen=True)
class Dataset:
    """What one dataset holds.

    Attributes:
        axes: Names and sizes, such as "T V 3"; a name has one size in the whole shard if it is T (frames), W or L
            (windows and their frames), else in its group. "..." allows any shape.
        units: SI units of the decoded values; "1" for none.
        dtype: Type in the file: "float32", "int16" .., "bool", or "any".
        quantum: Step of the fixed point in `units`; 0 if the values are stored exactly.
        origin: "trans" if positions are relative to the frame's `trans`, "" otherwise.
        optional: Whether a shard may lack it.
    """

    axes: str
    units: str = "1"
    dtype: str = "float32"
    quantum: float = 0.0
    origin: str = ""
    optional: bool = False


@dataclass(frozen=True)
class Schema:
    """One kind of shard.

    Attributes:
        name: Name of the schema.
        version: Raised with every change of `datasets` or of the attributes' meaning.
        datasets: Name -> dataset; in a name, `*` stands for one level and a last `**` for one or more levels.
        attrs: Names of the JSON attributes that must be there.
    """

    name: str
    version: int
    datasets: Mapping[str, Dataset]
    attrs: tuple[str, ...] = ()

    def match(self, name: str) -> str | None:
        """The pattern in `datasets` that dataset `name` follows, or None."""
        parts = name.split("/")
        for pattern in self.datasets:
            wanted = pattern.split("/")
            if wanted[-1] == "**":
                fits = len(parts) >= len(wanted) and _level_match(wanted[:-1], parts[: len(wanted) - 1])
            else:
                fits = len(parts) == len(wanted) and _level_match(wanted, parts)
            if fits:
                return pattern
        return None


def _level_match(wanted: list[str], parts: list[str]) -> bool:
    return all(part == want or (want == "*" and part != "") for want, part in zip(wanted, parts))


def _positions(axes: str, *, origin: str = "trans") -> Dataset:
    return Dataset(axes, "m", "int16", POSITION_QUANTUM, origin)


_INDEX = "int32"

SHARED_AXES = ("T", "W", "L")
"""Axes that have one size in the whole shard; the others belong to a group, as a garment's vertices N and faces F."""

SCHEMAS: dict[str, Schema] = {
    schema.name: schema
    for schema in (
        Schema(
            "body",
            2,
            {
                "betas": Dataset("10"),
                "pose": Dataset("T 24 3", "rad"),
                "trans": Dataset("T 3", "m"),
                "rest_pose": Dataset("24 3", "rad"),
                "faces": Dataset("F 3", dtype=_INDEX),
                # Skin after its collisions with itself were solved; betas, pose and trans tell it as it was before.
                "vertices": _positions("T V 3"),
                "rest_vertices": Dataset("V 3", "m"),
                # Faces that cloth collides with: all, but for hands, forearms or arms that nothing else would free.
                "face_kept": Dataset("F", dtype="bool", optional=True),
                # What was parted, frame by frame, for each of the pairs of segments named in the attribute `collision`.
                "collision/depth": Dataset("T P", "m", optional=True),
                "collision/moved": Dataset("T P", "m", optional=True),
                "collision/vertices": Dataset("T P", dtype="int32", optional=True),
            },
            ("gender", "motion", "action", "fps", "kind"),
        ),
        Schema(
            "outfit",
            2,
            {
                "tight_betas": Dataset("10"),
                "garments/*/vertices": Dataset("N 3", "m"),
                "garments/*/faces": Dataset("F 3", dtype=_INDEX),
                "garments/*/elastic": Dataset("N", dtype="int8"),
                "garments/*/waistband": Dataset("N", dtype="bool"),
                # 0, or the `number` that the attribute `borders` gives the border on which a vertex lies; the higher
                # one where two meet, at the corners of an open front.
                "garments/*/border": Dataset("N", dtype="int8", optional=True),
                # The sewing pattern: each face's place in the attribute `panels`; the panels side by side in one plane,
                # u to the right and v upwards seen from outside; their seams, numbered in the attribute `panel_seams`.
                "garments/*/panel": Dataset("F", dtype="int8", optional=True),
                "garments/*/uv": Dataset("M 2", "m", optional=True),
                "garments/*/uv_faces": Dataset("F 3", dtype=_INDEX, optional=True),
                "garments/*/seam_edges": Dataset("S 2", dtype=_INDEX, optional=True),
                "garments/*/seam": Dataset("S", dtype="int8", optional=True),
            },
            ("kind", "gender", "tightness", "garments", "layers"),
        ),
        Schema(
            "simulate",
            2,
            {
                "garments/*/vertices": _positions("T N 3"),
                "garments/*/faces": Dataset("F 3", dtype=_INDEX),
                # Error bars: in frames `error_frames` of T, how far the cloth was from where half the step, and a mesh
                # of triangles cut in four, would have had it by then, from the same state a frame before the window.
                "error_frames": Dataset("W L", dtype=_INDEX, optional=True),
                "garments/*/step_error_rms": Dataset("W L", "m", optional=True),
                "garments/*/step_error_max": Dataset("W L", "m", optional=True),
                "garments/*/mesh_error_rms": Dataset("W L", "m", optional=True),
                "garments/*/mesh_error_max": Dataset("W L", "m", optional=True),
            },
            ("fps", "garments", "quality"),
        ),
        Schema(
            "register",
            1,
            {
                "garments/*/face": Dataset("N", dtype=_INDEX),
                "garments/*/barycentric": Dataset("N 3"),
                "garments/*/mask": Dataset("N", dtype="bool"),
                "garments/*/registered": Dataset("N 3", "m"),
            },
            ("garments",),
        ),
        Schema(
            "encode",
            1,
            {
                "betas": Dataset("10"),
                "pose": Dataset("T 24 3", "rad"),
                "trans": Dataset("T 3", "m"),
                "garments/*/mask": Dataset("N", dtype="bool"),
                "garments/*/static_offsets": Dataset("N 3", "m", "int16", OFFSET_QUANTUM),
                "garments/*/offsets": Dataset("T N 3", "m", "int16", OFFSET_QUANTUM, optional=True),
            },
            ("gender", "tightness", "fps", "garments"),
        ),
        Schema(
            "train",
            1,
            {
                "networks/**": Dataset("...", dtype="any", optional=True),
                "baselines/**": Dataset("...", dtype="any", optional=True),
                "hierarchy/**": Dataset("...", dtype="any", optional=True),
                "generated/*/vertices": Dataset("M 3", "m"),
                "generated/*/faces": Dataset("F 3", dtype=_INDEX),
                "generated/*/body_vertices": Dataset("V 3", "m"),
                "generated/*/body_faces": Dataset("G 3", dtype=_INDEX),
            },
            ("metrics",),
        ),
        # A folder: its files are listed with their checksums in `key.json`.
        Schema("report", 1, {}),
    )
}

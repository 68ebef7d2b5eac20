"""Settings of the stage report."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class ReportConfig:
    """What the report shows, how large, and what it calls good."""

    picture_width: int = field(default=320, metadata={"ge": 64, "le": 2048})
    """Width of one view of a sequence [px]; a video shows two views side by side."""

    picture_height: int = field(default=560, metadata={"ge": 64, "le": 2048})
    """Height of one view of a sequence [px]."""

    strip_frames: int = field(default=6, metadata={"ge": 1, "le": 24})
    """Frames in the picture strip of a sequence."""

    sequences: int = field(default=12, metadata={"ge": 0})
    """Sequences shown at most, spread evenly over the dataset."""

    statics: int = field(default=12, metadata={"ge": 0})
    """Outfits at rest shown at most, spread evenly over the dataset."""

    max_depth: float = field(default=1e-3, metadata={"ge": 0.0})
    """Depth inside the body that a vertex of the cloth may reach [m]."""

    stretch_limit: float = field(default=0.10, metadata={"gt": 0.0})
    """Stretch beyond which an edge counts as stretched, as a share of its rest length."""

    max_stretched: float = field(default=0.01, metadata={"ge": 0.0, "le": 1.0})
    """Share of a garment's edges that may be stretched in its worst frame."""

    def __post_init__(self) -> None:
        if self.picture_height % 2:
            raise ValueError(f"picture_height must be even, which videos need, got {self.picture_height}")

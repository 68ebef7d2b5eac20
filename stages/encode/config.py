"""Settings of the stage encode."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class EncodeConfig:
    """What is encoded of a sequence."""

    every: int = field(default=1, metadata={"ge": 1})
    """Frames from one encoded frame to the next; 1 keeps all."""

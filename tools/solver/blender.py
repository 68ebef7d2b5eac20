"""Blender's cloth on a scene, through the peers' runner, in the Python that has `bpy`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tools.solver.child import ROOT, Ended, run

PYTHON = ROOT / ".peers" / "bin" / "python"
"""Python of the environment that `make peers` sets up."""
LIMIT = 4 * 3600.0
"""Longest run [s]."""


@dataclass(frozen=True)
class Blender:
    """The runner.

    Attributes:
        python: Python that has bpy; folder: the peers' folder.
    """

    python: Path
    folder: Path

    @property
    def missing(self) -> str:
        """What is missing for it to run, "" if nothing is."""
        if not (self.folder / "run_blender.py").exists():
            return f"{self.folder}: no run_blender.py there; name the peers' folder: PEERS=/path/to/peers"
        if not self.python.exists():
            return f"{self.python}: not found; `make peers` sets it up"
        return ""

    def __call__(self, scene: Path, out: Path, quality: int = 14, frames: int = 0, collider: bool = True) -> Ended:
        """Simulate `scene` with Cotton and self-collision, `quality` steps a frame; writes x to `out`."""
        command: list[str | Path] = [self.python, self.folder / "run_blender.py", scene, out]
        command += ["--preset", "Cotton", "--quality", str(quality), "--self", "1"]
        if frames:
            command += ["--frames", str(frames)]
        if not collider:
            command.append("--no-collider")
        ended = run(command, LIMIT, self.folder)
        # Where the scene lies on this machine is nobody's business.
        ended.line.pop("scene", None)
        return ended

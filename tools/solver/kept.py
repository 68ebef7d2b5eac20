"""Runs whose result is kept, so that an interrupted measurement goes on and a changed solver is measured anew."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from tools.solver.child import ROOT, Ended


def sources() -> str:
    """Hash of everything that the solver is made of."""
    digest = hashlib.sha256()
    for path in sorted((ROOT / "stages" / "simulate").glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def once(out: Path, key: str, solve: Callable[[], Ended]) -> Ended:
    """How the run that writes `out` ended: as kept beside it with the same `key`, or now; a failed one isn't kept."""
    kept = out.with_suffix(".json")
    if kept.exists() and out.exists():
        data = json.loads(kept.read_text())
        if data["key"] == key:
            return Ended(**data["ended"])
    ended = solve()
    if not ended.fault:
        kept.write_text(json.dumps({"key": key, "ended": asdict(ended)}))
    return ended

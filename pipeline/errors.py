"""The runner's error."""

from __future__ import annotations


class PipelineError(Exception):
    """The recipe, its inputs or its output can't be worked with: what, where, the value and the remedy, in one line."""

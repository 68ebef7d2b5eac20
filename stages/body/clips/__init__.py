"""Embedded motion: clips made by code, on the measures of the person who performs them."""

from stages.body.clips.repertoire import CLIPS, Clip, perform

__all__ = ["CLIPS", "Clip", "perform"]

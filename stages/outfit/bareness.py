"""What people wear whose hands or forearms cloth doesn't collide with: sleeves that end before."""

from collections.abc import Collection
from dataclasses import replace

from stages.outfit.config import Config

LONGEST = {"hand": 0.85, "forearm": 0.37}
"""Part of the arm that was left out -> where sleeves end at the latest, as `sleeve_length`. The widest sleeve had no
vertex nearest to that part on the mean body and on the largest and smallest; a forearm's 0.45 and a hand's 0.9 had."""


def for_body(config: Config, left_out: Collection[str]) -> Config:
    """The settings to draw an outfit with that one body can wear.

    Args:
        config: The recipe's.
        left_out: What the body's stage left out of what cloth collides with, such as `left_hand` (CLOTH3D,
            "Self-collision", the special case).

    Returns:
        The settings with the range of sleeves cut off at what was left out; the same if nothing was. Whole arms leave
        no sleeve to choose: what covers them is refused when it is simulated.
    """
    ends = [share for part, share in LONGEST.items() if any(name.endswith(part) for name in left_out)]
    if not ends:
        return config
    low, high = config.sleeve_length
    return replace(config, sleeve_length=(min(low, *ends), min(high, *ends)))

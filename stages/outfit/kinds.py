"""The names of outfits: kinds of the embedded templates, and combinations with garments of one's own."""

from collections.abc import Collection

from stages.settings import suggestion

KINDS = ("tshirt+trousers", "top+trousers", "tshirt+skirt", "top+skirt", "jumpsuit", "dress")
"""Kinds of outfit; `random` stands for any of them."""

UPPER, LOWER = ("tshirt", "top"), ("trousers", "skirt")
"""Garments above and below the waist that have a template."""

TYPES = (*UPPER, *LOWER, "jumpsuit", "dress")
"""Types of garment; the type says which topology a garment is registered to."""

NECKLINES = ("round", "v", "boat")
"""Necklines that upper garments are cut to."""

MOST_OWN = 4
"""Garments of one's own that an outfit may have."""


def worn(kind: str, own: Collection[str] = ()) -> list[str]:
    """The garments of a kind of outfit, from the outer one to the inner one.

    Args:
        kind: One of `KINDS`, or names joined by `+` of which one at least is an own garment's: `coat+tshirt+trousers`
            is a coat over a t-shirt over trousers.
        own: Names of own garments.

    Raises:
        ValueError: There is no such kind.
    """
    names = kind.split("+")
    if kind in KINDS:
        return names
    mine = [name for name in names if name in own]
    strange = [name for name in names if name not in own and name not in TYPES]
    if strange or not mine:
        more = f", or garments joined by + with one at least of your own ({', '.join(sorted(own))})" if own else ""
        close = suggestion(kind, (*KINDS, "random", *own))
        hint = f"; {close}" if close.startswith("did") else ""
        raise ValueError(f"outfit must be one of {', '.join(KINDS)} or random{more}, got {kind!r}{hint}")
    if len(set(names)) < len(names) or len(mine) > MOST_OWN:
        raise ValueError(f"outfit must name each garment once, and at most {MOST_OWN} own ones, got {kind!r}")
    return names

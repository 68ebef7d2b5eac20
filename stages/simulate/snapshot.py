"""The state of a simulation at one moment, to go on from there a second time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.simulate.stepper import Stepper

CLOTH = ("x", "v", "x_old", "v_old")
CONTACT = ("shear", "reaction", "pinched", "fresh", "touched", "face")
LEVELS = ("inverse", "coarsest")
PAIRS = ("age", "lasts", "fast", "total", "faces_first", "meets_for")
PAIRS_MET = ("met_count", "met")
CROSSINGS = ("edge", "face")
PAIR_LISTS = ("found_vertices", "side", "gap")


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """All that a step takes from the steps before it.

    Attributes:
        time: When [s]; last_dt: The step that led there [s].
        cloth: x, v and those a step earlier, x_old, v_old, shape [N, 3] each.
        followed: Patches of the body that are followed, by which its faces are numbered.
        contact: What contact with the body keeps, as the elastic slip of the friction [m], shape [N, ...] each.
        levels: The preconditioner's matrices, for which step [s] and their age; empty if they are to be made anew.
        pairs: The list of pairs of cloth in use and its age; empty if cloth doesn't collide or the list is to be new.
    """

    time: float
    last_dt: float
    cloth: dict[str, np.ndarray]
    followed: np.ndarray
    contact: dict[str, np.ndarray]
    levels: dict[str, Any]
    pairs: dict[str, Any]


def take(stepper: Stepper) -> Snapshot:
    """A copy of the state of `stepper`, between two steps."""
    pairs: dict[str, Any] = {}
    if stepper.pairs is not None:
        pairs = {name: getattr(stepper.pairs, name) for name in PAIRS}
        pairs |= {name: getattr(stepper.pairs, name).copy() for name in PAIRS_MET}
        pairs |= {name: getattr(stepper.pairs.crossings, name) for name in CROSSINGS}
        pairs |= {name: getattr(stepper.pairs, name)[: stepper.pairs.total].copy() for name in PAIR_LISTS}
    return Snapshot(
        time=stepper.time,
        last_dt=stepper.last_dt,
        cloth={name: getattr(stepper, name).copy() for name in CLOTH},
        followed=stepper.contact.body.followed,
        contact={name: getattr(stepper.contact, name).copy() for name in CONTACT},
        levels={name: getattr(stepper.levels, name).copy() for name in LEVELS}
        | {"h": stepper.levels_h, "age": stepper.levels_age},
        pairs=pairs,
    )


def restore(stepper: Stepper, snapshot: Snapshot) -> None:
    """Put `stepper`, of the same cloth, into the state of `snapshot`: from there it makes the same steps."""
    stepper.time, stepper.last_dt = snapshot.time, snapshot.last_dt
    for name, values in snapshot.cloth.items():
        np.copyto(getattr(stepper, name), values)
    for name, values in snapshot.contact.items():
        np.copyto(getattr(stepper.contact, name), values)
    if snapshot.levels:
        stepper.levels_h, stepper.levels_age = snapshot.levels["h"], snapshot.levels["age"]
        for name in LEVELS:
            np.copyto(getattr(stepper.levels, name), snapshot.levels[name])
    else:
        stepper.levels_age = stepper.LEVELS_LAST
    contact = stepper.contact
    contact.met_until = -1.0
    if not np.array_equal(contact.body.followed, snapshot.followed):
        contact.body.follow(snapshot.followed)
        contact.fit_body()
    pairs = stepper.pairs
    if pairs is None:
        return
    if not snapshot.pairs:
        pairs.age = pairs.lasts = pairs.every
        pairs.meets_for = 0.0
        pairs.crossings.forget()
        return
    if snapshot.pairs["total"] > len(pairs.gap):
        pairs.room(int(snapshot.pairs["total"] * 1.3))
    for name in PAIRS:
        setattr(pairs, name, snapshot.pairs[name])
    for name in CROSSINGS:
        setattr(pairs.crossings, name, snapshot.pairs[name])
    for name in PAIRS_MET:
        setattr(pairs, name, snapshot.pairs[name].copy())
    for name in PAIR_LISTS:
        getattr(pairs, name)[: pairs.total] = snapshot.pairs[name]

"""The check during a run that what the plan leaves out isn't needed, which turns it on where it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import coo_matrix, csgraph
from scipy.spatial import cKDTree

from stages.simulate.patches import in_box
from stages.simulate.plan import Plan, longer
from stages.simulate.springs import Springs

if TYPE_CHECKING:
    from stages.simulate.stepper import Stepper

EVERY = 4
"""One in so many cloth vertices is looked at."""
AHEAD = 1.25
"""How much further than its velocity says cloth may go in a frame."""
GROWTH = 1.5
"""Greatest ratio of a step to one in the frame before, if it is longer than the level's."""
MORE = 0.05
"""Skin that is within this distance of what has come into reach is turned on with it [m]."""


class Watch:
    """A plan in force.

    Attributes:
        plan: The plan.
        events: What was turned on: frame, what and why.
        steps: How many steps each frame has taken.
    """

    def __init__(self, plan: Plan, springs: Springs) -> None:
        self.plan = plan
        self.events: list[dict[str, Any]] = []
        self.steps: dict[int, int] = {}
        self.cover = _cover(springs)

    def record(self) -> dict[str, Any]:
        """The plan as JSON values, with what became of it."""
        made = self.plan.record
        taken = [self.steps[k] for k in sorted(self.steps)]
        return {**made, "steps": {**made["steps"], "taken": taken}, "events": self.events}

    def longest(self, stepper: Stepper, frame: int, share: float) -> float:
        """Longest step for `frame` [s]: as planned, unless the cloth itself moves faster than its body says.

        Its speed is the greater of what it is and of how much it changes in a frame: cloth that swings stands still
        where it turns. Beyond the level's, steps grow by GROWTH from frame to frame: the first one of a run, and any
        that is longer than twice the one before, are of first order. Steps made are `share` of it.
        """
        # Cloth far stiffer than fabrics has shorter steps than the level that was planned for.
        planned = float(self.plan.dt[frame]) * (stepper.config.dt / self.plan.step)
        dt = min(planned, max(stepper.config.dt, GROWTH * stepper.last_dt / share))
        if not self.plan.calm[frame] or dt <= stepper.config.dt:
            return dt
        change = (stepper.v - stepper.v_old) / (stepper.last_dt * stepper.contact.body.fps)
        speed = max(_most(stepper.v - stepper.v.mean(0)), _most(change))
        return min(dt, stepper.config.dt * float(longer(speed, stepper.config.calm)))

    def look(self, stepper: Stepper, frame: int, near: cKDTree) -> None:
        """Turn on the skin that cloth may reach on the way to `frame`; `near` holds every EVERY-th cloth vertex."""
        contact, forecast = stepper.contact, self.plan.forecast
        body = contact.body
        if not len(body.watched):
            return
        watched, guard = body.watched, self.plan.guard
        spot, spread = forecast.spot[watched], forecast.spread[watched]
        skin = body.frame(frame - 1)[spot]
        move = body.frame(frame)[spot] - skin
        fly = stepper.v[::EVERY] / body.fps
        # What is further away than any of them can go need not be known.
        furthest = np.linalg.norm(move, axis=1).max() + np.linalg.norm(fly, axis=1).max()
        limit = spread.max() + self.cover + AHEAD * furthest + guard + MORE
        about = in_box(skin, near.mins - limit, near.maxes + limit)
        watched, spread, skin, move = watched[about], spread[about], skin[about], move[about]
        distance, nearest = near.query(skin, distance_upper_bound=limit, workers=1)
        past = np.linalg.norm(move - fly[np.minimum(nearest, len(fly) - 1)], axis=1)
        free = distance - spread - self.cover - AHEAD * past - guard
        if (free > 0).all():
            return
        wanted = watched[free < MORE]
        self.events.append({
            "frame": frame - stepper.first_frame,
            "what": f"{len(wanted)} patches of skin turned on",
            "why": f"cloth may come {-1e3 * free.min():.0f} mm nearer than {1e3 * guard:.0f} mm to some of them",
        })  # fmt: skip
        body.take_in(wanted)
        contact.fit_body()


def _most(v: np.ndarray) -> float:
    """A length that all but 1 in 100 of the vectors v [N, 3] don't exceed."""
    return float(np.percentile(np.linalg.norm(v, axis=1), 99))


def _cover(springs: Springs) -> float:
    """How far along the cloth, stretched a little, any vertex is from one of those that are looked at [m]."""
    count = len(springs.mass)
    graph = coo_matrix((1.05 * springs.length, springs.edges.T), shape=(count, count)).tocsr()
    along = csgraph.dijkstra(graph, directed=False, indices=np.arange(0, count, EVERY), min_only=True)
    return float(along[np.isfinite(along)].max(initial=0.0))

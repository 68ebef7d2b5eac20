"""The kernel that compares where cloth can be with where skin is."""

import taichi as ti

from stages.simulate.kernels import Array, Int, Real, kernel, vec


@kernel
def pass_by(
    skin: Array,
    skin_move: Array,
    spread: Array,
    centre: Array,
    radius: Array,
    place: Array,
    wide: Array,
    extent: Array,
    move: Array,
    enough: Real,
    beyond: Real,
    every: Int,
    # outputs
    gap: Array,
    into: Array,
) -> None:
    """For every patch of skin in a ball of radius `spread`: lowers `gap` to the least distance to where cloth can be,
    while it is more than `enough`; and how far it moves `into` cloth meanwhile, for one patch in `every`.

    A group of cloth stays in both the ball about `centre` of radius `radius` and that about `place`, where it is
    expected, of radius `wide`; if it is just where it is expected, in one of radius `extent`. Both move by `move`. Skin
    counts as near if no further than its motion past the cloth and `beyond`; along the cloth, a third.
    """
    for p in range(skin.shape[0]):
        s = vec(skin, p)
        if gap[p] > enough:
            for g in range(centre.shape[0]):
                away = (vec(centre, g) - s).norm() - radius[g]
                gap[p] = ti.min(gap[p], ti.max(away, (vec(place, g) - s).norm() - wide[g]) - spread[p])
        most = 0.0
        if p % every == 0:
            for g in range(centre.shape[0]):
                way = vec(place, g) - s
                past = vec(skin_move, p) - vec(move, g)
                size, distance = past.norm(), ti.max(way.norm(), 1e-9)
                if distance - spread[p] - extent[g] < size + beyond:
                    most = ti.max(most, past.dot(way) / distance, size / 3.0)
        into[p] = most

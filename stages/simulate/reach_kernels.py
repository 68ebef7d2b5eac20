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
    counts if the nearest cloth is no further than its motion past it and `beyond`; motion along the cloth, a third.
    """
    for p in range(skin.shape[0]):
        s = vec(skin, p)
        least = gap[p]
        if least > enough:
            for g in range(centre.shape[0]):
                # Most are too far away to matter, and roots are dear.
                known, off = least + spread[p] + wide[g], vec(place, g) - s
                if off.norm_sqr() < known * known:
                    away = (vec(centre, g) - s).norm() - radius[g]
                    least = ti.min(least, ti.max(away, off.norm() - wide[g]) - spread[p])
        gap[p] = least
        most = 0.0
        if p % every == 0:
            nearest, best = -1, 1e30
            for g in range(centre.shape[0]):
                d2 = (vec(place, g) - s).norm_sqr()
                if d2 < best:
                    nearest, best = g, d2
            way, past = vec(place, nearest) - s, vec(skin_move, p) - vec(move, nearest)
            size, distance = past.norm(), ti.max(way.norm(), 1e-9)
            if distance < spread[p] + extent[nearest] + beyond + size:
                most = ti.max(past.dot(way) / distance, size / 3.0)
        into[p] = most

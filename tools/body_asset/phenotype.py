"""Adults of MakeHuman's phenotype space: its blend targets, their coefficients, and a random population."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tools.body_asset.source import Source

AGES = ("young", "old")
RACES = ("african", "asian", "caucasian")
MUSCLES = ("minmuscle", "averagemuscle", "maxmuscle")
WEIGHTS = ("minweight", "averageweight", "maxweight")
HEIGHTS = ("minheight", "maxheight")
PROPORTIONS = ("idealproportions", "uncommonproportions")
CUPS = ("mincup", "averagecup", "maxcup")
FIRMNESSES = ("minfirmness", "averagefirmness", "maxfirmness")

HEIGHT_CENTRE = {"female": 0.376, "male": 0.372}
"""MakeHuman's height parameter of the average adult, chosen for a realistic mean stature (1.63 m and 1.75 m)."""

HEIGHT_SPREAD = 0.06
"""Standard deviation of the height parameter: a standard deviation of about 8 cm in stature."""

FATNESS = {"female": (3.8, 2.5), "male": (2.1, 3.0)}
"""Beta distribution of the fatness axis: mean body mass index 22 and 24 kg/m^2."""


@dataclass(frozen=True, eq=False)
class Blendshapes:
    """Blend targets of one gender, with the phenotype labels whose product weighs each."""

    displacements: NDArray[np.float32]
    """Displacements [m], shape [K, N, 3]."""
    labels: list[tuple[str, ...]]


def load_blendshapes(source: Source, gender: str) -> Blendshapes:
    """Reads every macro target that an adult of that gender can weigh.

    Args:
        source: The data.
        gender: `female` or `male`.

    Returns:
        The targets and their labels.
    """
    names: list[tuple[str, tuple[str, ...]]] = []
    macro = "macrodetails"
    for age in AGES:
        names += [(f"{macro}/{race}-{gender}-{age}", (age, race)) for race in RACES]
        for muscle, weight in product(MUSCLES, WEIGHTS):
            build = f"{gender}-{age}-{muscle}-{weight}"
            labels = (age, muscle, weight)
            names.append((f"{macro}/universal-{build}", labels))
            names += [(f"{macro}/height/{build}-{height}", (*labels, height)) for height in HEIGHTS]
            names += [(f"{macro}/proportions/{build}-{kind}", (*labels, kind)) for kind in PROPORTIONS]
            if gender == "female":
                names += [
                    (f"breast/{build}-{cup}-{firmness}", (*labels, cup, firmness))
                    for cup, firmness in product(CUPS, FIRMNESSES)
                    if source.has_target(f"breast/{build}-{cup}-{firmness}")
                ]
    return Blendshapes(np.stack([source.target(name) for name, _ in names]), [labels for _, labels in names])


def sample_adult(rng: np.random.Generator, gender: str) -> dict[str, float]:
    """Draws one adult.

    Fat bodies need much weight and little muscle together, so both follow one fatness axis.

    Args:
        rng: Source of randomness.
        gender: `female` or `male`.

    Returns:
        The weight of each phenotype label, in [0, 1].
    """
    fatness = rng.beta(*FATNESS[gender])
    age = rng.beta(1.2, 2.5)
    weight = np.clip(0.12 + 0.9 * fatness + rng.normal(0.0, 0.08), 0.0, 1.0)
    muscle = np.clip(0.72 - 0.62 * fatness + rng.normal(0.0, 0.13), 0.0, 1.0)
    height = np.clip(rng.normal(HEIGHT_CENTRE[gender], HEIGHT_SPREAD), 0.0, 1.0)
    proportions = rng.beta(2.0, 2.0)
    cup, firmness = rng.beta(2.0, 2.5), rng.beta(2.0, 2.0)
    race = rng.dirichlet([1.0, 1.0, 1.0])
    return (
        _two_ends(age, AGES)
        | _three_ends(muscle, MUSCLES)
        | _three_ends(weight, WEIGHTS)
        | _two_ends(height, HEIGHTS)
        | _two_ends(proportions, PROPORTIONS)
        | _three_ends(cup, CUPS)
        | _three_ends(firmness, FIRMNESSES)
        | dict(zip(RACES, race.tolist(), strict=True))
    )


def coefficients(labels: list[tuple[str, ...]], adult: dict[str, float]) -> NDArray[np.float32]:
    """Weight of every blend target for one adult: the product over its labels, shape [K]."""
    return np.array([np.prod([adult[label] for label in target]) for target in labels], dtype=np.float32)


def _two_ends(x: float, labels: tuple[str, ...]) -> dict[str, float]:
    return dict(zip(labels, (1.0 - float(x), float(x)), strict=True))


def _three_ends(x: float, labels: tuple[str, ...]) -> dict[str, float]:
    """Piecewise linear hats at 0, 1/2 and 1."""
    x = float(x)
    return dict(zip(labels, (max(1.0 - 2.0 * x, 0.0), 1.0 - abs(2.0 * x - 1.0), max(2.0 * x - 1.0, 0.0)), strict=True))

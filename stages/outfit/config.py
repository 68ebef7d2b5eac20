"""Settings of the outfit stage: the ranges that garments are drawn from, and how they are made."""

from dataclasses import dataclass, field, fields

from stages.outfit.kinds import NECKLINES, TYPES, UPPER
from stages.settings import suggestion

FABRICS = ("cotton", "silk", "denim", "leather")
"""Fabrics of `stages/fabrics.toml`."""

_SHARE = {"ge": 0.0, "le": 1.0}


@dataclass(frozen=True, kw_only=True)
class Config:
    """The recipe's section `[outfit]`. Every range is drawn from uniformly (CLOTH3D, Variability)."""

    edge_length: float = field(default=0.010, metadata={"ge": 0.005, "le": 0.025})
    """Mean edge length of the garments' triangles [m]."""
    tightness_range: tuple[float, float] = field(default=(-1.5, 0.5), metadata={"ge": -3.0, "le": 3.0})
    """Tightness of either component, subtracted from the first two betas [1]; positive is a smaller garment."""
    sleeve_length: tuple[float, float] = field(default=(0.15, 1.0), metadata={"ge": 0.12, "le": 1.0})
    """Where sleeves end: share of the way from shoulder to wrist [1]."""
    leg_length: tuple[float, float] = field(default=(0.33, 1.0), metadata={"ge": 0.33, "le": 1.0})
    """Where trouser legs end: share of the way from hip to ankle [1]."""
    torso_length: tuple[float, float] = field(default=(0.3, 1.0), metadata=_SHARE)
    """Where upper garments end: share of the way from the waist to just below the crotch [1]."""
    waist_height: tuple[float, float] = field(default=(0.3, 1.0), metadata=_SHARE)
    """Where trousers and skirts begin: share of the way from the hips to the waist [1]."""
    skirt_length: tuple[float, float] = field(default=(0.35, 1.0), metadata={"ge": 0.2, "le": 1.0})
    """Where skirts end: share of the way from the waist to the shins [1]."""
    seam_height: tuple[float, float] = field(default=(0.6, 1.0), metadata=_SHARE)
    """Waist seam of dresses and jumpsuits: share of the way from the hips to the waist [1]."""
    sleeve_narrowing: tuple[float, float] = field(default=(-0.35, 0.0), metadata={"ge": -0.6, "le": 0.0})
    """alpha_1 of sleeves: change of width from shoulder to wrist, as a share of the width at the shoulder [1]."""
    sleeve_widening: tuple[float, float] = field(default=(0.0, 0.9), metadata={"ge": 0.0, "le": 1.5})
    """alpha_2 of sleeves: growth of width beyond the offset, per arm length, as a share of the width [1]."""
    leg_narrowing: tuple[float, float] = field(default=(-0.4, 0.0), metadata={"ge": -0.6, "le": 0.0})
    """alpha_1 of trouser legs: change of width from crotch to ankle, as a share of the width at the crotch [1]."""
    leg_widening: tuple[float, float] = field(default=(0.0, 0.8), metadata={"ge": 0.0, "le": 1.5})
    """alpha_2 of trouser legs: growth of width beyond the offset, per leg length, as a share of the width [1]."""
    widening_offset: tuple[float, float] = field(default=(0.4, 0.95), metadata=_SHARE)
    """x_offset of sleeves and legs: where the widening starts, as a share of the axis [1]."""
    skirt_widening: tuple[float, float] = field(default=(0.85, 1.6), metadata={"gt": 0.0, "le": 2.0})
    """alpha_1 of skirts: growth of width from waist to shins, as a share of the width at the waist [1]."""
    necklines: tuple[str, ...] = field(default=NECKLINES, metadata={"choices": NECKLINES})
    """Necklines of t-shirts and tops, each as often as the others [names]."""
    neck_depth: tuple[float, float] = field(default=(0.0, 1.0), metadata=_SHARE)
    """Depth of necklines: share of the way from the neck to as deep as that kind is cut [1]."""
    neck_width: tuple[float, float] = field(default=(0.0, 1.0), metadata=_SHARE)
    """Width of necklines: share of the way from the neck to as wide as that kind, or the shoulder, lets [1]."""
    collar_chance: float = field(default=0.2, metadata=_SHARE)
    """Chance that a t-shirt has a stand-up collar on the smallest neckline in place of those [1]."""
    collar_height: tuple[float, float] = field(default=(0.015, 0.03), metadata={"ge": 0.01, "le": 0.05})
    """Height of collars [m]."""
    placket_chance: float = field(default=0.6, metadata=_SHARE)
    """Chance that a shirt with a collar that is not open in front has a placket below it, as a polo shirt [1]."""
    placket_length: tuple[float, float] = field(default=(0.08, 0.16), metadata={"ge": 0.06, "le": 0.2})
    """Length of plackets below the neckline [m]."""
    vest_chance: float = field(default=0.15, metadata=_SHARE)
    """Chance that a t-shirt is cut to a vest, without sleeves [1]."""
    armhole_depth: tuple[float, float] = field(default=(0.0, 1.0), metadata=_SHARE)
    """Armholes of vests: share of the way from close around the shoulder to wide and low [1]."""
    strapless_chance: float = field(default=0.15, metadata=_SHARE)
    """Chance that a top has no straps; a band as wide as the wearer holds it [1]."""
    chest_height: tuple[float, float] = field(default=(0.0, 1.0), metadata=_SHARE)
    """Upper border of strapless tops: share of the way from the chest to just below the armpits [1]."""
    open_front_chance: float = field(default=0.2, metadata=_SHARE)
    """Chance that a t-shirt that is not sewn to anything is open in front, as a shirt or waistcoat [1]."""
    opening_width: tuple[float, float] = field(default=(0.04, 0.12), metadata={"ge": 0.02, "le": 0.15})
    """How far the sides of an open front part up to the shoulders' height; twice that at the longest hem [m]."""
    fastening_height: tuple[float, float] = field(default=(0.1, 0.3), metadata={"ge": 0.05, "le": 0.9})
    """Where an open front is fastened, its sides side by side: share of the way from shoulders to longest hem [1]."""
    upper_fabrics: tuple[str, ...] = ("cotton", "silk")
    """Fabrics of t-shirts and tops, embedded ones or of the file that `fabrics` in [dataset] names [names]."""
    lower_fabrics: tuple[str, ...] = FABRICS
    """Fabrics of every other garment [names]."""
    fabrics: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Fabrics of single types of garment, such as jumpsuit = ["denim"], in place of those two lists [names]."""
    elastic_chance: float = field(default=0.5, metadata=_SHARE)
    """Chance of an elastic, for sleeve ends, leg ends and the waist of a full-body garment each [1]."""
    elastic_ratio: tuple[float, float] = field(default=(0.7, 0.9), metadata={"gt": 0.3, "le": 1.0})
    """Rest length of an elastic as a share of the cloth's [1]."""
    smoothing_width: float = field(default=0.04, metadata={"ge": 0.0, "le": 0.2})
    """How far body detail is smoothed out of the transferred shape: standard deviation along the cloth [m]."""
    clearance: float = field(default=0.003, metadata={"gt": 0.0, "le": 0.02})
    """Least distance of every vertex from the body that the outfit is made for [m]."""
    layer_gap: float = field(default=0.003, metadata={"gt": 0.0, "le": 0.02})
    """Least distance of an outer garment's vertices from the garment below it [m]."""

    def __post_init__(self) -> None:
        """Checks that ranges are not reversed and that there is a fabric to choose.

        Raises:
            ValueError: Which setting is wrong, and how.
        """
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, tuple) and not value:
                what = "neckline" if item.name == "necklines" else "fabric"
                raise ValueError(f"{item.name} must name at least one {what}, got none")
            if isinstance(value, tuple) and not isinstance(value[0], str) and value[0] > value[1]:
                raise ValueError(f"{item.name} must run from low to high, got [{value[0]:g}, {value[1]:g}]")
        for name, names in self.fabrics.items():
            if name not in TYPES:
                raise ValueError(f"fabrics: there is no garment {name!r}; {suggestion(name, TYPES)}")
            if not names:
                raise ValueError(f"fabrics.{name} must name at least one fabric, got none")

    def fabrics_of(self, garment: str) -> tuple[str, ...]:
        """Fabrics that a type of garment is made of [names]."""
        return self.fabrics.get(garment) or (self.upper_fabrics if garment in UPPER else self.lower_fabrics)

    @property
    def fabric_names(self) -> dict[str, tuple[str, ...]]:
        """Every setting that names fabrics, and the names."""
        single = {f"fabrics.{name}": names for name, names in self.fabrics.items()}
        return {"upper_fabrics": self.upper_fabrics, "lower_fabrics": self.lower_fabrics, **single}

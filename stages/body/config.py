"""Settings of the body stage: whose bodies, and how much room there must be between arms, trunk and legs."""

from dataclasses import dataclass, field

BETA_COUNT = 10
"""Number of shape coefficients."""

LEAVE_OUT = ("nothing", "hands", "forearms", "arms")
"""What may be left out of the collider, from the least to the most."""


@dataclass(frozen=True, kw_only=True)
class Config:
    """The recipe's section `[body]`."""

    shape_range: tuple[float, float] = field(default=(-3.0, 3.0), metadata={"ge": -3.0, "le": 3.0})
    """Every beta is drawn uniformly from this range (CLOTH3D, Human 3D Sequences) [standard deviations]."""
    betas: tuple[float, ...] = field(default=(), metadata={"ge": -3.0, "le": 3.0})
    """First betas of everybody, instead of random ones; the others are drawn [standard deviations]."""
    joints: dict[str, str] = field(default_factory=dict)
    """Which joint of the motion files moves which of SMPL's, where their names don't tell: left_knee = "Calf_L"."""
    rate: float = field(default=120.0, metadata={"ge": 1.0, "le": 10000.0})
    """Rate of motion files that don't tell theirs, such as AMC [frames/s]."""
    arm_gap: float = field(default=0.030, metadata={"gt": 0.0, "le": 0.05})
    """Free space to which arms are opened from the trunk: sleeve and side of a garment gather there in folds [m]."""
    leg_gap: float = field(default=0.012, metadata={"gt": 0.0, "le": 0.05})
    """Free space to which legs are opened from each other [m]."""
    separation: float = field(default=0.020, metadata={"gt": 0.0, "le": 0.05})
    """Free space to which skin is parted where it would touch skin: eight layers of cloth, folded twice on either side,
    2 mm from skin and from each other, and 2 mm more [m]."""
    smallest_gap: float = field(default=0.004, metadata={"ge": 0.0, "le": 0.05})
    """The least that any of these gaps may be: folded cloth must fit (CLOTH3D, Self-collision) [m]."""
    largest_turn: float = field(default=0.8, metadata={"gt": 0.0, "le": 1.6})
    """The farthest that an arm may be turned to be free [rad]."""
    largest_shift: float = field(default=0.15, metadata={"gt": 0.0, "le": 0.5})
    """The farthest that a foot may be moved to part the legs [m]."""
    largest_move: float = field(default=0.05, metadata={"gt": 0.0, "le": 0.5})
    """The farthest that skin may be moved to part it from other skin; hands and feet less, as they are thin [m]."""
    thinner_tries: int = field(default=3, metadata={"ge": 0, "le": 10})
    """How often a thinner body is tried where that isn't enough."""
    thinner_step: float = field(default=1.0, metadata={"gt": 0.0, "le": 6.0})
    """How much thinner each of them is [standard deviations]."""
    leave_out: str = field(default="forearms", metadata={"choices": LEAVE_OUT})
    """The most that may be left out of what cloth collides with, where no thinner body helps: hands; forearms too;
    or whole arms. Sleeves then end before; every upper garment covers a little of whole arms, and is refused."""

    def __post_init__(self) -> None:
        """Checks what concerns several settings.

        Raises:
            ValueError: Which setting is wrong, and how.
        """
        if self.shape_range[0] > self.shape_range[1]:
            low, high = self.shape_range
            raise ValueError(f"shape_range must run from low to high, got [{low:g}, {high:g}]")
        if len(self.betas) > BETA_COUNT:
            raise ValueError(f"betas must have at most {BETA_COUNT} values, got {len(self.betas)}")
        for name in ("arm_gap", "leg_gap", "separation"):
            if getattr(self, name) < self.smallest_gap:
                raise ValueError(
                    f"{name} must be >= smallest_gap = {self.smallest_gap:g} m, got {getattr(self, name):g}"
                )

"""The knobs of the simulation, and the levels of accuracy that set those which trade speed for it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

LEVELS: dict[str, dict[str, Any]] = {
    "preview": {
        "dt": 1 / 90,
        "newton_iterations": 2,
        "newton_tolerance": 1e-4,
        "tolerance": 0.2,
        "linear_iterations": 200,
        "precision": "f32",
        "pair_every": 4,
        "calm": 2.0,
    },
    "standard": {
        "dt": 1 / 120,
        "newton_iterations": 2,
        "newton_tolerance": 2e-5,
        "tolerance": 0.2,
        "linear_iterations": 400,
        "precision": "f32",
        "pair_every": 4,
        "calm": 2.0,
    },
    "fine": {
        "dt": 1 / 240,
        "newton_iterations": 3,
        "newton_tolerance": 2e-5,
        "tolerance": 0.12,
        "linear_iterations": 400,
        "precision": "f32",
        "pair_every": 8,
        "calm": 1.0,
    },
    "reference": {
        "dt": 1 / 1920,
        "newton_iterations": 20,
        "newton_tolerance": 1e-7,
        "tolerance": 1e-3,
        "linear_iterations": 2000,
        "precision": "f64",
        "pair_every": 1,
        "calm": 1.0,
    },
}
"""What each level of accuracy sets, unless the recipe sets it itself."""


def by_level(**limits: Any) -> Any:
    """A knob that the level of accuracy sets where the recipe does not."""
    return field(default=None, metadata=limits)


@dataclass(frozen=True, kw_only=True)
class SimulateConfig:
    """Section [simulate] of a recipe."""

    accuracy: str = field(default="standard", metadata={"choices": tuple(LEVELS)})
    """A point on the measured curve of error against time; sets those of the next knobs that aren't given."""
    dt: float = by_level(gt=0.0, le=1 / 30)
    """Longest time step [s] where things move; it is shortened where they move fast, and halved where it fails."""
    calm: float = by_level(ge=1.0, le=2.0)
    """How many times longer than `dt` a step may be in the transition, and where body and cloth hardly move."""
    plan: str = field(default="scene", metadata={"choices": ("scene", "everything")})
    """Whether what the scene doesn't need is left out, or all skin, pairs in every step and the shortest step of all
    frames are used throughout."""
    shortest_dt: float = field(default=1 / 16000, metadata={"gt": 0.0, "le": 1 / 240})
    """Floor of the step [s]: a step that still fails there ends the task."""
    integrator: str = field(default="bdf2", metadata={"choices": ("bdf2", "euler")})
    """Time integration: second order, or the more damped implicit Euler."""
    newton_iterations: int = by_level(ge=1, le=50)
    """Most Newton iterations of a step."""
    newton_tolerance: float = by_level(ge=0.0, le=1e-2)
    """A step is solved when no vertex moves further than this in an iteration [m]."""
    tolerance: float = by_level(gt=0.0, lt=1.0)
    """Relative residual at which the linear solve ends, in the preconditioner's norm."""
    linear_iterations: int = by_level(ge=4, le=10000)
    """Most iterations of the linear solve."""
    precision: str = by_level(choices=("f32", "f64"))
    """Numbers of the linear solve; positions, forces and time are always f64."""
    gravity: float = field(default=-9.81, metadata={"ge": -100.0, "le": 100.0})
    """Acceleration along z [m/s^2]."""
    margin: float = field(default=0.002, metadata={"gt": 0.0, "le": 0.02})
    """Distance at which skin starts to push cloth away [m]."""
    floor: float = field(default=0.001, metadata={"ge": 0.0, "le": 0.02})
    """Least distance from skin at which cloth is left at the end of a step [m]."""
    contact_stiffness: float = field(default=1.0e6, metadata={"gt": 0.0, "le": 1e9})
    """Pressure of skin on cloth per missing margin [N/m^3]."""
    contact_damping: float = field(default=1.0e-3, metadata={"ge": 0.0, "le": 1.0})
    """Damping of approach, over contact stiffness [s]."""
    grip: float = field(default=0.5, metadata={"gt": 0.0, "le": 10.0})
    """Tangential over normal stiffness of the skin, while friction holds."""
    travel: float = field(default=0.01, metadata={"gt": 0.0, "le": 0.05})
    """Furthest that skin may move past cloth in one step [m]; faster motion gets shorter steps."""
    self_collision: bool = True
    """Whether cloth collides with cloth."""
    thickness: float = field(default=0.002, metadata={"gt": 0.0, "le": 0.02})
    """Distance that layers of cloth keep from each other [m], at most a third of an edge."""
    pair_damping: float = field(default=5.0e-3, metadata={"ge": 0.0, "le": 1.0})
    """Damping of cloth against cloth, over its contact stiffness [s]."""
    pair_slack: float = field(default=0.002, metadata={"gt": 0.0, "le": 0.05})
    """Distance beyond `thickness` to look for pairs of cloth [m], besides what they may move meanwhile."""
    pair_every: int = by_level(ge=1, le=100)
    """Most steps for which pairs of cloth are kept before they are looked for again."""
    untangle: float = field(default=0.01, metadata={"ge": 0.0, "le": 0.1})
    """Depth up to which garments that start through each other are put in the order of their layers [m]."""
    deepest_start: float = field(default=0.01, metadata={"ge": 0.0, "le": 1.0})
    """How deep cloth may start inside the body [m]; deeper is refused."""
    waist_stiffness: float = field(default=5.0e4, metadata={"ge": 0.0, "le": 1e8})
    """Pull of a waistband towards the skin it was put on, per area and distance [N/m^3]."""
    shape_speed: float = field(default=0.3, metadata={"gt": 0.0, "le": 10.0})
    """Fastest skin while the body grows from its tight shape to its own [m/s]."""
    pose_speed: float = field(default=1.5, metadata={"gt": 0.0, "le": 10.0})
    """Fastest skin while the body goes from rest to the first pose [m/s]."""
    run_up: float = field(default=0.25, metadata={"ge": 0.0, "le": 2.0})
    """Time in which limbs get up to the speed that they have in the sequence's first frame [s]."""
    settle_frames: int = field(default=12, metadata={"ge": 0, "le": 300})
    """Frames at rest between the two transitions."""
    device: str = field(default="cpu", metadata={"choices": ("cpu", "gpu")})
    """Where the kernels run; a GPU is one of CUDA, and pays for meshes far larger than a garment, if at all."""
    threads: int = field(default=0, metadata={"ge": 0, "le": 1024})
    """CPU threads; 0 takes what the process may use. Results don't depend on it."""
    error_bars: bool = False
    """Whether windows of the sequence are simulated again, finer, and the difference is stored with it."""
    error_bar_windows: int = field(default=3, metadata={"ge": 1, "le": 100})
    """How many windows, spread over the sequence; fewer where it is too short."""
    error_bar_frames: int = field(default=10, metadata={"ge": 1, "le": 300})
    """Frames in a window."""

    def __post_init__(self) -> None:
        for knob, value in LEVELS[self.accuracy].items():
            if getattr(self, knob) is None:
                object.__setattr__(self, knob, value)

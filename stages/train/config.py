"""Settings of the stage train."""

from __future__ import annotations

from dataclasses import dataclass, field

from model.gcvae import LEVELS


@dataclass(frozen=True, kw_only=True)
class NetworkConfig:
    """Sizes and schedule of one network."""

    widths: tuple[int, ...] = field(default=(16, 24, 32, 48, 64, 96), metadata={"ge": 1})
    """Features of a vertex at each of the six levels, finest first."""

    latent: int = field(default=128, metadata={"ge": 1})
    """Numbers in the latent code z (128 in the paper)."""

    middle: int = field(default=16, metadata={"ge": 1})
    """Numbers in cvar^z, the middle layer of the conditioning network."""

    hidden: int = field(default=256, metadata={"ge": 1})
    """Width of the fully connected layers around the latent code."""

    depth: int = field(default=1, metadata={"ge": 1})
    """Graph convolutions in each residual block."""

    node_bias: bool = True
    """Whether each vertex of the decoder has learned biases of its own."""

    modes: int = field(default=64, metadata={"ge": 0})
    """Principal modes of the linear path beside the graph layers; 0 for the paper's network."""

    epochs: int = field(default=16, metadata={"ge": 1})
    """Passes over the training samples."""

    batch: int = field(default=8, metadata={"ge": 1})
    """Samples of one optimiser step."""

    learning_rate: float = field(default=1e-3, metadata={"gt": 0.0})
    """Peak rate of AdamW; it falls to zero along a cosine."""

    weight_decay: float = field(default=0.05, metadata={"ge": 0.0})
    """Decay of AdamW."""

    def __post_init__(self) -> None:
        if len(self.widths) != LEVELS:
            raise ValueError(f"widths must have {LEVELS} numbers, one a level, got {len(self.widths)}")


@dataclass(frozen=True, kw_only=True)
class TrainConfig:
    """What is trained, on what, and for how long."""

    static: NetworkConfig = field(default_factory=NetworkConfig)
    """SVAE, the network of garments at rest."""

    dynamic: NetworkConfig = field(default_factory=lambda: NetworkConfig(epochs=4, middle=32))
    """DVAE, the network of wrinkles in motion."""

    normals_weight: float = field(default=0.1, metadata={"ge": 0.0})
    """Weight of the loss on face normals."""

    mask_weight: float = field(default=1.0, metadata={"ge": 0.0})
    """Weight of the loss on the mask (SVAE)."""

    mask_loss: str = field(default="bce", metadata={"choices": ("bce", "l1")})
    """Loss on the mask: cross entropy, or the paper's absolute error."""

    collision_weight: float = field(default=10.0, metadata={"ge": 0.0})
    """Weight of the mean depth inside the body [1/m]."""

    condition_weight: float = field(default=0.1, metadata={"ge": 0.0})
    """Weight of the regressed cvar^z."""

    kl_weight: float = field(default=1e-4, metadata={"ge": 0.0})
    """Weight of the KL divergence, summed over the latent code."""

    conditioning_steps: int = field(default=400, metadata={"ge": 1})
    """Optimiser steps of the conditioning network, which is trained first."""

    frames: int = field(default=1, metadata={"ge": 1, "le": 16})
    """Poses that condition DVAE: the frame's own and those before it (1 or 4 in the paper)."""

    frame_spacing: int = field(default=3, metadata={"ge": 1})
    """Frames between those poses [1/fps s]."""

    frames_per_sequence: int = field(default=60, metadata={"ge": 2})
    """Frames that DVAE takes of each sequence, spread evenly."""

    components: tuple[int, ...] = field(default=(16, 64, 128), metadata={"ge": 1})
    """Sizes of the PCA baselines; at most one less than there are samples."""

    generated: int = field(default=6, metadata={"ge": 0, "le": 1000})
    """Garments to generate."""

    latent_source: str = field(default="type", metadata={"choices": ("type", "prior")})
    """Where generated codes come from: a Gaussian fitted to each type's codes, or the prior N(0, I)."""

    temperature: float = field(default=0.8, metadata={"ge": 0.0, "le": 2.0})
    """Factor on the deviation of generated codes from their mean: below 1, fewer odd garments and less variety."""

    threads: int = field(default=0, metadata={"ge": 0, "le": 256})
    """Parts of a batch computed at once; 0 takes every core. The result doesn't depend on it."""

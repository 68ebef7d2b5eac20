"""The loss of one micro-batch: from samples to normalised tensors, through a network, to weighted terms."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from model.gcvae import losses
from model.gcvae.network import GarmentVae
from model.gcvae.normalise import Normaliser
from stages.train.config import TrainConfig
from stages.train.samples import Samples

TERMS = ("offsets", "normals", "mask", "collision", "condition", "kl")


def topology_of(skirt: bool | np.bool_) -> str:
    """Name of the topology of a sample."""
    return "skirt" if skirt else "body"


def node_major(array: NDArray, device: str = "cpu") -> Tensor:
    """A tensor (N, B, ..) of an array (B, N, ..)."""
    return torch.from_numpy(np.ascontiguousarray(np.moveaxis(array, 0, 1))).to(device)


def network_input(samples: Samples, rows: NDArray[np.int64], scales: Normaliser) -> Tensor:
    """The encoder's input (N, B, inputs): normalised offsets, the mask (SVAE only), and what the offsets are added to.

    The paper's X is zero where there is no garment. Here X is continued and SVAE's mask is a channel of its own, since
    tight cloth a few millimetres off the skin would hardly differ from none.
    """
    parts = [samples.target[rows] / scales.offset_scale]
    if samples.worn is None:
        parts.append(samples.mask[samples.garment[rows]][..., None].astype(np.float32))
    parts.append((samples.base(rows) - scales.body_mean) / scales.body_scale)
    if samples.posed is not None and samples.frame is not None:
        parts.append(samples.posed[samples.frame[rows]])
    return node_major(np.concatenate(parts, axis=2, dtype=np.float32))


def input_channels(samples: Samples) -> int:
    """Channels of `network_input`."""
    return 7 if samples.worn is None else 9


class Objective:
    """Loss of a network on micro-batches of `samples`, each of one topology."""

    def __init__(
        self,
        samples: Samples,
        scales: Normaliser,
        config: TrainConfig,
        face_normals: Mapping[str, losses.FaceNormals],
    ) -> None:
        self.samples, self.scales, self.face_normals = samples, scales, face_normals
        self.mask_kind = config.mask_loss
        self.weights = {
            "offsets": 1.0,
            "normals": config.normals_weight,
            "mask": config.mask_weight,
            "collision": config.collision_weight,
            "condition": config.condition_weight,
            "kl": config.kl_weight,
        }

    def __call__(self, network: GarmentVae, rows: NDArray[np.int64], noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Weighted loss and its unweighted terms, each summed over the samples `rows`; `noise` is (B, Z)."""
        samples, scale = self.samples, self.scales.offset_scale
        topology = topology_of(samples.skirt[rows[0]])
        cvar = torch.from_numpy(self.scales.conditions(samples.cvar[rows]))
        offsets, logits, encoded, middle = network(network_input(samples, rows, self.scales), cvar, noise, topology)
        target = node_major(samples.target[rows])
        mask = node_major(samples.mask[samples.garment[rows]])
        base = node_major(samples.base(rows))
        metres = offsets * scale
        face_normals = self.face_normals[topology]
        terms = {
            "offsets": losses.offsets_loss(offsets, target / scale, mask),
            "condition": (encoded.middle - middle).abs().mean(1),
            "kl": losses.kl_divergence(encoded.mean, encoded.log_variance).sum(1),
        }
        if self.weights["normals"]:
            with torch.no_grad():
                truth = face_normals(base + target)
            terms["normals"] = losses.normals_loss(face_normals(base + metres), truth, face_normals.inside(mask))
        if self.weights["collision"]:
            from_body = metres if samples.worn is None else metres + node_major(samples.worn[samples.garment[rows]])
            normals = node_major(samples.normals[samples.wearer[rows]])
            terms["collision"] = losses.collision_loss(from_body, normals, mask)
        if logits is not None:
            terms["mask"] = losses.mask_loss(logits, mask, self.mask_kind)
        total = torch.stack([self.weights[name] * value.sum() for name, value in terms.items()]).sum()
        return total, {name: value.detach().sum() for name, value in terms.items()}

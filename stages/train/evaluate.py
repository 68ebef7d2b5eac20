"""Networks and baselines scored on the same samples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from model.gcvae.losses import kl_divergence
from model.gcvae.network import GarmentVae
from model.gcvae.normalise import Normaliser
from stages.train import metrics
from stages.train.baselines import Components, TypeMeans, feature_rows
from stages.train.fit import MICRO_BATCH, single_threaded_torch
from stages.train.objective import network_input, topology_of
from stages.train.samples import Samples

# One prediction a sample: row, offsets [m] (N, 3), mask (N,) or None where the method predicts none.
Prediction = tuple[int, NDArray[np.float32], NDArray[np.bool_] | None]
Predictor = Callable[[Samples], Iterable[Prediction]]


@dataclass(frozen=True, kw_only=True)
class Codes:
    """What an encoder says of samples.

    Attributes:
        mean: Posterior means, shape (S, Z).
        log_variance: Posterior log variances, shape (S, Z).
    """

    mean: NDArray[np.float32]
    log_variance: NDArray[np.float32]

    def divergence(self) -> NDArray[np.float32]:
        """KL divergence from the prior, summed over the code, shape (S,)."""
        return kl_divergence(torch.from_numpy(self.mean), torch.from_numpy(self.log_variance)).sum(1).numpy()


def one_topology_batches(skirt: NDArray[np.bool_]) -> Iterable[NDArray[np.int64]]:
    """Rows of all samples in micro-batches of one topology each."""
    for wanted in (False, True):
        rows = np.flatnonzero(skirt == wanted)
        yield from (rows[k : k + MICRO_BATCH] for k in range(0, len(rows), MICRO_BATCH))


def encode(network: GarmentVae, samples: Samples, scales: Normaliser) -> Codes:
    """Posteriors of all samples."""
    shape = (len(samples), network.shape.latent)
    codes = Codes(mean=np.empty(shape, np.float32), log_variance=np.empty(shape, np.float32))
    with torch.no_grad(), single_threaded_torch():
        for rows in one_topology_batches(samples.skirt):
            encoded = network.encoder(network_input(samples, rows, scales), topology_of(samples.skirt[rows[0]]))
            codes.mean[rows], codes.log_variance[rows] = encoded.mean.numpy(), encoded.log_variance.numpy()
    return codes


def decode(
    network: GarmentVae, scales: Normaliser, code: NDArray[np.float32], cvar: NDArray[np.float32], topology: str
) -> tuple[NDArray[np.float32], NDArray[np.bool_] | None]:
    """Offsets [m] (B, N, 3) and masks (B, N), or None, of codes (B, Z) under conditions (B, C)."""
    with torch.no_grad(), single_threaded_torch():
        middle = network.conditioning.encode(torch.from_numpy(scales.conditions(cvar)))
        offsets, logits = network.decoder(torch.from_numpy(code), middle, topology)
    metres = (offsets * scales.offset_scale).transpose(0, 1).contiguous().numpy()
    return metres, None if logits is None else (logits > 0).T.contiguous().numpy()


def reconstruct(network: GarmentVae, scales: Normaliser, codes: Codes) -> Predictor:
    """The network's own reconstruction, from the mean of the posterior."""

    def predict(samples: Samples) -> Iterable[Prediction]:
        for rows in one_topology_batches(samples.skirt):
            topology = topology_of(samples.skirt[rows[0]])
            offsets, masks = decode(network, scales, codes.mean[rows], samples.cvar[rows], topology)
            for k, row in enumerate(rows):
                yield int(row), offsets[k], None if masks is None else masks[k]

    return predict


def zero_offset(samples: Samples) -> Iterable[Prediction]:
    """No offset at all: the bare body for SVAE, the posed garment at rest for DVAE."""
    nothing = np.zeros(samples.target.shape[1:], np.float32)
    yield from ((row, nothing, None) for row in range(len(samples)))


def mean_offset(means: TypeMeans, masked: bool) -> Predictor:
    """The mean garment of the sample's true type."""

    def predict(samples: Samples) -> Iterable[Prediction]:
        for row, kind in enumerate(samples.types):
            offsets, mask = means(kind)
            yield row, offsets, mask if masked else None

    return predict


def projection(components: Components, size: int) -> Predictor:
    """The sample itself, projected on the first principal components."""

    def predict(samples: Samples) -> Iterable[Prediction]:
        for row in range(len(samples)):
            features = feature_rows(samples, np.array([row]), components.scale, components.masked)
            offsets, masks = components(features, size)
            yield row, offsets[0], None if masks is None else masks[0]

    return predict


def score(
    samples: Samples, predictions: Iterable[Prediction], faces: Mapping[str, NDArray[np.int32]]
) -> dict[str, list[float]]:
    """Metrics of every sample, in the samples' order, for predictions in any order.

    Returns:
        "surface_mm", "normals_rad", "inside_share" and, if masks are predicted, "mask_iou".
    """
    found: dict[str, dict[int, float]] = {}
    for row, offsets, mask in predictions:
        index = np.array([row])
        base, true = samples.base(index)[0], samples.mask[samples.garment[row]]
        target, normals = samples.target[row], samples.normals[samples.wearer[row]]
        worn = 0.0 if samples.worn is None else samples.worn[samples.garment[row]]
        topology = topology_of(samples.skirt[row])
        values = {
            "surface_mm": metrics.surface_error(offsets, target, true),
            "normals_rad": metrics.normals_error(offsets, target, base, faces[topology], true),
            "inside_share": metrics.inside_share(offsets + worn, normals, true),
        }
        if mask is not None:
            values["mask_iou"] = metrics.mask_iou(mask, true)
        for name, value in values.items():
            found.setdefault(name, {})[row] = value
    return {name: [rows[k] for k in range(len(samples))] for name, rows in found.items()}


def compare(
    samples: Samples, predictors: Mapping[str, Predictor], faces: Mapping[str, NDArray[np.int32]]
) -> dict[str, Any]:
    """Method -> averages of its scores; see `metrics.averages`."""
    return {
        name: metrics.averages(score(samples, predict(samples), faces), samples.types)
        for name, predict in predictors.items()
    }

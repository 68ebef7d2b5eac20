"""Trained networks as plain named arrays: no pickles, and enough to build each network again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from model.gcvae.graphs import MeshGraphs
from model.gcvae.network import Architecture, GarmentVae
from model.gcvae.normalise import Normaliser
from stages.train.experiment import Trained
from stages.train.generate import Generated

# Points of a loss curve that a report needs at most.
MOST_POINTS = 500


def network_arrays(name: str, trained: Trained) -> dict[str, NDArray]:
    """Weights, units and baselines of one network under its name."""
    arrays = {
        f"networks/{name}/weights/{key}": value.numpy()
        for key, value in unique_state(trained.network).items()
        if value.numel()
    }
    arrays |= {f"networks/{name}/scales/{key}": value for key, value in trained.scales.arrays().items()}
    arrays |= {f"baselines/{name}/mean/{kind}/offsets": value for kind, value in trained.means.offsets.items()}
    arrays |= {f"baselines/{name}/mean/{kind}/mask": value for kind, value in trained.means.mask.items()}
    arrays[f"baselines/{name}/components/mean"] = trained.components.mean
    arrays[f"baselines/{name}/components/basis"] = trained.components.basis
    return arrays


def unique_state(network: GarmentVae) -> dict[str, torch.Tensor]:
    """The state of a network; the linear path's modes, which encoder and decoder share, are named once."""
    return {k: v for k, v in network.state_dict().items() if not k.startswith(("encoder.modes.", "decoder.modes."))}


def load_network(
    name: str, stored: Mapping[str, NDArray], shape: Mapping[str, Any], graphs: MeshGraphs
) -> tuple[GarmentVae, Normaliser]:
    """The network and units that `network_arrays` and `shape_attrs` described.

    Raises:
        ValueError: If a weight is missing or has another shape.
    """
    network = GarmentVae(graphs, Architecture(**{**shape, "widths": tuple(shape["widths"])}))
    for key, parameter in unique_state(network).items():
        if not parameter.numel():
            continue
        array = stored.get(f"networks/{name}/weights/{key}")
        if array is None or array.shape != tuple(parameter.shape):
            found = "missing" if array is None else f"of shape {array.shape}"
            raise ValueError(f"network {name}: weight {key!r} is {found}, wanted {tuple(parameter.shape)}; train again")
        with torch.no_grad():
            parameter.copy_(torch.from_numpy(np.array(array)))
    prefix = f"networks/{name}/scales/"
    scales = {key.removeprefix(prefix): value for key, value in stored.items() if key.startswith(prefix)}
    return network, Normaliser.from_arrays(scales)


def shape_attrs(trained: Trained) -> dict[str, Any]:
    """The network's sizes as JSON."""
    return {**asdict(trained.network.shape), "widths": list(trained.network.shape.widths)}


def loss_curves(history: Mapping[str, NDArray[np.float32]]) -> dict[str, list[float]]:
    """Loss terms by epoch, thinned out evenly to at most `MOST_POINTS`."""
    count = len(history["total"])
    kept = np.unique(np.rint(np.linspace(0, count - 1, min(count, MOST_POINTS))).astype(int))
    return {"step": (kept + 1).tolist(), **{name: values[kept].tolist() for name, values in history.items()}}


def generated_arrays(garments: list[Generated]) -> dict[str, NDArray]:
    """Meshes of generated garments and their bodies."""
    arrays: dict[str, NDArray] = {}
    for k, garment in enumerate(garments):
        arrays[f"generated/{k:03d}/vertices"] = garment.vertices
        arrays[f"generated/{k:03d}/faces"] = garment.faces
        arrays[f"generated/{k:03d}/body_vertices"] = garment.body_vertices
        arrays[f"generated/{k:03d}/body_faces"] = garment.body_faces
    return arrays

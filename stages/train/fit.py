"""The training loops: Gamma first, then a network, the same bits at any number of threads."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from model.gcvae.conditioning import Conditioning
from model.gcvae.network import GarmentVae
from stages.train.config import NetworkConfig
from stages.train.objective import TERMS, Objective
from stages.train.samples import micro_batches

# Samples that one thread works on at a time. A batch is cut the same way whatever the number of threads, and the parts'
# gradients are added in order: that, and one BLAS thread in each, makes the bits independent of the machine's cores.
MICRO_BATCH = 4
# Share of the steps over which the learning rate rises to its peak.
WARM_UP = 0.05
GRADIENT_LIMIT = 1.0

Report = Callable[[int, int], None]


@contextmanager
def single_threaded_torch() -> Iterator[None]:
    """Torch's own operations on one thread while the block runs."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


Network = TypeVar("Network", bound=nn.Module)


def built(make: Callable[[], Network], seed: int) -> Network:
    """`make()` with its random weights drawn from `seed`, leaving torch's global generator as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return make()


def cosine_rate(step: int, steps: int, peak: float) -> float:
    """Learning rate at `step` of `steps`: a linear rise, then a cosine down to zero."""
    rise = max(1, round(WARM_UP * steps))
    if step < rise:
        return peak * (step + 1) / rise
    return 0.5 * peak * (1.0 + math.cos(math.pi * (step - rise) / max(1, steps - rise)))


def fit_conditioning(gamma: Conditioning, cvar: Tensor, steps: int) -> float:
    """Train Gamma on normalised conditions (S, C) with L1, freeze it, and give back its last error.

    The batch is the whole set, up to 256 conditions taken in turn: cvar is a few hundred numbers.
    """
    optimiser = torch.optim.AdamW(gamma.parameters(), lr=3e-3, weight_decay=0.0)
    size = min(256, len(cvar))
    with single_threaded_torch():
        for step in range(steps):
            for group in optimiser.param_groups:
                group["lr"] = cosine_rate(step, steps, 3e-3)
            rows = (torch.arange(size) + step * size) % len(cvar)
            error = (gamma(cvar[rows])[0] - cvar[rows]).abs().mean()
            optimiser.zero_grad()
            error.backward()
            optimiser.step()
    for parameter in gamma.parameters():
        parameter.requires_grad_(False)
    return float(error.detach())


def fit_network(
    network: GarmentVae,
    objective: Objective,
    settings: NetworkConfig,
    rng: np.random.Generator,
    threads: int,
    report: Report,
) -> dict[str, NDArray[np.float32]]:
    """Train encoder and decoder; Gamma must be frozen.

    Args:
        network: Trained in place.
        objective: Loss on the training samples.
        settings: Schedule.
        rng: Source of the order and of the noise.
        threads: Micro-batches computed at once.
        report: Called with the epochs done and in all, after each.

    Returns:
        Mean of each loss term over the samples of every epoch, term -> (epochs,).
    """
    parameters = [p for p in network.parameters() if p.requires_grad]
    optimiser = torch.optim.AdamW(parameters, lr=settings.learning_rate, weight_decay=settings.weight_decay)
    samples = objective.samples
    per_step = max(1, settings.batch // MICRO_BATCH)
    size = min(MICRO_BATCH, settings.batch)
    history: dict[str, list[float]] = {name: [] for name in TERMS}
    step = 0

    def part(rows: NDArray[np.int64], noise: Tensor, count: int) -> tuple[tuple[Tensor, ...], dict[str, Tensor]]:
        total, terms = objective(network, rows, noise)
        return torch.autograd.grad(total / count, parameters), terms

    with single_threaded_torch(), ThreadPoolExecutor(threads, initializer=lambda: torch.set_num_threads(1)) as pool:
        for epoch in range(settings.epochs):
            order = micro_batches(samples.skirt, size, rng)
            steps = settings.epochs * math.ceil(len(order) / per_step)
            sums: dict[str, float] = dict.fromkeys(TERMS, 0.0)
            for first in range(0, len(order), per_step):
                batch = order[first : first + per_step]
                shapes = [(len(rows), settings.latent) for rows in batch]
                noises = [torch.from_numpy(rng.standard_normal(shape, np.float32)) for shape in shapes]
                results = list(pool.map(part, batch, noises, [sum(map(len, batch))] * len(batch)))
                for k, parameter in enumerate(parameters):
                    parameter.grad = _in_order([gradients[k] for gradients, _ in results])
                nn.utils.clip_grad_norm_(parameters, GRADIENT_LIMIT)
                for group in optimiser.param_groups:
                    group["lr"] = cosine_rate(step, steps, settings.learning_rate)
                optimiser.step()
                step += 1
                for _, terms in results:
                    for name, value in terms.items():
                        sums[name] += float(value)
            for name in TERMS:
                history[name].append(sums[name] / len(samples))
            report(epoch + 1, settings.epochs)
    return {name: np.array(values, np.float32) for name, values in history.items()}


def _in_order(gradients: list[Tensor]) -> Tensor:
    total = gradients[0]
    for gradient in gradients[1:]:
        total = total + gradient
    return total

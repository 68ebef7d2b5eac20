"""The record of a run: means of what presses, and the peak of memory."""

import numpy as np
import pytest

from stages.simulate.record import counts, forget_peak, peak_memory_mb
from stages.simulate.stepper import Report


def test_contacts_and_pairs_are_means_over_the_iterations() -> None:
    report = Report(steps=3, newton=8, linear=40, contacts=20, pairs=4)
    assert counts(report) == {
        "steps": 3, "halvings": 0, "unsolved": 0,
        "newton_iterations": 8, "linear_iterations": 40, "contacts": 2.5, "pairs": 0.5,
    }  # fmt: skip
    assert counts(Report())["contacts"] == 0


def test_peak_rises_with_what_is_used_and_can_be_forgotten() -> None:
    forget_peak()
    before = peak_memory_mb()
    held = np.ones(8_000_000)
    peak = peak_memory_mb()
    assert peak - before == pytest.approx(held.nbytes / 1e6, abs=8)
    del held
    assert peak_memory_mb() > peak - 8
    forget_peak()
    assert peak_memory_mb() < peak - 48

"""The contest on peaks over a cycle, and what contests share."""

import numpy as np
from stability.search import Contest

from vibecalc.numerics.cycle_peak import cycle_peak


def between(value: float, low: float, high: float) -> float:
    """Logarithmic from low to high."""
    return float(low * (high / low) ** value)


def worst(off: object, error: object) -> float:
    """Largest |off| / error; a difference without any error is infinite."""
    apart, uncertainty = np.abs(np.asarray(off, dtype=float)), np.asarray(error, dtype=float)
    share = np.where(apart == 0.0, 0.0, apart / np.where(uncertainty > 0.0, uncertainty, 1e-320))
    return float(np.max(share))


def peak_over_cycle(point: np.ndarray) -> float:
    """Branch and bound against 40 000 samples: none may lie above the peak."""
    random = np.random.default_rng(int(point[0] * 1e5))
    count = 1 + int(point[1] * 11.9)
    highest = 1 + int(between(point[2], 1.0, 300.0))
    orders = np.unique(random.integers(0, highest + 1, count))
    size = 10.0 ** random.uniform(-16.0 * point[3], 0.0, len(orders))
    wave = size * np.exp(2j * np.pi * np.round(random.random(len(orders)) * 4) ** (point[4] > 0.5))
    found = cycle_peak(wave, orders)
    angle = np.concatenate([
        np.linspace(0.0, 2.0 * np.pi, 40_001), found.angle + np.linspace(-1e-6, 1e-6, 2001)
    ])  # fmt: skip
    top = float(np.max(np.abs((np.exp(1j * np.outer(angle, orders)) @ wave).real)))
    noise = 4e-16 * float(np.sum(np.abs(wave)))
    return max(0.0, top - float(found.value)) / (float(found.error) + noise)


MACHINES = (Contest("peak over a cycle", "branch and bound against samples", 5, peak_over_cycle),)

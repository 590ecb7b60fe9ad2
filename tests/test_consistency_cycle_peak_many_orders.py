"""Claim: peaks over a cycle of many orders are exact, and their cost does not grow as a square.

Up to a number of orders the signal is sampled by a table of waves, beyond by a Fourier transform.
"""

import math

import numpy as np
import pytest

from vibecalc.numerics import cycle_peak as module
from vibecalc.numerics.cycle_peak import cycle_peak, vector_cycle_peak


def harmonics(shape: tuple[int, ...]) -> np.ndarray:
    generator = np.random.default_rng(4)
    return generator.normal(size=shape) + 1j * generator.normal(size=shape)


@pytest.mark.parametrize("orders", [np.arange(61), np.array([80, 3, 3, 40, 0])])
def test_table_and_transform_give_the_same_peaks(
    orders: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    signals = harmonics((20, 3, len(orders)))
    found = []
    for table in (0, 1 << 30):
        monkeypatch.setattr(module, "TABLE", table)
        found.append(vector_cycle_peak(signals, orders))
    first, second = found
    assert np.all(np.abs(first.value - second.value) <= first.error)
    # next to a smooth maximum the angle is known to the root of the rounding only
    assert np.max(np.abs(first.angle - second.angle)) < 1e-8


def test_peak_of_many_orders_is_the_signal_there_and_above_all_samples() -> None:
    signal, orders = harmonics((400,)), np.arange(1, 401)
    found = cycle_peak(signal, orders)
    at = float(found.angle)
    terms = (signal * np.exp(1j * orders * at)).real
    assert abs(abs(math.fsum(terms)) - found.value) < found.error + 1e-12 * found.value
    samples = 1 << 16
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[orders] = 0.5 * samples * signal
    highest = np.max(np.abs(np.fft.irfft(spectrum, samples)))
    assert highest <= found.value + found.error
    # samples so dense miss the maximum by half the curvature times the step squared at most
    curvature = float(np.sum(orders**2 * np.abs(signal)))
    assert found.value - highest <= 0.5 * curvature * (math.pi / samples) ** 2

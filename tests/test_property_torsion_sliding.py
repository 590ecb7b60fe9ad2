"""Claim: an envelope over a sliding cycle is flat for a steady motion and holds the extremes."""

import numpy as np
import pytest

from vibecalc.torsion.line import chain
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import stretch
from vibecalc.torsion.transient.trace import extremes, section_peaks, sliding, traces

CYCLE = 4.0 * np.pi
ORDERS = np.arange(1, 17) / 2
LINE = chain(np.array([18.0, 19.0, 18.0, 900.0]), np.array([22e6, 21e6, 19e6]))._replace(
    damping=np.array([900.0, 800.0, 800.0])
)


def gas(lost: int | None = None) -> np.ndarray:
    found = np.zeros((4, ORDERS.size), dtype=complex)
    for cylinder, place in enumerate([0.0, 8.0, 4.0]):
        found[cylinder] = 3000.0 / ORDERS * np.exp(-1j * ORDERS * place * np.pi / 3.0)
    if lost is not None:
        found[lost] = 0.0
    return found


def change() -> TransientRun:
    """A misfire that sets in within a cycle."""
    parts = [stretch(0.4, 0.0, gas()), stretch(1.6, 0.0, gas(1))]
    return transient(LINE, ORDERS, parts, 83.0, start="steady")


def test_a_steady_motion_has_a_flat_envelope() -> None:
    run = transient(LINE, ORDERS, [stretch(1.0, 0.0, gas())], 83.0, start="steady")
    windows = sliding(run.course, CYCLE, 61)
    assert windows is not None
    seen = traces(run, np.concatenate(windows))
    for trace in seen:
        low, high, error = extremes(trace, windows.begin, windows.end)
        for values in (low, high):
            assert np.all(np.abs(values - values[0]) <= error + error[0])
            assert np.ptp(values) == pytest.approx(0.0, abs=2e-6 * high.max())
        assert np.all(error < 1e-5 * high.max())
        assert np.all(np.abs(high - trace.value.max()) <= error + error.max())


def test_a_long_run_is_left_out_nowhere_and_a_short_one_has_no_envelope() -> None:
    run = change()
    few = sliding(run.course, CYCLE, 4)
    assert few is not None
    seen = traces(run, np.concatenate(few))
    peaks = section_peaks(run, seen)
    for section, trace in enumerate(seen):
        low, high, _ = extremes(trace, few.begin, few.end)
        assert max(high.max(), -low.min()) == pytest.approx(peaks.peak[section], rel=1e-5)
    short = transient(LINE, ORDERS, [stretch(0.1, 0.0, gas())], 83.0, start="steady")
    assert sliding(short.course, CYCLE) is None

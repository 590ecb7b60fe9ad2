"""Claim: an envelope over a sliding cycle is flat for a steady motion and holds the extremes."""

import numpy as np
import pytest

from vibecalc.torsion.line import chain
from vibecalc.torsion.transient.cycles import sliding
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import stretch
from vibecalc.torsion.transient.peaks import envelope

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
    found = sliding(run, CYCLE, 61)
    assert found is not None
    for values in (found.low, found.high):
        assert np.all(np.abs(values - values[0]) <= found.error + found.error[0])
        assert np.ptp(values, axis=0) == pytest.approx(0.0, abs=2e-6 * found.high.max())
    assert np.all(found.error < 1e-5 * found.high.max())
    whole = envelope(run, windows=1)
    assert np.all(np.abs(found.high - whole.high[0]) <= found.error + whole.error[0])
    assert np.all(np.abs(found.low - whole.low[0]) <= found.error + whole.error[0])


def test_a_long_run_is_left_out_nowhere_and_a_short_one_has_no_envelope() -> None:
    run = change()
    few, peak = sliding(run, CYCLE, 4), envelope(run)
    assert few is not None
    assert np.all(few.high.max(axis=0) == pytest.approx(peak.high.max(axis=0), rel=1e-5))
    assert np.all(few.low.min(axis=0) == pytest.approx(peak.low.min(axis=0), rel=1e-5))
    short = transient(LINE, ORDERS, [stretch(0.1, 0.0, gas())], 83.0, start="steady")
    assert sliding(short, CYCLE) is None

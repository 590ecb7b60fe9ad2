"""A line of 2000 inertias: the error that is stated holds, at a cost that grows with its length."""

from typing import Any

import mpmath
import numpy as np
import pytest

import vibecalc.torsion.forced as forced_module
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.elimination import LineSolution
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, chain

COUNT = 2000


def long_line() -> Line:
    """Random inertias with dashpots in their shafts."""
    generator = np.random.default_rng(1)
    stiffness = 1e6 * (1.0 + generator.random(COUNT - 1)) * COUNT / 7
    line = chain(0.05 + 0.1 * generator.random(COUNT), stiffness)
    return line._replace(damping=1e-5 * stiffness)


def exact(line: Line, w: float, driven: int) -> np.ndarray:
    """Angles under a torque of one on the first stations, from the equations in 40 digits."""
    with mpmath.workdps(40):
        at = mpmath.mpf(w)
        k = [mpmath.mpc(a, at * b) for a, b in zip(line.stiffness, line.damping, strict=True)]
        d = [mpmath.mpc(-at * at * j) for j in line.inertia]
        x = [mpmath.mpc(1.0 * (i < driven)) for i in range(COUNT)]
        for e, one in enumerate(k):
            d[e] += one
            d[e + 1] += one
        for e, one in enumerate(k):
            d[e + 1] -= one * one / d[e]
            x[e + 1] += one / d[e] * x[e]
        x[-1] /= d[-1]
        for e in range(COUNT - 2, -1, -1):
            x[e] = (x[e] + k[e] * x[e + 1]) / d[e]
        return np.array([complex(one) for one in x])


def test_next_to_resonances_of_its_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few frequencies are solved as a network as well, and 40 digits agree within its bound."""
    solved = []
    by_network = forced_module.network_solution

    def counted(line: Line, frequency: FloatArray, *rest: Any) -> LineSolution:
        solved.append(len(frequency))
        return by_network(line, frequency, *rest)

    monkeypatch.setattr(forced_module, "network_solution", counted)
    line = long_line()
    w = np.linspace(20.0, 90.0, 10)[:, None] * np.arange(1, 31) * 0.5
    found = forced_masked(line, w, np.ones((1, 1, 6), complex), stations=range(6))
    assert not found.masked.any()
    size = np.max(np.abs(found.angle), axis=-1)
    share = found.error / size
    assert 0 < sum(solved) < w.size / 4
    assert share.max() < 1e-9
    for place in np.argsort(share, axis=None)[[-1, -2]]:
        row = np.unravel_index(place, w.shape)
        true = exact(line, float(w[row]), 6)
        assert np.max(np.abs(found.angle[row] - true)) <= found.error[row]

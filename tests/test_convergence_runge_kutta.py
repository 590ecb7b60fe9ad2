"""Claim: the march keeps fifth order, through kinks too, and its dense output fourth."""

import numpy as np
from marched_systems import System
from scipy.integrate import RK45

from vibecalc.numerics import runge_kutta
from vibecalc.numerics.runge_kutta_march import march


def bilinear(stiff: float = 4.0) -> System:
    """x'' = -x below zero and -stiff x above: half a period each of pi and pi / sqrt(stiff)."""

    def rates(time: np.ndarray, state: np.ndarray, piece: np.ndarray) -> np.ndarray:
        spring = np.where(piece[:, 0] == 0, 1.0, stiff)
        return np.stack([state[:, 1], -spring * state[:, 0]], axis=1)

    return System(rates, np.array([[1.0, 0.0]]), (np.array([0.0]),), 1e-13)


def test_the_table_is_that_of_the_published_pair() -> None:
    assert np.allclose(np.transpose(runge_kutta.DENSE), RK45.P, rtol=0.0, atol=1e-15)
    assert np.allclose(np.negative(runge_kutta._ERROR), RK45.E, rtol=0.0, atol=1e-15)
    for number, row in enumerate(runge_kutta.STAGES[:5], start=1):
        assert np.allclose(row, RK45.A[number, :number], rtol=0.0, atol=1e-15)
    assert np.allclose(runge_kutta.STAGES[5], RK45.B, rtol=0.0, atol=1e-15)


def test_the_error_follows_the_tolerance() -> None:
    start = np.array([[1.0, 0.0]])
    for tolerance in (1e-4, 1e-9):
        found = march(
            bilinear(), np.zeros(1), start, np.array([[1]]), np.array([6.0 * np.pi]),
            absolute=tolerance,
        )  # fmt: skip
        off = np.max(np.abs(found.state - start))
        assert off < 20.0 * tolerance

"""Claim: the march keeps fifth order, through kinks too, and its dense output fourth."""

import numpy as np
import pytest
from marched_systems import System
from scipy.integrate import RK45

from vibecalc.numerics import runge_kutta
from vibecalc.numerics.runge_kutta_march import march, sample

#: loose enough that the longest step alone decides
LOOSE = 1e3


def bilinear(stiff: float = 4.0) -> System:
    """x'' = -x below zero and -stiff x above: half a period each of pi and pi / sqrt(stiff)."""

    def rates(time: np.ndarray, state: np.ndarray, piece: np.ndarray) -> np.ndarray:
        spring = np.where(piece[:, 0] == 0, 1.0, stiff)
        return np.stack([state[:, 1], -spring * state[:, 0]], axis=1)

    return System(rates, np.array([[1.0, 0.0]]), (np.array([0.0]),), 1e-13)


def unaware() -> System:
    """The same without knowing of its kink."""

    def rates(time: np.ndarray, state: np.ndarray, piece: np.ndarray) -> np.ndarray:
        return np.stack([state[:, 1], -np.where(state[:, 0] < 0.0, 1.0, 4.0) * state[:, 0]], axis=1)

    return System(rates)


def error_after_periods(system: System, length: float) -> float:
    start = np.array([[1.0, 0.0]])
    piece = np.array([[1]])
    end = 2.0 * 1.5 * np.pi
    found = march(
        system, np.zeros(1), start, piece, np.array([end]), absolute=LOOSE,
        longest=length, first_length=length,
    )  # fmt: skip
    return float(np.max(np.abs(found.state - start)))


def test_the_table_is_that_of_the_published_pair() -> None:
    assert np.allclose(np.transpose(runge_kutta.DENSE), RK45.P, rtol=0.0, atol=1e-15)
    assert np.allclose(np.negative(runge_kutta._ERROR), RK45.E, rtol=0.0, atol=1e-15)
    for number, row in enumerate(runge_kutta._STAGE[:5], start=1):
        assert np.allclose(row, RK45.A[number, :number], rtol=0.0, atol=1e-15)
    assert np.allclose(runge_kutta._STAGE[5], RK45.B, rtol=0.0, atol=1e-15)


def test_smooth_problems_have_fifth_order() -> None:
    system = System(lambda t, y, _: np.stack([y[:, 1], -y[:, 0] + np.cos(2.0 * t)], axis=1))
    # x'' + x = cos 2t from (0, 0): x = (cos t - cos 2t) / 3
    errors = []
    for count in (40, 80, 160):
        found = march(
            system, np.zeros(1), np.zeros((1, 2)), np.zeros((1, 0), int), np.array([4.0]),
            absolute=LOOSE, longest=4.0 / count, first_length=4.0 / count,
        )  # fmt: skip
        errors.append(abs(found.state[0, 0] - (np.cos(4.0) - np.cos(8.0)) / 3.0))
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert rates == pytest.approx([5.0, 5.0], abs=0.25)


def test_kinks_keep_the_order_when_steps_end_on_them() -> None:
    lengths = [0.12, 0.06, 0.03]
    aware = [error_after_periods(bilinear(), h) for h in lengths]
    blind = [error_after_periods(unaware(), h) for h in lengths]
    assert np.log2(aware[0] / aware[2]) / 2.0 > 4.6
    assert np.log2(blind[0] / blind[2]) / 2.0 < 3.5
    assert aware[2] < 1e-3 * blind[2]


def test_dense_output_has_fourth_order_also_where_steps_were_cut() -> None:
    errors = []
    for length in (0.2, 0.1, 0.05):
        found = march(
            bilinear(), np.zeros(1), np.array([[1.0, 0.0]]), np.array([[1]]), np.array([5.0]),
            absolute=LOOSE, longest=length, first_length=length,
        )  # fmt: skip
        times = np.linspace(0.0, 5.0, 777)
        # cos 2t to pi/4, then -2 sin(t - pi/4) for half a period, then sin 2(..) again
        first, second = 0.25 * np.pi, 1.25 * np.pi
        exact = np.where(
            times < first,
            np.cos(2.0 * times),
            np.where(times < second, -2.0 * np.sin(times - first), np.sin(2.0 * (times - second))),
        )
        errors.append(np.max(np.abs(sample(found.record, 0, times).state[:, 0] - exact)))
    assert np.log2(errors[0] / errors[2]) / 2.0 > 3.6


def test_the_error_follows_the_tolerance() -> None:
    start = np.array([[1.0, 0.0]])
    for tolerance in (1e-4, 1e-9):
        found = march(
            bilinear(), np.zeros(1), start, np.array([[1]]), np.array([6.0 * np.pi]),
            absolute=tolerance,
        )  # fmt: skip
        off = np.max(np.abs(found.state - start))
        assert off < 20.0 * tolerance

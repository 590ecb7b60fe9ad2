"""Claim: the march conserves, errs as its tolerance says, through kinks too, stops where reported,
keeps members apart and refuses in words.
"""

from collections.abc import Callable, Sequence

import mpmath
import numpy as np
import pytest
from scipy.integrate import RK45

from vibecalc.errors import NumericalFailure
from vibecalc.numerics import runge_kutta
from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.numerics.runge_kutta import EventOutcome, Interval, State
from vibecalc.numerics.runge_kutta_march import fine, march, sample


class System:
    """Rates with kinks where linear combinations of the states pass given values.

    `rates(time (b,), state (b, n), interval (b, w)) -> (b, n)`, smooth for a fixed interval: number
    i of combination k means values[k][i - 1] <= combination[k] @ state <= values[k][i].
    `combination` (w, n); `values` w ascending arrays. Without any it is smooth.
    """

    def __init__(
        self,
        rates: Callable[[FloatArray, FloatArray, IntArray], FloatArray],
        combination: FloatArray | None = None,
        values: tuple[FloatArray, ...] = (),
        closeness: float = 0.0,
    ):
        self._rates = rates
        self._combination = combination
        self._edges = [np.concatenate([[-np.inf], row, [np.inf]]) for row in values]
        self.closeness = [closeness] * len(values)
        self.leading = 0 if combination is None else combination.shape[1]

    def rates(self, time: float, state: State, interval: Interval) -> State:
        pieces = np.array([interval], dtype=np.int64)
        found: State = self._rates(np.array([time]), np.array([state]), pieces)[0].tolist()
        return found

    def watched(self, time: float, state: Sequence[float], interval: Interval) -> list[float]:
        if self._combination is None:
            return []
        found: list[float] = (self._combination @ np.array(state)).tolist()
        return found

    def borders(self, interval: Interval) -> tuple[list[float], list[float]]:
        both = list(zip(self._edges, interval, strict=False))
        return [float(e[k]) for e, k in both], [float(e[k + 1]) for e, k in both]

    def crossed(
        self,
        member: int,
        time: float,
        state: State,
        interval: Interval,
        which: int,
        direction: int,
    ) -> EventOutcome:
        moved = [k + direction * (place == which) for place, k in enumerate(interval)]
        return EventOutcome(state, moved, False)

    def stopped(self, member: int, time: float, state: State, interval: Interval) -> EventOutcome:
        return EventOutcome(state, interval, False)

    def intervals_at(self, state: FloatArray) -> IntArray:
        """The intervals (b, w) of the states; a value on a border belongs to the one above it."""
        value = np.array([self.watched(0.0, row.tolist(), []) for row in state])
        columns = [
            np.searchsorted(edge[1:-1], value[:, k], side="right")
            for k, edge in enumerate(self._edges)
        ]
        return np.stack(columns, axis=1).astype(np.int64)


def bilinear(stiff: float = 4.0) -> System:
    """x'' = -x below zero and -stiff x above: half a period each of pi and pi / sqrt(stiff)."""

    def rates(time: np.ndarray, state: np.ndarray, piece: np.ndarray) -> np.ndarray:
        spring = np.where(piece[:, 0] == 0, 1.0, stiff)
        return np.stack([state[:, 1], -spring * state[:, 0]], axis=1)

    return System(rates, np.array([[1.0, 0.0]]), (np.array([0.0]),), 1e-13)


NO_PIECE = np.zeros((1, 0), dtype=np.int64)
PENDULUM = System(lambda t, y, _: np.stack([y[:, 1], -np.sin(y[:, 0])], axis=1))


@pytest.mark.long
@pytest.mark.parametrize("swing", [0.3, 1.5, 3.0])
def test_a_pendulum_keeps_its_energy_and_its_elliptic_period(swing: float) -> None:
    period = float(4 * mpmath.ellipk(mpmath.sin(mpmath.mpf(swing) / 2) ** 2))
    start = np.array([[swing, 0.0]])
    found = march(PENDULUM, np.zeros(1), start, NO_PIECE, np.array([3 * period]), absolute=1e-11)
    assert np.max(np.abs(found.state - start)) < 3e-8
    times, sampled = fine(found.record, 0, 4)
    energy = 0.5 * sampled.state[:, 1] ** 2 - np.cos(sampled.state[:, 0])
    assert np.all(np.diff(times) >= 0.0)
    assert np.max(np.abs(energy + np.cos(swing))) < 1e-8


def test_each_member_is_what_it_is_alone() -> None:
    system, count = bilinear(), 7
    rng = np.random.default_rng(5)
    start = rng.normal(size=(count, 2))
    begin, end = rng.uniform(0, 1, count), rng.uniform(3, 9, count)
    stops = np.sort(rng.uniform(1, 8, (count, 2)), axis=1)
    interval = system.intervals_at(start)
    both = march(system, begin, start, interval, end, absolute=1e-8, stops=stops)
    for k in range(count):
        one = march(
            system, begin[[k]], start[[k]], interval[[k]], end[[k]], absolute=1e-8, stops=stops[[k]]
        )
        assert one.steps[0] == both.steps[k] and one.rejected[0] == both.rejected[k]
        assert np.max(np.abs(one.state[0] - both.state[k])) < 1e-13
        times = np.linspace(begin[k], end[k], 50)
        gap = sample(one.record, 0, times).state - sample(both.record, k, times).state
        assert np.max(np.abs(gap)) < 1e-12


def test_steps_end_exactly_on_the_times_given() -> None:
    stops = np.array([[0.1, 1.0 / 3.0, 2.0, np.inf]])
    met: list[float] = []

    class Telling(System):
        def stopped(
            self, member: int, time: float, state: State, interval: Interval
        ) -> EventOutcome:
            met.append(time)
            return EventOutcome(state, interval, time >= 2.0)

    system = Telling(lambda t, y, _: -y)
    found = march(
        system, np.zeros(1), np.ones((1, 1)), NO_PIECE, np.array([5.0]), absolute=1e-9, stops=stops
    )
    assert met == stops[0, :3].tolist()
    assert found.finished[0] and found.time[0] == 2.0
    assert found.state[0, 0] == pytest.approx(np.exp(-2.0), abs=1e-8)


def test_borders_are_met_to_their_closeness_and_no_step_has_one_inside() -> None:
    nodes = np.linspace(-2.0, 2.0, 9)
    system = System(
        lambda t, y, p: np.stack([y[:, 1], -y[:, 0]], axis=1),
        np.array([[1.0, 0.0]]),
        (nodes,),
        1e-11,
    )
    start = np.array([[1.9, 0.0]])
    found = march(
        system, np.zeros(1), start, system.intervals_at(start), np.array([12.0]), absolute=1e-9
    )
    record = found.record
    assert record is not None
    _, sampled = fine(record, 0, 8)
    edges = np.concatenate([[-np.inf], nodes, [np.inf]])
    interval = record.interval[sampled.step, 0]
    assert np.all(sampled.state[:, 0] > edges[interval] - 3e-11)
    assert np.all(sampled.state[:, 0] < edges[interval + 1] + 3e-11)
    # 1.9 cos t meets each of the 7 nodes inside it 4 times less the way that is cut off at t = 12
    count = sum(
        np.sum(np.diff(np.sign(1.9 * np.cos(np.linspace(0, 12, 100001)) - n)) != 0) for n in nodes
    )
    assert np.sum(np.diff(record.interval[:, 0]) != 0) == count


@pytest.mark.long
def test_a_solution_that_blows_up_is_refused() -> None:
    system = System(lambda t, y, _: y * y)
    with pytest.raises(NumericalFailure, match="no step is short enough at time 1"):
        march(system, np.zeros(1), np.ones((1, 1)), NO_PIECE, np.array([2.0]), absolute=1e-4)


def test_rates_that_push_onto_a_border_from_both_sides_are_refused() -> None:
    system = System(
        lambda t, y, p: np.where(p == 0, 1.0, -1.0), np.ones((1, 1)), (np.zeros(1),), 1e-12
    )
    with pytest.raises(NumericalFailure, match="changes for ever at time"):
        march(
            system, np.zeros(1), np.array([[0.5]]), np.array([[1]]), np.array([2.0]), absolute=1e-8
        )


def test_too_many_steps_are_refused() -> None:
    with pytest.raises(NumericalFailure, match="after 20 sweeps"):
        march(
            PENDULUM, np.zeros(1), np.array([[1.0, 0.0]]), NO_PIECE, np.array([100.0]),
            absolute=1e-10, sweeps=20,
        )  # fmt: skip


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

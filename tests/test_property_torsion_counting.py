"""Claim: error estimates, soft starts and sliding envelopes of a transient behave as they must;
cycles of a section are those of the standard, and use up what S-N lines say.
"""

import numpy as np
import pytest
from torsion_lines import engine

from vibecalc.torsion.line import chain
from vibecalc.torsion.transient import march as transient_pieces
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import TorqueInTime, stretch
from vibecalc.torsion.transient.trace import (
    Cycles,
    Strength,
    equivalent_number,
    extremes,
    miner_sum,
    rainflow_cycles,
    range_table,
    samples,
    section_peaks,
    sliding,
    slope_below,
    traces,
)


def of(values: list[float] | np.ndarray, error: float = 0.0, ignore: float = 0.0) -> Cycles:
    value = np.asarray(values, dtype=float)
    return rainflow_cycles(value, np.full(value.size, error), ignore)


def test_the_example_of_the_standard() -> None:
    # ASTM E1049-85, figure 6: range 3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5 cycles
    found = of([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    sums = {one: found.number[found.range == one].sum() for one in np.unique(found.range)}
    assert sums == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    assert found.mean[found.range == 9.0] == [0.5]


def test_a_table_keeps_numbers_and_means() -> None:
    random = np.random.default_rng(3)
    found = of(random.uniform(0.1, 1.0, 200) * (-1.0) ** np.arange(200) + 3.0)
    table = range_table(found, 12)
    assert table.number.sum() == pytest.approx(found.number.sum(), rel=1e-14)
    assert table.number @ table.mean == pytest.approx(found.number @ found.mean, rel=1e-12)
    assert table.range[-1] == found.range.max()
    upper = np.array([found.number[found.range <= one].sum() for one in table.range])
    np.testing.assert_allclose(np.cumsum(table.number), upper, rtol=1e-14)


def test_what_may_lie_on_either_side_of_a_border_is_an_error() -> None:
    found = of([0.0, 10.0, 5.0 + 1e-9, 10.0, 0.0], error=1e-8)
    table = range_table(found, 2)
    assert table.error.max() >= 1.0
    assert range_table(of([0.0, 10.0, 4.0, 10.0, 0.0], error=1e-8), 2).error.max() == 0.0


@pytest.mark.parametrize(
    ("rule", "share", "expected"),
    [
        ("elementary", 2.0, 2.0**5),
        ("elementary", 0.5, 0.5**5),
        ("haibach", 2.0, 2.0**5),
        ("haibach", 0.5, 0.5**9),
        ("original", 2.0, 2.0**5),
        ("original", 0.5, 0.0),
    ],
)
def test_equal_cycles(rule: str, share: float, expected: float) -> None:
    amplitude, count = 40.0, 1000
    values = share * amplitude * (-1.0) ** np.arange(2 * count + 1)
    found = of(values)
    strength = Strength(amplitude, 1e6, 5.0, slope_below(5.0, rule))
    damage, error = miner_sum(found, strength)
    assert damage == pytest.approx(count * expected / 1e6, rel=1e-12)
    assert error <= 1e-12 * max(damage, 1.0)
    equal, _ = equivalent_number(found, strength)
    assert equal == pytest.approx(count if expected else 0.0, rel=1e-12)


def test_equivalent_cycles_take_the_line_on_both_sides_of_its_knee() -> None:
    signs = (-1.0) ** np.arange(2 * 7 + 1), (-1.0) ** np.arange(2 * 900 + 1)
    found = of(np.concatenate([80.0 * signs[0], 20.0 * signs[1]]))
    number, error = equivalent_number(found, Strength(40.0, 1e6, 5.0, slope_below(5.0, "haibach")))
    share = found.range / 80.0
    damage = found.number * np.where(share >= 1.0, share**5, share**9)
    assert number == pytest.approx(damage.sum() / 2.0**5, rel=1e-12) and number > 7.0
    assert error < 1e-9


def test_doubt_of_the_reversals_is_one_of_the_damage() -> None:
    values = 40.0 * (-1.0) ** np.arange(101)
    strength = Strength(40.0, 1e6, 7.0, np.inf)
    at_knee = miner_sum(of(values, error=1e-6), Strength(40.0 + 1e-7, 1e6, 7.0, np.inf))
    exact = miner_sum(of(values), strength)[0]
    assert abs(at_knee[0] - exact) <= at_knee[1]
    above = miner_sum(of(values + np.where(values > 0.0, 1e-3, 0.0), error=1e-3), strength)
    assert abs(above[0] - exact) <= above[1]


def test_small_cycles_can_be_left_out() -> None:
    found = of([0.0, 10.0, 9.95, 10.0, 0.0], ignore=0.01)
    assert found.range.min() == 10.0


def test_reversals_of_a_run_are_its_crests_and_troughs() -> None:
    line = chain(np.array([2.0, 3.0, 1.0]), np.array([4000.0, 9000.0]))
    none = np.zeros(0, dtype=complex)
    torque = TorqueInTime(np.array([0.0, 0.0, -1.0]), none, none, 70.0)
    gas = np.array([[30.0 + 5j, 8.0], [0.0, 0.0], [0.0, 0.0]])
    parts = [stretch(1.0, 0.0, gas), stretch(1.5, 3.0, gas)._replace(in_time=torque)]
    run = transient(line, np.array([1.0, 2.5]), parts, 30.0)
    history = samples(run, 0.0, 2.5, finer=40)
    for section, trace in enumerate(traces(run)):
        rises = np.diff(trace.value) > 0.0
        turning = np.concatenate([[True], rises[1:] != rises[:-1], [True]])
        found, error = trace.value[turning], trace.error[turning]
        value = history.value[:, section]
        inner = value[1:-1]
        turns = ((inner > value[:-2]) & (inner >= value[2:])) | (
            (inner < value[:-2]) & (inner <= value[2:])
        )
        expected = np.concatenate([value[:1], inner[turns], value[-1:]])
        assert found.size == expected.size
        assert np.all(np.abs(found - expected) <= error + 2e-4 * np.abs(value).max())


CYCLE = 4.0 * np.pi
ORDERS = np.arange(1, 17) / 2
LINE = chain(np.array([18.0, 19.0, 18.0, 900.0]), np.array([22e6, 21e6, 19e6]))._replace(
    damping=np.array([900.0, 800.0, 800.0])
)


def gas(orders: np.ndarray, stations: int, fires: dict[int, int]) -> np.ndarray:
    """Torques (stations, m), each of its station after as many sixths of a turn."""
    found = np.zeros((stations, orders.size), dtype=complex)
    for station, place in fires.items():
        found[station] = 3000.0 / orders * np.exp(-1j * orders * place * np.pi / 3.0)
    return found


THREE, TWO = gas(ORDERS, 4, {0: 0, 1: 8, 2: 4}), gas(ORDERS, 4, {0: 0, 2: 4})


def test_error_estimates_bound_the_error_and_the_order_is_high(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    line = engine(damper=True)._replace(damping=np.array([2000.0] + [800.0] * 6))
    orders = np.arange(1, 31) / 2
    part = stretch(1.0, 40.0, gas(orders, 8, {1: 0, 2: 8, 3: 4, 4: 10, 5: 2, 6: 6}))

    def ends(length: float) -> TransientRun:
        monkeypatch.setattr(transient_pieces, "ORDER_STEP", length)
        monkeypatch.setattr(transient_pieces, "MODE_STEP", 6.0 * length)
        return transient(line, orders, [part], 100.0, rtol=np.inf)

    exact = ends(0.5)
    errors = []
    for length in (4.0, 8.0):
        run = ends(length)
        gap = (run.states[-1][-1] - exact.states[-1][-1]) @ exact.system.torque.T
        assert np.all(np.abs(gap) <= run.torque_error + exact.torque_error)
        errors.append(np.abs(gap).max())
    # sixteen radians of the highest order in a step of the rough march: still distinguished
    assert errors[1] > 2**9 * errors[0]


def test_start_from_rest_ramps_the_torque_in() -> None:
    line = chain(np.array([2.0, 3.0]), np.array([4000.0]))._replace(damping=np.array([2.8]))
    grip, order = np.array([[40.0, 50.0], [0.0, 0.0]], dtype=complex), np.array([0.0, 1.0])
    ramp = [stretch(2.0, 5.0, grip, scale=(0.0, 1.0)), stretch(2.0, 5.0, grip)]
    soft = transient(line, order, ramp, 0.0)
    hard = transient(line, order, [stretch(4.0, 5.0, grip)], 0.0)
    early = [np.abs(run.states[0][:40] @ run.system.torque.T).max() for run in (soft, hard)]
    assert early[0] < 0.2 * early[1]
    assert soft.course.speed[-1] == pytest.approx(20.0) and soft.course.time.size == 3


def test_a_steady_motion_has_a_flat_envelope() -> None:
    run = transient(LINE, ORDERS, [stretch(1.0, 0.0, THREE)], 83.0, start="steady")
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
    """A misfire sets in within a cycle."""
    parts = [stretch(0.4, 0.0, THREE), stretch(1.6, 0.0, TWO)]
    run = transient(LINE, ORDERS, parts, 83.0, start="steady")
    few = sliding(run.course, CYCLE, 4)
    assert few is not None
    seen = traces(run, np.concatenate(few))
    peaks = section_peaks(run, seen)
    for section, trace in enumerate(seen):
        low, high, _ = extremes(trace, few.begin, few.end)
        assert max(high.max(), -low.min()) == pytest.approx(peaks.peak[section], rel=1e-5)
    short = transient(LINE, ORDERS, [stretch(0.1, 0.0, THREE)], 83.0, start="steady")
    assert sliding(short.course, CYCLE) is None

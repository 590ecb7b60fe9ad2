"""Gas torque from tables of tangential effort: as from cards, by hand, row by row."""

import copy
import tomllib
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from effort_tables import OVER_SPEED, ROWS, from_cards, swept_volume, table
from engine_cases import CARD, ENGINE
from engine_cases import ran as of_text
from shipped_cases import CASES

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import card_weights
from vibecalc.excitation.tangential_effort import effort_table, effort_torque
from vibecalc.schema import Case
from vibecalc.torsion.adapters.setup import build_setup
from vibecalc.torsion.adapters.transient_motion import torques

ROOT = "response/torsion/"
SAME = 1e-12
ORDERS = 9


def engine(**train: Any) -> dict[str, Any]:
    """Three in line, a two-mass damper in front, with other keys of its crank train."""
    data = tomllib.loads(ENGINE.replace(CARD + "\n", ""))
    data["machine"]["crank_train"] |= copy.deepcopy(train)
    return data


def effort(rows: Sequence[tuple[float, ...]] = ROWS, **load: Any) -> dict[str, Any]:
    return {"tangential_effort": {"harmonics": table(rows)} | load}


def ran(data: dict[str, Any]) -> Record:
    return run_case(validate(data))


@cache
def both() -> tuple[Case, Case]:
    """The shipped marine line by its four cards, and by a table of their harmonics."""
    data = copy.deepcopy(load_case(CASES["marine_propulsion"]).resolved)
    for key in ("limit", "reference", "reference_table"):
        data.pop(key, None)
    torsion = data["response"]["torsion"]
    torsion |= {"orders": {"step": 1, "count": ORDERS}, "limits": [], "misfire": ["2"],
                "conditions": {"misfire": "each", "imbalance": 0.1}}  # fmt: skip
    torsion["speeds"] |= {"points": 9}
    for key in ("curves", "irregularity", "transient"):
        torsion.pop(key, None)
    cards = validate(data)
    orders = np.arange(1.0, ORDERS + 1)
    return cards, validate(from_cards(data, cards.machine, orders))


@pytest.mark.long
def test_a_table_of_the_harmonics_of_cards_is_these_cards() -> None:
    cards, effort_ = (run_case(case).quantities for case in both())
    left_out = {f"{ROOT}excitation/pressure"}
    assert set(cards) - set(effort_) == left_out and not set(effort_) - set(cards)
    over_the_angle = {f"{ROOT}excitation/{name}_torque" for name in ("gas", "total")}
    compared = 0
    for path in sorted(set(effort_) - over_the_angle):
        old, new = (np.asarray(one[path].values) for one in (cards, effort_))
        if old.dtype.kind not in "fc" or not path.startswith(ROOT):
            continue
        assert np.array_equal(np.isfinite(old), np.isfinite(new)), path
        finite = np.isfinite(old)
        size = np.max(np.abs(old[finite]), initial=0.0)
        # where a flat maximum stands is known to half the digits
        near = 1e-7 if path.endswith("speed") else SAME
        assert np.max(np.abs(new[finite] - old[finite]), initial=0.0) <= near * size, path
        compared += 1
    assert compared > 30
    for name in ("torque_half_range", "angle", "speeds/torque_half_range", "healthy/mean_torque",
                 "excitation/mean_indicated_pressure", "conditions/torque_half_range"):  # fmt: skip
        assert ROOT + name in effort_, name


def test_a_run_in_time_takes_the_table_as_the_cards() -> None:
    setups = [build_setup(case) for case in both()]
    for speed in (0.0, 2.0, 5.5, 9.42, 12.0, 20.0):
        (gas, inertia), (gas_, inertia_) = (torques(one, speed) for one in setups)
        assert np.max(np.abs(gas - gas_)) <= SAME * np.max(np.abs(gas))
        assert np.array_equal(inertia, inertia_)


@pytest.mark.parametrize("cycle", ["four_stroke", "two_stroke"])
def test_mean_torque_is_pressure_times_swept_volume_over_the_cycle(cycle: str) -> None:
    rows = [row for row in ROWS if row[1] % (0.5 if cycle == "four_stroke" else 1.0) == 0.0]
    data = engine(wrist_pin_offset=0.01, **effort(rows, mean_indicated_pressure="9 bar"))
    data["machine"]["cycle"] = cycle
    if cycle == "two_stroke":
        data["response"]["torsion"]["misfire"] = ["3"]
    record, machine = ran(data), validate(data).machine
    firing, angle = (3.0, 4.0 * np.pi) if cycle == "four_stroke" else (2.0, 2.0 * np.pi)
    mean = firing * 9e5 * swept_volume(machine) / angle
    own = float(record[f"{ROOT}excitation/mean_torque"].values)
    assert own == pytest.approx(mean, rel=1e-14)
    pressure = record[f"{ROOT}excitation/mean_indicated_pressure"]
    assert abs(float(pressure.values) - 9e5) <= pressure.error_estimate <= 1e-6


def test_torque_over_the_angle_is_the_sum_of_the_rows() -> None:
    record = ran(engine(**effort(mean_indicated_pressure="12 bar")))
    angle = record[f"{ROOT}excitation/gas_torque"].axes[0].values
    machine = validate(engine(**effort(mean_indicated_pressure="12 bar"))).machine
    lever = 0.25 * np.pi * 0.1**2 * 0.06
    expected = np.full(len(angle), 12e5 * swept_volume(machine) / (4.0 * np.pi))
    for load, order, cosine, sine in ROWS:
        if load == 12e5:
            turn = order * np.asarray(angle)
            expected = expected + lever * (cosine * np.cos(turn) + sine * np.sin(turn))
    own = record[f"{ROOT}excitation/gas_torque"]
    assert np.max(np.abs(own.values - expected)) <= 2.0 * own.error_estimate
    assert own.error_estimate < 1e-10


def by_hand(rows: Sequence[tuple[float, ...]], load: float, order: float) -> complex:
    """a - i b at a load, straight between its neighbours."""
    own = sorted((row[0], row[2] - 1j * row[3]) for row in rows if row[1] == order)
    for (low, first), (high, last) in pairwise(own):
        if low <= load <= high:
            return first + (last - first) * (load - low) / (high - low)
    raise AssertionError


def test_two_loads_and_two_speeds_by_hand() -> None:
    found = effort_torque(
        effort_table([2e5, 1e5], [1.0, 1.0], [40e5, 10e5], [-6e5, 6e5]),
        [10.0, 30.0], [1.2e5, 1.6e5], [0.5, 1.0], lever=1e-3, swept_volume=2e-3, cycle=4.0,
    )  # fmt: skip
    assert found.speed.tolist() == [10.0, 30.0]
    # a: 10, 16, 28, 40 bar at 1, 1.2, 1.6, 2 bar of load; b: 6, 3.6, -1.2, -6 bar
    assert found.gas.value[:, 1] == pytest.approx([1600.0 - 360.0j, 2800.0 + 120.0j], rel=1e-14)
    assert found.mean.value == pytest.approx([60.0, 80.0], rel=1e-14)
    assert not np.any(found.gas.value[:, 0]) and not np.any(found.gas.error[:, 0])
    middle = card_weights(found.speed, 15.0) @ found.gas.value[:, 1]
    assert middle == pytest.approx(1900.0 - 240.0j, rel=1e-14)


@pytest.mark.parametrize("load", [[5e5, 19e5], [6e5, 18e5, 4e5, 12e5], [4e5, 20e5], [7e5, 8e5]])
def test_between_speeds_each_row_of_the_table_is_met(load: list[float]) -> None:
    speed = 100.0 + 37.0 * np.arange(len(load))
    orders = np.arange(0.5, 6.1, 0.5)
    columns = [list(one) for one in zip(*ROWS[::-1], strict=True)]
    found = effort_torque(effort_table(*columns), speed, load, orders, lever=1.0,
                          swept_volume=1.0, cycle=1.0)  # fmt: skip
    assert set(speed.tolist()) <= set(found.speed.tolist())
    for at in np.linspace(speed[0], speed[-1], 201):
        own = card_weights(found.speed, at)
        p = float(np.interp(at, speed, load))
        expected = np.array([by_hand(ROWS, p, order) for order in orders])
        off = own @ found.gas.error
        assert np.all(np.abs(own @ found.gas.value - expected) <= off + 1e-15 * abs(expected))
        assert np.all(off < 1e-12 * np.max(np.abs(expected)))
        assert own @ found.mean.value == pytest.approx(p, rel=1e-14)


@pytest.mark.parametrize("load", [[3.9e5], [20.1e5]])
def test_beyond_the_loads_of_the_table_nothing_is_extrapolated(load: list[float]) -> None:
    columns = [list(one) for one in zip(*ROWS, strict=True)]
    with pytest.raises(NumericalFailure, match="not inside the table, 4 to 20 bar"):
        effort_torque(effort_table(*columns), [], load, [1.0], lever=1.0, swept_volume=1.0,
                      cycle=1.0)  # fmt: skip


@pytest.mark.long
def test_orders_left_out_are_told_as_far_as_the_table_has_them() -> None:
    def warned(highest: int, rows: Sequence[tuple[float, ...]]) -> str:
        data = engine(**effort(rows, over_speed=OVER_SPEED))
        data["response"]["torsion"]["orders"] = {"highest": highest}
        return " ".join(ran(data).warnings)

    assert "the orders above 4, up to 8 (of the gas up to 6, where its table ends), are" in (
        warned(4, ROWS)
    )
    assert "the orders above 3, up to 6, are neglected" in warned(3, ROWS)
    assert "has no order" not in warned(3, ROWS)
    # without gas at them, nothing but the small orders of the masses is left out
    assert "orders above 6" not in warned(6, ROWS)


def test_report_and_picture_say_what_there_is() -> None:
    pytest.importorskip("matplotlib")
    from vibecalc.core.report.plots import make
    from vibecalc.core.report.text import render_report

    columns = ", ".join(f"{name} = {value}" for name, value in table(ROWS).items())
    load = 'mean_indicated_pressure = "12 bar"'
    effort_ = f"tangential_effort = {{ {load}, harmonics = {{ {columns} }} }}"
    result = of_text(ENGINE.replace(CARD, effort_))
    said = " ".join(render_report(result, full=True).split())
    words = "gas tangential effort over mean indicated pressure; mean indicated pressure 12"
    assert words in said
    figure = make(result, "torsion_excitation")
    assert figure is not None
    one, fast, all_ = figure.axes
    labels = [[line.get_label() for line in axes.get_lines()] for axes in figure.axes]
    assert all("card" not in row for row in labels)
    gas = next(line for line in one.get_lines() if line.get_label() == "gas")
    own = np.asarray(result.record[f"{ROOT}excitation/gas_torque"].values)
    np.testing.assert_allclose(np.asarray(gas.get_ydata()), own, rtol=1e-12)
    assert "1-3-2" in all_.get_title(loc="left") and "rpm" in fast.get_title(loc="left")


def test_half_orders_that_a_table_lacks_are_told() -> None:
    data = engine(**effort([row for row in ROWS if row[1] % 1.0 == 0.0], over_speed=OVER_SPEED))
    data["response"]["torsion"]["orders"] = {"step": 1, "count": 6}
    said = " ".join(ran(data).warnings)
    assert "has no order 0.5, 1.5, 2.5, ...: this gas excitation is neglected" in said

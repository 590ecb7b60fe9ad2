"""Claim: `where` picks the entries it names, in any unit, and says what exists if it cannot."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sample_results import DIRECTION, MOUNT, ORDER, SPEED, quantity

from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.results.select import scalar, select, worst
from vibecalc.errors import ResultError

FORCE = quantity("isolation/force", (MOUNT, DIRECTION, ORDER), is_complex=True)
CURVE = quantity("isolation/run_up", (SPEED,))


@given(st.integers(0, 2), st.integers(0, 2), st.integers(0, 9))
def test_every_entry_is_found_by_its_labels(mount: int, direction: int, order: int) -> None:
    where = {
        "order": float(ORDER.values[order]),
        "mount": str(MOUNT.values[mount]),
        "direction": str(DIRECTION.values[direction]),
    }
    assert scalar(FORCE, where) == FORCE.values[mount, direction, order]


def test_axes_left_free_keep_their_place_and_labels() -> None:
    picked = select(FORCE, {"direction": "z"})
    assert np.array_equal(picked.values, FORCE.values[:, 2, :])
    assert len(picked.labels) == picked.values.size
    assert picked.labels[0] == picked.label(0) == "mount=left front, direction=z, order=1"
    assert picked.labels[11] == picked.label(11) == "mount=höger, direction=z, order=2"
    assert select(quantity("a/b"), {}).labels == ("",)


def test_names_may_be_written_as_numbers_and_numbers_as_text() -> None:
    assert np.array_equal(select(FORCE, {"mount": 3}).values, FORCE.values[2])
    assert np.array_equal(select(FORCE, {"order": "2"}).values, FORCE.values[:, :, 1])


def test_units_are_converted() -> None:
    speed = replace(SPEED, values=np.array([0.0, 4900 * 2 * math.pi / 60, 513.0]))
    curve = replace(CURVE, axes=(speed,), values=np.array([1.0, 2.0, 3.0]))
    assert scalar(curve, {"speed": "4900 rpm"}) == 2.0
    assert scalar(curve, {"speed": 513.0 * (1 + 9e-10)}) == 3.0
    with pytest.raises(ResultError, match="there is 513 rad/s, "):
        scalar(curve, {"speed": 513.0 * (1 + 2e-9)})
    with pytest.raises(ResultError, match="speed = '3 kg' cannot be read"):
        scalar(curve, {"speed": "3 kg"})


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ({"mont": 1}, "isolation/force has no axis 'mont'; it has mount, direction, order"),
        ({"direction": "X"}, "no entry direction = 'X'; there is x, y, z"),
        ({"mount": "left frnt"}, "no entry mount = 'left frnt'; there is left front, höger, 3"),
        ({"order": 11}, "no entry order = 11; there is 10, 9, 8"),
        ({"order": True}, "no entry order = True"),
        ({"mount": True}, "no entry mount = True"),
        ({"order": math.nan}, "no entry order = nan"),
        ({"order": "first"}, "order = 'first' cannot be read"),
    ],
)
def test_what_does_not_exist(where: dict[str, int | float | str], words: str) -> None:
    with pytest.raises(ResultError) as caught:
        select(FORCE, where)
    assert words in str(caught.value)


def test_one_number_is_asked_for() -> None:
    with pytest.raises(ResultError) as caught:
        scalar(FORCE, {"mount": 3, "order": 1})
    assert str(caught.value) == (
        "isolation/force has 3 entries here, one is needed: name also direction (x, y, z)"
    )
    with pytest.raises(ResultError, match="is one number, it has no axis 'order'"):
        scalar(quantity("a/b"), {"order": 1})
    with pytest.raises(ResultError, match="holds names"):
        scalar(replace(quantity("a/b"), values=np.array("stiffness")), {})


@given(st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=9))
def test_the_worst_entry_is_the_extreme_one(entries: list[float]) -> None:
    axis = Axis(name="order", values=np.arange(len(entries)))
    one = replace(quantity("a/b", (axis,)), values=np.array(entries))
    for sense, extreme in (("max", max(entries)), ("min", min(entries))):
        value, label = worst(one, {}, sense)
        assert value == extreme
        assert label == f"order={entries.index(extreme)}"


def test_complex_entries_count_by_magnitude_and_nan_as_worst() -> None:
    value, label = worst(FORCE, {"mount": 3}, "max")
    assert value == np.abs(FORCE.values[2]).max()
    assert label.startswith("mount=3, direction=")
    one = replace(quantity("a/b", (DIRECTION,)), values=np.array([1.0, math.nan, math.inf]))
    for sense in ("max", "min"):
        value, label = worst(one, {}, sense)
        assert math.isnan(value)
        assert label == "direction=y"
    empty = replace(quantity("a/b", (replace(ORDER, values=ORDER.values[:0]),)))
    with pytest.raises(ResultError, match="no entries"):
        worst(empty, {}, "max")
    with pytest.raises(ResultError, match="there is no entry at all"):
        select(empty, {"order": 1})


def sampled(values: np.ndarray, at: np.ndarray) -> Quantity:
    return replace(CURVE, axes=(replace(SPEED, values=at),), values=values)


@given(st.floats(2.0, 40.0), st.floats(1e-2, 0.2))
def test_between_two_speeds_a_curve_is_a_straight_line_with_its_error(
    wanted: float, step: float
) -> None:
    at = np.arange(1.0, 41.0 + step, step)
    curve = sampled(np.sin(at), at)
    where = {"speed": wanted}
    found = scalar(curve, where)
    assert found == pytest.approx(np.interp(wanted, at, np.sin(at)), abs=3e-9)
    off = abs(found - np.sin(wanted))
    # the next terms of the polynomial, and how close a speed is that of a sample
    assert off <= select(curve, where).curving + 0.05 * step**4 + 5e-8
    assert select(curve, where).curving <= 0.13 * step**2 + 1e-14
    assert worst(curve, where, "max") == (found, f"speed={wanted:.9g} rad/s") or off == 0.0


def test_between_speeds_of_some_sections_with_gaps_and_whole_numbers() -> None:
    at = np.array([10.0, 20.0, 30.0, 40.0])
    rows = quantity("isolation/force", (MOUNT, SPEED))
    rows = replace(rows, axes=(MOUNT, replace(SPEED, values=at)),
                   values=np.array([at, 2.0 * at, at**2]))  # fmt: skip
    assert np.array_equal(select(rows, {"speed": 25.0}).values, [25.0, 50.0, 650.0])
    assert scalar(rows, {"speed": "25 rad/s", "mount": 3}) == 650.0
    assert select(rows, {"speed": 25.0, "mount": 3}).curving == pytest.approx(25.0)
    assert select(rows, {"speed": 25.0, "mount": "left front"}).curving == pytest.approx(
        0.0, abs=1e-12
    )
    assert select(rows, {"speed": 20.0}).curving == 0.0
    endless = sampled(np.array([1.0, np.inf, 3.0, 4.0]), at)
    assert scalar(endless, {"speed": 12.0}) == np.inf
    assert scalar(endless, {"speed": 35.0}) == 3.5 == select(endless, {"speed": 35.0}).curving
    with pytest.raises(ResultError, match="no entry speed = 15"):
        scalar(sampled(np.array([1, 2, 3, 4]), at), {"speed": 15.0})
    with pytest.raises(ResultError, match="no entry speed = 41"):
        scalar(endless, {"speed": 41.0})

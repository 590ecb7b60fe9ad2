"""Claim: `where` picks the entries it names, in any unit, and says what exists if it cannot."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sample_results import DIRECTION, MOUNT, ORDER, SPEED, quantity

from vibecalc.errors import ResultError
from vibecalc.results.record import Axis
from vibecalc.results.select import scalar, select, worst

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
    values, labels = select(FORCE, {"direction": "z"})
    assert np.array_equal(values, FORCE.values[:, 2, :])
    assert len(labels) == values.size
    assert labels[0] == "mount=left front, direction=z, order=1"
    assert labels[11] == "mount=höger, direction=z, order=2"
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

"""Claim: the comparison sees a change of the physics, and nothing else."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_results import (
    COORDINATE,
    DIRECTION,
    MODE,
    MOUNT,
    ORDER,
    changed,
    quantity,
    result_of,
    typical,
    with_quantities,
)

from vibecalc.core.report.differences import differences_object, render_differences, render_junit
from vibecalc.core.results.compare import ComparedRow, Comparison, FilePair, compare
from vibecalc.core.results.compare_rules import Rule, Rules
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.errors import UsageError

INFINITY = math.inf


def only(comparison: Comparison) -> ComparedRow:
    assert len(comparison.rows) == 1
    return comparison.rows[0]


def ruled(**keys: Any) -> Rules:
    return Rules(rules=(Rule(quantity="*", **keys),))


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    size=st.floats(1e-30, 1e30),
    ratio=st.floats(0.01, 100.0).filter(lambda ratio: abs(ratio - 1) > 1e-3),
    is_complex=st.booleans(),
)
def test_the_tolerance_is_where_it_says(
    seed: int, size: float, ratio: float, is_complex: bool
) -> None:
    """One entry changed by `ratio` times rtol * scale + errors differs exactly if ratio > 1."""
    generator = np.random.default_rng(seed)
    one = quantity("a/b", (MOUNT, ORDER), seed=seed, is_complex=is_complex)
    one = replace(one, values=one.values * size, error_estimate=1e-9 * size)
    place = tuple(generator.integers(one.values.shape))
    allowed = 1e-7 * np.abs(one.values[:, place[1]]).max() + 2e-9 * size  # of its own order
    turn = np.exp(2j * np.pi * generator.random()) if is_complex else generator.choice([-1, 1])
    values = one.values.copy()
    values[place] += ratio * allowed * turn
    row = only(compare(result_of(one), result_of(replace(one, values=values))))
    assert row.same == (ratio <= 1)
    assert row.ratio == pytest.approx(ratio, rel=1e-4)
    assert row.failed == int(ratio > 1)
    if ratio > 1:
        assert row.entry == f"mount={MOUNT.values[place[0]]}, order={ORDER.values[place[1]]}"
        assert row.reference == one.values[place]
        assert row.value == values[place]


@pytest.mark.parametrize("estimate", [1.0, 1e300, math.inf])
def test_a_worse_error_estimate_is_no_excuse(estimate: float) -> None:
    """A value twice as large does not pass because it says that it knows nothing of itself."""
    one = replace(quantity("a/b", (ORDER,)), error_estimate=1e-13)
    other = replace(one, values=2.0 * one.values, error_estimate=estimate)
    assert only(compare(result_of(one), result_of(other))).failed == 10
    coarse = replace(one, error_estimate=math.inf)
    assert only(compare(result_of(coarse), result_of(other))).failed == 10


def test_a_reference_that_knows_less_is_met_by_a_better_value() -> None:
    one = replace(quantity("a/b", (ORDER,)), error_estimate=1e-3)
    other = replace(one, values=one.values + 1e-3, error_estimate=1e-13)
    assert compare(result_of(one), result_of(other)).same


def test_what_cancels_is_compared_with_its_terms() -> None:
    """A zero by symmetry keeps no digit; only the reference says what it is the sum of."""
    one = replace(quantity("a/b", (ORDER,)), values=np.full(10, 1e-11), error_estimate=1e-11)
    near, far = (replace(one, values=one.values + off) for off in (4e-10, 2e-9))
    known = replace(one, terms=1e4)
    assert not compare(result_of(one), result_of(near)).same
    assert not compare(result_of(one), result_of(replace(near, terms=1e4))).same
    assert compare(result_of(known), result_of(near)).same
    assert not compare(result_of(known), result_of(replace(far, terms=1e9))).same
    # the phases that a search found are known to a 1e-12 of a radian: so much of the terms is left
    phase = replace(quantity("optimisation/variable/phase"), values=np.array(3.0), unit="rad")
    loose, sure = (replace(phase, error_estimate=error) for error in (1e-12, 1e-15))
    assert compare(result_of(known, loose), result_of(far, loose)).same
    assert not compare(result_of(known, sure), result_of(far, sure)).same


def test_relative_to_the_whole_or_to_each_entry() -> None:
    one = replace(quantity("a/b", (DIRECTION,)), values=np.array([1e6, 1.0, 0.0]), error_estimate=0)
    other = replace(one, values=np.array([1e6, 1.01, 0.0]))
    assert compare(result_of(one), result_of(other)).same
    strict = compare(result_of(one), result_of(other), ruled(relative_to="entry"))
    assert (only(strict).failed, only(strict).entry) == (1, "direction=y")


@pytest.mark.parametrize(
    ("left", "right", "nan_equal", "same"),
    [
        (math.nan, math.nan, False, False),
        (math.nan, math.nan, True, True),
        (math.nan, math.nan, None, True),
        (math.nan, 1.0, True, False),
        (1.0, math.nan, True, False),
        (INFINITY, INFINITY, False, True),
        (-INFINITY, INFINITY, False, False),
        (INFINITY, 1.0, False, False),
        (1.0, INFINITY, False, False),
        (0.0, 0.0, False, True),
        (complex(INFINITY, 1), complex(INFINITY, 1), False, True),
    ],
)
@pytest.mark.parametrize("kind", ["value", "vector", "curve", None])
def test_what_is_not_finite(
    left: complex, right: complex, nan_equal: bool | None, same: bool, kind: str | None
) -> None:
    axis = Axis(name="speed", values=np.array([1.0, 2.0, 3.0])) if kind == "curve" else DIRECTION
    one = replace(quantity("a/b", (axis,)), values=np.array([1.0, left, 2.0]))
    other = replace(one, values=np.array([1.0, right, 2.0]))
    rules = ruled(compare=kind, nan_equal=nan_equal)
    comparison = compare(result_of(one), result_of(other), rules)
    assert comparison.same == same
    differing = only(comparison)
    assert differing.ratio == (0.0 if same else INFINITY)


def test_what_has_another_shape_is_a_difference() -> None:
    one = result_of(quantity("a/b", (MOUNT, ORDER)), quantity("a/c"))
    two = one.record["a/b"]
    for fields, words in (
        ({"unit": "kN"}, "unit: 'N' became 'kN'"),
        ({"amplitude": "rms"}, "amplitude: None became 'rms'"),
        ({"axes": (ORDER,), "values": np.zeros(10)}, "axes: ['mount', 'order'] became ['order']"),
        ({"values": two.values.astype(str)}, "values: 'numbers' became 'names'"),
        ({"axes": (MOUNT, replace(ORDER, unit="Hz"))}, "unit of axis order: '' became 'Hz'"),
        (
            {"axes": (MOUNT, replace(ORDER, values=ORDER.values[:8])), "values": two.values[:, :8]},
            "order=9 (and 1 more) is missing",
        ),
    ):
        row = compare(one, changed(one, "a/b", **fields)).rows[0]
        assert row.problems == (words,)
        assert not row.same
    # the entries that both have are equal: a row of zeros would tell of no difference
    said = render_differences(compare(one, changed(one, "a/b", **fields)))
    assert f"a/b: {words}" in said and "worst first" not in said
    assert compare(one, with_quantities(one, {"a/c": None})).rows[1].problems == ("is missing",)
    extra = compare(one, with_quantities(one, {"b/d": quantity("b/d")})).rows[2]
    assert extra.problems == ("is not in the reference",)
    quiet = Rules(rules=(Rule(quantity="b/*", compare="ignore"),))
    ignoring = compare(one, with_quantities(one, {"b/d": quantity("b/d")}), quiet)
    assert (ignoring.same, ignoring.ignored) == (True, ("b/d",))


def test_labels_decide_and_not_positions() -> None:
    one = quantity("a/b", (MOUNT, ORDER))
    turned = replace(
        one,
        values=one.values[::-1],
        axes=(replace(MOUNT, values=MOUNT.values[::-1]), replace(ORDER, values=ORDER.values * 1.0)),
    )
    assert compare(result_of(one), result_of(turned)).same
    renamed = replace(one, axes=(replace(MOUNT, values=np.array(["left front", "?", "3"])), ORDER))
    row = only(compare(result_of(one), result_of(renamed)))
    assert row.problems == ("mount=höger is missing", "mount=? is not in the reference")


def test_names_as_values() -> None:
    names = np.array(["stiffness", "damping", "mass"])
    one = replace(quantity("a/b", (MOUNT,)), values=names)
    assert compare(result_of(one), result_of(one)).same
    other = replace(one, values=np.array(["stiffness", "damper", "mass"]))
    row = only(compare(result_of(one), result_of(other)))
    assert (row.failed, row.reference, row.value) == (1, "damping", "damper")


def test_vectors_are_measured_by_length() -> None:
    one = replace(quantity("a/b", (MOUNT, DIRECTION)), error_estimate=0.0)
    other = replace(one, values=one.values + 1e-3)
    row = only(compare(result_of(one), result_of(other), ruled(compare="vector", rtol=1e-9)))
    assert row.entries == 3
    assert row.difference == pytest.approx(1e-3 * math.sqrt(3))


def test_phases_are_modulo_a_turn_and_above_a_floor() -> None:
    angle = np.array([3.14159, 0.3, -1.0])
    one = replace(quantity("a/b", (DIRECTION,)), values=angle, unit="rad", error_estimate=0.0)
    other = replace(one, values=angle + 2 * np.pi * np.array([-1, 2, 0]))
    assert compare(result_of(one), result_of(other), ruled(compare="phase")).same
    assert not compare(result_of(one), result_of(other)).same
    late = replace(one, values=angle + np.array([0, 0, 1e-3]))
    row = only(compare(result_of(one), result_of(late), ruled(compare="phase")))
    assert (row.entry, row.difference) == ("direction=z", pytest.approx(1e-3))
    amplitudes = np.array([1.0, 1e-9, 2.0]) * np.exp(1j * angle)
    one = replace(one, values=amplitudes, unit="N")
    noise = replace(one, values=amplitudes * np.array([3.0, -1.0, 1.0]))
    assert compare(result_of(one), result_of(noise), ruled(compare="phase")).same
    low = compare(result_of(one), result_of(noise), ruled(compare="phase", floor=1e-12))
    assert only(low).entry == "direction=y"
    with pytest.raises(UsageError, match="it needs complex numbers or angles in rad"):
        compare(result_of(quantity("a/b")), result_of(quantity("a/b")), ruled(compare="phase"))


def test_statistics_are_compared_by_their_standard_errors() -> None:
    one = replace(quantity("a/b"), values=np.array(1.0), standard_error=0.03)
    for difference, same in ((0.199, True), (0.201, False)):
        other = replace(one, values=np.array(1.0 + difference), standard_error=0.04)
        assert compare(result_of(one), result_of(other)).same == same


def machine_modes(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies, shapes (rows) and mass matrix of a random body; modes 3 to 5 coincide."""
    generator = np.random.default_rng(seed)
    frequencies = np.array([10.0, 20.0, 30.0, 30.0, 30.0, 55.0])
    root = np.diag(generator.uniform(1, 3, 6))
    basis, _ = np.linalg.qr(generator.normal(size=(6, 6)))
    return frequencies, np.linalg.solve(root, basis).T, root @ root


def modes_result(
    frequencies: np.ndarray, shapes: np.ndarray, mass: np.ndarray | None = None
) -> Result:
    """Modes; with a mass matrix of unit modal mass, with their energies and damping."""
    scale = "" if mass is None else ", of unit modal mass"
    folder, axes = "isolation/modes", (replace(MODE, values=np.arange(1, len(frequencies) + 1)),)
    both = (*axes, replace(COORDINATE, values=COORDINATE.values[: shapes.shape[1]]))

    def of(name: str, values: np.ndarray, chosen: tuple[Axis, ...]) -> Quantity:
        error = 1e-13 * float(np.abs(values).max())
        words = f"{name}{scale}"
        return quantity(f"{folder}/{name}", chosen, long_name=words, values=values, unit="",
                        error_estimate=error)  # fmt: skip

    made = [of("natural_frequency", frequencies, axes), of("shape", shapes, both)]
    if mass is not None:
        energy = shapes * (shapes @ mass) / np.einsum("mi,ij,mj->m", shapes, mass, shapes)[:, None]
        made.append(of("energy_fraction", energy, both))
        made.append(of("damping_ratio", 0.01 * frequencies, axes))
    return result_of(*made)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_modes_are_the_same_in_any_sign_and_those_that_coincide_in_any_basis(seed: int) -> None:
    frequencies, shapes, mass = machine_modes(seed)
    generator = np.random.default_rng(seed + 1)
    turn, _ = np.linalg.qr(generator.normal(size=(3, 3)))
    other = shapes.copy()
    other[2:5] = turn @ shapes[2:5]
    other *= generator.choice([-1, 1], 6)[:, None]
    again = modes_result(frequencies, other, mass)
    comparison = compare(modes_result(frequencies, shapes, mass), again)
    assert [row.kind for row in comparison.rows] == [
        "spectrum", "mode_shape", "spectrum", "spectrum",
    ]  # fmt: skip
    assert comparison.same, render_differences(comparison)


def test_modes_in_another_order_or_scale_differ() -> None:
    frequencies, shapes, mass = machine_modes(3)
    golden = modes_result(frequencies, shapes, mass)
    swapped = [5, 1, 2, 3, 4, 0]
    comparison = compare(golden, modes_result(frequencies[swapped], shapes[swapped], mass))
    assert [row.same for row in comparison.rows] == [False] * 4
    assert comparison.rows[0].problems[0].startswith("mode=1 has become mode=6")
    # two modes that are no further apart than their errors may change places
    near = frequencies + np.array([0.0, 0.0, 0.0, 1e-5, 2e-5, 0.0])
    known = modes_result(near, shapes, mass)
    swapped = [0, 1, 3, 2, 4, 5]
    other = modes_result(near[swapped], shapes[swapped], mass)
    assert compare(known, other).same
    for mode in (0, 3):  # alone, and one of those that coincide
        other = shapes.copy()
        other[mode] *= 3.0
        rows = compare(golden, modes_result(frequencies, other, mass)).rows
        assert [row.path for row in rows if not row.same] == ["isolation/modes/shape"]
        assert rows[1].value == pytest.approx(3.0)


def test_an_estimate_that_has_grown_beyond_the_tolerance_differs() -> None:
    one = replace(quantity("a/b", (ORDER,)), error_estimate=1e-12)
    largest = float(np.abs(one.values).max())
    for estimate, same in ((9e-12, True), (1e-9 * largest, True), (largest, False)):
        row = only(compare(result_of(one), result_of(replace(one, error_estimate=estimate))))
        assert row.same == same and bool(row.problems) != same


def test_each_mode_order_and_condition_has_its_own_size() -> None:
    mode, condition = (Axis(name=name, values=np.arange(1, 3)) for name in ("mode", "condition"))
    for axis in (mode, condition, replace(mode, name="order"), replace(mode, name="a.b[0]")):
        values = np.array([[1.0, 2.0, 3.0], [1e6, 2e6, 0.0]])
        one = replace(quantity("a/b", (axis, DIRECTION)), values=values, error_estimate=1e-9)
        other = replace(one, values=values * np.array([[1.001], [1.0]]))
        assert only(compare(result_of(one), result_of(other))).failed == 3
        small = replace(one, values=values + np.array([[1e-8], [0.0]]))
        assert compare(result_of(one), result_of(small)).same
    sections = replace(one, axes=(replace(mode, name="section"), DIRECTION))
    assert compare(result_of(sections), result_of(replace(sections, values=other.values))).same


@pytest.mark.parametrize(
    "path",
    ["response/torsion/modes/frequency_error", "optimisation/kkt_residual", "tuning/evaluations",
     "optimisation/history/objective", "find/shell/evaluations", "fit/search_chi_square",
     "find/shell/machine/response/roll/energy/residual"],
)  # fmt: skip
def test_diagnostics_are_no_results_unless_a_rule_says_how(path: str) -> None:
    one = quantity(path, (ORDER,))
    other = replace(one, values=2.0 * one.values)
    comparison = compare(result_of(one), result_of(other))
    assert comparison.same and comparison.ignored == (path,)
    assert not compare(result_of(one), result_of(other), ruled(compare="value")).same


@pytest.mark.parametrize(
    ("path", "kind", "period", "same"),
    [
        (
            "optimisation/variable/machine.crank_train.cylinders[2].crank_phase",
            "generator",
            1,
            True,
        ),
        ("response/roll/phase_lag/slip", "compressor", 1, True),
        ("bearing_loads/main/peak_angle", "engine", 1, False),
        ("bearing_loads/main/peak_angle", "engine", 2, True),
        ("bearing_loads/main/peak_angle", "generator", 1, True),
        ("isolation/pitch/angle_peak", "engine", 1, False),
    ],
)
def test_angles_on_a_circle_are_the_same_after_it(
    path: str, kind: str, period: int, same: bool
) -> None:
    one = replace(quantity(path, (MOUNT,)), values=np.radians([-60.0, 0.0, 170.0]), unit="rad")
    other = replace(one, values=one.values + 2.0 * np.pi * period)
    left, right = (
        replace(result_of(each), case={"machine": {"kind": kind}}) for each in (one, other)
    )
    assert compare(left, right).same == same
    off = replace(other, values=other.values + 1e-5)
    assert not compare(left, replace(result_of(off), case=left.case)).same


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32), mode=st.sampled_from([0, 1, 5]), turn=st.floats(1e-4, 1.0))
def test_a_turned_mode_shape_is_seen(seed: int, mode: int, turn: float) -> None:
    frequencies, shapes, mass = machine_modes(seed)
    other = shapes.copy()
    across = np.random.default_rng(seed + 2).normal(size=6)
    mine = shapes[mode] / np.linalg.norm(shapes[mode])
    across -= mine * (mine @ across)
    across /= np.linalg.norm(across)
    other[mode] = math.cos(turn) * mine + math.sin(turn) * across
    other[mode] *= np.linalg.norm(shapes[mode])
    row = compare(
        modes_result(frequencies, shapes, mass), modes_result(frequencies, other, mass)
    ).rows[1]
    assert row.failed >= 1
    assert row.entry == f"mode={mode + 1}"
    assert row.difference == pytest.approx(math.sin(turn), rel=1e-6)
    assert row.value == pytest.approx(math.cos(turn), rel=1e-6)


def test_a_changed_a_missing_and_an_extra_mode_are_seen() -> None:
    frequencies, shapes, mass = machine_modes(7)
    golden = modes_result(frequencies, shapes, mass)
    higher = modes_result(frequencies * np.array([1, 1.3, 1, 1, 1, 1]), shapes, mass)
    row = compare(golden, higher).rows[0]
    assert (row.failed, row.entry, row.reference, row.value) == (1, "mode=2", 20.0, 26.0)
    fewer = modes_result(frequencies[1:], shapes[1:], mass)
    assert compare(golden, fewer).rows[0].problems == ("mode=1 is missing",)
    assert compare(fewer, golden).rows[1].problems == ("mode=1 is not in the reference",)


@pytest.mark.parametrize(
    ("shapes", "same"),
    [
        ([[2.0, 2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], True),
        ([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]], True),
        ([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 1.0]], False),
        ([[1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], False),
    ],
)
def test_a_mode_that_moves_nothing_shown_is_a_mode(shapes: list[list[float]], same: bool) -> None:
    frequencies = np.array([0.0, 0.0, 50.0])
    golden = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    other = modes_result(frequencies, np.array(shapes))
    assert compare(modes_result(frequencies, golden), other).same == same


def test_an_axis_that_moved_is_said_with_the_largest_shift_and_its_entry() -> None:
    axis = Axis(name="frequency", values=np.array([1.0, 2.0, 3.0, 4.0]), unit="Hz")
    one = replace(quantity("a/b", (axis,)), values=np.zeros(4))
    moved = replace(one, axes=(replace(axis, values=np.array([1.0, 2.25, 2.5, 4.0])),))
    words = "axis frequency: 2 of 4 entries moved, most by -0.5 Hz, at frequency=3 Hz"
    comparison = compare(result_of(one), result_of(moved), ruled(compare="value"))
    assert only(comparison).problems == (words,) and words in render_differences(comparison)
    longer = replace(axis, values=np.array([1.0, 2.0, 3.0, 4.0, 5.0]))
    other = replace(one, axes=(longer,), values=np.zeros(5))
    row = only(compare(result_of(one), result_of(other), ruled(compare="value")))
    assert row.problems == ("frequency=5 Hz is not in the reference",)


def resonance(speed: np.ndarray, centre: float = 31.74, damping: float = 0.08) -> np.ndarray:
    ratio = speed / centre
    return np.asarray(100 * ratio**2 / np.abs(1 - ratio**2 + 2j * damping * ratio))


def run_up(speed: np.ndarray, values: np.ndarray) -> Quantity:
    axis = Axis(name="speed", values=speed, unit="rad/s")
    return replace(quantity("isolation/run_up", (axis,)), values=values)


def refined(generator: np.random.Generator, tolerance: float) -> np.ndarray:
    """Speeds from random ones on, halved until straight lines follow the resonance."""
    speed = np.sort(np.concatenate([[0.0, 513.0], generator.uniform(0, 513, 15)]))
    scale = resonance(np.linspace(30, 34, 99)).max()
    while True:
        middle = (speed[1:] + speed[:-1]) / 2
        values = resonance(speed)
        coarse = np.abs(resonance(middle) - (values[1:] + values[:-1]) / 2) > tolerance * scale
        if not coarse.any() and np.diff(speed).max() < 40:
            return speed
        speed = np.sort(np.concatenate([speed, middle[coarse | (np.diff(speed) >= 40)]]))


@settings(max_examples=2, deadline=None)
@given(seed=st.integers(0, 2**32), finer=st.floats(1.0, 4.0))
def test_curves_may_be_sampled_elsewhere(seed: int, finer: float) -> None:
    generator = np.random.default_rng(seed)
    first, second = refined(generator, 2e-5), refined(generator, 2e-5 / finer)
    golden = result_of(run_up(first, resonance(first)))
    comparison = compare(golden, result_of(run_up(second, resonance(second))))
    assert comparison.same, render_differences(comparison)
    # 4 % in the frequency moves the flank by 25 times the tube's half-width of 0.05 rad/s ...
    moved = run_up(second, resonance(second, centre=33.0))
    assert not compare(golden, result_of(moved)).same
    # ... and 0.1 % in height is ten times the tolerance
    row = only(compare(golden, result_of(run_up(second, 1.001 * resonance(second)))))
    assert row.failed > 0
    assert row.difference == pytest.approx(
        1e-3 * resonance(np.linspace(31, 33, 999)).max(), rel=0.3
    )


def test_a_steep_flank_nearby_its_sample_is_no_difference() -> None:
    """A step moved by less than the tube; point by point it would be 100 % off."""
    speed = np.linspace(0.0, 100.0, 11)
    one = run_up(np.array([0, 50.0, 50.001, 100]), np.array([0, 0, 1.0, 1]))
    for place, same in ((50.005, True), (50.1, False)):
        other = run_up(np.array([0, place, place + 0.001, 100]), np.array([0, 0, 1.0, 1]))
        assert compare(result_of(one), result_of(other)).same == same
        assert compare(result_of(other), result_of(one)).same == same
    short = run_up(speed[:-1], np.ones(10))
    row = only(compare(result_of(run_up(speed, np.ones(11))), result_of(short)))
    assert row.problems == ("speed covers 0 to 100 against 0 to 90 rad/s",)


def test_changes_of_the_case_are_shown_and_not_counted() -> None:
    one = typical()
    other = replace(
        one,
        case={"title": "another", "machine": {"speed": 513.0, "positions": [[0.1, 0.3]], "x": 1}},
        version="0.2.0",
        provenance={},
    )
    comparison = compare(one, other)
    assert comparison.same
    assert [(c.what, c.reference, c.value) for c in comparison.changes] == [
        ("vibecalc", "0.1.0", "0.2.0"),
        ("title", "'a sample'", "'another'"),
        ("machine.positions[0][1]", "0.2", "0.3"),
        ("machine.x", "absent", "1"),
    ]


def test_the_words_table_json_and_junit_agree() -> None:
    one = result_of(
        quantity("a/force<&>\"'", (MOUNT, ORDER), is_complex=True),
        quantity("a/same"),
        quantity("a/gone", (ORDER,)),
        quantity("a/left_out"),
    )
    odd = "bell \x07 and 'quotes' & <tags>"
    axes = (replace(MOUNT, values=np.array([odd, "2", "3"])), ORDER)
    first = "a/force<&>\"'"
    one = changed(one, first, axes=axes)
    values = one.record[first].values.copy()
    values[0, 4] += 0.5
    values[1, 1] = complex(math.nan, INFINITY)
    other = with_quantities(changed(one, first, values=values), {"a/gone": None})
    rules = Rules(rules=(Rule(quantity="a/left_out", compare="ignore"),))
    comparison = compare(one, other, rules)
    text = render_differences(comparison)
    assert "2 of 30 entries" in text
    assert "a/gone: is missing" in text
    assert text.endswith("3 quantities compared, 2 differ.\n")
    assert max(map(len, text.splitlines())) <= 100
    pair = FilePair(name="one.h5", golden=Path("a"), result=Path("b"), comparison=comparison)
    whole = json.loads(json.dumps(differences_object([pair], ["b/*"]), allow_nan=False))
    assert (whole["same"], whole["unused_rules"], whole["error"]) == (False, ["b/*"], None)
    (found,) = whole["results"]
    assert found["same"] is False
    assert [entry["same"] for entry in found["quantities"]] == [False, True, False]
    assert found["quantities"][0]["value"] == ["nan", "inf"]
    assert found["quantities"][0]["ratio"] is None
    suite = ElementTree.fromstring(render_junit([pair])).find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("4", "2", "1")
    cases = suite.findall("testcase")
    assert [case.get("name") for case in cases] == ["force<&>\"'", "same", "gone", "left_out"]
    assert [case.find("failure") is not None for case in cases] == [True, False, True, False]
    assert cases[3].find("skipped") is not None

"""Claim: an axis of a sweep takes the values a person would write in the case, ends included.

Truth: single values read as a case reads them, exact fractions, mpmath at 40 digits.
"""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sweep_samples import DAMPING, MODEL, PHASE, SPEED, STIFFNESS, axis, design_of, spread

from vibecalc.core.study.sweep.keys import as_written
from vibecalc.core.study.sweep.prepare import axis_table, axis_tables, sampling_table
from vibecalc.core.study.sweep.values import scattered, spaced
from vibecalc.units import parse_quantity


def values(*tables, **more):
    key_values = design_of(*tables, **more).axes[0].keys[0].values
    return key_values.at(np.arange(key_values.count))


def test_each_step_is_what_a_case_gets_that_says_so():
    steps = values(spread(STIFFNESS, "5 N/mm", "50 N/mm", 10))
    assert steps.tolist() == [parse_quantity(f"{5 * n} N/mm", "N/m") for n in range(1, 11)]
    turns = values(spread(SPEED, "1000 rpm", "4900 rpm", 40))
    assert turns.tolist() == [parse_quantity(f"{1000 + 100 * n} rpm", "rad/s") for n in range(40)]
    tenths = values(spread(DAMPING, 0, 0.3, 4))
    assert tenths.tolist() == [0.0, 0.1, 0.2, 0.3]


def test_steps_of_a_temperature_count_from_its_own_zero():
    for ends, steps in (("degC", [293.15, 313.15, 333.15]), ("K", [20.0, 40.0, 60.0])):
        start, stop = f"20 {ends}", f"60 {ends}"
        read = parse_quantity(start, "K"), parse_quantity(stop, "K")
        between = spaced(*as_written(start, stop, "K", read), "linear", 3)
        assert between.at(np.arange(3)) == pytest.approx(steps)


def test_equal_ratios_keep_their_ends_and_round_powers():
    decades = values(spread(STIFFNESS, "1 N/mm", "1000 N/mm", 4, spacing="log"))
    assert decades.tolist() == [1e3, 1e4, 1e5, 1e6]
    steps = values(spread(STIFFNESS, "7.3 N/mm", "91.7 N/mm", 13, spacing="log"))
    assert steps[0] == parse_quantity("7.3 N/mm", "N/m")
    assert steps[-1] == parse_quantity("91.7 N/mm", "N/m")
    with mpmath.workdps(40):
        for n, found in enumerate(steps):
            exact = (
                1000
                * mpmath.mpf("7.3")
                * (mpmath.mpf("91.7") / mpmath.mpf("7.3")) ** (mpmath.mpf(n) / 12)
            )
            # the number keeps 15 digits
            assert abs(found - exact) <= 6e-15 * exact


def test_names_units_and_labels():
    design = design_of(
        axis(STIFFNESS, "5 N/mm", "6 N/mm", **{"in_step": [axis(DAMPING, 10, 20)]}),
        axis(SPEED, "2000 rpm", "2500 rpm"),
        axis(PHASE, "10 deg", "20 deg"),
        axis(MODEL, "pitch", "rigid_body"),
    )
    # `speed` is an axis of results, so the axis of the sweep needs a longer name
    names = [axis.name for axis in design.axes]
    assert names == ["stiffness", "machine.speed", "crank_phase", "model"]
    assert [key.unit for key in design.every] == ["N/m", "N*s/m", "rad/s", "rad", ""]
    assert [axis.keys[0].written_unit for axis in design.axes] == ["N/mm", "rpm", "deg", ""]
    assert [key.choices for key in design.every] == [(), (), (), (), ("pitch", "rigid_body")]
    assert all(key.label for key in design.every)


def test_a_text_and_a_table_make_the_same_design():
    grid = [f"{STIFFNESS}=5 N/mm:50 N/mm:7log", f"{MODEL}=pitch,rigid_body"]
    zipped = [f"{SPEED}=2000 rpm,3000 rpm", f"{DAMPING}=10,20"]
    tables = axis_tables([*map(axis_table, grid)], [*map(axis_table, zipped)])
    written = (
        spread(STIFFNESS, "5 N/mm", "50 N/mm", 7, spacing="log"),
        axis(MODEL, "pitch", "rigid_body"),
        axis(SPEED, "2000 rpm", "3000 rpm", **{"in_step": [axis(DAMPING, 10, 20)]}),
    )
    typed, read = design_of(*tables), design_of(*written)
    assert typed.description() == read.description()
    assert typed.shape == (7, 2, 2)
    assert sampling_table("sobol:64:7") == {"sampling": "sobol", "points": 64, "seed": 7}
    assert sampling_table("monte_carlo:64") == {"sampling": "monte_carlo", "points": 64}


def probability(kind, parameters, value):
    """Distribution functions in closed form, in mpmath."""
    first, second, *mode = (mpmath.mpf(one) for one in parameters)
    value = mpmath.mpf(value)
    if kind == "uniform":
        return (value - first) / (second - first)
    if kind == "triangular":
        if value < mode[0]:
            return (value - first) ** 2 / ((second - first) * (mode[0] - first))
        return 1 - (second - value) ** 2 / ((second - first) * (second - mode[0]))
    if kind == "normal":
        return mpmath.ncdf((value - first) / second)
    variance = mpmath.log(1 + (second / first) ** 2)
    return mpmath.ncdf((mpmath.log(value / first) + variance / 2) / mpmath.sqrt(variance))


SCATTERS = [
    ("uniform", (2.0, 5.0)),
    ("triangular", (1.0, 4.0, 1.5)),
    ("triangular", (1.0, 4.0, 1.0)),
    ("triangular", (1.0, 4.0, 4.0)),
    ("normal", (10.0, 2.0)),
    ("lognormal", (10.0, 2.0)),
    ("lognormal", (10.0, 1e-3)),
    ("lognormal", (1.0, 30.0)),
]


@pytest.mark.parametrize(("kind", "parameters"), SCATTERS)
def test_quantiles_invert_the_distribution_functions(kind, parameters):
    shares = np.array([1e-9, 0.01, 0.2, 0.5, 0.77, 0.999])
    found = scattered(kind, *parameters).drawn(shares)
    assert np.all(np.diff(found) > 0.0)
    with mpmath.workdps(40):
        for share, value in zip(shares, found, strict=True):
            # rounding of the value itself, times the density, is seen in the probability
            step = value * 2.0**-48
            low, high = (probability(kind, parameters, value + s) for s in (-step, step))
            assert low - 1e-15 <= share <= high + 1e-15


def decimals(least):
    return st.builds(
        lambda digits, places: Fraction(digits, 10**places),
        st.integers(least, 10**17),
        st.integers(0, 20),
    )


@given(decimals(-(10**17)), decimals(-(10**17)), st.integers(2, 10**9), st.data())
def test_equal_steps_are_the_doubles_next_to_the_fractions(start, stop, count, data):
    place = data.draw(st.lists(st.integers(0, count - 1), min_size=1, max_size=5))
    steps = spaced(start, stop, 1.0, "linear", count)
    exact = [float(start + (stop - start) * Fraction(k, count - 1)) for k in place]
    assert steps.at(np.array(place)).tolist() == exact

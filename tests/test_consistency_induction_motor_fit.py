"""Claim: a fit finds the curve it was given, and says what no torque table can tell."""

from functools import cache

import mpmath
import numpy as np
import pytest
from induction_motors import GIVEN, ONE_CAGE, RPM, TABLE_SLIP, TABLE_TORQUE, TWO_CAGES
from scipy.optimize import differential_evolution

from vibecalc.excitation.induction_motor import InductionMotor, steady_torque, torque_curve
from vibecalc.excitation.induction_motor_fit import fit_induction_motor
from vibecalc.excitation.induction_motor_flux import torque_answer
from vibecalc.excitation.induction_motor_identify import transient_inductance

MADE = TABLE_SLIP[1:]


@cache
def source_fit(cages=2):
    return fit_induction_motor(TABLE_SLIP, TABLE_TORQUE, **GIVEN, cages=cages)


def stator_inductance(motor):
    return float(motor.stator_leakage + motor.magnetising_inductance)


def test_two_cages_are_found_again():
    table = steady_torque(TWO_CAGES, MADE).value
    share = float(TWO_CAGES.stator_leakage / transient_inductance(TWO_CAGES))
    fit = fit_induction_motor(
        MADE, table, **GIVEN,
        stator_inductance=stator_inductance(TWO_CAGES), stator_share=share,
    )  # fmt: skip
    assert fit.worst_relative < 1e-11
    assert fit.log_error < 1e-10
    # between the rows and beyond them as well
    slips = np.linspace(0.01, 150.0, 400)
    ours, exact = steady_torque(fit.motor, slips).value, steady_torque(TWO_CAGES, slips).value
    assert np.max(np.abs(ours / exact - 1.0)) < 1e-9
    # with both assumptions true, so are the parameters
    for found, true in zip(fit.motor, TWO_CAGES, strict=True):
        assert np.allclose(found, true, rtol=1e-12)
    waves = np.array([94.0, 300.0])
    answers = [torque_answer(motor, 0.9, waves)[0].value for motor in (fit.motor, TWO_CAGES)]
    assert np.allclose(*answers, rtol=1e-10)
    assert np.all(fit.used) and fit.agreeing >= 2


def test_one_cage_is_found_again_from_the_rows_up_to_breakdown():
    table = steady_torque(ONE_CAGE, MADE).value
    fit = fit_induction_motor(MADE, table, **GIVEN, cages=1)
    assert fit.used.sum() == np.argmax(table) + 1 < MADE.size
    # one cage has one shape of curve: the rows beyond breakdown are met as well
    assert np.max(np.abs(fit.residual / fit.table)) < 1e-10
    assert any("beyond the breakdown torque are not fitted" in text for text in fit.warnings)


def test_what_the_table_does_not_tell_is_named():
    fit = source_fit()
    known = fit.identifiability
    assert known.names == (
        "stator_leakage", "magnetising_inductance", "rotor_resistance 1", "rotor_resistance 2",
        "rotor_leakage 1", "rotor_leakage 2",
    )  # fmt: skip
    assert known.identifiable.tolist() == [True] * 4 + [False] * 2
    assert np.isinf(known.spread[4:]).all() and np.isinf(known.free_spread).all()
    assert np.all(known.singular_values[4:] < 1e-13 * known.singular_values[0])
    # with the assumptions held, one percent in the table is a few percent in the parameters
    assert np.all((known.held_spread > 0.0) & (known.held_spread < 0.05))
    # one unknown product moves the leakage alone, the other the magnetising inductance
    sums = known.combinations[4:, :2] @ [
        fit.motor.stator_leakage,
        fit.motor.magnetising_inductance,
    ]
    assert abs(sums[0]) < 1e-12 * abs(sums[1])
    assert abs(known.combinations[5, 1]) > 0.9
    assert np.allclose(known.combinations @ known.combinations.T, np.eye(6), atol=1e-12)
    text = " | ".join(fit.warnings)
    assert "not identifiable from the slip table: stator_leakage^0.76" in text
    assert "not identifiable from the slip table: magnetising_inductance^0.99" in text
    assert "assumed: 10 times" in fit.assumptions[0]


@pytest.mark.long
def test_spread_is_that_of_fits_to_tables_with_errors():
    rng = np.random.default_rng(11)
    table = steady_torque(TWO_CAGES, MADE).value
    base = fit_induction_motor(MADE, table, **GIVEN, stator_inductance=0.028)
    found = []
    for _ in range(24):
        shaken = table * (1.0 + 1e-3 * rng.normal(size=table.size))
        fit = fit_induction_motor(MADE, shaken, **GIVEN, stator_inductance=0.028)
        motor = fit.motor
        found.append(
            np.log(np.concatenate([
                [motor.stator_leakage, motor.magnetising_inductance],
                motor.rotor_resistance, motor.rotor_leakage,
            ]).astype(float))
        )  # fmt: skip
    seen = np.std(found, axis=0, ddof=1)
    ratio = seen / (0.1 * base.identifiability.held_spread)
    assert np.all((ratio > 0.65) & (ratio < 1.5))


def test_source_table_is_met_as_well_as_two_cages_can():
    fit = source_fit()
    off = 100.0 * fit.residual / fit.table
    # no circuit with two cages holds 542 N m at standstill next to 1009 N m at breakdown
    assert np.allclose(off[[0, 1, 8, 10]], [-5.5, 2.3, 17.6, -30.1], atol=0.05)
    assert fit.rms_relative == pytest.approx(0.1212, abs=5e-5)
    assert fit.agreeing == fit.starts
    assert any("-30.1 % (at a slip of 900 rpm" in text for text in fit.warnings)
    curve = torque_curve(fit.motor)
    assert curve.breakdown_torque.value == pytest.approx(1036.7, abs=0.1)
    assert curve.breakdown_slip.value / RPM == pytest.approx(158.8, abs=0.1)
    three = source_fit(3)
    assert three.worst_relative == pytest.approx(0.0529, abs=5e-5)
    assert three.agreeing == three.starts
    one = source_fit(1)
    assert one.worst_relative == pytest.approx(0.2933, abs=5e-5)
    assert np.min(one.residual / one.table) == pytest.approx(-0.722, abs=5e-4)


def test_minimum_is_as_close_as_its_error_says():
    fit = fit_induction_motor(TABLE_SLIP, TABLE_TORQUE, **GIVEN, stator_share=0.0)
    ours = np.log(np.concatenate([fit.motor.rotor_resistance, fit.motor.rotor_leakage]))
    with mpmath.workdps(40):
        line, p, voltage, stator = (mpmath.mpf(float(GIVEN[name])) for name in GIVEN)
        inverse = 1 / mpmath.mpf(float(fit.motor.magnetising_inductance))
        rows = [tuple(map(mpmath.mpf, row)) for row in zip(fit.slip, fit.table, strict=True)]

        def gradient(*logarithms):
            rotor = [mpmath.exp(x) for x in logarithms]
            sums = [mpmath.mpf(0)] * 4
            for slip, wanted in rows:
                x = mpmath.mpc(0, p * slip)
                branch = [r + x * ll for r, ll in zip(rotor[:2], rotor[2:], strict=True)]
                y = inverse + x / branch[0] + x / branch[1]
                d = mpmath.mpc(0, line) + stator * y
                factor = mpmath.mpf(3) / 2 * p * voltage**2 / wanted
                off = factor * y.imag / abs(d) ** 2 - 1
                changes = [-x * r / z**2 for r, z in zip(rotor[:2], branch, strict=True)]
                changes += [-(x**2) * ll / z**2 for ll, z in zip(rotor[2:], branch, strict=True)]
                for k, change in enumerate(changes):
                    moved = mpmath.re(mpmath.conj(d) * stator * change)
                    slope = change.imag / abs(d) ** 2 - 2 * y.imag * moved / abs(d) ** 4
                    sums[k] += off * factor * slope
            return sums

        exact = np.array(
            list(mpmath.findroot(gradient, [mpmath.mpf(x) for x in ours])), dtype=float
        )
    assert np.linalg.norm(ours - exact) <= fit.log_error
    assert fit.log_error < 1e-10


def test_no_other_minimum_is_lower():
    fit = source_fit()
    total = stator_inductance(fit.motor)

    def squares(logarithms):
        values = np.exp(logarithms)
        resistance, leakage = np.moveaxis(values.reshape(2, 2, -1), -1, 0).swapaxes(0, 1)
        motor = InductionMotor(
            **{name: np.full((1, 1), value) for name, value in GIVEN.items()},
            stator_leakage=np.zeros((1, 1)), magnetising_inductance=np.full((1, 1), total),
            rotor_resistance=resistance[:, None, :], rotor_leakage=leakage[:, None, :],
        )  # fmt: skip
        off = steady_torque(motor, TABLE_SLIP[1:]).value / TABLE_TORQUE[1:] - 1.0
        return (off**2).sum(axis=-1)

    bounds = [(np.log(1e-3), np.log(30.0))] * 2 + [(np.log(1e-4), np.log(0.5))] * 2
    other = differential_evolution(
        squares, bounds, rng=5, maxiter=300, popsize=20, vectorized=True, updating="deferred",
        polish=False, tol=1e-8,
    )  # fmt: skip
    ours = np.sum((fit.residual / fit.table) ** 2)
    assert ours <= other.fun * (1.0 + 1e-12)
    assert other.fun < ours * (1.0 + 1e-5)

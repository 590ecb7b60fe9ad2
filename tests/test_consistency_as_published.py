"""Claim: the modal route of the source, where its premises hold, is the direct solution, and a
damping series of many terms says how ill conditioned it is.
"""

import engine_source as source
import mpmath
import numpy as np
import pytest
from engine_as_published import ORDER, full_torque, modes

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.errors import with_errors
from vibecalc.torsion.adapters.as_published import (
    caughey_series,
    empirical_magnifier,
    magnifier,
    modal_excitation,
    modal_twist,
    series_damping,
    twist_on_criticals,
)
from vibecalc.torsion.line import chain, stiffness_matrix
from vibecalc.torsion.modes_of_tree import holzer_table, relative_residual

FREQUENCY, SHAPE, INERTIA = modes(8)
TORQUE = full_torque(8, speed=source.SPEED_OF_TEXT)
EXCITATION = modal_excitation(SHAPE[1:], FREQUENCY[1:], INERTIA, TORQUE)


def test_all_modes_together_are_the_direct_solution():
    # Rayleigh damping, one speed: shafts' twists (the rigid mode drops out of them) at t = 0
    alpha = caughey_series(FREQUENCY[1:3], [0.01, 0.01]).alpha
    line = chain(source.DAMPED_INERTIA, source.DAMPED_STIFFNESS)
    stiffness, speed = stiffness_matrix(line), 191.3
    zeta = 0.5 * (alpha[0] / FREQUENCY[1:] + alpha[1] * FREQUENCY[1:])
    modal = np.array([
        modal_twist(
            modal_excitation(SHAPE[c : c + 1], FREQUENCY[c : c + 1], INERTIA, TORQUE),
            FREQUENCY[c : c + 1], ORDER, [speed], zeta[c - 1],
        ).real[0, 0]
        for c in range(1, 8)
    ])  # fmt: skip
    by_modes = np.diff(modal @ SHAPE[1:])
    direct = np.zeros(8)
    for q, torque in zip(ORDER, TORQUE, strict=True):
        w = q * speed
        damping = alpha[0] * np.diag(INERTIA) + alpha[1] * stiffness
        matrix = stiffness + 1j * w * damping - w**2 * np.diag(INERTIA)
        direct += np.linalg.solve(matrix, torque).real
    assert np.diff(direct) == pytest.approx(by_modes, abs=1e-9 * np.abs(by_modes).max())


def test_empirical_magnifier_only_for_the_resonant_order():
    bare = twist_on_criticals(EXCITATION, ORDER)
    term = np.diff(bare, axis=-1, prepend=0.0)
    static = EXCITATION.deflection
    c, w = 1, 5
    bump = empirical_magnifier(np.abs(static[c, w])) * static[c, w].real
    assert term[c, w, w] == pytest.approx(bump, rel=1e-9)
    # eq. 4.20 for another order, whatever the frequency
    assert term[c, w, 2] == pytest.approx(static[c, 2].real / (1 - (3 / 6) ** 2), rel=1e-9)
    # its result depends on how the mode is scaled: a shape twice as large is not half the twist
    double = modal_excitation(2.0 * SHAPE[1:], FREQUENCY[1:], INERTIA, TORQUE)
    resonant = np.diff(twist_on_criticals(double, ORDER), axis=-1, prepend=0.0)[c, w, w]
    assert 2.0 * resonant / term[c, w, w] == pytest.approx(2.0**0.25, rel=1e-9)


def test_the_residual_of_holzers_table_is_the_product_of_its_roots():
    """sigma_3 of eq. 4.12, figures 4.11 and 4.20: J w^2 times all 1 - (w / W)^2."""
    line = chain(source.DAMPED_INERTIA, source.DAMPED_STIFFNESS)
    driven = np.linspace(0.0, 1.05 * FREQUENCY[-1], 801)[1:]
    left = holzer_table(line, driven).sum_torque[:, -1]
    roots = np.prod(1.0 - (driven[:, None] / FREQUENCY[1:]) ** 2, axis=1)
    expected = driven**2 * np.sum(source.DAMPED_INERTIA) * roots
    assert left == pytest.approx(expected, rel=1e-6, abs=1e-9 * np.abs(expected).max())
    share = relative_residual(line, driven)
    assert np.abs(share).max() <= 1.0 + 1e-12 and share[0] == pytest.approx(1.0, abs=1e-3)
    assert np.array_equal(np.sign(share), np.sign(left))
    met = np.flatnonzero(np.diff(np.sign(share)))
    assert np.all((driven[met] < FREQUENCY[1:]) & (FREQUENCY[1:] < driven[met + 1]))


def test_series_goes_through_its_points_and_tells_its_condition():
    ratios = [0.01, 0.02, 0.015, 0.03]
    alpha = with_errors(lambda at: caughey_series(at, ratios).alpha, FREQUENCY[1:5])
    back = series_damping(caughey_series(FREQUENCY[1:5], ratios), FREQUENCY[1:5])
    assert np.all(np.abs(back - ratios) <= 1e-9)
    with mpmath.workdps(40):
        system = mpmath.matrix(4, 4)
        for i in range(4):
            for d in range(4):
                system[i, d] = mpmath.mpf(float(FREQUENCY[i + 1])) ** (2 * d - 1)
        exact = mpmath.lu_solve(system, mpmath.matrix([2 * mpmath.mpf(z) for z in ratios]))
        off = np.array([float(abs(mpmath.mpf(float(alpha.value[d])) - exact[d])) for d in range(4)])
    assert np.all(off <= 10.0 * alpha.error)
    assert np.all(alpha.error < 1e-8 * np.abs(alpha.value))
    two, seven = (
        caughey_series(FREQUENCY[1:3], ratios[:2]),
        caughey_series(FREQUENCY[1:], [0.01] * 7),
    )
    assert seven.condition > 1e4 * two.condition
    # through .01 at every mode, and yet anything but constant: far out it runs away
    assert abs(series_damping(seven, 1.5 * FREQUENCY[7])) > 0.1


def test_what_has_no_value_is_refused():
    with pytest.raises(NumericalFailure, match="rigid mode"):
        modal_excitation(SHAPE[:2], [0.0, FREQUENCY[1]], INERTIA, TORQUE)
    with pytest.raises(NumericalFailure, match="meets an undamped"):
        magnifier([0.5, 1.0])
    with pytest.raises(NumericalFailure, match="positive static deflection"):
        empirical_magnifier(0.0)
    with pytest.raises(NumericalFailure, match="all different"):
        caughey_series([1.0, 1.0], [0.1, 0.1])
    close = 100.0 * (1.0 + 1e-3 * np.arange(8))
    with pytest.raises(NumericalFailure, match="ill conditioned"):
        caughey_series(close, np.linspace(0.01, 0.02, 8))
    with pytest.raises(NumericalFailure, match="no damping ratio"):
        series_damping(caughey_series([1.0, 2.0], [0.1, 0.1]), [0.0])

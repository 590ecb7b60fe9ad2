"""Claim: the derivatives of an optimum are those of differences between optima, and the loss from
mistuning is the difference of peaks, first order in stiffness where the peaks part.
"""

import numpy as np
import pytest
from long_but import long_but

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.mistuning import mistuning, sensitivity
from vibecalc.absorber.tuning.several import several_tuning
from vibecalc.errors import NumericalFailure

KINDS = [("force", "displacement"), ("force", "velocity"), ("base", "displacement"),
         ("unbalance", "displacement")]  # fmt: skip


def optimum(z1, m, kind):
    found = minimax(z1, m, *kind)
    return np.array([float(found.largest), float(found.stiffness_ratio),
                     float(found.secondary_damping)])  # fmt: skip


@pytest.mark.parametrize(
    "kind", long_but(KINDS, ("force", "displacement"), ("base", "displacement"))
)
@pytest.mark.parametrize(
    ("z1", "m"),
    [
        (0.1, 0.01),
        pytest.param(0.05, 0.5, marks=pytest.mark.long),
        (0.3, 0.2),
        pytest.param(0.5, 0.05, marks=pytest.mark.long),
    ],
)
def test_derivatives_against_differences(kind, z1, m):
    _, k, z = optimum(z1, m, kind)
    found = sensitivity(z1, m, k, z, (0,), *kind)
    got = np.stack([found.peak, found.stiffness_ratio[0], found.secondary_damping[0]])
    step = 1e-4
    # fourth order
    by = []
    for z_by, m_by in ((z1 * step, 0.0), (0.0, m * step)):
        values = [optimum(z1 + f * z_by, m + f * m_by, kind) for f in (-2, -1, 1, 2)]
        change = (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / 12.0
        by.append(change / (z_by + m_by))
    expected = np.stack(by, axis=-1)
    scale = np.abs(expected) + np.array([[1.0], [k], [z]])
    assert np.all(np.abs(got - expected) <= 2e-6 * scale)
    for error in (found.peak_error, found.stiffness_error, found.damping_error):
        assert np.all(error > 0.0)
    assert np.all(found.peak_error < 1e-7 * np.abs(found.peak))


def test_an_optimum_that_is_a_set_has_no_derivative():
    kind = ("unbalance", "displacement")
    _, k, z = optimum(0.5, 0.5, kind)
    with pytest.raises(NumericalFailure, match="not an optimum held by its peaks"):
        sensitivity(0.5, 0.5, k, z, (0,), *kind)


@pytest.mark.long
def test_two_absorbers_a_bound_included():
    tuned = several_tuning(0.1, [0.05, 0.05], (0, 1))
    found = sensitivity(0.1, [0.05, 0.05], tuned.stiffness_ratio, tuned.secondary_damping, (0, 1))
    step = 1e-4
    ends = [several_tuning(0.1 + s, [0.05, 0.05], (0, 1)) for s in (step, -step)]
    assert found.peak[0] == pytest.approx((ends[0].peak - ends[1].peak) / (2 * step), rel=1e-5)
    change = (ends[0].stiffness_ratio - ends[1].stiffness_ratio) / (2 * step)
    assert found.stiffness_ratio[:, 0] == pytest.approx(change, rel=1e-4)
    held = tuned.on_lower[2:]
    assert np.all(found.secondary_damping[held] == 0.0)


@pytest.mark.parametrize("kind", long_but(KINDS, *KINDS[:2]))
def test_losses_are_differences_of_peaks(kind):
    z1, m = np.array([0.0, 0.1, 0.3]), np.array([0.1, 0.01, 0.1])
    tuned = minimax(z1, m, *kind)
    absorber = Absorber(z1, m, tuned.stiffness_ratio, tuned.secondary_damping)
    found = mistuning(absorber, *kind)
    assert found.stiffness.value.shape == (3, 3, 2) and found.corner.value.shape == (3, 3)
    for share, sign, column in ((0.05, -1.0, 0), (0.05, 1.0, 1)):
        off = absorber._replace(stiffness_ratio=tuned.stiffness_ratio * (1.0 + sign * share))
        loss = peaks(off, *kind).largest / tuned.largest - 1.0
        assert found.stiffness.value[:, 1, column] == pytest.approx(loss, rel=1e-9)
        off = absorber._replace(secondary_damping=tuned.secondary_damping * (1.0 + sign * share))
        loss = peaks(off, *kind).largest / tuned.largest - 1.0
        assert found.damping.value[:, 1, column] == pytest.approx(loss, rel=1e-9)
    # an optimum loses by every change, and by both more than by one
    for part in (found.stiffness, found.damping, found.corner):
        assert np.all(part.value > 0.0) and np.all(part.error < 1e-9)
    assert np.all(np.diff(found.corner.value, axis=-1) > 0.0)
    assert np.all(found.corner.value >= np.max(found.stiffness.value, axis=-1) - 1e-12)

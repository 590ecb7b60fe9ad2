"""Claim: the motor's axial force fits its skewed conductors, and its sums are those of a signal.

The torque is that of the shipped case. Truth: virtual work, Parseval, dense sampling, many digits.
"""

from types import SimpleNamespace

import mpmath as mp
import numpy as np
import pytest
from shipped_cases import ROOT, fresh, result_of

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.axial_force import axial_force

TABLE = np.loadtxt(ROOT / "cases" / "compressor_motor_torque.csv", delimiter=",", skiprows=2)
ORDER, COSINE, SINE = TABLE[:, 0].astype(int), TABLE[:, 1], TABLE[:, 2]
DIAMETER, SKEW = 6.0, 0.035
PATH = "excitation/motor/"


def force_of(order=ORDER, cosine=COSINE, sine=SINE, diameter=DIAMETER, skew=SKEW):
    torque = SimpleNamespace(order=order, cosine=cosine, sine=sine)
    motor = SimpleNamespace(torque=torque, rotor_diameter=diameter, skew_angle=skew)
    orders, force = axial_force(motor)
    assert orders.tolist() == sorted(n for n in order if n)
    return force


def signal_of(force, angle):
    return (force.axial_force.value @ np.exp(1j * np.multiply.outer(ORDER[1:], angle))).real


@pytest.mark.parametrize("skew", [0.035, -0.5, 1.2])
def test_sliding_along_the_conductors_does_no_work(skew):
    """A force normal to the conductors: turn and shift along them cost torque and force nothing."""
    force = force_of(skew=skew)
    torque = COSINE[1:] - 1j * SINE[1:]
    turn, shift = -np.sin(skew) / (DIAMETER / 2.0), np.cos(skew)
    work = torque * turn + force.axial_force.value * shift
    assert np.all(np.abs(work) <= 4e-16 * np.abs(torque * turn) + force.axial_force.error * shift)
    assert force.mean_force.value == pytest.approx(
        COSINE[0] * 2.0 * np.tan(skew) / DIAMETER, rel=1e-15
    )


def test_peak_is_that_of_dense_samples_and_the_sum_bounds_it():
    force = force_of()
    step = 2.0 * np.pi / 65536
    samples = np.abs(signal_of(force, step * np.arange(65536)))
    curvature = float(np.abs(force.axial_force.value) @ ORDER[1:].astype(float) ** 2)
    assert samples.max() <= force.peak.value + force.peak.error
    assert force.peak.value <= samples.max() + 0.5 * curvature * (step / 2.0) ** 2
    assert force.rms.value < force.peak.value < force.sum_of_amplitudes.value
    # what the source sums is a bound: the force stays a tenth below it
    assert 0.90 < force.peak.value / force.sum_of_amplitudes.value < 0.92


def test_values_and_errors_in_digits():
    force = force_of()
    with mp.workdps(40):
        factor = 2 * mp.tan(mp.mpf(SKEW)) / mp.mpf(DIAMETER)
        exact = [
            factor * mp.mpc(c, -s) for c, s in zip(COSINE.tolist(), SINE.tolist(), strict=True)
        ]
        size = [abs(value) for value in exact[1:]]
        errors = [
            abs(mp.mpmathify(complex(ours)) - value)
            for ours, value in zip(force.axial_force.value, exact[1:], strict=True)
        ]
        assert all(
            one <= bound
            for one, bound in zip(errors, force.axial_force.error.tolist(), strict=True)
        )
        assert max(force.axial_force.error) <= 1e3 * max(errors)
        for ours, value in (
            (force.mean_force, exact[0].real),
            (force.sum_of_amplitudes, mp.fsum(size)),
            (force.rms, mp.sqrt(mp.fsum(one**2 for one in size) / 2)),
        ):
            assert abs(mp.mpf(float(ours.value)) - value) <= ours.error <= 1e-13 * abs(value)


@pytest.mark.parametrize("scale", [1e-250, 1e250])
def test_scales_do_not_under_or_overflow(scale):
    one, other = force_of(), force_of(cosine=COSINE * scale, sine=SINE * scale)
    for name in ("sum_of_amplitudes", "peak", "rms"):
        value = float(getattr(other, name).value)
        assert value == pytest.approx(scale * float(getattr(one, name).value), rel=1e-12)


@pytest.mark.parametrize("order", [0, 3])
def test_a_force_beyond_all_numbers_is_refused(order):
    with pytest.raises(NumericalFailure, match="axial force of the motor"):
        force_of([order], [1e308], [0.0], diameter=1e-3)


def test_the_case_holds_the_kernel_in_newtons():
    record = result_of("compressor_motor").record
    inch, pound_force = 0.0254, 4.4482216152605
    ours = force_of(cosine=COSINE * inch * pound_force, sine=SINE * inch * pound_force,
                    diameter=DIAMETER * inch)  # fmt: skip
    force = record[PATH + "axial_force"]
    np.testing.assert_array_equal(force.axes[0].values, np.arange(1, 41))
    np.testing.assert_allclose(force.values, ours.axial_force.value, rtol=1e-14)
    for name, value in (("mean_force", ours.mean_force), ("peak", ours.peak), ("rms", ours.rms)):
        quantity = record[PATH + name]
        assert float(quantity.values) == pytest.approx(float(value.value), rel=1e-14)
        assert 0.0 < quantity.error_estimate < 1e-13 * abs(float(value.value))
    assert any("skew angle" in method.citation for method in record.methods)


def test_the_force_shakes_no_body():
    """It is internal: without the motor the excitation is the same to the last bit."""
    straight = result_of("compressor_motor", "machine.motor.skew_angle=0.0").record
    skewed = fresh("compressor_motor").record
    for path in ("excitation/force", "excitation/couple"):
        np.testing.assert_array_equal(straight[path].values, skewed[path].values)
    assert not np.any(straight[PATH + "axial_force"].values)

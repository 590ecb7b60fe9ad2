"""Axial force of a rotor whose conductors are skewed, from the harmonics of its torque."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.results import OfMotor
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.cycle_peak import cycle_peak

if TYPE_CHECKING:
    from vibecalc.parts.motor_tables import Motor


def axial_force(motor: "Motor | None") -> tuple[np.ndarray, OfMotor]:
    """Axial force (2 T / D) tan(beta) of a torque T on conductors skewed by beta.

    The torque needs the tangential force 2 T / D at the conductors. The force on a conductor is
    normal to it, so that a skewed one, held to the same torque, is pushed along the rotor by the
    tangential force times tan(beta). (Ong 2000, eqs. 6.1 to 6.6, write sin(beta), as if 2 T / D
    were the normal force; and give the sum of amplitudes as the force.)

    The stator has the opposite force, and the thrust bearing carries it from the rotor. Where both
    sit in one housing it is internal to the body: it loads the bearing and does not shake the body,
    hence is no part of the excitation.

    The torque on the rotor is the sum of cosine cos(n a) + sine sin(n a) over the orders n of the
    crank speed, D in m the diameter of the rotor, beta in rad within a quarter of a turn. A
    positive beta leans the conductors back against the crank's sense of rotation, seen along the
    axis; then a torque in that sense pushes the rotor along the axis. Gives the orders above 0,
    ascending, and the force.

    Raises
    ------
    NumericalFailure
        A force is not a finite number.
    """
    assert motor is not None, "only asked of a machine with a motor"
    order = np.asarray(motor.torque.order, dtype=np.int64)
    sequence = np.argsort(order, kind="stable")
    order = order[sequence]
    torque = np.array(motor.torque.cosine) - 1j * np.array(motor.torque.sine)
    with np.errstate(over="ignore", invalid="ignore"):
        force = (torque * (2.0 * np.tan(motor.skew_angle) / motor.rotor_diameter))[sequence]
    if not np.isfinite(force).all():
        raise NumericalFailure(
            "the axial force of the motor is not a finite number: its torque, the skew angle or "
            "the diameter of its rotor is out of range"
        )
    bounded = rounded(force, 8)
    harmonics = bounded[order > 0]
    scale = float(np.abs(force).max()) or 1.0  # free of overflow
    peak = cycle_peak(np.where(order > 0, force, 0.0), order)
    found = OfMotor(
        axial_force=harmonics,
        mean_force=bounded[order == 0].real.sum(),
        sum_of_amplitudes=abs(harmonics).sum(),
        peak=Bounded(peak.value, peak.error + harmonics.error.sum(-1)),
        rms=(harmonics * (np.sqrt(0.5) / scale)).norm() * scale,
    )
    return order[order > 0], found

"""Motors that no terminal and no shaft can tell apart: leakage moved between stator and rotor.

With D = i w + Z Y the circuit enters the terminals as l_stator + 1 / Y(i v) alone. Taking the
difference d = l_stator - l_new out of the stator and putting it in front of 1 / Y leaves a function
of the same kind, hence another rotor with as many cages. Torque and stator current are then the
same, steady and in transients. (Commonly shown for one cage as T, Gamma and inverse Gamma form:
G. R. Slemon, IEEE Transactions on Industry Applications 25, 1989. For more cages: own derivation.)
"""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.numerics.typing import FloatArray


def transient_inductance(motor: InductionMotor) -> FloatArray:
    """What a sudden stator current meets, the rotor's fluxes being held, H (...,)."""
    shares = (1.0 / np.asarray(motor.rotor_leakage)).sum(axis=-1)
    inside = 1.0 / (1.0 / np.asarray(motor.magnetising_inductance) + shares)
    return np.asarray(np.asarray(motor.stator_leakage) + inside)


def with_stator_leakage(motor: InductionMotor, stator_leakage: ArrayLike) -> InductionMotor:
    """The equivalent motor with this stator leakage (H), cages with the lowest R / l first.

    With m = M d / (M + d) and t = M / (M + d), the rotor seen from behind d is
    1 / (M + d) + t^2 x 1' (R + x (l + m 1 1'))^-1 1 at x = i v; the eigenvectors of the symmetric
    pair in the brackets give the cages. The rounding is some 100 units in the last place as long as
    both leakages are below nine tenths of `transient_inductance` and the cages well apart.

    Raises
    ------
    NumericalFailure
        The leakage asked for is not below the transient inductance: no such motor exists. Or two
        cages have the same ratio of resistance to leakage and are one.
    """
    wanted = np.asarray(stator_leakage, dtype=float)
    if not np.all(wanted < transient_inductance(motor)):
        raise NumericalFailure(
            "the stator leakage of a motor must be below its transient inductance"
        )
    magnetising = np.asarray(motor.magnetising_inductance, dtype=float)
    moved = np.asarray(motor.stator_leakage, dtype=float) - wanted
    ratio = magnetising / (magnetising + moved)
    resistance = np.asarray(motor.rotor_resistance, dtype=float)
    leakage = np.asarray(motor.rotor_leakage, dtype=float)
    inductance = leakage[..., None] * np.eye(leakage.shape[-1])
    inductance = inductance + (ratio * moved)[..., None, None]
    root = np.sqrt(resistance)
    times, vectors = np.linalg.eigh(inductance / (root[..., :, None] * root[..., None, :]))
    times, vectors = times[..., ::-1], vectors[..., ::-1]
    share = np.abs(ratio)[..., None] * (vectors / root[..., :, None]).sum(axis=-2)
    if not np.all(share**2 > 0.0):
        raise NumericalFailure("cages with one ratio of resistance to leakage are one cage")
    return motor._replace(
        stator_leakage=wanted,
        magnetising_inductance=magnetising + moved,
        rotor_resistance=1.0 / share**2,
        rotor_leakage=times / share**2,
    )

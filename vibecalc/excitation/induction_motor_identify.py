"""Which parameters of an induction motor a torque table determines, and which it cannot."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import STEP, InductionMotor, torque_of
from vibecalc.numerics.rounding import BoolArray, FloatArray

# ----------------------------------------------------------------------------
# How the steady torque of an induction motor follows its parameters.
# ----------------------------------------------------------------------------


def parameter_names(cages: int) -> tuple[str, ...]:
    """Names of the columns of `torque_sensitivity`."""
    numbers = [""] if cages == 1 else [f" {cage + 1}" for cage in range(cages)]
    return (
        "stator_resistance",
        "stator_leakage",
        "magnetising_inductance",
        *(f"rotor_resistance{number}" for number in numbers),
        *(f"rotor_leakage{number}" for number in numbers),
    )


def torque_sensitivity(motor: InductionMotor, slip_speed: ArrayLike) -> FloatArray:
    """Derivatives of the steady torque by the logarithm of each parameter, N m (..., parameters).

    A column is the torque's change in N m for a parameter that grows by the factor e, to first
    order; columns as in `parameter_names`. The voltage needs none: torque goes with its square.
    Leading axes of the motor and of `slip_speed` (rad/s, mechanical) broadcast.
    """
    columns = []
    for name in InductionMotor._fields[3:]:
        value = np.asarray(getattr(motor, name), dtype=float)
        cages = np.eye(value.shape[-1]) if name.startswith("rotor") else [1.0]
        for share in cages:
            moved = motor._replace(**{name: value * (1.0 + 1j * STEP * np.asarray(share))})
            columns.append(torque_of(moved, np.asarray(slip_speed, dtype=float)).imag / STEP)
    return np.stack(np.broadcast_arrays(*columns), axis=-1)


# ----------------------------------------------------------------------------
# Which parameters of a motor a torque table tells, and which it does not.
#
# For small changes the logarithms of the parameters move the logarithms of the torques by a matrix
# J. Its singular vectors are products of powers of the parameters; its singular values say how
# strongly the table answers to each product. An error of one percent in every row, independent of
# the others, moves a product by the factor exp(.01 / singular value). (G. H. Golub and C. F. Van
# Loan, Matrix Computations, 4th ed. 2013, sec. 5.5.)
# ----------------------------------------------------------------------------

#: standard error of a row of the table to which all spreads refer
TABLE_ERROR = 0.01
#: a product that this table error moves by more than exp(.5) counts as not identifiable
NOT_IDENTIFIABLE = 0.5
#: singular values below this share of the largest are zero to rounding
ZERO = 1e-11


class Identifiability(NamedTuple):
    """What the table tells of the n parameters in `names`, near the motor given.

    `singular_values` (n,) fall; row k of `combinations` (n, n) holds the exponents of the product
    that belongs to value k; `spread` (n,) is the standard error of its logarithm for 1 % of error
    in the table (infinite where the table does not answer at all), `identifiable` (n,) whether it
    is below `NOT_IDENTIFIABLE`. The two products of which no table tells anything are chosen so
    that the first keeps the inductance of the stator (it moves leakage between stator and rotor)
    and the second is at right angles to it. `free_spread` (n,) is the same for each parameter alone
    if all are unknown, `held_spread` (n,) if the two assumptions of the fit are held: the sum of
    stator leakage and magnetising inductance, and the ratio of the stator leakage to the transient
    inductance.
    """

    names: tuple[str, ...]
    singular_values: FloatArray
    combinations: FloatArray
    spread: FloatArray
    identifiable: BoolArray
    free_spread: FloatArray
    held_spread: FloatArray


def identifiability(motor: InductionMotor, slip: FloatArray) -> Identifiability:
    """Singular values and spreads for the slips (rows,) in rad/s of a table.

    All parameters but line, poles and stator resistance, which are given with the table, each row
    of which has the error `TABLE_ERROR`.
    """
    names = parameter_names(np.asarray(motor.rotor_resistance).shape[-1])[1:]
    torque = torque_of(motor, slip)
    change = torque_sensitivity(motor, slip)[:, 1:] / torque[:, None]
    _, singular, rows = np.linalg.svd(change, full_matrices=True)
    values = np.zeros(len(names))
    values[: singular.size] = singular
    there = values > ZERO * values[0]
    rows[~there] = _leakage_first(rows[~there], motor)
    strongest = np.argmax(np.abs(rows), axis=1)
    rows *= np.sign(rows[np.arange(len(names)), strongest])[:, None]
    spread = np.full(len(names), np.inf)
    spread[there] = TABLE_ERROR / values[there]
    takes_part = np.abs(rows) > 1e-7
    parts = np.abs(rows) * np.where(takes_part, spread[:, None], 0.0)
    basis = _directions_left(motor, names)
    _, triangle = np.linalg.qr(change @ basis)
    held = TABLE_ERROR * np.linalg.norm(basis @ np.linalg.pinv(triangle), axis=1)
    return Identifiability(
        names=names,
        singular_values=values,
        combinations=rows,
        spread=spread,
        identifiable=spread < NOT_IDENTIFIABLE,
        free_spread=np.linalg.norm(parts, axis=0),
        held_spread=held,
    )


def _leakage_first(rows: FloatArray, motor: InductionMotor) -> FloatArray:
    """The same directions, one of which changes the stator's inductance, in last place."""
    inductance = np.zeros(rows.shape[1])
    inductance[:2] = (
        float(np.asarray(motor.stator_leakage)),
        float(np.asarray(motor.magnetising_inductance)),
    )
    turn = np.linalg.svd((rows @ inductance)[None, :])[2] if len(rows) else np.eye(0)
    return np.asarray(turn[::-1] @ rows)


def product_of_powers(names: tuple[str, ...], exponents: FloatArray) -> str:
    """The combination in words, its small exponents left out."""
    strong = np.flatnonzero(np.abs(exponents) >= 0.1)
    strong = strong[np.argsort(-np.abs(exponents[strong]), kind="stable")]
    return " * ".join(f"{names[k]}^{exponents[k]:.2f}" for k in strong)


def _directions_left(motor: InductionMotor, names: tuple[str, ...]) -> FloatArray:
    """Orthonormal basis (n, n - 2) of the changes that keep both assumptions of the fit."""
    leakage = float(np.asarray(motor.stator_leakage))
    magnetising = float(np.asarray(motor.magnetising_inductance))
    shares = 1.0 / np.concatenate([[magnetising], np.asarray(motor.rotor_leakage, dtype=float)])
    inside = 1.0 / shares.sum()
    fixed = np.zeros((2, len(names)))
    fixed[0, :2] = leakage, magnetising
    # ratio of the leakage to leakage + inside: d log inside = sum of shares times d log of each
    fixed[1, 0] = 1.0
    fixed[1, 1] = -shares[0] * inside
    fixed[1, -(shares.size - 1) :] = -shares[1:] * inside
    fixed /= np.linalg.norm(fixed, axis=1, keepdims=True)
    return np.asarray(np.linalg.svd(fixed)[2][2:].T)


# ----------------------------------------------------------------------------
# Motors that no terminal and no shaft can tell apart: leakage moved between stator and rotor.
#
# With D = i w + Z Y the circuit enters the terminals as l_stator + 1 / Y(i v) alone. Taking the
# difference d = l_stator - l_new out of the stator and putting it in front of 1 / Y leaves a
# function of the same kind, hence another rotor with as many cages. Torque and stator current are
# then the same, steady and in transients. (Commonly shown for one cage as T, Gamma and inverse
# Gamma form: G. R. Slemon, IEEE Transactions on Industry Applications 25, 1989. For more cages: own
# derivation.)
# ----------------------------------------------------------------------------


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

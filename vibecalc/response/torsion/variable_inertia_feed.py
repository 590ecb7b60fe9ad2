"""Which orders feed which: what a variable inertia adds to the twist of each section, by source.

Order q of the twist makes, through the inertias' order p - q (and p + q), the torque

    w^2 / 2 (p^2 + q^2) (J_{p-q} d_q + J_{p+q} conj d_q)

of order p. Where p w is near a natural frequency the line answers: a secondary resonance, at an
order that may have no torque of its own.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, SINGULAR
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.variable_inertia import VariableLine, free_pieces
from vibecalc.response.torsion.variable_inertia_balance import shaft_matrices


class Feed(NamedTuple):
    """Twist phi[first] - phi[second] by receiving order, feeding order and element, rad, 0-to-peak.

    `twist` and `error` (N + 1, N + 1, e). Summed over the feeding orders it is, for the linear
    response, exactly its twist less that at constant inertia. Round-off is estimated from the
    condition of the line at each order.
    """

    twist: ComplexArray
    error: FloatArray


def section_twist(line: Line, angle: ComplexArray) -> ComplexArray:
    """Twist (..., e) of every element from angles (..., n)."""
    return np.asarray(angle[..., line.first] - angle[..., line.second])


def feed(system: VariableLine, speed: float, angle: ComplexArray, angle_error: FloatArray) -> Feed:
    """Contributions at one speed, from the linear response `angle` (N + 1, n) and its error.

    Raises
    ------
    NumericalFailure
        An order meets an undamped natural frequency of the mean line.
    """
    orders = np.arange(len(angle))
    n = angle.shape[1]
    drive = _coupling(system, speed, len(angle), angle)
    slip = np.abs(
        _coupling(system, speed, len(angle), np.abs(angle).astype(np.complex128), sizes=True)
    )
    doubt = np.abs(
        _coupling(system, speed, len(angle), angle_error.astype(np.complex128), sizes=True)
    )
    twist = np.empty((len(orders), len(orders), len(system.line.first)), dtype=np.complex128)
    error = np.empty(twist.shape)
    for p in orders:
        compliance, relative = _compliance(system, speed, int(p), n)
        rows = section_twist(system.line, compliance.T).T
        twist[p] = drive[p] @ rows.T
        error[p] = (doubt[p] + (relative + 8.0 * EPSILON) * slip[p]) @ np.abs(rows).T
        error[p] += relative * (slip[p] @ np.abs(compliance).max(axis=0))[:, None]
    return Feed(twist, error)


def _coupling(
    system: VariableLine, speed: float, count: int, angle: ComplexArray, *, sizes: bool = False
) -> ComplexArray:
    """Torques (P, Q, n) at orders p from orders q; with `sizes` bounds from magnitudes."""
    n = angle.shape[1]
    half = np.zeros((2 * count, n), dtype=np.complex128)
    given = 0.5 * (np.abs(system.variation) if sizes else system.variation).T
    steps = system.turns * np.arange(1, len(given) + 1)
    kept = steps < 2 * count
    half[steps[kept]] = given[kept]
    both = np.concatenate([half[:0:-1].conj(), half])
    step = np.arange(count)
    middle = 2 * count - 1
    sum_, apart = (both[middle + step[:, None] + s * step] for s in (1, -1))
    torque = apart * angle + sum_ * angle.conj()
    # a mean is one harmonic of the two-sided series, every other order two
    torque[0] *= 0.5
    if not sizes:
        torque[0] = torque[0].real
    squares = step[:, None] ** 2 + step**2
    return np.asarray(0.5 * (speed / system.turns) ** 2 * squares[..., None] * torque)


def _compliance(
    system: VariableLine, speed: float, step: int, n: int
) -> tuple[ComplexArray, float]:
    """Twist (n, n) of the mean line for torques at one order, and its relative round-off."""
    own = shaft_matrices(system, speed, np.array([step]))[0]
    index = np.arange(n)
    own[index, index] -= (speed * step / system.turns) ** 2 * system.line.inertia
    if step == 0:
        free = free_pieces(system.line)
        load, origin = free * system.load, free * system.line.inertia
        scale = np.abs(own).max()
        load, origin = (scale * (part.T / np.abs(part).max(axis=1)) for part in (load, origin))
        corner = np.zeros((len(free), len(free)))
        own = np.block([[own, -load], [origin.T, corner]])
    relative = EPSILON * float(np.linalg.cond(own)) if own.size else 0.0
    if not relative < SINGULAR:
        raise NumericalFailure(
            f"variable inertia at {speed:.6g} rad/s: order {step / system.turns:g} meets an "
            "undamped natural frequency of the line"
        )
    return np.asarray(np.linalg.inv(own)[:n, :n]), relative

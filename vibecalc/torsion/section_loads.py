"""What sections, gears and dampers of a shaft line carry: torque and heat."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.bounded import Bounded, reshaped, rounded, square, where
from vibecalc.numerics.rounding import ComplexArray, FloatArray
from vibecalc.numerics.synthesis import over_cycle
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, complex_stiffness, stiffness_matrix, walk

#: of a complex stiffness
STIFFNESS_ROUNDINGS = 4.0

# ----------------------------------------------------------------------------
# Torque of the elements of a shaft line, and the largest half range against speed.
# ----------------------------------------------------------------------------


def twist_and_torque(line: Line, frequency: ArrayLike, angle: Bounded) -> tuple[Bounded, Bounded]:
    """Twists phi[first] - phi[second] in rad and torques in N m, (..., e), complex, 0-to-peak.

    From angles (..., n) at frequencies (...) in rad/s. The twist of a shaft much stiffer than what
    it drives is a small difference of angles: its relative error is large then, and counted.
    """
    twist = angle[..., line.first] - angle[..., line.second]
    stiffness = complex_stiffness(line, np.asarray(frequency, dtype=float))
    return twist, rounded(stiffness, STIFFNESS_ROUNDINGS) * twist


#: speeds of one block of `largest_half_range`
ROWS = 64


def largest_half_range(
    line: Line,
    order: FloatArray,
    torque: Callable[[FloatArray], ComplexArray],
    stations: Sequence[int],
    weight: FloatArray,
    speed: FloatArray,
    *,
    of_twist: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Largest weighted half range (s,) of torque or twist at speeds (s,) in rad/s, and its error.

    `torque` gives for speeds (s,) the torques (s, m, k) in N m of the orders (m,) on k `stations`;
    elements whose `weight` (e,) is zero do not count. Infinite where nothing damps an order.
    """
    counts = np.flatnonzero(weight > 0.0)
    value, error = np.empty(len(speed)), np.zeros(len(speed))
    for start in range(0, len(speed), ROWS):
        part = slice(start, start + ROWS)
        frequency = speed[part, None] * order
        solved = forced_masked(line, frequency, torque(speed[part]), stations=stations)
        uncertainty = np.where(solved.masked, 0.0, solved.error)[..., None]
        both = twist_and_torque(line, frequency, Bounded(solved.angle, uncertainty))
        wave = reshaped(
            both[0 if of_twist else 1][..., counts], lambda one: np.moveaxis(one, 1, -1)
        )
        half = weight[counts] * over_cycle(order, wave).half_range
        masked = np.any(solved.masked, axis=-1)
        value[part], error[part] = where(masked, np.inf, half.max())
    return value, error


# ----------------------------------------------------------------------------
# Steady torque that the elements of a line carry, from the mean torques at its freedoms.
# ----------------------------------------------------------------------------


def steady_shares(line: Line) -> FloatArray:
    """Torque (e, n) of each element for a mean torque of one at each freedom of a line at rest.

    With mean torques M (n,) that balance, shares @ M is k (phi[first] - phi[second]). In a tree
    that nothing holds, or one spring to ground, which has nothing to carry then, equilibrium alone
    tells it (shares of 0 and 1, without rounding), else the stiffnesses do. An element without
    stiffness carries nothing.
    """
    count, elements = len(line.inertia), len(line.stiffness)
    neighbours: dict[int, dict[int, int]] = {station: {} for station in range(count)}
    springs = np.flatnonzero(line.stiffness).tolist()
    for e in springs:
        a, b = int(line.first[e]), int(line.second[e])
        neighbours[a][b] = neighbours[b][a] = e
    above: dict[int, int] = {}
    for root in range(count):
        if root not in above:
            above |= walk(neighbours, root)
    held = np.count_nonzero(line.ground_stiffness)
    if len(springs) > sum(parent >= 0 for parent in above.values()) or held > 1:
        inverse = np.linalg.pinv(stiffness_matrix(line), hermitian=True)
        twist = inverse[line.first] - inverse[line.second]
        return np.asarray(line.stiffness[:, None] * twist)
    below = np.eye(count)
    shares = np.zeros((elements, count))
    for station, parent in reversed(above.items()):
        if parent >= 0:
            # what stands below an element is kept in balance by it
            edge = neighbours[station][parent]
            shares[edge] = below[station] * (1.0 if line.first[edge] == station else -1.0)
            below[parent] += below[station]
    return shares


# ----------------------------------------------------------------------------
# Mean power that the dashpots and loss factors of a shaft line turn into heat.
# ----------------------------------------------------------------------------


def ground_heat(line: Line, frequency: FloatArray, angle: Bounded) -> Bounded:
    """Mean power (..., n) of absolute damping in W, w^2 c |angle|^2 / 2."""
    return 0.5 * frequency[..., None] ** 2 * line.absolute_damping * square(abs(angle))

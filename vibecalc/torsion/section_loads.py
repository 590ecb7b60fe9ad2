"""What sections, gears and dampers of a shaft line carry: torque and heat."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, stiffness_matrix
from vibecalc.torsion.synthesis import synthesis

# ----------------------------------------------------------------------------
# Torque of the elements of a shaft line, and the largest half range against speed.
# ----------------------------------------------------------------------------


class SectionTorque(NamedTuple):
    """Torques (..., e) in N m, complex, 0-to-peak, on the twist phi[first] - phi[second] in rad.

    `stiffness` is what the twist does, k times it; `damping` what dashpot and loss factor add.
    `error` (..., e) is absolute, of `total`.
    """

    twist: ComplexArray
    stiffness: ComplexArray
    damping: ComplexArray
    error: FloatArray

    @property
    def total(self) -> ComplexArray:
        """What the element carries."""
        return self.stiffness + self.damping


def section_torque(
    line: Line, frequency: ArrayLike, angle: ArrayLike, error: ArrayLike = 0.0
) -> SectionTorque:
    """From angles (..., n) with absolute errors (...) at frequencies (...) in rad/s.

    The twist of a shaft much stiffer than what it drives is a small difference of angles: its
    relative error is large then, and counted.
    """
    w = np.asarray(frequency, dtype=float)[..., None]
    value = np.asarray(angle)
    one, other = value[..., line.first], value[..., line.second]
    twist = one - other
    stiffness = line.stiffness * twist
    damping = 1j * (line.stiffness * line.loss_factor + w * line.damping) * twist
    size = line.stiffness * (1.0 + np.abs(line.loss_factor)) + w * line.damping
    uncertainty = 2.0 * np.asarray(error)[..., None] + 4.0 * EPSILON * np.abs(twist)
    return SectionTorque(twist, stiffness, damping, size * uncertainty)


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
        uncertainty = np.where(solved.masked, 0.0, solved.error)
        through = section_torque(line, frequency, solved.angle, uncertainty)
        wave, wave_error = through.total, through.error
        if of_twist:
            wave = through.twist
            wave_error = np.broadcast_to(2.0 * uncertainty[..., None], wave.shape)
        whole = synthesis(
            order,
            np.moveaxis(wave[..., counts], 1, -1),
            np.moveaxis(wave_error[..., counts], 1, -1),
        )
        masked = np.any(solved.masked, axis=-1)
        value[part] = np.where(masked, np.inf, np.max(weight[counts] * whole.half_range, axis=-1))
        # of orders the squares add: each is a solution of its own
        wave_uncertainty = np.sqrt(np.sum(np.square(wave_error[..., counts]), axis=1))
        bound = np.minimum(whole.error, wave_uncertainty + 8.0 * EPSILON * whole.half_range)
        error[part] = np.where(masked, 0.0, np.max(weight[counts] * bound, axis=-1))
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
    neighbours: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    springs = np.flatnonzero(line.stiffness).tolist()
    for e in springs:
        a, b = int(line.first[e]), int(line.second[e])
        neighbours[a].append((b, e))
        neighbours[b].append((a, e))
    order, above = _walked(neighbours)
    held = np.count_nonzero(line.ground_stiffness)
    if len(springs) > sum(edge >= 0 for _, edge in above) or held > 1:
        inverse = np.linalg.pinv(stiffness_matrix(line), hermitian=True)
        twist = inverse[line.first] - inverse[line.second]
        return np.asarray(line.stiffness[:, None] * twist)
    below = np.eye(count)
    shares = np.zeros((elements, count))
    for station in reversed(order):
        parent, edge = above[station]
        if edge >= 0:
            # what stands below an element is kept in balance by it
            shares[edge] = below[station] * (1.0 if line.first[edge] == station else -1.0)
            below[parent] += below[station]
    return shares


def _walked(
    neighbours: list[list[tuple[int, int]]],
) -> tuple[list[int], list[tuple[int, int]]]:
    """Freedoms, each after the one it hangs on, with that one and the element between (or -1)."""
    above = [(-1, -1)] * len(neighbours)
    visited = [False] * len(neighbours)
    order: list[int] = []
    for root in range(len(neighbours)):
        if visited[root]:
            continue
        visited[root] = True
        queue = [root]
        for station in queue:
            for other, edge in neighbours[station]:
                if not visited[other]:
                    visited[other] = True
                    above[other] = (station, edge)
                    queue.append(other)
        order += queue
    return order, above


# ----------------------------------------------------------------------------
# Gear mesh: mean and alternating torque together, and whether the teeth leave each other.
# ----------------------------------------------------------------------------


class MeshTorque(NamedTuple):
    """Arrays (...). `least` and `largest` over the cycle in N m, mean included, error `error`.

    `hammer`: the torque changes its sign within the cycle, so that the teeth lift off and strike
    back. `share` is the half range over the mean's magnitude, infinite for an unloaded mesh that
    vibrates, 0 for one at rest. `uncertain`: an end is zero to within the error.
    """

    least: FloatArray
    largest: FloatArray
    half_range: FloatArray
    share: FloatArray
    hammer: BoolArray
    uncertain: BoolArray
    error: FloatArray


def mesh_torque(
    mean: ArrayLike, order: ArrayLike, amplitude: ArrayLike, error: ArrayLike = 0.0
) -> MeshTorque:
    """From the mean torque (...) that the mesh transmits and orders (m,) of its torque (..., m).

    An order 0 among them would be counted alongside `mean`.
    """
    steady = np.asarray(mean, dtype=float)
    varying = synthesis(order, amplitude, error)
    least, largest = steady + varying.lowest, steady + varying.highest
    half_range = np.broadcast_to(varying.half_range, least.shape)
    size = np.abs(steady)
    unloaded = np.where(half_range > 0.0, np.inf, 0.0)
    share = np.where(size > 0.0, half_range / np.where(size > 0.0, size, 1.0), unloaded)
    uncertainty = varying.error + EPSILON * (size + half_range)
    hammer = (least < -uncertainty) & (largest > uncertainty)
    # the end that the mean keeps away from zero decides
    near = np.minimum(np.abs(least), np.abs(largest)) <= uncertainty
    return MeshTorque(
        least, largest, half_range, share, hammer, near & (half_range > 0.0), uncertainty
    )


# ----------------------------------------------------------------------------
# Mean power that the dashpots and loss factors of a shaft line turn into heat.
# ----------------------------------------------------------------------------


class Heat(NamedTuple):
    """Mean power in W at each frequency: `element` (..., e), `ground` (..., n), `error` of both.

    `dashpot` and `loss` are the parts of `element`; `ground` is of absolute damping. Powers of
    different orders add up to the total over the cycle. `error` (...) bounds each of them.
    """

    element: FloatArray
    dashpot: FloatArray
    loss: FloatArray
    ground: FloatArray
    error: FloatArray


def heat(line: Line, frequency: ArrayLike, angle: ArrayLike, error: ArrayLike = 0.0) -> Heat:
    """From angles (..., n), 0-to-peak, with absolute errors (...) at frequencies (...) in rad/s.

    A dashpot takes w^2 c |twist|^2 / 2, a loss factor w k eta |twist|^2 / 2.
    """
    w = np.asarray(frequency, dtype=float)[..., None]
    value, uncertainty = np.asarray(angle), np.asarray(error, dtype=float)[..., None]
    twist = np.abs(value[..., line.first] - value[..., line.second])
    size = np.abs(value)
    dashpot = 0.5 * w**2 * line.damping * twist**2
    loss = 0.5 * w * line.stiffness * line.loss_factor * twist**2
    ground = 0.5 * w**2 * line.absolute_damping * size**2
    element = dashpot + loss
    factor = 0.5 * w * (w * line.damping + line.stiffness * np.abs(line.loss_factor))
    wrong = factor * 2.0 * uncertainty * (2.0 * twist + 2.0 * uncertainty) + 8.0 * EPSILON * np.abs(
        element
    )
    of_ground = 0.5 * w**2 * line.absolute_damping * uncertainty * (2.0 * size + uncertainty)
    of_ground = of_ground + 8.0 * EPSILON * ground
    worst = np.maximum(np.max(wrong, axis=-1, initial=0.0), np.max(of_ground, axis=-1, initial=0.0))
    return Heat(element, dashpot, loss, ground, worst)

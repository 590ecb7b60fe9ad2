"""What is asked of a damper, and the line with its ring solved for complex amplitudes."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.torsion.line import Line

# ----------------------------------------------------------------------------
# Torque on the stations of a line as a smooth function of speed, with its slope.
# ----------------------------------------------------------------------------


class SpeedTorque(NamedTuple):
    """Piecewise polynomials: `knot` (p + 1,) in rad/s, `coefficient` (p, d + 1, m, n) in N m.

    In the piece that begins at knot[i] the torque of order m on freedom n is
    sum_j coefficient[i, j, m, n] (speed - knot[i])^j; complex, 0-to-peak.
    """

    knot: FloatArray
    coefficient: ComplexArray


def torque_at(torque: SpeedTorque, speed: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Torque and its derivative by speed, (s, m, n) each, at speeds (s,)."""
    interval = np.searchsorted(torque.knot, speed, side="right") - 1
    interval = np.clip(interval, 0, len(torque.coefficient) - 1)
    beyond = (speed - torque.knot[interval])[:, None, None]
    parts = torque.coefficient[interval]
    value, slope = np.zeros_like(parts[:, 0]), np.zeros_like(parts[:, 0])
    for power in range(parts.shape[1] - 1, -1, -1):
        slope = slope * beyond + value
        value = value * beyond + parts[:, power]
    return value, slope


# ----------------------------------------------------------------------------
# What is asked of a damper: the line, its torque, what is made small, and the limits.
# ----------------------------------------------------------------------------


def speed_torque(gas: ComplexArray, inertia: ComplexArray, card_speed: FloatArray) -> SpeedTorque:
    """Torques from gas (c, m, n) in N m of cards at speeds (c,), and inertia (m, n).

    Gas along straight lines between the cards, inertia, in N m per (rad/s)^2, with the square of
    the speed; one card holds at every speed.
    """
    if len(card_speed) < 2:
        parts = np.stack([gas[0], np.zeros_like(inertia), inertia])
        return SpeedTorque(np.array([0.0, np.inf]), parts[None])
    slope = np.diff(gas, axis=0) / np.diff(card_speed)[:, None, None]
    begin = card_speed[:-1, None, None]
    lines = np.stack(
        [gas[:-1] + begin**2 * inertia, slope + 2.0 * begin * inertia,
         np.broadcast_to(inertia, slope.shape)],
        axis=1,
    )  # fmt: skip
    return SpeedTorque(card_speed, lines)


class Damper(NamedTuple):
    """Ring inertia in kg m^2, spring in N m/rad, dashpot in N m s/rad, all referred."""

    inertia: float
    stiffness: float
    damping: float


class DamperProblem(NamedTuple):
    """A line without the ring of its damper, and what is made small.

    `station` the freedom that carries the damper; its hub belongs to the line.
    `order` (m,) multiples of the crank speed, each a multiple of 2 pi / `cycle`.
    `cycle` crank angle of one cycle in rad: 4 pi for four strokes, 2 pi for two.
    `torque` on all freedoms by order; `speed` (lowest, highest) of the range in rad/s.
    `weight` (e,) of each element: what is made small is weight times half range. With `quantity`
    "torque" the half range is of its torque, spring and dashpot together (a stress is a torque with
    the weight 1 / section modulus), with "twist" of its twist. Weight 0 leaves an element out.
    """

    line: Line
    station: int
    order: FloatArray
    cycle: float
    torque: SpeedTorque
    speed: tuple[float, float]
    weight: FloatArray
    quantity: str = "torque"


class Limits(NamedTuple):
    """Bounds (low, high) of the damper, and what it must bear.

    Equal bounds hold a value; `stiffness` (0, 0) is a viscous damper. `heat` in W is the mean power
    of the dashpot at the worst speed, `travel` in rad the largest angle between ring and hub over
    the cycle at the worst speed.
    """

    inertia: tuple[float, float]
    stiffness: tuple[float, float]
    damping: tuple[float, float]
    heat: float = np.inf
    travel: float = np.inf

    @property
    def bounds(self) -> FloatArray:
        """(3, 2): inertia, stiffness, damping by low, high."""
        return np.array([self.inertia, self.stiffness, self.damping], dtype=float)


def harmonics(problem: DamperProblem) -> IntArray:
    """Number of periods in a cycle of each order (m,); refuses orders that are not whole there."""
    exact = np.asarray(problem.order, dtype=float) * problem.cycle / (2.0 * np.pi)
    whole = np.rint(exact)
    if np.any(np.abs(exact - whole) > 1e-9) or np.any(whole < 1):
        raise NumericalFailure("orders of a damper design have to repeat with the cycle, above 0")
    return whole.astype(np.int64)


def check(problem: DamperProblem, limits: Limits) -> None:
    """Raise NumericalFailure for bounds of which no logarithm is searched, and unknown torques."""
    low, high = limits.bounds.T
    if low[0] <= 0.0 or low[2] <= 0.0:
        raise NumericalFailure("ring inertia and damping need a lower bound above zero")
    if low[1] == 0.0 and high[1] > 0.0:
        raise NumericalFailure(
            "a spring between zero and some bound is searched by its logarithm: give a lower bound "
            "above zero, or (0, 0) for a damper without spring"
        )
    (slow, fast), knot = problem.speed, problem.torque.knot
    if slow < knot[0] or fast > knot[-1]:
        raise NumericalFailure(
            f"the torque is known from {knot[0]:.6g} to {knot[-1]:.6g} rad/s, the range asks for "
            f"{slow:.6g} to {fast:.6g}"
        )


# ----------------------------------------------------------------------------
# A line with its ring in relative coordinates: one angle, and twists instead of the others.
#
# At low frequency a free line turns as one body, and the twist, a small difference of large angles,
# would lose digits. Here the twists are the unknowns, and stiffness enters on the diagonal alone.
# ----------------------------------------------------------------------------


class System(NamedTuple):
    """n freedoms and the ring: unknowns are one angle, n - 1 twists, and hub less ring (last).

    `angle` (n, n + 1) and `twist` (e, n + 1) give angles and twists from the unknowns, `ring`
    (n + 1,) the ring's angle. `mass`, `loss`, `spring` (n + 1, n + 1) are the line's own.
    """

    problem: DamperProblem
    harmonic: IntArray
    angle: FloatArray
    twist: FloatArray
    ring: FloatArray
    mass: FloatArray
    loss: FloatArray
    spring: ComplexArray

    def dynamic(self, damper: Damper, frequency: FloatArray) -> ComplexArray:
        """Dynamic stiffness (..., n + 1, n + 1) with the damper at frequencies (...) in rad/s."""
        w = frequency[..., None, None]
        mass = self.mass + damper.inertia * np.outer(self.ring, self.ring)
        matrix: ComplexArray = np.asarray(
            self.spring + 1j * w * self.loss - w**2 * mass, dtype=np.complex128
        )
        matrix[..., -1, -1] += damper.stiffness + 1j * frequency * damper.damping
        return matrix


def system_of(problem: DamperProblem) -> System:
    """Raises NumericalFailure for a line in several pieces."""
    line = problem.line
    angle = _spanning(line)
    station = problem.station
    n = line.inertia.size
    angle = np.hstack([angle, np.zeros((n, 1))])
    twist = angle[line.first] - angle[line.second]
    ring = angle[station].copy()
    ring[-1] = -1.0

    def whole(element: FloatArray, ground: FloatArray) -> FloatArray:
        matrix: FloatArray = (twist.T * element) @ twist + (angle.T * ground) @ angle
        return matrix

    none = np.zeros(n)
    return System(
        problem, harmonics(problem), angle, twist, ring,
        whole(np.zeros(line.stiffness.size), line.inertia),
        whole(line.damping, line.absolute_damping),
        whole(line.stiffness, line.ground_stiffness)
        + 1j * whole(line.stiffness * line.loss_factor, none),
    )  # fmt: skip


def _spanning(line: Line) -> FloatArray:
    """Angles (n, n) of the freedoms from the angle of one and n - 1 twists: entries 0, 1, -1.

    That one is held most or heaviest, so that what is summed over the others stays small. The
    stiffest elements are taken into the tree first, so that a loop is measured by the others.
    """
    n = line.inertia.size
    group = np.arange(n)
    nearby: list[list[tuple[int, float]]] = [[] for _ in range(n)]
    for e in np.argsort(-line.stiffness, kind="stable"):
        a, b = int(line.first[e]), int(line.second[e])
        if group[a] != group[b]:
            group[group == group[b]] = group[a]
            nearby[a].append((b, -1.0))
            nearby[b].append((a, 1.0))
    if np.any(group != group[0]):
        raise NumericalFailure("a damper is tuned on one line; this one is in several pieces")
    angle = np.zeros((n, n))
    held = line.ground_stiffness if np.any(line.ground_stiffness > 0.0) else line.inertia
    root = int(np.argmax(held))
    angle[root, 0] = 1.0
    visited, waiting, column = {root}, [root], 1
    while waiting:
        a = waiting.pop()
        for b, sign in nearby[a]:
            if b not in visited:
                # twist first - second: phi_b = phi_a - twist where a comes first
                angle[b] = angle[a]
                angle[b, column] += sign
                visited.add(b)
                waiting.append(b)
                column += 1
    return angle


# ----------------------------------------------------------------------------
# Complex amplitudes of a line with its damper, with all first derivatives, by direct solution.
# ----------------------------------------------------------------------------


class States(NamedTuple):
    """Unknowns (s, m, n + 1) of `System` at s speeds, and derivatives (4, s, m, n + 1).

    Derivatives by the logarithms of ring inertia, stiffness and damping, then by speed in rad/s;
    by speed alone (1, s, m, n + 1) where no others were asked for.
    """

    value: ComplexArray
    slope: ComplexArray


def solve(matrix: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Solutions (..., n, r), with rows and columns brought to equal size first."""
    size = _sizes(matrix)
    return _solved(_even(matrix, size), right, size)


def _sizes(matrix: ComplexArray) -> FloatArray:
    """What rows and columns are multiplied by."""
    size = 1.0 / np.sqrt(np.abs(np.diagonal(matrix, axis1=-2, axis2=-1)) + 1e-300)
    # a resonating diagonal says nothing of its row
    most: FloatArray = 1e3 / np.sqrt(np.max(np.abs(matrix), axis=-1))
    return np.minimum(size, most)


def _even(matrix: ComplexArray, size: FloatArray) -> ComplexArray:
    even: ComplexArray = size[..., :, None] * matrix * size[..., None, :]
    return even


def _solved(even: ComplexArray, right: ComplexArray, size: FloatArray) -> ComplexArray:
    try:
        found = np.linalg.solve(even, size[..., :, None] * right)
    except np.linalg.LinAlgError:
        found = np.full_like(right, np.nan)
    found = size[..., :, None] * found
    if not np.all(np.isfinite(found)):
        raise NumericalFailure(
            "an order meets an undamped natural frequency of the line with its damper"
        )
    return np.asarray(found)


def states(system: System, damper: Damper, speed: FloatArray, by_damper: bool = True) -> States:
    """Solve at speeds (s,) in rad/s; raises NumericalFailure on an undamped resonance.

    Without `by_damper` the derivatives are those by speed alone.
    """
    order = np.asarray(system.problem.order, dtype=float)
    w = speed[:, None] * order
    torque, torque_slope = torque_at(system.problem.torque, speed)
    matrix = system.dynamic(damper, w)
    size = _sizes(matrix)
    even = _even(matrix, size)
    right = np.zeros((*w.shape, matrix.shape[-1], 3 if by_damper else 1), dtype=complex)
    right[..., 0] = torque @ system.angle
    if by_damper:
        right[..., -1, 1] = 1.0
        right[..., 2] = system.ring
    u, *others = np.moveaxis(_solved(even, right, size), -1, 0)
    mass = system.mass + damper.inertia * np.outer(system.ring, system.ring)
    by_frequency = u @ (1j * system.loss) - 2.0 * w[..., None] * (u @ mass)
    by_frequency[..., -1] += 1j * damper.damping * u[..., -1]
    pushed = torque_slope @ system.angle - order[:, None] * by_frequency
    by_speed = _solved(even, pushed[..., None], size)[..., 0]
    if not by_damper:
        return States(u, by_speed[None])
    spring, ring = others
    relative = u[..., -1:]
    slope = np.stack([
        damper.inertia * w[..., None] ** 2 * ring * (u @ system.ring)[..., None],
        -damper.stiffness * spring * relative,
        -1j * damper.damping * w[..., None] * spring * relative,
        by_speed,
    ])  # fmt: skip
    return States(u, slope)

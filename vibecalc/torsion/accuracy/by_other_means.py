"""Shaft lines by other means: plain methods, long arithmetic, samples, steps in time."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import samples_of_harmonics
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import gas_torque_at, inertia_torque_at
from vibecalc.numerics.rounding import ComplexArray, FloatArray
from vibecalc.torsion.adapters.setup import Drive, Setup
from vibecalc.torsion.line import (
    Line,
    connected_parts,
    damping_matrix,
    dynamic_stiffness,
    path_order,
    stiffness_matrix,
)
from vibecalc.torsion.modes import Modes
from vibecalc.torsion.transient.march import transient_system

# ----------------------------------------------------------------------------
# Shaft lines by plain methods, and in long arithmetic from their equations of motion.
# ----------------------------------------------------------------------------

#: decimal digits of long arithmetic
DIGITS = 40


def exact_modes(line: Line) -> tuple[FloatArray, FloatArray]:
    """Frequencies (n,) in rad/s, ascending, and shapes (n, n), rounded from 40 digits.

    From the symmetric form of K and J; every freedom needs an inertia. Shapes as `as_shown`.
    """
    import mpmath

    n = len(line.inertia)
    with mpmath.workdps(DIGITS):
        root = [mpmath.sqrt(mpmath.mpf(j)) for j in line.inertia.tolist()]
        matrix = mpmath.zeros(n)
        for i, k in enumerate(line.ground_stiffness.tolist()):
            matrix[i, i] += mpmath.mpf(k)
        for a, b, k in zip(
            line.first.tolist(), line.second.tolist(), line.stiffness.tolist(), strict=True
        ):
            for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                matrix[i, j] += sign * mpmath.mpf(k)
        for i in range(n):
            for j in range(n):
                matrix[i, j] /= root[i] * root[j]
        square, vector = mpmath.eigsy(matrix)
        frequency = [float(mpmath.sqrt(abs(one))) for one in square]
        shape = [[float(vector[i, m] / root[i]) for i in range(n)] for m in range(n)]
    return np.array(frequency), as_shown(np.array(shape))


def as_shown(shape: FloatArray) -> FloatArray:
    """Shapes (m, n) with a largest angle of 1; of several within a thousandth the first counts."""
    size = np.abs(shape)
    top = size.max(axis=1)
    first = np.argmax(size >= (1.0 - 1e-3) * top[:, None], axis=1)
    row = np.arange(len(shape))
    return np.asarray(shape / np.copysign(top, shape[row, first])[:, None])


def exact_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """Angles (m, n) for torques (m, n) at frequencies (m,) in rad/s, rounded from 40 digits.

    Elimination of one freedom after the other, whatever the network.
    """
    import mpmath

    rows = []
    with mpmath.workdps(DIGITS):
        for w, load in zip(frequency.tolist(), torque, strict=True):
            rows.append([complex(one) for one in _exact_row(line, mpmath.mpf(w), load)])
    return np.array(rows)


def _exact_row(line: Line, w: Any, load: ComplexArray) -> list[Any]:
    """One frequency, all in the numbers of mpmath; `rest` holds rows of what is not eliminated."""
    import mpmath

    turn = mpmath.mpc(0, 1)
    rest: list[dict[int, Any]] = []
    for j, c, k in zip(
        line.inertia.tolist(), line.absolute_damping.tolist(), line.ground_stiffness.tolist(),
        strict=True,
    ):  # fmt: skip
        rest.append({len(rest): mpmath.mpf(k) + turn * w * mpmath.mpf(c) - w * w * mpmath.mpf(j)})
    for a, b, k, c, loss in zip(
        line.first.tolist(), line.second.tolist(), line.stiffness.tolist(), line.damping.tolist(),
        line.loss_factor.tolist(), strict=True,
    ):  # fmt: skip
        element = mpmath.mpf(k) * (1 + turn * mpmath.mpf(loss)) + turn * w * mpmath.mpf(c)
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            rest[i][j] = rest[i].get(j, mpmath.mpc(0)) + sign * element
    right = [mpmath.mpc(complex(one)) for one in load]
    for i, row in enumerate(rest):
        for j in [one for one in row if one > i]:
            factor = rest[j][i] / row[i]
            for column, value in row.items():
                if column > i:
                    rest[j][column] = rest[j].get(column, mpmath.mpc(0)) - factor * value
            right[j] -= factor * right[i]
    for i in range(len(rest) - 1, -1, -1):
        total = right[i] - sum(value * right[j] for j, value in rest[i].items() if j > i)
        right[i] = total / rest[i][i]
    return right


def dense_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """The same in double precision: one full matrix for each frequency."""
    try:
        found = np.linalg.solve(dynamic_stiffness(line, frequency), torque[..., None])
    except np.linalg.LinAlgError:
        raise NumericalFailure("the matrix of an order is singular") from None
    return np.asarray(found[..., 0])


def transfer_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """The same by 2 x 2 transfer matrices along a row, from a free end to the other.

    Angle and torque of each station are sums of what an angle of one at the first end does and of
    what the torques do; no torque may be left at the other end. Raises NumericalFailure for
    branches.
    """
    (piece, *others) = connected_parts(line)
    order = path_order(piece)
    if others or order is None:
        raise NumericalFailure("2 x 2 transfer matrices follow a row; this line has branches")
    place = {
        frozenset((a, b)): e
        for e, (a, b) in enumerate(zip(line.first.tolist(), line.second.tolist(), strict=True))
    }
    w = np.asarray(frequency)
    angle = np.zeros((2, *torque.shape), dtype=np.complex128)
    moved, held = np.zeros((2, 2, len(w)), dtype=np.complex128)
    moved[0] = 1.0
    for k, station in enumerate(order):
        angle[:, :, station] = moved
        own = line.ground_stiffness[station] + 1j * w * line.absolute_damping[station]
        held = held + (own - w**2 * line.inertia[station]) * moved
        held[1] -= torque[:, station]
        if k + 1 < len(order):
            e = place[frozenset((station, order[k + 1]))]
            shaft = line.stiffness[e] * (1.0 + 1j * line.loss_factor[e]) + 1j * w * line.damping[e]
            moved = moved + held / shaft
    return np.asarray(angle[1] - (held[1] / held[0])[:, None] * angle[0])


def modal_angles(
    line: Line, modes: Modes, count: int, frequency: FloatArray, torque: ComplexArray
) -> ComplexArray:
    """The same as a sum over the first `count` modes, what damping couples them by left out."""
    shape, w = modes.shape[:count], np.asarray(frequency)[:, None]
    loss = line._replace(damping=line.stiffness * line.loss_factor)
    loss = loss._replace(absolute_damping=np.zeros_like(line.inertia))
    own, lost = (
        np.einsum("mi,ij,mj->m", shape, damping_matrix(one), shape) for one in (line, loss)
    )
    natural = modes.frequency[:count]
    stiffness = modes.modal_inertia[:count] * (natural - w) * (natural + w)
    return np.asarray((torque @ shape.T / (stiffness + 1j * (w * own + lost))) @ shape)


def pole_angles(line: Line, frequency: FloatArray, torque: ComplexArray) -> ComplexArray:
    """The same by the eigenvalues and vectors of the state matrix, for dashpots alone."""
    if np.any(line.loss_factor):
        raise NumericalFailure("loss factors have no state matrix: it holds dashpots alone")
    n = len(line.inertia)
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -stiffness_matrix(line) / line.inertia[:, None]
    matrix[n:, n:] = -damping_matrix(line) / line.inertia[:, None]
    pole, right = np.linalg.eig(matrix)
    drive = np.linalg.solve(right, np.vstack([np.zeros((n, n)), np.diag(1.0 / line.inertia)]))
    part = (torque @ drive.T) / (1j * np.asarray(frequency)[:, None] - pole)
    return np.asarray(part @ right[:n].T)


# ----------------------------------------------------------------------------
# What the cylinders of an engine do over a cycle, by samples, plain rules and steps in time.
# ----------------------------------------------------------------------------

#: torque at crank angles (...) in rad
Torque = Callable[[FloatArray], FloatArray]


def cylinder_gas(drive: Drive, speed: float) -> Torque:
    """Gas torque in N m of a healthy cylinder at its own angles, with the cards of a speed."""
    share = drive.weights(np.asarray(speed))

    def torque(angle: FloatArray) -> FloatArray:
        each = [gas_torque_at(card, drive.geometry, angle) for card in drive.cards]
        return np.asarray(np.tensordot(share, np.array(each), 1))

    return torque


def on_freedoms(setup: Setup, torque: ComplexArray, drive: Drive | None = None) -> ComplexArray:
    """Torques (..., k) at the driven stations as those (..., n) on all freedoms of the line."""
    freedom = (setup.drive if drive is None else drive).freedom
    return np.asarray(torque @ (freedom[:, None] == np.arange(len(setup.model.line.inertia))))


def is_even(scene: Scene, setup: Setup) -> bool:
    """Whether all cylinders fire alike and have the same masses."""
    drive, train = setup.drive, scene.parts.crank_train
    masses = train.reciprocating_mass
    alike = np.all(drive.firing.fires) and np.all(drive.firing.pressure_scale == 1.0)
    return bool(alike and np.all(masses == masses[0]))


def station_torque(setup: Setup, speed: float) -> Callable[[FloatArray], FloatArray]:
    """Referred torque (..., n) of all cylinders on the freedoms at crank angles (...), means too.

    For engines that fire evenly, see `is_even`.
    """
    drive, shaft, gas = setup.drive, setup.shaft, cylinder_gas(setup.drive, speed)
    ratio = shaft.station_ratio[shaft.cylinder_station]

    def torque(angle: FloatArray) -> FloatArray:
        total = np.zeros((*np.shape(angle), len(setup.model.line.inertia)))
        for late, freedom, turns in zip(
            drive.firing.angle, shaft.cylinder_freedom, ratio, strict=True
        ):
            own = np.asarray(angle) - late
            total[..., freedom] += turns * gas(own)
            total[..., freedom] += (
                turns
                * speed**2
                * inertia_torque_at(
                    drive.geometry, drive.reciprocating_mass, drive.rod_inertia, own
                )
            )
        return total

    return torque


def fejer_rule(points: int) -> tuple[FloatArray, FloatArray]:
    """Nodes in 0 ... 1 and weights of Fejer's first rule: no value at an end is asked for."""
    place = (2.0 * np.arange(points) + 1.0) * np.pi / (2.0 * points)
    j = np.arange(1, points // 2 + 1)
    weight = 1.0 - 2.0 * np.sum(np.cos(2.0 * j * place[:, None]) / (4.0 * j**2 - 1.0), axis=1)
    return 0.5 - 0.5 * np.cos(place), weight / points


def quadrature_harmonics(
    torque: Torque, border: FloatArray, cycle: float, order: FloatArray,
    rule: tuple[FloatArray, FloatArray],
) -> tuple[ComplexArray, int]:  # fmt: skip
    """Harmonics (m,), 0-to-peak, by a rule on each piece of the cycle, and angles evaluated."""
    node, weight = rule
    width = np.diff(border)[:, None]
    angle = (border[:-1, None] + width * node).ravel()
    share = (width * weight).ravel() * (2.0 / cycle) * torque(angle)
    turned = np.exp(-1j * order[:, None] * angle)
    return np.asarray(turned @ share), angle.size


class Shooting(NamedTuple):
    """Section torques (steps, e) over a steady cycle, without their means, and multiplications."""

    torque: FloatArray
    work: float


def steady_by_steps(
    line: Line, torque: Callable[[FloatArray], FloatArray], speed: float, cycle: float, steps: int
) -> Shooting:
    """The steady cycle by the classical Runge-Kutta method and the state that comes back.

    The equations are linear: a step is x -> R x + what the torque adds, a cycle is P x + q, and the
    state that comes back solves (1 - P) x = q. Raises NumericalFailure for loss factors, and for
    steps so long that free motion grows.
    """
    system = transient_system(line)
    h, size = cycle / speed / steps, len(system.state_matrix)
    a = system.state_matrix * h
    one = np.eye(size)
    growth = one + a @ (one + a @ (one / 2.0 + a @ (one / 6.0 + a / 24.0)))
    if np.max(np.abs(np.linalg.eigvals(growth))) > 1.0 + 1e-9:
        raise NumericalFailure(f"{steps} steps in a cycle: RK4 is unstable with so long a step")
    values = torque(np.asarray(cycle / (2.0 * steps) * np.arange(2 * steps + 1)))
    # a mean would speed up the free line; what it twists is left out of the answer anyway
    values = values - values[:-1].mean(axis=0)
    drive = h * values @ system.input_matrix.T
    begin, middle, end = drive[:-2:2], drive[1::2], drive[2::2]
    at_begin = one / 6.0 + a @ (one / 6.0 + a @ (one / 12.0 + a / 24.0))
    at_middle = 2.0 / 3.0 * one + a @ (one / 3.0 + a / 12.0)
    gain = begin @ at_begin.T + middle @ at_middle.T + end / 6.0
    state = np.zeros(size)
    for one_gain in gain:
        state = growth @ state + one_gain
    whole = np.linalg.matrix_power(growth, steps)
    state = np.linalg.lstsq(one - whole, state, rcond=1e-10)[0]
    states = np.empty((steps, size))
    for number, one_gain in enumerate(gain):
        states[number] = state
        state = growth @ state + one_gain
    found = states @ system.torque.T
    each = 2.0 * size**2 + 3.0 * size * values.shape[1]
    return Shooting(found - found.mean(axis=0), 0.25 * each * steps)


def through_three(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Highest (r,) of periodic samples (r, s) by a parabola, and its place in steps."""
    row, best = np.arange(len(values)), np.argmax(values, axis=1)
    count = values.shape[1]
    before, at, after = (values[row, (best + k) % count] for k in (-1, 0, 1))
    bend = before - 2.0 * at + after
    share = 0.5 * (before - after) / np.where(bend < 0.0, bend, -np.inf)
    return at - 0.25 * (before - after) * share, np.mod(best + share, count)


def half_ranges_of_samples(values: FloatArray) -> FloatArray:
    """Of rows (r, s) over a cycle, with parabolas through highest and lowest samples."""
    return np.asarray(0.5 * (through_three(values)[0] + through_three(-values)[0]))


def exact_highest(rows: ComplexArray, place: np.ndarray) -> tuple[FloatArray, FloatArray]:
    """Highest values (r,) of sums of whole harmonics, and where in a cycle of 2 pi."""
    import mpmath

    samples = 32768
    start = np.argmax(samples_of_harmonics(rows, place, samples), axis=1)
    value, where = np.zeros(len(rows)), np.zeros(len(rows))
    with mpmath.workdps(30):
        for r, begin in enumerate(start.tolist()):
            at = 2 * mpmath.pi * begin / samples
            for _ in range(5):
                terms = _terms(rows[r], place, at)
                slope = sum(-n * one.imag for n, one in terms)
                bend = sum(-n * n * one.real for n, one in terms)
                if bend == 0:
                    break
                at -= slope / bend
            value[r] = float(sum(one.real for _, one in _terms(rows[r], place, at)))
            where[r] = float(at % (2 * mpmath.pi))
    return value, where


def _terms(row: ComplexArray, place: np.ndarray, at: Any) -> list[tuple[int, Any]]:
    import mpmath

    return [
        (n, mpmath.mpc(complex(one)) * mpmath.expj(n * at))
        for n, one in zip(place.tolist(), row, strict=True)
    ]

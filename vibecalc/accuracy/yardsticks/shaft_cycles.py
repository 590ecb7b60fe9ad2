"""What the cylinders of an engine do over a cycle, by samples, plain rules and steps in time."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.accuracy.yardsticks.fourier_samples import samples_of_harmonics
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import gas_torque_at, inertia_torque_at
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.drive import Drive
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.transient_system import transient_system

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

"""Modes of a shaft line with its dampers: one frequency and one damping ratio each."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.line import (
    Line,
    damping_matrix,
    lines_of,
    network_matrix,
    part_of,
    stiffness_matrix,
)
from vibecalc.torsion.modes import Modes

# ----------------------------------------------------------------------------
# Natural modes of a shaft line as it vibrates: one frequency and one damping ratio a mode.
#
# Without a damper they are the undamped modes: damping spread over shafts and stations moves a
# frequency in the second order only. A ring that hangs by a dashpot is another matter: how much of
# its inertia goes along depends on the frequency. Then the modes are the poles s of
#
#     (s^2 J + s C + K) x = 0,
#
# natural frequency |s|, damping ratio -Re s / |s|. A loss factor eta counts as the dashpot
# eta k / |s|, which takes the same heat at the frequency of the mode.
# ----------------------------------------------------------------------------

#: from this damping ratio on, 1 / sqrt(2), the response to a constant torque has no peak
NO_PEAK = float(np.sqrt(0.5))
#: rounds until a mode has the dashpots of its own frequency
_ROUNDS = 40


class LineModes(NamedTuple):
    """m modes of n freedoms: first those that do not vibrate, then by rising frequency.

    `frequency` (m,) in rad/s is exactly 0 for a rigid motion, for a ring in oil that turns against
    the line, and for an overdamped mode; `damping_ratio` (m,) is 0 for the former and 1 for
    an overdamped mode. `pole` (m,) in rad/s; `shape` (m, n) complex, referred angles, the largest
    of the freedoms that are no ring is 1, zero for an overdamped mode; `scale` (m,) = x^T (2 s J +
    C) x. `frequency_error` (m,) in rad/s holds for the pole too; `shape_error` (m,) for the worst
    angle. `damped` tells poles of a damped line from undamped modes, whose shapes are real;
    `failure` says why they stand for poles that could not be found.
    """

    frequency: FloatArray
    frequency_error: FloatArray
    damping_ratio: FloatArray
    pole: ComplexArray
    shape: ComplexArray
    shape_error: FloatArray
    scale: ComplexArray
    damped: bool
    failure: str = ""

    @property
    def silent(self) -> BoolArray:
        """Modes (m,) near whose frequency no response peaks: rigid, overdamped, or nearly so."""
        heavy = self.damped & (self.damping_ratio >= NO_PEAK)
        return np.asarray((self.frequency == 0.0) | heavy)

    @property
    def inertia(self) -> FloatArray:
        """|scale| / (2 |s|) (m,): the modal inertia of an undamped mode; 0 for those without."""
        size = 2.0 * self.frequency
        return np.divide(np.abs(self.scale), size, out=np.zeros_like(size), where=size > 0.0)


def undamped_line_modes(modes: Modes, damping_ratio: FloatArray, failure: str = "") -> LineModes:
    """Of undamped modes with damping ratios (m,) that leave their frequencies as they are."""
    pole = modes.frequency * (1j - damping_ratio)
    return LineModes(
        modes.frequency,
        modes.frequency_error,
        damping_ratio,
        pole,
        modes.shape.astype(np.complex128),
        modes.shape_error,
        np.asarray(2j * modes.frequency * modes.modal_inertia),
        damped=False,
        failure=failure,
    )


def damped_line_modes(
    line: Line, rings: int, line_at: Callable[[float], Line] | None = None
) -> LineModes:
    """Of a line without leading axes whose last `rings` freedoms are the rings of dampers.

    Every freedom with inertia has a mode. `line_at` gives the line at a frequency in rad/s where
    its elements depend on it: each pole is then that of its own magnitude. Raises
    NumericalFailure where a pole cannot be distinguished from another one to four digits, or has no
    dashpots that equal its loss factors.
    """
    poles: list[complex] = []
    shapes: list[ComplexArray] = []
    errors: list[float] = []
    scales: list[complex] = []
    for guess in vibrating_guesses(line).tolist():
        found = converged_pole(line, guess) if line_at is None else _own_pole(line_at, guess)
        converged, turned, uncertainty, damping = found
        # a real pole next to which the guess was complex
        if converged.imag <= 1e3 * uncertainty or converged.imag <= 1e-9 * abs(converged):
            continue
        if uncertainty > 1e-4 * abs(converged) or any(
            abs(converged - p) < 1e-9 * abs(p) for p in poles
        ):
            raise NumericalFailure(
                f"the pole near {converged:.6g} rad/s of the damped line cannot be separated "
                "from another"
            )
        poles.append(converged)
        shapes.append(turned)
        errors.append(uncertainty)
        scales.append(complex(2.0 * converged * np.sum(line.inertia * turned**2) + damping))
    _, rigid = line_matrices(line)
    still = [*rigid, *resting(line)]
    count = int(np.count_nonzero(line.inertia))
    over = max(count - len(poles) - len(still), 0)
    blank = [np.zeros(len(line.inertia))] * over
    first = len(still) + over
    pole: ComplexArray = np.array([0.0j] * first + poles)
    size = np.abs(pole)
    ascending = np.argsort(size, kind="stable")
    pole, size = pole[ascending], size[ascending]
    shape = np.array([*still, *blank, *shapes], dtype=np.complex128)[ascending]
    error = np.array([0.0] * first + errors)[ascending] + 4.0 * EPSILON * size
    ratio = np.divide(-pole.real, size, out=np.zeros_like(size), where=size > 0.0)
    ratio[len(still) : first] = 1.0
    shape, factor = _scaled(shape, len(line.inertia) - rings)
    scale = np.array([0.0j] * first + scales)[ascending] * factor**2
    return LineModes(size, error, ratio, pole, shape, _shape_error(pole, error, scale), scale, True)


def vibrating_guesses(line: Line, taken: FloatArray | None = None) -> ComplexArray:
    """Poles near those that vibrate, with loss factors as they are in steady vibration.

    `taken` (n, n) is taken off the inertias.
    """
    matrices, _ = line_matrices(line)
    if np.any(line.loss_factor):
        none = np.zeros_like(line.inertia)
        loss = network_matrix(line, line.stiffness * line.loss_factor, none)
        loss = matrices.full.T @ loss @ matrices.full
        matrices = matrices._replace(stiffness=matrices.stiffness + 1j * loss)
    if taken is None:
        eigenvalues = np.linalg.eigvals(state_matrix(matrices))
    else:
        count = len(matrices.inertia)
        mass = np.diag(matrices.inertia) - matrices.full.T @ taken @ matrices.full
        sides = np.hstack([-matrices.stiffness, -matrices.damping])
        lower = np.linalg.lstsq(mass, sides, rcond=None)[0]
        eigenvalues = np.linalg.eigvals(np.vstack([np.eye(count, 2 * count, count), lower]))
    return np.asarray(eigenvalues[eigenvalues.imag > 1e-7 * np.abs(eigenvalues)])


def converged_pole(line: Line, guess: complex) -> tuple[complex, ComplexArray, float, complex]:
    """A pole whose loss factors are dashpots of its own magnitude, shape, error, x^T C x.

    Raises NumericalFailure where it has no such dashpots.
    """
    lossy = bool(np.any(line.loss_factor))
    pole, last = guess, np.inf
    for _ in range(_ROUNDS):
        matrices, _ = line_matrices(equivalent_line(line, abs(pole)) if lossy else line)
        before, (pole, vector, error) = pole, corrected_pole(matrices, pole)
        moved = abs(abs(pole) - abs(before))
        if not lossy or moved <= error or (moved >= last and moved < 1e-12 * abs(pole)):
            damping = complex(vector @ matrices.damping @ vector)
            return pole, matrices.full @ vector, error + (2.0 * moved if lossy else 0.0), damping
        last = moved
    raise NumericalFailure(
        f"loss factors as dashpots near {abs(guess):.6g} rad/s: the mode there is damped so "
        "strongly that it has no frequency of its own"
    )


def _own_pole(
    line_at: Callable[[float], Line], guess: complex
) -> tuple[complex, ComplexArray, float, complex]:
    """The same of the line at the frequency of the pole itself. Raises NumericalFailure."""
    pole = guess
    for _ in range(_ROUNDS):
        found = converged_pole(line_at(abs(pole)), pole)
        moved, pole = abs(abs(found[0]) - abs(pole)), found[0]
        if moved <= 2.0 * found[2] or moved <= 1e-13 * abs(pole):
            return pole, found[1], found[2] + moved, found[3]
    raise NumericalFailure(
        f"the mode near {abs(guess):.6g} rad/s has no frequency of its own: elements of the line "
        "change with the frequency as fast as it does"
    )


def mode_number(line: Line, pole: complex, count: int) -> int:
    """Place of a pole of the line among its `count` modes, as `damped_line_modes` orders them."""
    found = vibrating_guesses(line)
    found = found[np.argsort(np.abs(found), kind="stable")]
    return count - len(found) + int(np.argmin(np.abs(found - pole)))


def _scaled(shape: ComplexArray, stations: int) -> tuple[ComplexArray, ComplexArray]:
    """Shapes with their largest station at 1, of several within a thousandth the first."""
    row = np.arange(len(shape))
    size = np.abs(shape)
    moves = np.max(size[:, :stations], axis=1) > 1e-9 * np.max(size, axis=1)
    size[moves, stations:] = 0.0
    top = size.max(axis=1, keepdims=True)
    first = np.argmax(size >= (1.0 - 1e-3) * top, axis=1)
    value = shape[row, first]
    safe = np.where(value == 0.0, 1.0, value)
    # the largest is 1 in size, the first of equals in phase
    size_of = np.abs(safe) * np.where(top[:, 0] > 0.0, top[:, 0], 1.0)
    factor: ComplexArray = np.asarray(safe.conj() / size_of, dtype=np.complex128)
    return shape * factor[:, None], factor


def _shape_error(pole: ComplexArray, error: FloatArray, scale: ComplexArray) -> FloatArray:
    """Bound (m,) of what the error of a pole turns its shape towards the others by."""
    moving = pole != 0.0
    size = np.where(moving, np.abs(pole), 1.0)
    inertia = np.abs(scale) / (2.0 * size)
    away = np.abs(pole[:, None] - pole)
    np.fill_diagonal(away, np.inf)
    share = np.where(moving, 1.0 / np.where(inertia > 0.0, inertia, np.inf), 0.0)
    # never below what rounding leaves of two poles' distance
    away = np.maximum(away, EPSILON * size)
    mixed = error * np.sqrt(inertia * (away**-2.0 @ share))
    return np.where(moving, np.fmin(mixed + 64.0 * EPSILON, 2.0), 0.0)


# ----------------------------------------------------------------------------
# Matrices of a damped shaft line without its rigid motion, for first guesses of its poles.
# ----------------------------------------------------------------------------


class Matrices(NamedTuple):
    """A line of which undamped stations without inertia are condensed; r freedoms are kept.

    `inertia` (r,), `damping`, `stiffness` (r, r); elements of what is kept as `differences`
    (e + r, r) with `element_stiffness` and `element_damping` (e + r,), ground last; `free` lists
    the kept freedoms of each piece without springs to ground and whether nothing brakes it;
    `full` (n, r) gives all angles.
    """

    inertia: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    differences: FloatArray
    element_stiffness: FloatArray
    element_damping: FloatArray
    free: list[tuple[IntArray, bool]]
    full: FloatArray


def line_matrices(line: Line) -> tuple[Matrices, list[FloatArray]]:
    """The matrices, and the rigid motion (n,) of each ungrounded piece.

    Raises `NumericalFailure` for a piece without inertia.
    """
    count = len(line.inertia)
    damping, stiffness = damping_matrix(line), stiffness_matrix(line)
    still = (line.inertia == 0.0) & (np.diag(damping) == 0.0)
    moving = np.flatnonzero(~still)
    taken = np.flatnonzero(still)
    differences = np.zeros((len(line.stiffness) + count, count))
    rows = np.arange(len(line.stiffness))
    differences[rows, line.first] += 1.0
    differences[rows, line.second] -= 1.0
    differences[len(rows) :] = np.eye(count)
    free, rigid = _free_parts(line, moving)
    full = np.zeros((count, len(moving)))
    full[moving, np.arange(len(moving))] = 1.0
    if taken.size:
        inner = stiffness[np.ix_(taken, taken)]
        full[taken] = -np.linalg.solve(inner, stiffness[np.ix_(taken, moving)])
    matrices = Matrices(
        line.inertia[moving],
        damping[np.ix_(moving, moving)],
        full.T @ stiffness @ full if taken.size else stiffness,
        differences @ full,
        np.concatenate([line.stiffness, line.ground_stiffness]),
        np.concatenate([line.damping, line.absolute_damping]),
        free,
        full,
    )
    return matrices, rigid


def resting(line: Line) -> list[FloatArray]:
    """Displacements (n,) that nothing brings back, next to the rigid ones.

    Parts joined to the rest by dashpots alone can rest anywhere; one of each ungrounded part
    is the one that the others are counted from.
    """
    count = len(line.inertia)
    by_springs = part_of(line, line.stiffness != 0.0).tolist()
    by_both = part_of(line, (line.stiffness != 0.0) | (line.damping != 0.0)).tolist()
    shapes = []
    for number in sorted(set(by_both)):
        inside = [s for s in range(count) if by_both[s] == number]
        parts = sorted({by_springs[s] for s in inside})
        free = [
            part
            for part in parts
            if not any(line.ground_stiffness[s] for s in inside if by_springs[s] == part)
        ]
        taken = 1 if len(free) == len(parts) else 0
        shapes += [np.array([float(one == part) for one in by_springs]) for part in free[taken:]]
    return shapes


def _free_parts(
    line: Line, moving: IntArray
) -> tuple[list[tuple[IntArray, bool]], list[FloatArray]]:
    """Ungrounded parts (springs and dampers join): moving freedoms, unbraked; rigid motions."""
    label = part_of(line, (line.stiffness != 0.0) | (line.damping != 0.0))
    free, rigid = [], []
    for number in sorted(set(label.tolist())):
        part = label == number
        if not np.any(line.inertia[part]):
            raise NumericalFailure(
                f"the shaft line has a piece without any inertia, with station {number + 1}"
            )
        if not np.any(line.ground_stiffness[part]):
            braked = bool(np.any(line.absolute_damping[part]))
            free.append((np.flatnonzero(part[moving]), not braked))
            rigid.append(part.astype(float))
    return free, rigid


def state_matrix(matrices: Matrices) -> FloatArray:
    """A with x' = A x: positions but those of a root per free piece, speeds of all inertias but
    the root's where momentum is zero. Raises `NumericalFailure` if massless dampers leave a
    station without a law of motion."""
    inertia, damping, stiffness = matrices.inertia, matrices.damping, matrices.stiffness
    count = len(inertia)
    heavy, light = np.flatnonzero(inertia > 0.0), np.flatnonzero(inertia == 0.0)
    positions, speeds = np.eye(count), np.eye(count)[:, heavy]
    rate = np.eye(count)
    drop_position, drop_speed = [], []
    for held, unbraked in matrices.free:
        root = held[np.argmax(inertia[held])]
        drop_position.append(root)
        rate[held, root] -= 1.0
        if unbraked:
            drop_speed.append(int(np.flatnonzero(heavy == root)[0]))
            speeds[root] = np.where(np.isin(heavy, held), -inertia[heavy] / inertia[root], 0.0)
    positions = np.delete(positions, drop_position, axis=1)
    rate = np.delete(rate, drop_position, axis=0)
    with_speed = np.delete(np.arange(len(heavy)), drop_speed)
    speeds = speeds[:, with_speed]
    pull = np.zeros((count, positions.shape[1]), dtype=stiffness.dtype)
    if light.size:
        inner = damping[np.ix_(light, light)]
        if np.linalg.cond(inner) > 0.01 / EPSILON:
            raise NumericalFailure(
                "stations without inertia are joined to each other by dampers alone: give one "
                "of them an inertia or leave it out"
            )
        pull[light] = -np.linalg.solve(inner, stiffness[light] @ positions)
        speeds[light] = -np.linalg.solve(inner, damping[np.ix_(light, heavy)] @ speeds[heavy])
    moving = heavy[with_speed]
    force = -(stiffness @ positions + damping @ pull)[moving] / inertia[moving, None]
    brake = -(damping @ speeds)[moving] / inertia[moving, None]
    matrix: FloatArray = np.block([[rate @ pull, rate @ speeds], [force, brake]])
    return matrix


def work_terms(
    matrices: Matrices, pole: complex, shape: ComplexArray
) -> tuple[complex, complex, float]:
    """v'P(s)v, its derivative by s, and its rounding, from twists and not from sums of forces."""
    twist = matrices.differences @ shape
    square, kinetic = twist**2, shape**2 * matrices.inertia
    elastic = matrices.element_stiffness + pole * matrices.element_damping
    work = pole**2 * kinetic.sum() + elastic @ square
    slope = 2.0 * pole * kinetic.sum() + matrices.element_damping @ square
    size = abs(pole) ** 2 * np.abs(kinetic).sum()
    # two damping ratios may ask for a negative damping of the inertias
    whole = np.abs(matrices.element_stiffness) + abs(pole) * np.abs(matrices.element_damping)
    size += whole @ np.abs(square)
    # a twist is the difference of two angles, each right to a rounding
    coarse = np.abs(matrices.differences) @ np.abs(shape)
    size += 0.5 * whole @ (np.abs(twist) * coarse)
    return complex(work), complex(slope), float(8.0 * EPSILON * size)


# ----------------------------------------------------------------------------
# One pole of a shaft line with any viscous damping, (s^2 J + s C + K) v = 0, from a guess of it.
#
# The guess is corrected on the pencil itself, s - v'P(s)v / v'P'(s)v, whose rounding is the error.
# ----------------------------------------------------------------------------

#: most rounds of inverse iteration on the pencil; a good guess takes two
_POLE_ROUNDS = 10


class DampedModes(NamedTuple):
    """m poles of n freedoms in rad/s, one for each undamped mode.

    `frequency` (m,) = |pole|; `damping_ratio` (m,) = -Re / |pole|, 0 for a rigid motion; `shape`
    (m, n) complex, largest component 1; `pole_error` (m,) in rad/s, absolute, on real and imaginary
    part together.
    """

    pole: ComplexArray
    frequency: FloatArray
    damping_ratio: FloatArray
    shape: ComplexArray
    pole_error: FloatArray


def corrected_pole(matrices: Matrices, guess: complex) -> tuple[complex, ComplexArray, float]:
    """A pole, its shape on the kept stations, and what rounding leaves open of the pole.

    P is symmetric, so the left vector is the right one. A step that goes further than the guess
    may be off is not taken: the pole is then one of a cluster, and the error says so. A last step
    above round-off counts in the error: next to another pole the way is long.
    """
    inertia = matrices.inertia
    pole, moved = guess, 0.0
    shape = np.ones(len(inertia), dtype=complex) * np.exp(1j * np.arange(len(inertia)))
    for _ in range(_POLE_ROUNDS):
        shape = _inverse_iteration(matrices, pole, shape)
        shape /= shape[np.argmax(np.abs(shape))]
        if guess.imag == 0.0:
            shape = shape.real.astype(complex)
        work, slope, rounding = work_terms(matrices, pole, shape)
        if abs(work) >= 0.1 * abs(pole * slope):
            moved = 0.0
            break
        pole -= work / slope
        moved = abs(work)
        if moved <= rounding:
            moved = 0.0
            break
    work, slope, rounding = work_terms(matrices, pole, shape)
    curvature = abs(shape**2 @ inertia)
    remainder = rounding + abs(work) + moved
    linear = remainder / abs(slope) if slope != 0.0 else np.inf
    double = np.sqrt(remainder / curvature) if curvature > 0.0 else np.inf
    # two nearly equal poles: the error cannot grow beyond that of a double one
    return pole, shape, float(min(linear, 2.0 * double))


def _inverse_iteration(matrices: Matrices, pole: complex, shape: ComplexArray) -> ComplexArray:
    """A shape after two solves with P a few roundings from a pole, further off where singular."""
    for roundings in (4.0, 4e3, 4e6, 4e9):
        near = pole + roundings * EPSILON * abs(pole)
        pencil = near**2 * np.diag(matrices.inertia) + near * matrices.damping + matrices.stiffness
        try:
            for _ in range(2):
                shape = np.linalg.solve(pencil, shape / np.max(np.abs(shape)))
                for held, unbraked in matrices.free:
                    if unbraked:  # no momentum: nothing of the rigid motion in it
                        inertia = matrices.inertia[held]
                        shape[held] -= (inertia @ shape[held]) / inertia.sum()
            return shape
        except np.linalg.LinAlgError:
            continue
    raise NumericalFailure(f"the damped line is singular at every frequency near {pole:.6g} rad/s")


# ----------------------------------------------------------------------------
# Poles of a line with loss factors, each mode with dashpots that equal them at its frequency.
#
# A loss factor has no free motion in time. A dashpot eta k / w takes the same heat from a vibration
# at w; put in for every loss factor at the natural frequency w of one mode, it gives that mode a
# pole. Every mode has its own set of dashpots: the poles are of different lines.
# ----------------------------------------------------------------------------

#: in so many steps of the damping a pole is followed from the undamped frequency
_STEPS = (1, 12)
#: shapes of two steps that agree less belong to two modes
_ALIKE = 0.5


def equivalent_line(line: Line, frequency: float) -> Line:
    """The line with dashpots eta k / w in place of its loss factors; w in rad/s."""
    dashpot = line.damping + np.abs(line.loss_factor) * line.stiffness / frequency
    return line._replace(damping=dashpot, loss_factor=np.zeros_like(line.loss_factor))


def equivalent_modes(line: Line, modes: Modes) -> DampedModes:
    """One pole (m,) for each undamped mode of the line; a rigid one stays exactly 0.

    The line may have the modes as a leading axis of its stiffness and loss factor.

    Raises `NumericalFailure` where a pole cannot be followed from its mode: damping so strong that
    a mode does not swing any more, or cannot be distinguished from another one.
    """
    poles = np.zeros(len(modes.frequency), dtype=complex)
    errors = np.zeros(len(poles))
    shapes = np.asarray(modes.shape, dtype=complex).copy()
    lines = lines_of(line) if line.stiffness.ndim > 1 else [line] * len(poles)
    for place, frequency in enumerate(modes.frequency.tolist()):
        if frequency == 0.0:
            continue
        dashed = equivalent_line(lines[place], frequency)
        attempts = (_followed(dashed, frequency, shapes[place], steps) for steps in _STEPS)
        tracked = next((one for one in attempts if one is not None), None)
        if tracked is None:
            raise NumericalFailure(
                f"loss factors as dashpots at {frequency:.6g} rad/s: the mode there is damped so "
                "strongly that its pole cannot be followed"
            )
        poles[place], shapes[place], errors[place] = tracked
    size = np.abs(poles)
    ratio = np.divide(-poles.real, size, out=np.zeros_like(size), where=size > 0.0)
    return DampedModes(poles, size, ratio, shapes, errors)


def _followed(
    line: Line, frequency: float, shape: ComplexArray, steps: int
) -> tuple[complex, ComplexArray, float] | None:
    """The pole that grows out of a natural frequency as dashpots grow; None where it is lost."""
    work = np.real(shape @ damping_matrix(line) @ shape)
    pole, error = 1j * frequency, 0.0
    step = complex(-0.5 * work / (line.inertia @ np.real(shape) ** 2) / steps)
    for share in np.arange(1, steps + 1) / steps:
        partly = line._replace(
            damping=share * line.damping, absolute_damping=share * line.absolute_damping
        )
        matrices, _ = line_matrices(partly)
        corrected, vector, error = corrected_pole(matrices, pole + step)
        turned = matrices.full @ vector
        lost = corrected.imag <= 0.0 or error > 1e-4 * abs(corrected)
        if lost or _alike(line, shape, turned) < _ALIKE:
            return None
        pole, step, shape = corrected, corrected - pole, turned
    return pole, shape / shape[np.argmax(np.abs(shape))], error


def _alike(line: Line, one: ComplexArray, other: ComplexArray) -> float:
    """1 for shapes that differ by a factor, 0 for shapes of two undamped modes."""
    joint = np.abs(np.vdot(one, line.inertia * other)) ** 2
    sizes = [float(np.vdot(v, line.inertia * v).real) for v in (one, other)]
    return float(joint / (sizes[0] * sizes[1]))


# ----------------------------------------------------------------------------
# All poles of a damped line at once, and at each order of its excitation.
# ----------------------------------------------------------------------------


class LinePoles(NamedTuple):
    """Poles (r,) in rad/s with vectors (r, n) and `scale` (r,) = x^T (2 s J + C) x.

    `order` (r,) is the place of the order of the excitation that they are met by, `machine` (r,),
    ascending at each order, that of their line among many.
    """

    pole: ComplexArray
    shape: ComplexArray
    scale: ComplexArray
    order: IntArray
    machine: IntArray


def poles_at_orders(poles: LinePoles, count: int) -> LinePoles:
    """The same poles (r,) at each of so many orders."""
    each = np.tile(np.arange(len(poles.pole)), count)
    order = np.repeat(np.arange(count), len(poles.pole))
    pole, shape, scale = (part[each] for part in poles[:3])
    return LinePoles(pole, shape, scale, order, poles.machine[each])


def all_poles(line: Line) -> LinePoles:
    """Poles above the real axis, each at order 0; of many lines (p,) those of one after the other.

    Eigenvalues of the state matrix, in units of its highest frequency (or the digits of the soft
    modes are lost), each bettered by one step of Newton's method; a loss factor counts as a complex
    stiffness.
    """
    return _all_poles(line, line.inertia[..., None] * np.eye(line.inertia.shape[-1]))


def all_poles_by_order(line: Line, speed_stiffness: FloatArray, order: FloatArray) -> LinePoles:
    """The same at each order (m,) of a line whose stiffness grows with the square of the speed.

    By `speed_stiffness` (e,) in N m/rad per (rad/s)^2; at a pole s of an order the speed is
    s / (i order), so that it counts as an inertia.
    """
    sets = []
    for place, one in enumerate(order.tolist()):
        nothing = np.zeros_like(line.inertia)
        tied = network_matrix(line, speed_stiffness, nothing)
        found = _all_poles(line, np.diag(line.inertia) - tied / one**2)
        sets.append(found._replace(order=np.full_like(found.order, place)))
    return LinePoles(*(np.concatenate(part) for part in zip(*sets, strict=True)))


def _all_poles(line: Line, mass: FloatArray) -> LinePoles:
    """Of lines (..., n) with this inertia (..., n, n)."""
    count = line.inertia.shape[-1]
    stiffness, damping = stiffness_matrix(line), damping_matrix(line)
    # about the highest frequency: no more than twice the stiffness over the inertia of a freedom
    held, inertia = np.broadcast_arrays(np.diagonal(stiffness, 0, -2, -1), line.inertia)
    square = np.divide(held, inertia, out=np.zeros_like(held), where=inertia > 0.0)
    unit = np.sqrt(np.maximum(2.0 * np.max(square, axis=-1, initial=0.0), 1.0))[..., None]
    if np.any(line.loss_factor):
        loss = network_matrix(line, line.stiffness * line.loss_factor, np.zeros(count))
        stiffness = stiffness + 1j * loss
    leading = np.broadcast_shapes(mass.shape[:-2], stiffness.shape[:-2], damping.shape[:-2])
    mass, damping, stiffness = (
        np.broadcast_to(one, (*leading, count, count)).reshape(-1, count, count)
        for one in (mass, damping, stiffness)
    )
    unit = np.broadcast_to(unit, (*leading, 1)).reshape(-1, 1)
    by = unit[..., None]
    whole = np.zeros((len(mass), 2 * count, 2 * count), dtype=stiffness.dtype)
    whole[:, :count, count:] = np.eye(count)
    right = np.concatenate([-stiffness / by**2, -damping / by], axis=-1)
    try:
        whole[:, count:] = np.linalg.solve(mass, right)
    except np.linalg.LinAlgError:
        whole = whole[:0]
    pole, vector = np.linalg.eig(whole)
    up = pole.imag > 1e-9
    machine = np.nonzero(up)[0]
    shape = np.moveaxis(vector, -1, 1)[up][:, :count].astype(np.complex128)
    pole = (pole * unit[: len(whole)])[up].astype(np.complex128)
    held = _held_by_springs(line, mass, machine, pole, shape)
    machine, shape, pole = machine[held], shape[held], pole[held]
    a, b, c = (
        np.sum(np.matmul(shape[:, None], part[machine])[:, 0] * shape, axis=1)
        for part in (mass, damping, stiffness)
    )
    # one step of Newton with the quotient of the vector: errors of the vector count squared
    slope = 2.0 * pole * a + b
    with np.errstate(divide="ignore", invalid="ignore"):
        better = pole - (pole * (pole * a + b) + c) / slope
    pole = np.where(np.abs(better - pole) <= 1e-6 * np.abs(pole), better, pole)
    return LinePoles(pole, shape, 2.0 * pole * a + b, np.zeros_like(machine), machine)


#: part of |s|^2 x^H J x that springs hold of a motion that swings; 1 without loss factors. Rounding
#: leaves EPSILON times the square of highest over lowest frequency where they hold nothing.
_HELD = 0.1


def _held_by_springs(
    line: Line, mass: FloatArray, machine: IntArray, pole: ComplexArray, shape: ComplexArray
) -> BoolArray:
    """Which poles (r,) swing, and are no rigid motion, whose double zero rounding moves apart.

    By |s|^2 x^H J x = x^H K x, of twists and not of sums of forces. Inertias `mass` (p, n, n).
    """
    twist = shape[:, line.first] - shape[:, line.second]
    springs = line.stiffness * np.abs(1.0 + 1j * line.loss_factor)
    work = np.zeros(len(pole))
    for move, stiffness in ((twist, springs), (shape, line.ground_stiffness)):
        of_machine = np.broadcast_to(
            stiffness.reshape(-1, move.shape[1]), (len(mass), move.shape[1])
        )
        work += np.sum(np.abs(of_machine[machine]) * np.square(np.abs(move)), axis=1)
    momentum = np.matmul(mass[machine], shape[..., None])[..., 0]
    moved = np.abs(np.sum(shape.conj() * momentum, axis=1))
    return np.asarray(work >= _HELD * np.square(np.abs(pole)) * moved)

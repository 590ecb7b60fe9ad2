"""Poles of a damped shaft line: first guesses, all at once to rounding, those at each order."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure, in_hertz
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.line import (
    Line,
    columns,
    damping_matrix,
    equivalent_line,
    lines_of,
    mapped,
    network_matrix,
    stiffness_matrix,
)
from vibecalc.torsion.modes import Modes, natural_modes
from vibecalc.torsion.network import inverse_iteration

# ----------------------------------------------------------------------------
# First guesses of the poles that vibrate, in undamped modes, so that low ones keep their digits.
# ----------------------------------------------------------------------------

#: modes up to which all poles are eigenvalues of one matrix; of more, those of weak damping are
#: each next to its mode, and those that damping couples more are eigenvalues of small ones
MANY, COUPLED = 200, 50
#: share of another mode in the shape of a pole up to which damping counts as weak
WEAK = 0.1
#: part of |s|^2 x^H J x that springs hold of a motion that swings; 1 without loss factors. Rounding
#: leaves EPSILON times the square of highest over lowest frequency where they hold nothing.
_HELD = 0.1


def modal_damping_matrix(line: Line, modes: Modes) -> FloatArray:
    """Row r (m, m): damping between undamped modes in rad/s, loss factors as dashpots at mode r."""
    shape = modes.shape / np.sqrt(modes.modal_inertia)[:, None]
    twist = shape[:, line.first] - shape[:, line.second]
    w = np.where(modes.frequency > 0.0, modes.frequency, np.inf)
    dashpot = equivalent_line(line, w).damping
    if dashpot.ndim == 1 and np.all(dashpot >= 0.0):
        # the product of a matrix with its own transpose takes half the time
        twist *= np.sqrt(dashpot)
        found = twist @ twist.T
    else:
        found = (twist * dashpot) @ twist.T
    if np.any(line.absolute_damping):
        found += (shape * line.absolute_damping) @ shape.T
    return np.asarray(found)


def guesses(
    line: Line, modes: Modes, taken: FloatArray | None = None
) -> tuple[ComplexArray, ComplexArray]:
    """Poles (g,) near those that vibrate, by size, and shapes (n, g); losses as complex stiffness.

    `taken` (n, n) is taken off the inertias. The modes, with the displacements of stations without
    inertia where dashpots turn them, are the coordinates. Those at rest have no state but a speed.
    """
    if taken is None and len(modes.frequency) > MANY:
        weak = _weakly_damped(line, modes)
        if weak is not None:
            return weak
    shape = modes.shape / np.sqrt(modes.modal_inertia)[:, None]
    m, w = len(shape), modes.frequency
    light = np.flatnonzero(line.inertia == 0.0)
    if not np.any(np.diag(damping_matrix(line))[light]):
        light = light[:0]
    basis = np.concatenate([shape, np.eye(shape.shape[1])[light]])
    twist = basis[:, line.first] - basis[:, line.second]
    unit = max(float(w.max(initial=0.0)), 1.0)
    damping = ((twist * line.damping) @ twist.T + (basis * line.absolute_damping) @ basis.T) / unit
    stiffness = np.zeros((len(basis), len(basis)))
    stiffness[np.arange(m), np.arange(m)] = (w / unit) ** 2
    stiffness[m:, m:] = stiffness_matrix(line)[np.ix_(light, light)] / unit**2
    if np.any(line.loss_factor):
        loss = (twist * (line.stiffness * line.loss_factor)) @ twist.T
        stiffness = stiffness + 1j * loss / unit**2
    mass = np.eye(m) if taken is None else np.eye(m) - shape @ taken @ shape.T
    turns = np.append(np.flatnonzero(w > 0.0), np.arange(m, len(basis)))
    count, elastic = len(turns), int(np.count_nonzero(w))
    whole = np.zeros((count + m, count + m), dtype=stiffness.dtype)
    whole[np.arange(elastic), count + turns[:elastic]] = 1.0
    if not len(light):
        sides = np.hstack([-stiffness[:, turns], -damping])
        whole[count:] = sides if taken is None else np.linalg.lstsq(mass, sides, rcond=None)[0]
        value, vector = np.linalg.eig(whole)
    else:
        from scipy.linalg import eig

        whole[elastic:count, :count] = -stiffness[np.ix_(np.arange(m, len(basis)), turns)]
        whole[elastic:count, count:] = -damping[m:, :m]
        whole[count:, :count], whole[count:, count:] = -stiffness[:m, turns], -damping[:m, :m]
        right = np.eye(count + m)
        right[elastic:count, elastic:count] = damping[m:, m:]
        right[count:, elastic:count] = damping[:m, m:]
        right[count:, count:] = mass
        value, vector = eig(whole, right)
    swings = np.flatnonzero(np.isfinite(value) & (value.imag > 1e-7 * np.abs(value)))
    swings = swings[np.argsort(np.abs(value[swings]), kind="stable")]
    place = np.zeros((len(basis), len(swings)), dtype=complex)
    place[turns] = vector[:count, swings]
    resting_modes = np.flatnonzero(w == 0.0)
    place[resting_modes] = vector[count + resting_modes][:, swings] / value[swings]
    # |s|^2 x^H J x = x^H K x: what springs do not hold is a rigid motion that rounding made swing
    work = np.sum(place.conj() * (stiffness.real @ place), axis=0).real
    moved = np.sum(place[:m].conj() * (mass @ place[:m]), axis=0).real
    held = work >= _HELD * np.abs(value[swings]) ** 2 * np.abs(moved)
    return value[swings[held]] * unit, basis.T @ place[:, held]


def _weakly_damped(line: Line, modes: Modes) -> tuple[ComplexArray, ComplexArray] | None:
    """Poles to first order in the damping, with shapes without it; None where that is too strong.

    Modes that damping couples more, as two of nearly one frequency, are taken together, up to
    `COUPLED` of them. A step of inverse iteration from there costs less than the sum over the other
    modes would.
    """
    damping, w = modal_damping_matrix(line, modes), modes.frequency
    # of each mode the share of another one is w d / |w'^2 - w^2 + i w d|
    own = np.diag(damping)
    away = w[:, None] * np.abs(damping)
    apart = np.hypot(w**2 - w[:, None] ** 2, w[:, None] * own)
    np.fill_diagonal(away, 0.0)
    pole, shape = 1j * w - 0.5 * own, modes.shape.astype(np.complex128)
    for group in _groups(away > WEAK * apart):
        found = _coupled(damping[np.ix_(group, group)], w[group]) if len(group) <= COUPLED else None
        if found is None:
            return None
        pole[group], mixed = found
        shape[group] = mixed.T @ (modes.shape[group] / np.sqrt(modes.modal_inertia[group])[:, None])
    moving = w > 0.0
    return np.asarray(pole[moving]), np.asarray(shape[moving].T)


def _groups(coupled: BoolArray) -> list[IntArray]:
    """Members of each group of several that pairs (m, m) join, directly or by way of others."""
    one, other = np.nonzero(coupled | coupled.T)
    label, before = np.arange(len(coupled)), np.zeros(len(coupled), dtype=np.int64)
    while np.any(label != before):
        before = label.copy()
        np.minimum.at(label, one, before[other])
    return [np.flatnonzero(label == least) for least in np.unique(label[one])]


def _coupled(damping: FloatArray, w: FloatArray) -> tuple[ComplexArray, ComplexArray] | None:
    """Poles (m,) by size and shapes (m, m), in modes with frequencies (m,) and damping (m, m).

    None where not all of them vibrate.
    """
    unit, count = float(np.max(w)), len(w)
    whole = np.eye(2 * count, k=count)
    whole[count:, :count] = -np.diag(np.square(w / unit))
    whole[count:, count:] = -damping / unit
    value, vector = np.linalg.eig(whole)
    swings = np.flatnonzero(value.imag > 1e-7 * np.abs(value))
    if len(swings) != count:
        return None
    swings = swings[np.argsort(np.abs(value[swings]), kind="stable")]
    return np.asarray(value[swings] * unit), np.asarray(vector[:count, swings])


def mode_number(line: Line, pole: complex, count: int) -> int:
    """Place of a pole of the line among its `count` modes, as `damped_line_modes` orders them."""
    found, _ = guesses(line, natural_modes(line))
    return count - len(found) + int(np.argmin(np.abs(found - pole)))


# ----------------------------------------------------------------------------
# Poles from their guesses: inverse iteration on s^2 J + s C + K along the network, all at once.
#
# Poles that stand together are iterated as one subspace; within it they are the eigenvalues of a
# small pencil, whether they can be told apart or not.
# ----------------------------------------------------------------------------

#: relative distance up to which poles are iterated together, rounds at most
TOGETHER, ROUNDS = 1e-5, 60
#: entries of what is summed up at once: more leave the cache
CACHED = 1 << 15
#: relative move of a pole that stands, and of one that is not settled after all rounds
SETTLED, UNSETTLED = 4.0 * EPSILON, 1e-9
#: share of a guess below which a pole is at rest, and of a pole below which it is real
STILL, REAL = 1e-3, 1e-9


class Poles(NamedTuple):
    """Poles (g,) in rad/s, their shapes (n, g), slope (g,) = x^T (2 s J + C) x, and error (g,)."""

    pole: ComplexArray
    shape: ComplexArray
    slope: ComplexArray
    error: FloatArray


def refined(
    line: Line,
    guess: ComplexArray,
    shape: ComplexArray,
    line_at: Callable[[FloatArray], Line] | None = None,
) -> Poles:
    """The poles that vibrate, by size, near guesses (g,) with shapes (n, g).

    A loss factor is a dashpot at the magnitude of the pole itself; `line_at` gives the line at
    frequencies (g,) where it depends on them. The error is that of v'P(s)v, summed over twists,
    over v'P'(s)v; of poles together never more than that of a multiple one. Raises NumericalFailure
    where a pole does not settle.
    """
    at = line_at or (lambda w: line)
    pole, x, best = guess.copy(), shape / np.linalg.norm(shape, axis=0), np.inf
    cluster, moved = np.zeros(len(pole), dtype=np.int64), np.full(len(pole), np.inf)
    for _ in range(ROUNDS):
        if not len(pole):
            break
        cluster = _clusters(pole, TOGETHER * np.abs(pole))
        middle = _mean(pole, cluster)
        # a few take many rounds: the others, and all of their clusters, stand as they are
        goes = np.bincount(cluster, moved > SETTLED * np.abs(pole))[cluster] > 0
        own: Any = slice(None) if np.all(goes) else np.flatnonzero(goes)
        mean, of = middle[own], np.unique(cluster[own], return_inverse=True)[1]
        turned = inverse_iteration(at(np.abs(mean)), mean, x[:, own])
        pole[own], x[:, own] = _next(at(np.abs(pole[own])), mean, pole[own], turned, of)
        moved[own] = np.abs(_mean(pole[own], of) - mean)
        # what is real, or slides to rest, was made to vibrate in the guess by loss factors alone
        left = np.flatnonzero(
            (pole.imag > REAL * np.abs(pole)) & (np.abs(pole) > STILL * np.abs(guess))
        )
        pole, x, guess, moved = pole[left], x[:, left], guess[left], moved[left]
        cluster = np.unique(cluster[left], return_inverse=True)[1]
        largest = float(np.max(moved / np.abs(pole), initial=0.0))
        if largest <= SETTLED or (best < 1e-12 and largest >= best):
            break
        best = largest
    lost = np.flatnonzero(moved > UNSETTLED * np.abs(pole))
    if len(lost):
        raise NumericalFailure(
            f"loss factors as dashpots near {in_hertz(abs(guess[lost[0]]))}: the mode there is "
            "damped so strongly that it has no natural frequency"
        )
    if not len(pole):
        return Poles(pole, x, pole, pole.real)
    law = columns(equivalent_line(at(np.abs(pole)), np.abs(pole)))
    error = _pole_errors(law, pole, x, cluster, moved)
    _part_shapes(law, pole, x, error, cluster)
    swings = np.flatnonzero(pole.imag > 1e3 * error)
    swings = swings[np.argsort(np.abs(pole[swings]), kind="stable")]
    law = mapped(law, lambda one: one[:, swings] if one.shape[1] > 1 else one)
    pole, x, error = pole[swings], x[:, swings], error[swings]
    return Poles(pole, x, _slope(law, pole, x, x), error)


def refined_pole(line: Line, guess: complex) -> tuple[complex, float]:
    """One pole near a guess, and its error; NumericalFailure where none that vibrates is there."""
    n = line.inertia.shape[-1]
    shape: ComplexArray = np.exp(1j * np.arange(n))[:, None]
    for _ in range(2):
        shape = inverse_iteration(line, np.array([guess]), shape)
    found = refined(line, np.array([guess]), shape)
    if not len(found.pole):
        raise NumericalFailure(f"no mode near {in_hertz(abs(guess))} vibrates")
    return complex(found.pole[0]), float(found.error[0])


def close(pole: ComplexArray, error: FloatArray) -> BoolArray:
    """Pairs (g, g) of poles no farther from each other than their errors."""
    return np.asarray(np.abs(pole[:, None] - pole) <= error[:, None] + error)


def _clusters(pole: ComplexArray, error: FloatArray) -> IntArray:
    """Of each pole (g,) the place of the first one that a chain of close ones joins it to."""
    first, most = np.arange(len(pole)), float(np.max(error, initial=0.0))
    size = np.abs(pole)
    rising = np.argsort(size, kind="stable")
    for apart in range(1, len(pole)):
        one, other = rising[:-apart], rising[apart:]
        # sizes are no farther apart than poles, but for their rounding
        near = np.flatnonzero(size[other] - size[one] <= error[one] + 2.0 * most)
        if not len(near):
            break
        one, other = one[near], other[near]
        joined = np.abs(pole[one] - pole[other]) <= error[one] + error[other]
        one, other = one[joined], other[joined]
        np.minimum.at(first, one, other)
        np.minimum.at(first, other, one)
    while np.any(first != first[first]):
        first = first[first]
    return np.asarray(np.unique(first, return_inverse=True)[1])


def _mean(values: ComplexArray, cluster: IntArray) -> ComplexArray:
    """Of each pole (g,) the mean of its cluster."""
    total = np.bincount(cluster, values.real) + 1j * np.bincount(cluster, values.imag)
    return np.asarray((total / np.bincount(cluster))[cluster])


def _products(law: Line, one: ComplexArray, two: ComplexArray) -> tuple[ComplexArray, ...]:
    """x'J y, x'C y, x'K y (g,) of columns, from twists and not from sums of forces."""
    shape = np.broadcast_shapes(one.shape, two.shape)[1:]
    mass, drag, held = np.zeros((3, *shape), dtype=np.complex128)
    rows = max(1, CACHED // max(1, math.prod(shape)))
    for start in range(0, len(one), rows):
        part = slice(start, start + rows)
        both = one[part] * two[part]
        mass += np.sum(law.inertia[part] * both, axis=0)
        drag += np.sum(law.absolute_damping[part] * both, axis=0)
        held += np.sum(law.ground_stiffness[part] * both, axis=0)
    for start in range(0, len(law.first), rows):
        part = slice(start, start + rows)
        first, second = law.first[part], law.second[part]
        twists = (one[first] - one[second]) * (two[first] - two[second])
        drag += np.sum(law.damping[part] * twists, axis=0)
        held += np.sum(law.stiffness[part] * twists, axis=0)
    return mass, drag, held


def _slope(law: Line, pole: ComplexArray, one: ComplexArray, two: ComplexArray) -> ComplexArray:
    """x' (2 s J + C) y (g,) of columns."""
    mass, drag, _ = _products(law, one, two)
    return np.asarray(2.0 * pole * mass + drag)


def _next(
    line: Line, middle: ComplexArray, pole: ComplexArray, x: ComplexArray, cluster: IntArray
) -> tuple[ComplexArray, ComplexArray]:
    """Better poles (g,) and shapes (n, g), each with its own dashpots; `line` is that of each."""
    law = columns(equivalent_line(line, np.abs(pole)))
    mass, drag, held = _products(law, x, x)
    better = middle - (middle * (middle * mass + drag) + held) / (2.0 * middle * mass + drag)
    for one in np.flatnonzero(np.bincount(cluster) > 1).tolist():
        mine = np.flatnonzero(cluster == one)
        basis, size = np.linalg.qr(x[:, mine])[0], np.abs(middle[mine[0]])
        for rank, at in enumerate(mine.tolist()):
            mass, drag, held = _pencil(law, basis, at)
            lower = -np.linalg.solve(mass, np.hstack([held / size**2, drag / size]))
            count = len(mine)
            value = np.linalg.eigvals(np.vstack([np.eye(count, 2 * count, count), lower])) * size
            nearest = np.argsort(np.abs(value - middle[at]), kind="stable")[:count]
            chosen = nearest[np.argsort(np.abs(value[nearest]), kind="stable")[rank]]
            better[at] = value[chosen]
        x[:, mine] = basis
    return better, x


def _pencil(law: Line, basis: ComplexArray, at: int) -> tuple[ComplexArray, ...]:
    """x'J y, x'C y, x'K y (p, p) between columns (n, p), by the values of pole number `at`."""
    own = mapped(law, lambda one: one[:, [at if one.shape[1] > 1 else 0], None])
    return _products(own, basis[:, :, None], basis[:, None, :])


def _pole_errors(
    law: Line, pole: ComplexArray, x: ComplexArray, cluster: IntArray, moved: FloatArray
) -> FloatArray:
    """Errors (g,): what rounding and the last move leave of x'P x, over its slope."""
    twist, size = np.abs(x[law.first] - x[law.second]), np.abs(x)
    # two damping ratios may ask for a negative damping of the inertias
    element = np.abs(law.stiffness) + np.abs(pole) * np.abs(law.damping)
    # a twist is the difference of two angles, each right to a rounding
    rough = twist * (twist + 0.5 * (size[law.first] + size[law.second]))
    rounding = np.sum(np.abs(pole) ** 2 * law.inertia * size**2, axis=0)
    rounding += np.sum(element * rough, axis=0)
    rounding += np.sum(np.abs(law.ground_stiffness) * size**2, axis=0)
    rounding += np.sum(np.abs(pole * law.absolute_damping) * size**2, axis=0)
    mass, drag, _ = _products(law, x, x)
    slope, bend = np.abs(2.0 * pole * mass + drag), np.abs(mass)
    for one in np.flatnonzero(np.bincount(cluster) > 1).tolist():
        mine = np.flatnonzero(cluster == one)
        masses, drags, _ = _pencil(law, np.linalg.qr(x[:, mine])[0], int(mine[0]))
        slope[mine] = np.linalg.svd(2.0 * pole[mine[0]] * masses + drags, compute_uv=False)[-1]
        bend[mine] = np.linalg.svd(masses, compute_uv=False)[-1]
        rounding[mine] = np.max(rounding[mine])
    left = 8.0 * EPSILON * rounding + moved * slope
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.fmin(left / slope, 2.0 * np.sqrt(left / bend))
    return np.asarray(error + 4.0 * EPSILON * np.abs(pole))


def _part_shapes(
    law: Line, pole: ComplexArray, x: ComplexArray, error: FloatArray, cluster: IntArray
) -> None:
    """From bases (n, g) of clusters to the shapes of single poles, in place.

    Of poles that cannot be told apart, as of equal branches, each shape turns a place at which the
    others rest; then they are made orthogonal in their slope.
    """
    equal = _clusters(pole, error)
    for one in np.flatnonzero(np.bincount(cluster) > 1).tolist():
        within = np.flatnonzero(cluster == one)
        basis = x[:, within]
        for group in np.unique(equal[within]).tolist():
            mine = within[equal[within] == group]
            middle = np.mean(pole[mine])
            mass, drag, held = _pencil(law, basis, int(mine[0]))
            right = np.linalg.svd(middle * (middle * mass + drag) + held)[2]
            shapes = _one_at_a_time(basis @ right[-len(mine) :].conj().T)
            for j in range(1, len(mine)):
                mass, drag, _ = _pencil(law, shapes, int(mine[0]))
                slope = 2.0 * middle * mass + drag
                shapes[:, j] -= shapes[:, :j] @ (slope[:j, j] / np.diag(slope)[:j])
            x[:, mine] = shapes / np.linalg.norm(shapes, axis=0)


def _one_at_a_time(shape: ComplexArray) -> ComplexArray:
    """Shapes (n, q) of the same space, each 1 at a place where the others are 0."""
    left, places = np.linalg.qr(shape)[0], list[int]()
    for _ in range(shape.shape[1]):
        size = np.linalg.norm(left, axis=1)
        places.append(int(np.argmax(size >= (1.0 - 1e-3) * size.max())))
        row = left[places[-1]] / size[places[-1]]
        left = left - np.outer(left @ row.conj(), row)
    return np.asarray(shape @ np.linalg.inv(shape[places]))


# ----------------------------------------------------------------------------
# All poles of a damped line at once, and at each order of its excitation.
# ----------------------------------------------------------------------------


class LinePoles(NamedTuple):
    """Poles (r,) in rad/s.

    `order` (r,) is the place of the order of the excitation that they are met by, `machine` (r,),
    ascending at each order, that of their line among many.
    """

    pole: ComplexArray
    order: IntArray
    machine: IntArray


def poles_at_orders(poles: LinePoles, count: int) -> LinePoles:
    """The same poles (r,) at each of so many orders."""
    order = np.repeat(np.arange(count), len(poles.pole))
    return LinePoles(np.tile(poles.pole, count), order, np.tile(poles.machine, count))


def all_poles(line: Line) -> LinePoles:
    """Poles that vibrate, each at order 0; of many lines (p,) those of one after the other.

    Loss factors count as complex stiffness.
    """
    sets = [_bettered(one, natural_modes(one)) for one in lines_of(line) or [line]]
    machine = np.repeat(np.arange(len(sets)), [len(one) for one in sets])
    return LinePoles(np.concatenate(sets), np.zeros_like(machine), machine)


def all_poles_by_order(line: Line, speed_stiffness: FloatArray, order: FloatArray) -> LinePoles:
    """The same at each order (m,) of a line whose stiffness grows with the square of the speed.

    By `speed_stiffness` (e,) in N m/rad per (rad/s)^2; at a pole s of an order the speed is
    s / (i order), so that it counts as an inertia.
    """
    tied, modes = network_matrix(line, speed_stiffness, 0.0 * line.inertia), natural_modes(line)
    sets = [_bettered(line, modes, tied / one**2) for one in order.tolist()]
    place = np.repeat(np.arange(len(order)), [len(one) for one in sets])
    return LinePoles(np.concatenate(sets), place, np.zeros_like(place))


def _bettered(line: Line, modes: Modes, taken: FloatArray | None = None) -> ComplexArray:
    """`guesses` (g,), each by a step of Newton's method: errors of its shape count squared."""
    pole, shape = guesses(line, modes, taken)
    law = columns(line)
    lossy = law._replace(stiffness=law.stiffness * (1.0 + 1j * law.loss_factor))
    mass, drag, held = _products(lossy, shape, shape)
    if taken is not None:
        mass = mass - np.sum(shape * (taken @ shape), axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        better = pole - (pole * (pole * mass + drag) + held) / (2.0 * pole * mass + drag)
    return np.where(np.abs(better - pole) <= 1e-6 * np.abs(pole), better, pole)

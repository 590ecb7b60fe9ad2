"""Modes of a shaft line with its dampings: one frequency and one damping ratio each."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.line import Line, free_parts
from vibecalc.torsion.modes import Modes, natural_modes
from vibecalc.torsion.poles import Poles, close, guesses, modal_damping_matrix, refined

# ----------------------------------------------------------------------------
# Natural modes of a shaft line as it vibrates: one frequency and one damping ratio a mode.
#
# Where damping moves no frequency worth mentioning they are the undamped modes. A ring that hangs
# by a dashpot is another matter: how much of its inertia goes along depends on the frequency. Then
# the modes are the poles s of
#
#     (s^2 J + s C + K) x = 0,
#
# natural frequency |s|, damping ratio -Re s / |s|. A loss factor eta counts as the dashpot
# eta k / |s|, which takes the same heat at the frequency of the mode.
# ----------------------------------------------------------------------------

#: from this damping ratio on, 1 / sqrt(2), the response to a constant torque has no peak
NO_PEAK = float(np.sqrt(0.5))
#: share of a natural frequency by which damping must move one for poles to count as modes
MOVES = 0.005
#: others that have up to this share of what the mode of its rank has of a pole are not asked for it
MIXED = 0.5


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

    @property
    def together(self) -> BoolArray:
        """Modes (m,) that share their frequency with another one as far as digits go.

        Their shapes are any of a subspace.
        """
        near = close(self.pole, self.frequency_error)
        return np.asarray((np.sum(near, axis=1) > 1) & (self.frequency > 0.0))


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


def moves_modes(line: Line, modes: Modes) -> bool:
    """Whether damping moves a natural frequency by `MOVES` of it, or leaves a mode without a peak.

    By the modal damping d (m, m) of undamped modes to second order, without signs that cancel:
    sum over s of |Re d_rs^2 / (w_s^2 - w_r^2 + i w_r d_ss)| / 2. `line` may have the modes as a
    leading axis of its stiffness and loss factor.
    """
    if not any(np.any(one) for one in (line.damping, line.loss_factor, line.absolute_damping)):
        return False
    damping = modal_damping_matrix(line, modes)
    w, own = modes.frequency, np.diag(damping)
    apart = (w**2 - w[:, None] ** 2) + 1j * w[:, None] * own
    np.fill_diagonal(apart, np.inf)
    coupled = (damping != 0.0) & np.isfinite(apart) & (w[:, None] > 0.0)
    share = np.divide(damping**2, apart, out=np.zeros_like(apart), where=coupled)
    moved = 0.5 * np.sum(np.abs(share.real), axis=1)
    return bool(np.any(moved >= MOVES) or np.any(own >= 2.0 * NO_PEAK * np.where(w, w, np.inf)))


def damped_line_modes(
    line: Line,
    rings: int,
    line_at: Callable[[FloatArray], Line] | None = None,
    guess: tuple[ComplexArray, ComplexArray] | None = None,
) -> LineModes:
    """Of a line without leading axes whose last `rings` freedoms are the rings of dampers.

    Every freedom with inertia has a mode. `line_at` gives the line at frequencies (g,) in rad/s
    where its elements depend on it: each pole is then that of its own magnitude. `guess` are poles
    (g,) and shapes (n, g) to begin with, if they are at hand. Raises NumericalFailure where a pole
    cannot be distinguished from another one to four digits, or has no dashpots that equal its loss
    factors.
    """
    found = refined(line, *(guess or guesses(line, natural_modes(line))), line_at)
    first = int(np.count_nonzero(line.inertia)) - len(found.pole)
    # as one with all that dashpots join, and each part of it that only these join to the first
    springs = line.stiffness != 0.0
    rigid, parts = free_parts(line, springs | (line.damping != 0.0)), free_parts(line, springs)
    parts = np.delete(parts, [int(np.argmax(parts @ one > 0.0)) for one in rigid], axis=0)
    over = max(first - len(rigid) - len(parts), 0)
    still = np.concatenate([rigid, parts, np.zeros((over, len(line.inertia)))])[:first]
    blank: FloatArray = np.zeros(first)
    pole = np.concatenate([blank, found.pole])
    size = np.abs(pole)
    ratio = np.divide(0.0 - pole.real, size, out=np.zeros_like(size), where=size > 0.0)
    ratio[first - over : first] = 1.0
    shape = np.concatenate([still, found.shape.T])
    shape, factor = _scaled(shape, len(line.inertia) - rings)
    error = np.concatenate([blank, found.error])
    scale = np.concatenate([blank, found.slope]) * factor**2
    return LineModes(size, error, ratio, pole, shape, _shape_error(pole, error, scale), scale, True)


def poles_of_modes(line: Line, modes: Modes, line_at: Callable[[FloatArray], Line]) -> Poles:
    """One pole (m,) for each of the undamped modes, in their order; 0 for a rigid one.

    `modes` may be those of lines at their own frequencies. Raises NumericalFailure where a mode
    does not vibrate any more.
    """
    moving = np.flatnonzero(modes.frequency > 0.0)
    found = refined(line, *guesses(line, modes), line_at)
    if len(found.pole) != len(moving):
        raise NumericalFailure(
            "a mode is damped so strongly that it does not vibrate any more: no pole belongs to it"
        )
    # to each mode the pole whose shape has most of it, of close ones the next by size
    pole, left = np.arange(len(moving)), _unsure_of_rank(line, modes, found.shape)
    if len(left):
        weight = _weight(line, modes, moving[left], found.shape[:, left])
        pole[left] = left[_largest_first(weight)]
    count = len(modes.frequency)
    every = Poles(np.zeros(count, complex), modes.shape.T.astype(complex), *np.zeros((2, count)))
    every.pole[moving], every.shape[:, moving] = found.pole[pole], found.shape[:, pole]
    every.error[moving] = found.error[pole]
    return every


def _weight(line: Line, modes: Modes, chosen: IntArray, shape: ComplexArray) -> FloatArray:
    """How much chosen modes (m,) have of shapes (n, g): (m, g)."""
    # parts apart: numpy would make the real factor complex
    lever = modes.shape[chosen] * line.inertia
    weight = np.hypot(lever @ shape.real, lever @ shape.imag)
    return np.asarray(weight / np.sqrt(modes.modal_inertia[chosen])[:, None])


def _unsure_of_rank(line: Line, modes: Modes, shape: ComplexArray) -> IntArray:
    """Places of moving modes whose weight in the pole of their rank may not be the largest.

    Of shapes (n, g) of poles by size: neither among the poles nor among the modes. No sum over all
    modes tells more of most of them: what the inertia x^H J x of a pole has beyond that of the mode
    of its rank is all that any other can have of it.
    """
    moving = np.flatnonzero(modes.frequency > 0.0)
    lever = (modes.shape[moving] * line.inertia).T
    own = np.abs(np.sum(lever * shape, axis=0)) / np.sqrt(modes.modal_inertia[moving])
    whole = np.sum(line.inertia[:, None] * np.square(np.abs(shape)), axis=0)
    others = np.sqrt(np.maximum(whole - np.square(own), 0.0) + 1e-6 * whole)
    mixed = others >= MIXED * own
    unsure = mixed | (own <= np.max(others[~mixed], initial=0.0))
    if np.any(mixed):
        weight = _weight(line, modes, moving, shape[:, mixed])
        unsure |= own <= np.max(weight, axis=1)
    return np.flatnonzero(unsure)


def _largest_first(weight: FloatArray) -> IntArray:
    """Column of each row of weights (m, m), no column twice: the largest of all weights goes first.

    Entries that are the largest of their row and of their column are all given at once.
    """
    column: IntArray = np.argmax(weight, axis=1)
    rows = columns = np.arange(len(weight)) if np.any(np.bincount(column) > 1) else column[:0]
    while len(rows):
        left = weight[np.ix_(rows, columns)]
        best = np.argmax(left, axis=1)
        given = np.argmax(left, axis=0)[best] == np.arange(len(rows))
        column[rows[given]] = columns[best[given]]
        rows, columns = rows[~given], np.delete(columns, best[given])
    return column


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

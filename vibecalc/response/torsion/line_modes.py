"""Natural modes of a shaft line as it vibrates: one frequency and one damping ratio a mode.

Without a damper they are the undamped modes: damping spread over shafts and stations moves a
frequency in the second order only. A ring that hangs by a dashpot is another matter: how much of
its inertia goes along depends on the frequency. Then the modes are the poles s of

    (s^2 J + s C + K) x = 0,

natural frequency |s|, damping ratio -Re s / |s|. A loss factor eta counts as the dashpot
eta k / |s|, which takes the same heat at the frequency of the mode.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray
from vibecalc.response.torsion.damped_equivalent import equivalent_line
from vibecalc.response.torsion.damped_modes import mended_pole
from vibecalc.response.torsion.damped_state import line_matrices, resting, state_matrix
from vibecalc.response.torsion.line import Line, network_matrix
from vibecalc.response.torsion.modes import Modes

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


def damped_line_modes(line: Line, rings: int) -> LineModes:
    """Of a line without leading axes whose last `rings` freedoms are the rings of dampers.

    Every freedom with inertia has a mode. Raises NumericalFailure where a pole cannot be told from
    another one to four digits, or has no dashpots that equal its loss factors.
    """
    poles: list[complex] = []
    shapes: list[ComplexArray] = []
    errors: list[float] = []
    scales: list[complex] = []
    for guess in vibrating_guesses(line).tolist():
        found, turned, doubt, damping = own_pole(line, guess)
        # a real pole beside which the guess was complex
        if found.imag <= 1e3 * doubt or found.imag <= 1e-9 * abs(found):
            continue
        if doubt > 1e-4 * abs(found) or any(abs(found - p) < 1e-9 * abs(p) for p in poles):
            raise NumericalFailure(
                f"the pole near {found:.6g} rad/s of the damped line cannot be told from another"
            )
        poles.append(found)
        shapes.append(turned)
        errors.append(doubt)
        scales.append(complex(2.0 * found * np.sum(line.inertia * turned**2) + damping))
    _, rigid = line_matrices(line)
    still = [*rigid, *resting(line)]
    count = int(np.count_nonzero(line.inertia))
    over = max(count - len(poles) - len(still), 0)
    blank = [np.zeros(len(line.inertia))] * over
    first = len(still) + over
    pole: ComplexArray = np.array([0.0j] * first + poles)
    size = np.abs(pole)
    rise = np.argsort(size, kind="stable")
    pole, size = pole[rise], size[rise]
    shape = np.array([*still, *blank, *shapes], dtype=np.complex128)[rise]
    error = np.array([0.0] * first + errors)[rise] + 4.0 * EPSILON * size
    ratio = np.divide(-pole.real, size, out=np.zeros_like(size), where=size > 0.0)
    ratio[len(still) : first] = 1.0
    shape, factor = _scaled(shape, len(line.inertia) - rings)
    scale = np.array([0.0j] * first + scales)[rise] * factor**2
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
        found = np.linalg.eigvals(state_matrix(matrices))
    else:
        count = len(matrices.inertia)
        mass = np.diag(matrices.inertia) - matrices.full.T @ taken @ matrices.full
        sides = np.hstack([-matrices.stiffness, -matrices.damping])
        lower = np.linalg.lstsq(mass, sides, rcond=None)[0]
        found = np.linalg.eigvals(np.vstack([np.eye(count, 2 * count, count), lower]))
    return np.asarray(found[found.imag > 1e-7 * np.abs(found)])


def own_pole(line: Line, guess: complex) -> tuple[complex, ComplexArray, float, complex]:
    """A pole whose loss factors are dashpots of its own magnitude, shape, error, x^T C x.

    Raises NumericalFailure where it has no such dashpots.
    """
    lossy = bool(np.any(line.loss_factor))
    pole, last = guess, np.inf
    for _ in range(_ROUNDS):
        matrices, _ = line_matrices(equivalent_line(line, abs(pole)) if lossy else line)
        before, (pole, kept, error) = pole, mended_pole(matrices, pole)
        moved = abs(abs(pole) - abs(before))
        if not lossy or moved <= error or (moved >= last and moved < 1e-12 * abs(pole)):
            damping = complex(kept @ matrices.damping @ kept)
            return pole, matrices.full @ kept, error + (2.0 * moved if lossy else 0.0), damping
        last = moved
    raise NumericalFailure(
        f"loss factors as dashpots near {abs(guess):.6g} rad/s: the mode there is damped so "
        "strongly that it has no frequency of its own"
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

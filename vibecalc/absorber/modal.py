"""A primary of one or several modes with absorbers on it: response, gradient, maxima in a band.

Everything is relative to the first mode, of modal mass M1 and natural frequency w1, K1 = M1 w1^2:
x = w / w1, s = i x. In coordinates against the ground, y = (modal ones, absorbers),

    (s^2 M + s C + K) y = r,   M = diag(mu, m),   K = diag(mu nu^2) + sum of k e e',
    C = diag(2 zeta mu nu) + sum of 2 z e e'

with mu = M_r / M1, nu = w_r / w1, and e of each absorber 1 at itself and, at the modes, less their
shapes where it is, or -1 at the absorber that carries it. One mode of shape 1 with one absorber is
the system of `transfer.py`.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.readings import OF_ABSORBER, drifts
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.maxima import Jet, Maxima, by_slopes, seeds_about
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Modes, absorbers on them, and what is asked: lists of systems, one in each row.
# ----------------------------------------------------------------------------


class Modes(NamedTuple):
    """Modes (..., r) over the first: `mass` mu, `frequency` nu, `damping` zeta of critical.

    Shapes where each absorber (..., r, a), the force and what is read are; `participation` is the
    sum of mass times shape over M_r, the share of a motion of the ground that drives the mode.
    """

    mass: FloatArray
    frequency: FloatArray
    damping: FloatArray
    at_absorber: FloatArray
    at_force: FloatArray
    at_response: FloatArray
    participation: FloatArray


class Fitted(NamedTuple):
    """Rows of modes (n, r) with absorbers: mass m, stiffness k, damping z of `transfer`, (n, a).

    `carrier` (a,) is the absorber, before its own, on which each hangs, -1 for the primary.
    """

    modes: Modes
    mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    carrier: tuple[int, ...]

    def some(self, row: BoolArray | IntArray) -> "Fitted":
        """The rows that an index names."""
        modes = Modes(*(part[row] for part in self.modes))
        mass, stiffness, damping = (part[row] for part in self[1:4])
        return Fitted(modes, mass, stiffness, damping, self.carrier)

    def arms(self) -> FloatArray:
        """e (n, a, r + a): motion of each absorber against what carries it."""
        rows, count = self.mass.shape
        size = self.modes.mass.shape[-1]
        arm = np.zeros((rows, count, size + count))
        for place, carrier in enumerate(self.carrier):
            arm[:, place, size + place] = 1.0
            if carrier < 0:
                arm[:, place, :size] = -self.modes.at_absorber[:, :, place]
            else:
                arm[:, place, size + carrier] = -1.0
        return arm


def one_mode(damping: float, absorbers: int = 1) -> Modes:
    """The single mode (1,) of a primary in ratios."""
    one = np.ones(1)
    return Modes(one, one, np.array([damping]), np.ones((1, absorbers)), one, one, one)


def fitted(
    modes: Modes, mass: object, stiffness: object, damping: object, carrier: tuple[int, ...] = ()
) -> Fitted:
    """Rows of equal modes (r,), or modes (n, r), with absorbers (n, a) that broadcast.

    Without `carrier` all hang on the primary.
    """
    count = np.shape(modes.at_absorber)[-1]
    parts = [np.atleast_2d(np.asarray(part, float)) for part in (mass, stiffness, damping)]
    rows = np.broadcast_shapes(*(part.shape for part in parts), (1, count))[0]
    size = np.shape(modes.mass)[-1]
    wide = modes._replace(**{
        name: np.broadcast_to(part, (rows, size, count) if name == "at_absorber" else (rows, size))
        for name, part in modes._asdict().items()
    })  # fmt: skip
    m, k, z = (np.broadcast_to(part, (rows, count)) for part in parts)
    return Fitted(wide, m, k, z, carrier or (-1,) * count)


def bare(modes: Modes, rows: int = 1) -> Fitted:
    """The modes without absorbers: ones without mass, which follow their springs."""
    return fitted(modes, np.zeros((rows, 1)), 1.0, 0.0)


class Reading(NamedTuple):
    """s^power (constant + s slope)' y + direct s^direct_power: what is read of y.

    `constant` and `slope` (n, r + a); `direct` 0 or 1, of a ground that moves.
    """

    constant: FloatArray
    slope: FloatArray
    power: int
    direct: float
    direct_power: int


EXCITATIONS = ("force", "base", "unbalance", "base_acceleration")
#: what may be read -> power of s; `deflection` is displacement against the ground
_POWERS = {"displacement": 0, "velocity": 1, "acceleration": 2, "deflection": 0}
READINGS = (*_POWERS, "transmitted_force", *OF_ABSORBER)


def reading_of(system: Fitted, excitation: str, response: str, absorber: int = 0) -> Reading:
    """What is read, of one absorber where it is its own, over T0 / K1, forces over T0.

    Velocity and acceleration are over w1 and w1^2 more.
    For the ground the unit is its amplitude Y, or A / w1^2 under its acceleration A, and K1 times
    it of forces; for an unbalance T0 = m_u r w1^2. Raises NumericalFailure on unknown names and
    where a constant acceleration of the ground drifts.
    """
    if excitation not in EXCITATIONS or response not in READINGS or drifts(excitation, response):
        raise NumericalFailure(f"no response {response!r} to {excitation!r}")
    modes, arms = system.modes, system.arms()
    size = modes.mass.shape[-1]
    constant, slope = np.zeros_like(arms[:, 0]), np.zeros_like(arms[:, 0])
    power, direct, behind = _POWERS.get(response, 0), 0.0, 0
    if response in _POWERS:
        constant[:, :size] = modes.at_response
        if response != "deflection" and excitation.startswith("base"):
            direct, behind = 1.0, power - 2 * (excitation == "base_acceleration")
    elif response == "transmitted_force":
        if size > 1:
            raise NumericalFailure("the force on the ground is known of a single mode only")
        constant[:, :size] = modes.mass * np.square(modes.frequency)
        slope[:, :size] = 2.0 * modes.damping * modes.mass * modes.frequency
    else:
        arm, own = arms[:, absorber], (slice(None), absorber, None)
        if response == "damper_force":
            slope = 2.0 * system.damping[own] * arm
        else:
            constant = arm * (system.stiffness[own] if response == "spring_force" else 1.0)
    return Reading(constant, slope, power, direct, behind)


# ----------------------------------------------------------------------------
# Response at any frequency, its derivatives by frequency, stiffness and damping.
# ----------------------------------------------------------------------------


class Response(NamedTuple):
    """H (n,) with its absolute error, slopes by x (first, second), by each k and z (n, a)."""

    value: np.ndarray
    error: FloatArray
    first: np.ndarray
    second: np.ndarray
    by_stiffness: np.ndarray
    by_damping: np.ndarray


def _matrices(system: Fitted) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """M, C, K (n, r + a, r + a) and e (n, a, r + a)."""
    modes, arm = system.modes, system.arms()
    rows, _, width = arm.shape
    size = modes.mass.shape[-1]
    mass, drag, stiff = (np.zeros((rows, width, width)) for _ in range(3))
    place, own = np.arange(size), np.arange(size, width)
    mass[:, place, place], mass[:, own, own] = modes.mass, system.mass
    drag[:, place, place] = 2.0 * modes.damping * modes.mass * modes.frequency
    stiff[:, place, place] = modes.mass * np.square(modes.frequency)
    for one in range(arm.shape[1]):
        square = arm[:, one, :, None] * arm[:, one, None, :]
        drag += 2.0 * system.damping[:, one, None, None] * square
        stiff += system.stiffness[:, one, None, None] * square
    return mass, drag, stiff, arm


def _power(x: FloatArray, power: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """s^power at s = i x, and its two derivatives by x."""
    s = 1j * x
    zero = np.zeros_like(s)
    first = zero if power < 1 else 1j * power * s ** (power - 1)
    second = zero if power < 2 else -power * (power - 1) * s ** (power - 2)
    return s**power, first, second


def response_at(
    system: Fitted, x: FloatArray, excitation: str = "force", response: str = "displacement",
    absorber: int = 0,
) -> Response:  # fmt: skip
    """Complex amplitude H, 0-to-peak, of a unit excitation, each row at its frequency ratio (n,).

    Raises NumericalFailure on an undamped resonance.
    """
    mass, drag, stiff, arm = _matrices(system)
    read = reading_of(system, excitation, response, absorber)
    x = np.asarray(x, dtype=float)
    wide = x[:, None, None]
    z = stiff - np.square(wide) * mass + 1j * wide * drag
    z1, z2 = 1j * drag - 2.0 * wide * mass, -2.0 * mass
    r, r1, r2 = _loads(system, x, excitation)
    try:
        inverse = np.linalg.inv(z)
    except np.linalg.LinAlgError:
        raise NumericalFailure("without damping the response is infinite at a resonance") from None

    def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("nij,nj->ni", matrix, vector))

    y = times(inverse, r)
    y1 = times(inverse, r1 - times(z1, y))
    y2 = times(inverse, r2 - 2.0 * times(z1, y1) - times(z2, y))
    row = read.constant + 1j * x[:, None] * read.slope
    turn = 1j * read.slope
    g, g1, g2 = (
        np.sum(row * y, axis=1),
        np.sum(row * y1 + turn * y, axis=1),
        np.sum(row * y2 + 2.0 * turn * y1, axis=1),
    )
    p, p1, p2 = _power(x, read.power)
    d, d1, d2 = (read.direct * part for part in _power(x, read.direct_power))
    # Z is symmetric: what the reading weighs each load with
    weight = times(inverse, row + 0j)
    pull = -p[:, None] * np.einsum("nj,naj->na", weight, arm) * np.einsum("naj,nj->na", arm, y)
    spring, damper = pull, 2j * x[:, None] * pull
    if response in ("spring_force", "damper_force"):  # these rows hold k or z themselves
        spring = damper = np.full(pull.shape, np.nan)
    size = np.abs(row) * np.abs(p)[:, None]
    back = times(np.abs(inverse), times(np.abs(z), np.abs(y)) + np.abs(r))
    error = UNIT_ROUNDOFF * (z.shape[-1] + 4.0) * np.sum(size * back, axis=1)
    return Response(
        p * g + d, error + 4.0 * UNIT_ROUNDOFF * np.abs(d), p1 * g + p * g1 + d1,
        p2 * g + 2.0 * p1 * g1 + p * g2 + d2, spring, damper,
    )  # fmt: skip


def _loads(
    system: Fitted, x: FloatArray, excitation: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """r (n, r + a) and its derivatives by x."""
    modes = system.modes
    if excitation.startswith("base"):
        load = np.concatenate([modes.mass * modes.participation, system.mass], axis=1)
        if excitation == "base_acceleration":
            return -load, 0.0 * load, 0.0 * load
    else:
        load = np.concatenate([modes.at_force, np.zeros_like(system.mass)], axis=1)
        if excitation == "force":
            return load, 0.0 * load, 0.0 * load
    wide = x[:, None]
    return np.square(wide) * load, 2.0 * wide * load, 2.0 * load


def magnitude(
    system: Fitted, x: FloatArray, excitation: str, response: str, absorber: int = 0
) -> tuple[np.ndarray, FloatArray]:
    """Complex H (n, points) of each row over frequency ratios (points,), and its error."""
    rows, points = len(system.mass), len(x)
    row = np.repeat(np.arange(rows), points)
    found = response_at(system.some(row), np.tile(x, rows), excitation, response, absorber)
    return found.value.reshape(rows, points), found.error.reshape(rows, points)


# ----------------------------------------------------------------------------
# Maxima within a range of frequencies, its ends included.
# ----------------------------------------------------------------------------

#: seeds over the range, besides those about the poles
_SEEDS = 9


class Tops(NamedTuple):
    """Maxima (p,) of |H| by row and rising place, ends of the range among them."""

    row: IntArray
    place: Bounded
    height: Bounded

    def largest(self, rows: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Largest |H| (rows,), its error and where it is."""
        value, error, where = np.zeros(rows), np.zeros(rows), np.zeros(rows)
        order = np.lexsort((self.height.value, self.row))
        last = order[np.append(self.row[order][1:] != self.row[order][:-1], True)]
        value[self.row[last]] = self.height.value[last]
        error[self.row[last]] = self.height.error[last]
        where[self.row[last]] = self.place.value[last]
        return value, error, where


def poles(system: Fitted) -> np.ndarray:
    """Damped poles s (n, 2 r + 2 a) over w1; (n, 2 r) of modes alone. Masses all zero, or none."""
    if np.all(system.mass == 0.0):
        nu, zeta = system.modes.frequency, system.modes.damping
        root = np.sqrt(np.square(zeta) - 1.0 + 0j)
        return np.concatenate([nu * (-zeta + root), nu * (-zeta - root)], axis=1)
    mass, drag, stiff, _ = _matrices(system)
    size = mass.shape[-1]
    heavy = np.diagonal(mass, axis1=1, axis2=2)[:, :, None]
    state = np.zeros((len(mass), 2 * size, 2 * size))
    state[:, np.arange(size), size + np.arange(size)] = 1.0
    state[:, size:, :size], state[:, size:, size:] = -stiff / heavy, -drag / heavy
    return np.linalg.eigvals(state).astype(complex)


def tops_within(
    system: Fitted, excitation: str, response: str, low: float, high: float, absorber: int = 0
) -> Tops:
    """All maxima of |H| of each row from `low` to `high`; an end counts where H falls away from it.

    Raises NumericalFailure on an undamped resonance in the range.
    """
    rows = len(system.mass)
    grid = np.broadcast_to(np.linspace(low, high, _SEEDS), (rows, _SEEDS))
    roots = poles(system)
    swings = np.abs(roots.imag)
    sharp = (-roots.real <= 1e-13 * swings) & (swings >= low) & (swings <= high) & (swings > 0.0)
    if np.any(sharp):
        raise NumericalFailure("without damping the response is infinite at a resonance")
    seed = seeds_about(roots, grid)
    seed = np.where((seed > low) & (seed < high), seed, np.nan)
    ends = np.broadcast_to([low, high], (rows, 2))
    seed = np.concatenate([ends, seed], axis=1)

    def jet_at(row: IntArray, x: FloatArray) -> Jet:
        h = response_at(system.some(row), x, excitation, response, absorber)
        size = np.square(np.abs(h.value))
        slope = 2.0 * np.real(np.conj(h.value) * h.first)
        bend = 2.0 * (np.square(np.abs(h.first)) + np.real(np.conj(h.value) * h.second))
        return Jet(size, 2.0 * np.abs(h.value) * h.error + 2.0 * UNIT_ROUNDOFF * size, slope, bend)

    found: Maxima = by_slopes(jet_at, seed)
    row = np.tile(np.arange(rows), 2)
    at = np.repeat([low, high], rows)
    edge = jet_at(row, at)
    falls = np.where(at == low, edge.slope <= 0.0, edge.slope >= 0.0)
    row, at, edge = row[falls], at[falls], edge.some(falls)
    where = np.concatenate([found.row, row])
    place = np.concatenate([found.place.value, at])
    off = np.concatenate([found.place.error, np.zeros(len(at))])
    square = np.concatenate([found.height.value, edge.value])
    slack = np.concatenate([found.height.error, edge.error])
    height = np.sqrt(square)
    error = slack / np.maximum(height, np.sqrt(slack) + 1e-300)
    order = np.lexsort((place, where))
    return Tops(where[order], Bounded(place[order], off[order]),
                Bounded(height[order], error[order]))  # fmt: skip


def highest(
    system: Fitted, excitation: str, response: str, low: float, high: float, absorber: int = 0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Largest |H| (n,) of each row within the range, its error and where it is; infinite on an
    undamped resonance in it."""
    rows = len(system.mass)
    try:
        return tops_within(system, excitation, response, low, high, absorber).largest(rows)
    except NumericalFailure:
        pass
    value, error, where = np.full(rows, np.inf), np.zeros(rows), np.zeros(rows)
    for i in range(rows):
        one = system.some(np.array([i]))
        try:
            found = tops_within(one, excitation, response, low, high, absorber).largest(1)
        except NumericalFailure:
            roots = poles(one)[0]
            inside = (np.abs(roots.imag) >= low) & (np.abs(roots.imag) <= high)
            sharp = np.where(inside, np.abs(roots.real), np.inf)
            where[i] = abs(roots[np.argmin(sharp)].imag)
            continue
        value[i], error[i], where[i] = (float(part[0]) for part in found)
    return value, error, where

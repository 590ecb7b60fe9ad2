"""A primary of one or several modes with absorbers on it: response, derivatives, all maxima.

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
from vibecalc.absorber.transfer import Absorber
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

    `carrier` (a,) is the absorber, before its own, on which each hangs, -1 for the primary. An
    infinite stiffness, in all rows, fastens an absorber rigidly to it.
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

    @property
    def locked(self) -> BoolArray:
        """Absorbers (a,) that are fastened rigidly."""
        return np.asarray(np.any(np.isinf(self.stiffness), axis=0))

    def motions(self) -> tuple[FloatArray, FloatArray]:
        """Motion of each absorber against the ground, and e, against what carries it (n, a, f).

        Coordinates f are the modes and the absorbers that are free of what carries them.
        """
        locked, (rows, count) = self.locked, self.mass.shape
        size = self.modes.mass.shape[-1]
        absolute, arm = np.zeros((2, rows, count, size + count - int(np.sum(locked))))
        own = size + np.cumsum(~locked) - 1
        for place, carrier in enumerate(self.carrier):
            if carrier < 0:
                absolute[:, place, :size] = self.modes.at_absorber[:, :, place]
            else:
                absolute[:, place] = absolute[:, carrier]
            if not locked[place]:
                arm[:, place] = -absolute[:, place]
                absolute[:, place] = 0.0
                arm[:, place, own[place]] = absolute[:, place, own[place]] = 1.0
        return absolute, arm


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


def on_one_mode(absorber: Absorber) -> Fitted:
    """A single absorber on the mode of a primary in ratios."""
    z1, m, k, z2 = (np.reshape(np.asarray(part, dtype=float), (1, 1)) for part in absorber)
    return fitted(one_mode(float(z1[0, 0])), m, k, z2)


def bare(modes: Modes, rows: int = 1) -> Fitted:
    """The modes without absorbers: one without mass, fastened to them."""
    return fitted(modes, np.zeros((rows, 1)), np.inf, 0.0)


class Reading(NamedTuple):
    """s^power (constant + s slope)' y + direct s^direct_power: what is read of y.

    `constant` and `slope` (n, f); `direct` 0 or 1, of a ground that moves.
    """

    constant: FloatArray
    slope: FloatArray
    power: int
    direct: float
    direct_power: int


EXCITATIONS = ("force", "base", "unbalance", "base_acceleration")
#: what may be read -> power of s; `deflection` is displacement against the ground
_POWERS = {"displacement": 0, "velocity": 1, "acceleration": 2, "deflection": 0}
READINGS = (*_POWERS, "transmitted_force", "secondary_displacement", *OF_ABSORBER)


def reading_of(system: Fitted, excitation: str, response: str, absorber: int = 0) -> Reading:
    """What is read, of one absorber where it is its own, over T0 / K1, forces over T0.

    Velocity and acceleration are over w1 and w1^2 more.
    For the ground the unit is its amplitude Y, or A / w1^2 under its acceleration A, and K1 times
    it of forces; for an unbalance T0 = m_u r w1^2. Raises NumericalFailure on unknown names and
    where a constant acceleration of the ground drifts.
    """
    if excitation not in EXCITATIONS or response not in READINGS or drifts(excitation, response):
        raise NumericalFailure(f"no response {response!r} to {excitation!r}")
    modes, (absolute, arms) = system.modes, system.motions()
    size = modes.mass.shape[-1]
    constant, slope = np.zeros_like(arms[:, 0]), np.zeros_like(arms[:, 0])
    power, direct, behind = _POWERS.get(response, 0), 0.0, 0
    if response in _POWERS or response == "secondary_displacement":
        if response in _POWERS:
            constant[:, :size] = modes.at_response
        else:
            constant = absolute[:, absorber]
        if response != "deflection" and excitation.startswith("base"):
            direct, behind = 1.0, power - 2 * (excitation == "base_acceleration")
    elif response == "transmitted_force":
        if size > 1:
            raise NumericalFailure("the force on the ground is known of a single mode only")
        constant[:, :size] = modes.mass * np.square(modes.frequency)
        slope[:, :size] = 2.0 * modes.damping * modes.mass * modes.frequency
    elif not system.locked[absorber]:
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
    """H (n,) with its absolute error, derivatives by x (first, second)."""

    value: np.ndarray
    error: FloatArray
    first: np.ndarray
    second: np.ndarray


class Gradient(NamedTuple):
    """Derivatives of H by all k, then all z (n, 2 a), these by x, and the second (n, 2 a, 2 a)."""

    first: np.ndarray
    by_place: np.ndarray
    second: np.ndarray


def _matrices(system: Fitted) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """M, C, K (n, f, f) and e (n, a, f)."""
    modes, (absolute, arm) = system.modes, system.motions()
    rows, _, width = arm.shape
    mass, drag, stiff = (np.zeros((rows, width, width)) for _ in range(3))
    place = np.arange(modes.mass.shape[-1])
    mass[:, place, place] = modes.mass
    drag[:, place, place] = 2.0 * modes.damping * modes.mass * modes.frequency
    stiff[:, place, place] = modes.mass * np.square(modes.frequency)
    bonds = ~system.locked
    for matrix, size, motion in (
        (mass, system.mass, absolute),
        (drag, np.where(bonds, 2.0 * system.damping, 0.0), arm),
        (stiff, np.where(bonds, system.stiffness, 0.0), arm),
    ):
        matrix += np.einsum("na,nai,naj->nij", size, motion, motion)
    return mass, drag, stiff, arm


def _power(x: FloatArray, power: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """s^power at s = i x, and its two derivatives by x."""
    s = 1j * x
    zero = np.zeros_like(s)
    first = zero if power < 1 else 1j * power * s ** (power - 1)
    second = zero if power < 2 else -power * (power - 1) * s ** (power - 2)
    return s**power, first, second


#: frequency ratio that stands for rest, where what has no spring may be anywhere
_REST = 1e-30


class Driven(NamedTuple):
    """Matrices M, C, K (n, f, f), e (n, a, f), what drives and what is read, of rows of systems."""

    mass: FloatArray
    drag: FloatArray
    stiff: FloatArray
    arm: FloatArray
    load: FloatArray
    read: Reading
    rises: bool

    def at(self, row: IntArray, x: FloatArray) -> Response:
        """H of rows (n,) at one frequency ratio each.

        Raises NumericalFailure on an undamped resonance.
        """
        return self._solved(row, x, False)[0]

    def with_gradient(self, row: IntArray, x: FloatArray) -> tuple[Response, Gradient]:
        """The same with the derivatives by stiffness and damping of all absorbers."""
        found, gradient = self._solved(row, x, True)
        assert gradient is not None
        return found, gradient

    def singular(self, row: IntArray, x: FloatArray) -> BoolArray:
        """Where (n,) an undamped natural frequency is met exactly."""
        wide = np.maximum(x, _REST)[:, None, None]
        z = self.stiff[row] - np.square(wide) * self.mass[row] + 1j * wide * self.drag[row]
        return np.asarray(np.linalg.det(z) == 0.0)

    def _solved(
        self, row: IntArray, x: FloatArray, slopes: bool
    ) -> tuple[Response, Gradient | None]:
        x = np.maximum(np.asarray(x, dtype=float), _REST)
        wide, along = x[:, None, None], x[:, None]
        mass, drag, load, read = self.mass[row], self.drag[row], self.load[row], self.read
        z = self.stiff[row] - np.square(wide) * mass + 1j * wide * drag
        z1 = 1j * drag - 2.0 * wide * mass
        try:
            inverse = np.linalg.inv(z)
        except np.linalg.LinAlgError:
            raise NumericalFailure(
                "without damping the response is infinite at a resonance"
            ) from None

        def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
            return np.asarray((matrix @ vector[..., None])[..., 0])

        r = np.square(along) * load if self.rises else load
        y = times(inverse, r)
        pull = times(z1, y)
        y1 = times(inverse, 2.0 * along * load - pull if self.rises else -pull)
        bent = 2.0 * (times(mass, y) - times(z1, y1))
        y2 = times(inverse, 2.0 * load + bent if self.rises else bent)
        turn = 1j * read.slope[row]
        out = read.constant[row] + along * turn
        g, g1, g2 = (
            np.sum(out * y, axis=1),
            np.sum(out * y1 + turn * y, axis=1),
            np.sum(out * y2 + 2.0 * turn * y1, axis=1),
        )
        p, p1, p2 = _power(x, read.power)
        d, d1, d2 = (read.direct * part for part in _power(x, read.direct_power))
        back = times(np.abs(inverse), times(np.abs(z), np.abs(y)) + np.abs(r))
        error = np.abs(p) * np.sum(np.abs(out) * back, axis=1)
        found = Response(
            p * g + d,
            UNIT_ROUNDOFF * ((z.shape[-1] + 4.0) * error + 4.0 * np.abs(d)),
            p1 * g + p * g1 + d1, p2 * g + 2.0 * p1 * g1 + p * g2 + d2,
        )  # fmt: skip
        if not slopes:
            return found, None
        # Z is symmetric: what the reading weighs each load with
        arm, v = self.arm[row], times(inverse, out + 0j)
        v1 = times(inverse, turn - times(z1, v))
        left, left1, right, right1 = (np.tile(times(arm, part), 2) for part in (v, v1, y, y1))
        mobility = np.tile(arm @ inverse @ np.swapaxes(arm, 1, 2), (2, 2))
        spring = np.ones((len(x), arm.shape[1]))
        share = np.concatenate([spring, 2j * along * spring], axis=1)
        share1 = np.concatenate([0.0 * spring, 2j * spring], axis=1)
        p, p1, both = p[:, None], p1[:, None], left * right
        cross = (share * left)[:, :, None] * mobility * (share * right)[:, None, :]
        return found, Gradient(
            -p * share * both,
            -p1 * share * both - p * (share1 * both + share * (left1 * right + left * right1)),
            p[..., None] * (cross + np.swapaxes(cross, 1, 2)),
        )  # fmt: skip


def driven(system: Fitted, excitation: str, response: str, absorber: int = 0) -> Driven:
    """A response to an excitation, of one absorber where it is its own."""
    read = reading_of(system, excitation, response, absorber)
    modes, (absolute, _) = system.modes, system.motions()
    size, load = modes.mass.shape[-1], np.zeros_like(absolute[:, 0])
    if excitation.startswith("base"):
        load[:, :size] = modes.mass * modes.participation
        load += np.einsum("na,naf->nf", system.mass, absolute)
        load = -load if excitation == "base_acceleration" else load
    else:
        load[:, :size] = modes.at_force
    return Driven(*_matrices(system), load, read, excitation in ("base", "unbalance"))


def response_at(
    system: Fitted, x: FloatArray, excitation: str = "force", response: str = "displacement",
    absorber: int = 0,
) -> Response:  # fmt: skip
    """Complex amplitude H, 0-to-peak, of a unit excitation, each row at its frequency ratio (n,).

    Raises NumericalFailure on an undamped resonance.
    """
    return driven(system, excitation, response, absorber).at(np.arange(len(system.mass)), x)


def at_infinity(system: Driven) -> FloatArray:
    """|H| (n,) at infinite frequency: zero, a number or infinity.

    y is a series in 1 / s there: M y_j = r_j - C y_(j-1) - K y_(j-2), r_0 with s^2, r_2 constant.
    """
    read, none = system.read, np.zeros_like(system.load)[..., None]
    right = [none] * 4
    right[0 if system.rises else 2] = system.load[..., None] * (-1.0 if system.rises else 1.0)
    series: list[np.ndarray] = [none, none]
    for one in right:
        pull = system.drag @ series[-1] + system.stiff @ series[-2]
        series.append(np.linalg.solve(system.mass, one - pull))
    heights = np.zeros(len(none))
    for power in range(4):
        terms: list[np.ndarray] = [np.full(len(none), read.direct * (read.direct_power == power))]
        for row, order in enumerate((read.power - power, read.power + 1 - power)):
            if order >= 0:
                terms.append(np.sum(read[row] * series[order + 2][..., 0], axis=1))
        total = np.abs(np.sum(terms, axis=0))
        there = total > 1e-13 * np.sum(np.abs(terms), axis=0)
        heights = np.where(there, np.inf if power else total, heights)
    return heights


def magnitude(
    system: Fitted, x: FloatArray, excitation: str, response: str, absorber: int = 0
) -> tuple[np.ndarray, FloatArray]:
    """Complex H (n, points) of each row over frequency ratios (points,), and its error.

    Infinite on an undamped natural frequency that is felt.
    """
    rows, points = len(system.mass), len(x)
    row, at = np.repeat(np.arange(rows), points), np.tile(x, rows)
    asked = driven(system, excitation, response, absorber)
    sharp = asked.singular(row, at)
    found = asked.at(row, np.where(sharp, at * (1.0 + 1e-6), at))
    sharp &= np.abs(found.value) > 1e4
    value, error = np.where(sharp, np.inf, found.value), np.where(sharp, 0.0, found.error)
    return value.reshape(rows, points), error.reshape(rows, points)


# ----------------------------------------------------------------------------
# Maxima within a range of frequencies, its ends included.
# ----------------------------------------------------------------------------

#: seeds over the range, besides those about the poles
_SEEDS = 9
#: how far beyond all poles a response has no maximum left
_BEYOND = 100.0


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
    """Damped poles s (n, 2 f) over w1."""
    mass, drag, stiff, _ = _matrices(system)
    size = mass.shape[-1]
    state = np.zeros((len(mass), 2 * size, 2 * size))
    state[:, np.arange(size), size + np.arange(size)] = 1.0
    state[:, size:, :size] = -np.linalg.solve(mass, stiff)
    state[:, size:, size:] = -np.linalg.solve(mass, drag)
    return np.linalg.eigvals(state).astype(complex)


def tops_within(
    system: Fitted, excitation: str, response: str, low: float = 0.0, high: float = np.inf,
    absorber: int = 0,
) -> Tops:  # fmt: skip
    """All maxima of |H| of each row from `low` to `high`; an end counts where H falls away from it,
    rest and infinite frequency always.

    Raises NumericalFailure on an undamped resonance in the range, and where H has no bound.
    """
    rows, asked = len(system.mass), driven(system, excitation, response, absorber)
    roots = poles(system)
    swings = np.abs(roots.imag)
    sharp = (-roots.real <= 1e-13 * swings) & (swings >= low) & (swings <= high) & (swings > 0.0)
    if np.any(sharp) and _resounds(asked, sharp, swings):
        raise NumericalFailure("without damping the response is infinite at a resonance")
    # beside a resonance that is not felt
    roots = np.where(sharp, roots * (1.0 + 1e-6), roots)
    grid = np.linspace(low, high, _SEEDS) if np.isfinite(high) else np.zeros(_SEEDS)
    if np.isinf(high):
        size = np.abs(roots)
        size = size[size > _REST**0.5 * np.max(size)]
        grid = np.geomspace(np.min(size) / _BEYOND, np.max(size) * _BEYOND, _SEEDS)
    seed = seeds_about(roots, np.broadcast_to(grid, (rows, _SEEDS)))
    seed = np.where((seed > grid[0]) & (seed < grid[-1]), seed, np.nan)
    seed = np.concatenate([np.broadcast_to(grid[[0, -1]], (rows, 2)), seed], axis=1)

    def jet_at(row: IntArray, x: FloatArray) -> Jet:
        h = asked.at(row, x)
        size = np.square(np.abs(h.value))
        slope = 2.0 * np.real(np.conj(h.value) * h.first)
        bend = 2.0 * (np.square(np.abs(h.first)) + np.real(np.conj(h.value) * h.second))
        return Jet(size, 2.0 * np.abs(h.value) * h.error + 2.0 * UNIT_ROUNDOFF * size, slope, bend)

    found: Maxima = by_slopes(jet_at, seed)
    row = np.tile(np.arange(rows), 2)
    at = np.repeat([low, high], rows)
    edge = jet_at(row, np.minimum(at, grid[-1]))
    falls = np.where(at == low, edge.slope <= 0.0, edge.slope >= 0.0)
    if np.isinf(high):
        limit = np.square(at_infinity(asked))
        if np.any(np.isinf(limit)):
            raise NumericalFailure(
                f"the largest {response} under {excitation!r} is infinite: it grows with frequency "
                "without bound"
            )
        edge.value[rows:], edge.error[rows:] = limit, 16.0 * UNIT_ROUNDOFF * limit
        falls |= (at == 0.0) | (at == high)
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


def _resounds(asked: Driven, sharp: BoolArray, swings: FloatArray) -> bool:
    """Whether a response grows towards an undamped resonance: not all of them are seen by it."""
    row, place = np.nonzero(sharp)
    beside = [
        np.abs(asked.at(row, swings[row, place] * away).value) for away in (1.0 + 1e-6, 1.0 + 1e-4)
    ]
    return bool(np.any(beside[0] > 10.0 * beside[1]))


def highest(
    system: Fitted, excitation: str, response: str, low: float = 0.0, high: float = np.inf,
    absorber: int = 0,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
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

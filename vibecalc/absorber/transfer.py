"""A primary system with one absorber: ratios, transfer functions, poles, fixed points."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# A sprung and damped primary system with one absorber: its ratios and what may be asked of it.
# ----------------------------------------------------------------------------


class Absorber(NamedTuple):
    """The four ratios of primary and secondary system; arrays that broadcast.

    `primary_damping` z1 = c1 / (2 sqrt(K1 J1)), `mass_ratio` m = J2 / J1, `stiffness_ratio`
    k = K2 / K1 and `secondary_damping` z2 = c2 / (2 sqrt(K1 J1)), a coefficient referred to the
    primary system, so that it keeps its meaning at k = 0. Zero and infinite k and z2 are limits:
    an infinite one locks the secondary to the primary, two zeros set it free.
    """

    primary_damping: ArrayLike
    mass_ratio: ArrayLike
    stiffness_ratio: ArrayLike
    secondary_damping: ArrayLike


class Transfer(NamedTuple):
    """H = sign s^power (1 + 2 z1 s)^ground M(s) / D(s), s = i x; M by its name.

    `motion` is "primary" for N1 = m s^2 + g, "secondary" for g = k + 2 z2 s, "relative" for
    secondary less primary, -m s^2, and "ground" for N1 + m g.
    """

    sign: float
    power: int
    ground: int
    motion: str


_RESPONSES = {
    "displacement": Transfer(1.0, 0, 0, "primary"),
    "velocity": Transfer(1.0, 1, 0, "primary"),
    "acceleration": Transfer(1.0, 2, 0, "primary"),
    "transmitted_force": Transfer(1.0, 0, 1, "primary"),
    "secondary_displacement": Transfer(1.0, 0, 0, "secondary"),
    "relative_displacement": Transfer(1.0, 0, 0, "relative"),
}

#: what drives the system
EXCITATIONS = ("force", "base", "unbalance")
#: what is read: of the primary system, except for the last two
RESPONSES = tuple(_RESPONSES)


def transfer_of(excitation: str, response: str) -> Transfer:
    """What divides what for one pair of excitation and response.

    Amplitudes are relative to T0 / K1 for a force of amplitude T0, to the amplitude Y of the
    ground's motion, and to T0 / K1 with T0 = m_u r w1^2 for a rotating unbalance m_u r (the force
    grows with x^2). Velocity and acceleration are further divided by w1 and w1^2; the transmitted
    force, on the ground through K1 and c1, by T0, K1 Y and m_u r w1^2.
    Raises NumericalFailure on an unknown name.
    """
    if excitation not in EXCITATIONS or response not in _RESPONSES:
        raise NumericalFailure(
            f"no response {response!r} to {excitation!r}; excitations: {', '.join(EXCITATIONS)}; "
            f"responses: {', '.join(RESPONSES)}"
        )
    plain = _RESPONSES[response]
    if excitation == "base":
        if response == "transmitted_force":  # (1 + 2 z1 s) (theta1 - y), by the ground's motion
            return Transfer(-1.0, 2, 1, "ground")
        return plain._replace(ground=plain.ground + 1)
    if excitation == "unbalance":  # the force is x^2 = -s^2
        return plain._replace(sign=-1.0, power=plain.power + 2)
    return plain


def damping_from_own_ratio(
    ratio: ArrayLike, mass_ratio: ArrayLike, stiffness_ratio: ArrayLike
) -> np.ndarray:
    """z2 from the ratio on the secondary's own frequency, c2 / (2 J2 w2): z2 = ratio sqrt(m k).

    Source: Baca Vasquez (2007), eq. 2.7; meaningless at k = 0.
    """
    root = np.sqrt(np.multiply(mass_ratio, stiffness_ratio))
    damping: np.ndarray = np.asarray(ratio, dtype=float) * root
    return damping


def own_damping_ratio(absorber: Absorber) -> np.ndarray:
    """c2 / (2 J2 w2) = z2 / sqrt(m k): eps2 of eq. 2.7. Infinite at k = 0 with z2 > 0."""
    root = np.sqrt(np.multiply(absorber.mass_ratio, absorber.stiffness_ratio))
    damping = np.asarray(absorber.secondary_damping, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio: np.ndarray = np.where(damping == 0.0, 0.0, damping / root)
    return ratio


# ----------------------------------------------------------------------------
# Numerator and denominator in s = i x, with the limits of spring and damper divided out.
# ----------------------------------------------------------------------------


class Coupling(NamedTuple):
    """N1 = inertia s^2 + g and g = g0 + g1 s, both over s^shift and scaled by one positive number.

    `shift` is 0, or 1 without a spring, or 2 for a free secondary (then g is left out). `inertia`
    is the secondary's inertia in that scale, zero where it is locked to the primary. All arrays
    have the common shape of the four ratios.
    """

    primary_damping: np.ndarray
    mass: np.ndarray
    inertia: np.ndarray
    g0: np.ndarray
    g1: np.ndarray
    shift: np.ndarray

    @property
    def motion(self) -> np.ndarray:
        """Coefficients of N1 (..., 3), lowest power first, after the shift."""
        zero = np.zeros_like(self.inertia)
        whole = np.stack([self.g0, self.g1, self.inertia], axis=-1)
        late = np.stack([self.g1, self.inertia, zero], axis=-1)
        free = np.stack([self.inertia, zero, zero], axis=-1)
        shift = self.shift[..., None]
        return np.where(shift == 0, whole, np.where(shift == 1, late, free))

    @property
    def link(self) -> np.ndarray:
        """Coefficients of g (..., 2) after the shift."""
        zero = np.zeros_like(self.inertia)
        whole = np.stack([self.g0, self.g1], axis=-1)
        late = np.stack([self.g1, zero], axis=-1)
        return np.where(self.shift[..., None] == 0, whole, late)


def coupling(absorber: Absorber) -> Coupling:
    """Bring every absorber, its limits included, to finite numbers of order one.

    A mass ratio of zero leaves the primary system alone. The scale cancels in every quotient.
    """
    z1, m, k, z2 = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in absorber))
    locked = np.isinf(k) | np.isinf(z2) | (m == 0.0)
    g0 = np.where(locked, 1.0, k)
    g1 = np.where(locked, 0.0, 2.0 * np.where(locked, 0.0, z2))
    inertia = np.where(locked, 0.0, m)
    scale = np.maximum(np.maximum(g0, g1), inertia)
    shift = np.where(g0 > 0.0, 0, np.where(g1 > 0.0, 1, 2))
    return Coupling(z1.copy(), m.copy(), inertia / scale, g0 / scale, g1 / scale, shift)


def denominator(parts: Coupling) -> np.ndarray:
    """Coefficients of D = (1 + 2 z1 s + s^2) N1 + m s^2 g (..., 5): sums of positive terms."""
    n0, n1, n2 = np.moveaxis(parts.motion, -1, 0)
    g0, g1 = np.moveaxis(parts.link, -1, 0)
    c, m = 2.0 * parts.primary_damping, parts.mass
    return np.stack([n0, n1 + c * n0, n2 + c * n1 + n0 + m * g0, c * n2 + n1 + m * g1, n2], axis=-1)


def numerator(parts: Coupling, transfer: Transfer) -> np.ndarray:
    """Coefficients of M (..., 3) of one response, after the shift and without the other factors."""
    zero = np.zeros_like(parts.inertia)
    wide = np.concatenate([parts.link, zero[..., None]], axis=-1)
    if transfer.motion == "primary":
        return parts.motion
    if transfer.motion == "secondary":
        return wide
    if transfer.motion == "ground":
        both: np.ndarray = parts.motion + parts.mass[..., None] * wide
        return both
    # -inertia s^2 over s^shift
    inertia: np.ndarray = -parts.inertia[..., None] * (np.arange(3) == (2 - parts.shift)[..., None])
    return inertia


class Asymptotes(NamedTuple):
    """H ~ at_zero as x -> 0, and H ~ leading s^degree as x -> infinity."""

    at_zero: np.ndarray
    leading: np.ndarray
    degree: np.ndarray

    @property
    def magnitude_at_infinity(self) -> np.ndarray:
        """Limit of |H|: zero, a number or infinity."""
        size = np.abs(self.leading)
        return np.where(self.degree == 0, size, np.where((self.degree > 0) & (size > 0), np.inf, 0))


def ends(parts: Coupling, transfer: Transfer) -> Asymptotes:
    """What H becomes at very low and very high frequency."""
    below = denominator(parts)
    above = numerator(parts, transfer)
    damped = (parts.primary_damping > 0.0) * transfer.ground
    top, top_degree = _highest(above)
    bottom, bottom_degree = _highest(below)
    factor = np.where(damped > 0, (2.0 * parts.primary_damping) ** damped, 1.0)
    at_zero = transfer.sign * above[..., 0] / below[..., 0] * (transfer.power == 0)
    return Asymptotes(
        at_zero,
        transfer.sign * factor * top / bottom,
        transfer.power + damped + top_degree - bottom_degree,
    )


def _highest(coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Last coefficient that is not zero, and its power; (0, 0) of a polynomial that is zero."""
    there = coefficients != 0.0
    last = coefficients.shape[-1] - 1 - np.argmax(there[..., ::-1], axis=-1)
    last = np.where(np.any(there, axis=-1), last, 0)
    return np.take_along_axis(coefficients, last[..., None], axis=-1)[..., 0], last


# ----------------------------------------------------------------------------
# Natural frequencies, damped poles, the antiresonance and the locked and free limits.
# ----------------------------------------------------------------------------


class Landmarks(NamedTuple):
    """Frequency ratios x that belong to the undamped system, all (...).

    `lower`, `upper`: natural frequencies (`upper` infinite where the secondary is locked,
    `lower` zero where it has no spring); `antiresonance` sqrt(k / m), at which the undamped
    secondary holds the primary still under a force; `locked` 1 / sqrt(1 + m) and `free` 1, the
    only natural frequency with the secondary locked to the primary or parted from it.
    """

    lower: np.ndarray
    upper: np.ndarray
    antiresonance: np.ndarray
    locked: np.ndarray
    free: np.ndarray


def landmarks(mass_ratio: ArrayLike, stiffness_ratio: ArrayLike) -> Landmarks:
    """Undamped natural frequencies and limits (eq. 2.9 with all damping zero).

    m u^2 - (m + k + k m) u + k = 0 with u = x^2, solved without a difference of like numbers.
    """
    m, k = np.broadcast_arrays(
        np.asarray(mass_ratio, dtype=float), np.asarray(stiffness_ratio, dtype=float)
    )
    locked = 1.0 / np.sqrt(1.0 + m)
    stiff = np.isinf(k) | (m == 0.0)
    finite = np.where(stiff, 1.0, k)
    ratio = finite / np.where(stiff, 1.0, m)
    # u1 + u2 = 1 + ratio (1 + m), u1 u2 = ratio; the square below is a sum
    total = 1.0 + ratio * (1.0 + m)
    gap = np.hypot(1.0 - ratio * (1.0 + m), 2.0 * np.sqrt(ratio * m))
    upper = (total + gap) / 2.0
    lower = ratio / upper
    # without mass the secondary's own frequency is beyond all others
    return Landmarks(
        np.where(stiff, locked, np.sqrt(lower)),
        np.where(stiff, np.inf, np.sqrt(upper)),
        np.where(stiff, np.inf, np.sqrt(ratio)),
        locked,
        np.ones_like(locked),
    )


class Poles(NamedTuple):
    """Roots s = -decay + i x of D(s) in units of w1, (..., 4), and an error of each.

    Sorted by |s|; `present` is false in places that a limit (no spring, locked) leaves empty, where
    the value is zero.
    """

    value: np.ndarray
    error: np.ndarray
    present: np.ndarray


def poles(absorber: Absorber) -> Poles:
    """Damped poles of the coupled system, polished by Newton's method."""
    return roots_of(denominator(coupling(absorber)))


def roots_of(coefficients: np.ndarray) -> Poles:
    """Roots of polynomials (..., 5), coefficients by rising power, the first of them not zero."""
    shape = coefficients.shape[:-1]
    flat = coefficients.reshape(-1, 5)
    value = np.zeros((len(flat), 4), dtype=complex)
    present = np.zeros((len(flat), 4), dtype=bool)
    degree = 4 - np.argmax((flat != 0.0)[:, ::-1], axis=-1)
    for each in np.unique(degree):
        rows = np.flatnonzero(degree == each)
        count = int(each)
        matrix = np.zeros((len(rows), count, count))
        matrix[:, np.arange(1, count), np.arange(count - 1)] = 1.0
        matrix[:, :, -1] = -flat[rows, :count] / flat[rows, count, None]
        roots = np.linalg.eigvals(matrix).astype(complex)
        roots = np.take_along_axis(roots, np.argsort(np.abs(roots), axis=-1), axis=-1)
        value[rows, :count], present[rows, :count] = roots, True
    rising = np.arange(5)
    slopes = flat[:, 1:] * rising[1:]
    for _ in range(3):
        step = _ratio(_at(flat, value), _at(slopes, value))
        value = np.where(present & (np.abs(step) < 0.1 * np.abs(value)), value - step, value)
    size = _at(np.abs(flat), np.abs(value).astype(complex)).real
    uncertainty = 8.0 * UNIT_ROUNDOFF * size
    # a close pair moves by the root of the uncertainty
    simple = _ratio(uncertainty, np.abs(_at(slopes, value)))
    bend = np.abs(_at(slopes[:, 1:] * rising[1:4], value)) / 2.0
    error = np.minimum(4.0 * simple, 4.0 * np.sqrt(_ratio(uncertainty, bend)))
    error = np.where(present, error + 2.0 * UNIT_ROUNDOFF * np.abs(value), 0.0)
    return Poles(value.reshape(*shape, 4), error.reshape(*shape, 4), present.reshape(*shape, 4))


def _at(coefficients: np.ndarray, s: np.ndarray) -> np.ndarray:
    result = np.zeros_like(s)
    for place in range(coefficients.shape[-1] - 1, -1, -1):
        result = result * s + coefficients[:, place, None]
    return result


def _ratio(top: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        result = top / bottom
    return np.where(np.isfinite(result), result, np.inf)


# ----------------------------------------------------------------------------
# Frequencies at which the response does not depend on the secondary's damping.
# ----------------------------------------------------------------------------


class FixedPoints(NamedTuple):
    """Frequency ratios P and Q of the fixed points and |H| (force, displacement) there, all (...).

    `error_p` and `error_q` are of the magnitudes. Without a spring P is at zero frequency.
    """

    frequency_p: np.ndarray
    frequency_q: np.ndarray
    magnitude_p: np.ndarray
    magnitude_q: np.ndarray
    error_p: np.ndarray
    error_q: np.ndarray


def fixed_points(
    mass_ratio: ArrayLike, stiffness_ratio: ArrayLike, primary_damping: ArrayLike = 0.0
) -> FixedPoints:
    """The two points through which the curves of every z2 pass, for an undamped primary.

    Where they pass, the free curve 1 / (1 - u) of an undamped absorber and the locked curve
    1 / (1 - (1 + m) u) have the same magnitude: (2 + m) m u^2 - 2 (m + k + k m) u + 2 k = 0,
    |H| = 1 / |1 - (1 + m) u|. The frequencies are those of every response of the primary.
    With a damped primary no frequency is independent of z2: raises NumericalFailure.
    Source: Den Hartog, Mechanical Vibrations; Baca Vasquez (2007) takes the two peaks for them.
    """
    if np.any(np.asarray(primary_damping) != 0.0):
        raise NumericalFailure("a damped primary system has no fixed points: every curve differs")
    m, k = np.broadcast_arrays(
        np.asarray(mass_ratio, dtype=float), np.asarray(stiffness_ratio, dtype=float)
    )
    if not np.all((m > 0.0) & (k >= 0.0) & np.isfinite(k)):
        raise NumericalFailure("fixed points need a mass ratio above 0 and a finite stiffness")
    ratio = k / m
    total = 2.0 * (1.0 + ratio * (1.0 + m)) / (2.0 + m)
    # total^2/4 - 2 ratio/(2 + m), over (2 + m)^2: a sum of squares
    gap = np.sqrt(
        np.square(1.0 - ratio * (1.0 + m)) + 2.0 * m * ratio
    ) * 2.0 / (2.0 + m)  # fmt: skip
    upper = (total + gap) / 2.0
    lower = 2.0 * ratio / ((2.0 + m) * upper)
    height, error = [], []
    for u in (lower, upper):
        away = np.abs(1.0 - (1.0 + m) * u)
        height.append(1.0 / away)
        error.append(8.0 * UNIT_ROUNDOFF * (1.0 + (1.0 + m) * u) / np.square(away))
    return FixedPoints(np.sqrt(lower), np.sqrt(upper), *height, *error)

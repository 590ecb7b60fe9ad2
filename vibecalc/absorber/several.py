"""Response of a primary system with several absorbers, side by side, in a row, or as a tree."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.transfer import Transfer, transfer_of
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Several absorbers on one primary system, side by side, in a row, or as any tree: response.
#
# Seen from where it is fastened, a secondary with all that hangs on it is a mass that depends on
# frequency, w = K a / (K + s^2 a) with K = k + 2 z s and a = m + the sum of w over what it carries.
# Numerators and denominators are kept apart, so that an undamped absorber at its own frequency
# (w infinite, the primary system at rest) needs no special case.
# ----------------------------------------------------------------------------


class Several(NamedTuple):
    """n secondary systems; ratios as in `Absorber`, all referred to the primary system.

    `primary_damping` (...), the others (..., n). `parent` (n whole numbers): what each hangs on,
    0 the primary system, j the j-th secondary (counted from 1, and before it in the list).
    """

    primary_damping: ArrayLike
    mass_ratio: ArrayLike
    stiffness_ratio: ArrayLike
    secondary_damping: ArrayLike
    parent: tuple[int, ...]


def checked_parents(system: Several) -> tuple[int, ...]:
    """The parents; raises NumericalFailure where they make no tree."""
    count = np.shape(system.mass_ratio)[-1]
    if len(system.parent) != count or any(not 0 <= p <= i for i, p in enumerate(system.parent)):
        raise NumericalFailure(
            f"parents {system.parent} of {count} absorbers: each must be 0 (the primary system) "
            "or the number of an absorber before it"
        )
    return system.parent


def several_amplitude(
    system: Several,
    frequency: ArrayLike,
    excitation: str = "force",
    response: str = "displacement",
    absorber: int = 1,
) -> np.ndarray:
    """Complex amplitude H(x), 0-to-peak, relative to what `transfer_of` says.

    `frequency` x broadcasts with the leading axes (...). `absorber` (from 1) is the one meant by
    "secondary_displacement" and "relative_displacement" (against what it hangs on). Infinite on
    an undamped natural frequency; infinite k or z fasten an absorber rigidly.
    """
    transfer = transfer_of(excitation, response)
    parent = checked_parents(system)
    z1, m, k, z = (np.asarray(part, dtype=float) for part in system[:4])
    x = np.asarray(frequency, dtype=float)
    s = 1j * x
    branches = _branches(parent, m, k, z, s)
    top, bottom = branches[0].inner_top, branches[0].inner_bottom
    drag = 1.0 + 2.0 * z1 * s
    below = drag * bottom + s * s * top
    above = top if transfer.motion == "ground" else bottom
    if transfer.motion in ("relative", "secondary"):
        above = _numerator(parent, absorber, transfer.motion, branches)
    above = above * transfer.sign * s**transfer.power * drag**transfer.ground
    with np.errstate(divide="ignore", invalid="ignore"):
        value = above / below
    return np.where((below == 0.0) & (above != 0.0), np.inf, value)


def path_to(parent: tuple[int, ...], absorber: int) -> list[int]:
    """Numbers of the absorbers from the primary system to `absorber`, itself included."""
    if not 1 <= absorber <= len(parent):
        raise NumericalFailure(f"absorber {absorber} of {len(parent)}: counted from 1")
    path = [absorber]
    while parent[path[0] - 1]:
        path.insert(0, parent[path[0] - 1])
    return path


class _Branch(NamedTuple):
    """A secondary with what it carries: a and w as numerators over denominators.

    Both parts of w are over `scale`. `stiff` and `inertia` are K and s^2 over s^0, s or s^2, as
    many as K holds; a locked one has K = 1 and no inertia of its own in w's denominator.
    """

    inner_top: np.ndarray
    inner_bottom: np.ndarray
    top: np.ndarray
    bottom: np.ndarray
    scale: np.ndarray
    stiff: np.ndarray
    inertia: np.ndarray


def _branches(
    parent: tuple[int, ...], m: np.ndarray, k: np.ndarray, z: np.ndarray, s: np.ndarray
) -> list[_Branch]:
    """The primary system (first, with a alone) and all secondaries."""
    shape = np.broadcast_shapes(s.shape, m.shape[:-1], k.shape[:-1], z.shape[:-1])
    one = np.ones(shape, dtype=complex)
    inner = [(one, one)] + [(m[..., i] * one, one) for i in range(len(parent))]
    branches: list[_Branch] = []
    for i in reversed(range(len(parent))):
        top, bottom = inner[i + 1]
        stiff, inertia = _bond(k[..., i], z[..., i], s)
        above, below = stiff * top, stiff * bottom + inertia * top
        scale = np.maximum(np.abs(above), np.abs(below))
        above, below = above / scale, below / scale
        branches.insert(0, _Branch(top, bottom, above, below, scale, stiff, inertia))
        base = inner[parent[i]]
        inner[parent[i]] = base[0] * below + above * base[1], base[1] * below
    return [_Branch(inner[0][0], inner[0][1], one, one, one, one, one), *branches]


def _bond(k: np.ndarray, z: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    locked = np.isinf(k) | np.isinf(z)
    drag = 2.0 * np.where(locked, 0.0, z)
    loose, free = (k == 0.0) & ~locked, (k == 0.0) & (z == 0.0)
    stiff = np.where(loose, drag + 0.0 * s, np.where(locked, 1.0, k) + drag * s)
    inertia = np.where(free, 1.0 + 0.0 * s, np.where(loose, s, s * s))
    return stiff, np.where(locked, 0.0, inertia)


def _numerator(
    parent: tuple[int, ...], absorber: int, motion: str, branches: list[_Branch]
) -> np.ndarray:
    """Numerator of the motion of an absorber, alone or against what it hangs on.

    The denominators of w along the path cancel against the primary's numerator.
    """
    product = np.ones_like(branches[0].top)
    for number in path_to(parent, absorber):
        for other, above in enumerate(parent, start=1):
            if above == parent[number - 1] and other != number:
                product = product * branches[other].bottom
        here = branches[number]
        if number != absorber:
            product = product * here.stiff / here.scale
        elif motion == "relative":
            product = -product * here.inertia * here.inner_top / here.scale
        else:
            product = product * here.stiff * here.inner_bottom / here.scale
    return product


# ----------------------------------------------------------------------------
# Numerator and denominator of any response of several absorbers as polynomials in s.
# ----------------------------------------------------------------------------

Polynomial = np.ndarray


def several_polynomials(
    system: Several, transfer: Transfer, absorber: int = 1
) -> tuple[Polynomial, Polynomial]:
    """Coefficients of N and D, H = N / D, lowest power first, of one system (no leading axes).

    Built from sums and products of positive numbers only: every coefficient keeps its relative
    accuracy. Factors s common to both (an absorber without a spring) stay in.
    """
    parent = checked_parents(system)
    z1 = float(np.asarray(system.primary_damping))
    m, k, z = (np.asarray(part, dtype=float) for part in system[1:4])
    count = len(parent)
    inner: list[tuple[Polynomial, Polynomial]] = [(np.ones(1), np.ones(1))]
    inner += [(m[i : i + 1], np.ones(1)) for i in range(count)]
    outer_bottom = [np.ones(1)] * (count + 1)
    for i in reversed(range(count)):
        top, bottom = inner[i + 1]
        if np.isinf(k[i]) or np.isinf(z[i]):
            above, below = top, bottom
        else:
            stiff = np.array([k[i], 2.0 * z[i]])
            above = np.convolve(stiff, top)
            below = added(np.convolve(stiff, bottom), np.concatenate([[0.0, 0.0], top]))
        outer_bottom[i + 1] = below
        base = inner[parent[i]]
        inner[parent[i]] = (
            added(np.convolve(base[0], below), np.convolve(above, base[1])),
            np.convolve(base[1], below),
        )
    top, bottom = inner[0]
    drag = np.array([1.0, 2.0 * z1])
    denominator = added(np.convolve(drag, bottom), np.concatenate([[0.0, 0.0], top]))
    if transfer.motion == "primary":
        numerator = bottom
    elif transfer.motion == "ground":
        numerator = top
    else:
        numerator = _along_path(parent, absorber, transfer, k, z, inner, outer_bottom)
    numerator = np.concatenate([np.zeros(transfer.power), numerator])
    for _ in range(transfer.ground):
        numerator = np.convolve(numerator, drag)
    return transfer.sign * numerator, denominator


def added(first: Polynomial, second: Polynomial) -> Polynomial:
    """Sum of two polynomials."""
    result = np.zeros(max(len(first), len(second)))
    result[: len(first)] += first
    result[: len(second)] += second
    return result


def _along_path(
    parent: tuple[int, ...], absorber: int, transfer: Transfer, k: np.ndarray, z: np.ndarray,
    inner: list[tuple[Polynomial, Polynomial]], outer_bottom: list[Polynomial],
) -> Polynomial:  # fmt: skip
    """What w's denominators along the path leave, times what is transferred."""
    result = np.ones(1)
    path = path_to(parent, absorber)
    for number in path:
        for other, above in enumerate(parent, start=1):
            if above == parent[number - 1] and other != number:
                result = np.convolve(result, outer_bottom[other])
        last = number == absorber
        locked = np.isinf(k[number - 1]) or np.isinf(z[number - 1])
        if last and transfer.motion == "relative":
            inertia = np.concatenate([[0.0, 0.0], -inner[number][0]])
            result = np.zeros(1) if locked else np.convolve(result, inertia)
        elif not locked:
            result = np.convolve(result, [k[number - 1], 2.0 * z[number - 1]])
        if last and transfer.motion == "secondary":
            result = np.convolve(result, inner[number][1])
    return result


def squared(polynomial: Polynomial) -> Polynomial:
    """|p(i x)|^2 as a polynomial in u = x^2, lowest power first."""
    even, odd = polynomial[0::2].copy(), polynomial[1::2].copy()
    even[1::2] *= -1.0
    odd[1::2] *= -1.0
    if not len(odd):
        return np.convolve(even, even)
    return added(np.convolve(even, even), np.concatenate([[0.0], np.convolve(odd, odd)]))


# ----------------------------------------------------------------------------
# Rounding in the response of several absorbers, from the polynomials that it is a quotient of.
# ----------------------------------------------------------------------------

#: roundings on the way to a coefficient and to a power of the frequency
_ROUNDINGS = 8.0


def several_with_error(
    system: Several, frequency: np.ndarray, excitation: str, response: str, absorber: int = 1
) -> Bounded:
    """`several_amplitude` of one system at frequencies x (n,) with the error of |H|.

    Numerator and denominator are sums of terms that cancel near a zero or a resonance: what is left
    keeps the rounding of the largest of them. Zero error where the response is infinite.
    """
    value = several_amplitude(system, frequency, excitation, response, absorber)
    above, below = several_polynomials(system, transfer_of(excitation, response), absorber)
    if not np.any(above):  # a mass that nothing moves, at a resonance as well
        return Bounded(np.zeros_like(value), np.zeros(value.shape))
    finite = np.isfinite(value)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        lost = [_lost(side, frequency) for side in (above, below)]
        share = np.where(value == 0.0, 0.0, lost[0]) + lost[1]
        error = _ROUNDINGS * UNIT_ROUNDOFF * np.abs(value) * share
    return Bounded(value, np.where(finite & np.isfinite(error), error, 0.0))


def _lost(polynomial: Polynomial, x: np.ndarray) -> np.ndarray:
    """Sum of the magnitudes of all terms at s = i x over that of their sum."""
    size = np.polynomial.polynomial.polyval(np.abs(x), np.abs(polynomial))
    value = np.abs(np.polynomial.polynomial.polyval(1j * x, polynomial))
    return np.asarray(size / value)

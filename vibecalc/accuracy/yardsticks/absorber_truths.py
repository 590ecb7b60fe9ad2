"""Primary systems with absorbers in many digits: highest peaks and least highest peaks."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.absorber.model import transfer_of

if TYPE_CHECKING:
    from mpmath.ctx_mp import MPContext

#: digits of the values, and those of the check that they are right
_DIGITS, _MORE = 34, 50
#: relative distance of the two places from which a peak is closed in
_NEAR = 1e-6


#: numbers of n absorbers
Ratios = Sequence[float] | np.ndarray
_Many = Sequence[Any] | np.ndarray


class System(NamedTuple):
    """Ratios as in `response.absorber.several.Several`, (n,) each; response of the primary system.

    Infinite stiffness fastens an absorber rigidly.
    """

    primary_damping: float
    mass_ratio: Ratios
    stiffness_ratio: Ratios
    secondary_damping: Ratios
    parent: tuple[int, ...]
    excitation: str = "force"
    response: str = "displacement"


class Truth(NamedTuple):
    """A value, where it stands, and how far two precisions agree, relatively."""

    value: float
    place: tuple[float, ...]
    agreement: float


def is_of_primary(excitation: str, response: str) -> bool:
    """Whether these functions know the response."""
    return transfer_of(excitation, response).motion == "primary"


def highest_peak(system: System, near: float) -> Truth:
    """The maximum of |H| whose frequency ratio is close to `near`, which stands in `place`.

    Raises NumericalFailure where the slope has no zero near that.
    """
    coarse, fine = (_peak(system, near, digits) for digits in (_DIGITS, _MORE))
    return Truth(float(fine[0]), (float(fine[1]),), _apart(coarse[0], fine[0]))


def _peak(system: System, near: float, digits: int) -> tuple[Any, Any]:
    from mpmath import mp

    with mp.workdps(digits):

        def level(x: Any) -> Any:
            return _level(mp, system, system.stiffness_ratio, system.secondary_damping, x)

        try:
            beside = mp.mpf(near) * (1 - _NEAR), mp.mpf(near) * (1 + _NEAR)
            place = mp.findroot(lambda x: mp.diff(level, x), beside, tol=mp.mpf(10) ** -30)
        except (ValueError, ZeroDivisionError) as error:
            raise NumericalFailure(f"no peak near the frequency ratio {near:.9g}") from error
        if abs(place - near) > 0.01 * near or mp.diff(level, place, 2) >= 0:
            raise NumericalFailure(f"no peak near the frequency ratio {near:.9g}")
        return mp.exp(level(place) / 2), place


def least_highest_peak(
    system: System, spring: bool, peaks: Sequence[float], weights: Sequence[float]
) -> Truth:
    """The stationary point of the largest of some peaks, near the tuning and `peaks` given.

    Unknowns are the logarithms of all k (with `spring`) and all z2, the frequency ratios of the
    peaks and their weights; equations: peaks stationary and level, weighted slopes zero, weights
    one together. `place` holds k (n,), then z2 (n,).
    Raises NumericalFailure where Newton's method ends nowhere.
    """
    coarse, fine = (_balance(system, spring, peaks, weights, d) for d in (_DIGITS, _MORE))
    place = tuple(float(value) for value in fine[1])
    return Truth(float(fine[0]), place, _apart(coarse[0], fine[0]))


def _balance(
    system: System, spring: bool, peaks: Sequence[float], weights: Sequence[float], digits: int
) -> tuple[Any, list[Any]]:
    from mpmath import mp

    count, active = len(system.mass_ratio), len(peaks)
    with mp.workdps(digits):
        stiff = [mp.mpf(k) for k in system.stiffness_ratio]

        def split(unknown: Sequence[Any]) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
            values = list(unknown)
            k = [mp.exp(v) for v in values[:count]] if spring else stiff
            rest = values[count if spring else 0 :]
            z2 = [mp.exp(v) for v in rest[:count]]
            return k, z2, rest[count : count + active], rest[count + active :]

        def conditions(*unknown: Any) -> list[Any]:
            k, z2, places, shares = split(unknown)
            slopes = [_slopes(mp, system, k, z2, x) for x in places]
            levels = [_level(mp, system, k, z2, x) for x in places]
            left = [slope[0] for slope in slopes]
            left += [levels[i] - levels[0] for i in range(1, active)]
            for which in range(0 if spring else count, 2 * count):
                left.append(sum(w * s[1 + which] for w, s in zip(shares, slopes, strict=True)))
            return [*left, sum(shares) - 1]

        start = [mp.log(mp.mpf(k)) for k in system.stiffness_ratio] if spring else []
        start += [mp.log(mp.mpf(z)) for z in system.secondary_damping]
        start += [mp.mpf(float(v)) for v in (*peaks, *weights)]
        try:
            found = mp.findroot(conditions, start, tol=mp.mpf(10) ** (-2 * (digits - 6)))
        except (ValueError, ZeroDivisionError) as error:
            raise NumericalFailure("no balance of the peaks near the tuning given") from error
        k, z2, places, _ = split(found)
        return mp.exp(_level(mp, system, k, z2, places[0]) / 2), [*k, *z2]


def _level(mp: "MPContext", system: System, k: _Many, z2: _Many, x: Any) -> Any:
    """ln |H|^2."""
    z1, transfer = mp.mpf(system.primary_damping), transfer_of(system.excitation, system.response)
    s = mp.mpc(0, 1) * x
    below = 1 + 2 * z1 * s + s * s * (1 + _carried(mp, system, k, z2, s, 0))
    top = 2 * transfer.power * mp.log(x) + transfer.ground * mp.log(1 + 4 * z1 * z1 * x * x)
    return top - mp.log(below.real**2 + below.imag**2)


def _carried(mp: "MPContext", system: System, k: _Many, z2: _Many, s: Any, carrier: int) -> Any:
    """What hangs on one mass, as a mass that depends on frequency."""
    total = mp.mpf(0)
    for place, parent in enumerate(system.parent):
        if parent != carrier:
            continue
        mass = mp.mpf(system.mass_ratio[place]) + _carried(mp, system, k, z2, s, place + 1)
        link = mp.mpf(k[place]) + 2 * mp.mpf(z2[place]) * s
        total += mass if mp.isinf(k[place]) else mass * link / (link + s * s * mass)
    return total


def _slopes(mp: "MPContext", system: System, k: _Many, z2: _Many, x: Any) -> list[Any]:
    """Derivatives of ln |H|^2 by x, by all ln k, by all ln z2; absorbers on the primary only."""
    z1, transfer = mp.mpf(system.primary_damping), transfer_of(system.excitation, system.response)
    s = mp.mpc(0, 1) * x
    links = [a + 2 * b * s for a, b in zip(k, z2, strict=True)]
    masses = [mp.mpf(m) for m in system.mass_ratio]
    wholes = [link + m * s * s for link, m in zip(links, masses, strict=True)]
    carried = sum(m * g / n for m, g, n in zip(masses, links, wholes, strict=True))
    below = 1 + 2 * z1 * s + s * s * (1 + carried)
    # of m g / n by g; by s the link changes, too, and so does n
    by_link = [(m * s / n) ** 2 for m, n in zip(masses, wholes, strict=True)]
    turned = sum(
        d * 2 * z - 2 * m * m * s * g / (n * n)
        for d, z, m, g, n in zip(by_link, z2, masses, links, wholes, strict=True)
    )
    below_slope = 2 * z1 + 2 * s * (1 + carried) + s * s * turned
    first = 2 * transfer.power / x - 2 * (mp.mpc(0, 1) * below_slope / below).real
    if transfer.ground:
        first += transfer.ground * 8 * z1 * z1 * x / (1 + 4 * z1 * z1 * x * x)
    springs = [-2 * (s * s * d * a / below).real for d, a in zip(by_link, k, strict=True)]
    dampers = [-2 * (s * s * d * 2 * b * s / below).real for d, b in zip(by_link, z2, strict=True)]
    return [first, *springs, *dampers]


def _apart(one: Any, other: Any) -> float:
    """Relative distance, never below the rounding to double precision."""
    return max(float(abs(one / other - 1)), UNIT_ROUNDOFF)


def rounded(values: np.ndarray, digits: int = 4) -> list[float]:
    """A few digits of each: enough to start from, too few to hand errors on."""
    return [float(f"{value:.{digits - 1}e}") for value in np.atleast_1d(values)]

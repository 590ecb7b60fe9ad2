"""Hard cases of the tuned absorber: flat valleys, thresholds, dampers without a spring.

Baca Vasquez (2007), chapters 2 and 3. Asked are the stiffness ratio k, the damping z2 on the
primary and the largest response above what no absorber can lower.
"""

from functools import cache

import mpmath
import numpy as np
from exact_tree import optimum, tree
from exact_tree import peaks as exact_peaks
from mpmath import mp, mpf
from stability.hard_case import HardCase, Numbers, Way, condition_of, singular

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber, damping_from_own_ratio, own_damping_ratio
from vibecalc.absorber.tuning.closed_forms import den_hartog
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import pure_viscous
from vibecalc.numerics.bounded import Bounded

KIND = ("force", "displacement")
NEARBY = 2**-0.5 - 1e-8


def own(z1: float, m: float) -> Bounded:
    found = minimax(z1, m)
    values = np.array([found.stiffness_ratio, found.secondary_damping, found.above_floor])
    uncertainty = found.above_floor * found.excess_error / found.excess + 2e-16 * found.above_floor
    return Bounded(values, np.array([found.stiffness_error, found.damping_error, uncertainty]))


def exact(z1: float, m: float, near: tuple[float, float]) -> Numbers:
    """The tuning next to that of z1 and m `near`, in many digits."""
    found = minimax(*near)
    start = float(found.stiffness_ratio), float(found.secondary_damping)
    with mpmath.workdps(100):
        return optimum(
            KIND, z1, m, start, found.frequency.tolist(), found.weight.tolist(),
            mpf(float(found.floor)),
        )  # fmt: skip


@cache
def truth_of(z1: float, m: float) -> Numbers:
    return exact(z1, m, (z1, m))


def condition(z1: float, m: float) -> float:
    """Relative condition of k, z2 and the height, from two optima next to each other."""
    base, part = truth_of(z1, m), 1e-9
    total = [0.0, 0.0, 0.0]
    for one in ((z1 * (1 - part), m), (z1, m * (1 - part))):
        moved = exact(*one, (z1, m))
        total = [
            so_far + abs(float((b - a) / a)) / part
            for so_far, a, b in zip(total, base, moved, strict=True)
        ]
    return max(total)


def level(z1: float, m: float, k: float, z2: float) -> float:
    """Largest |H| over a grid of frequencies of .001, 0 to 2, in plain floats."""
    x = np.arange(1, 2001) * 1e-3
    s = 1j * x
    spring = k + 2.0 * z2 * s
    own_motion = m * s * s + spring
    primary = s * s + 2.0 * z1 * s + 1.0 + spring
    return float(np.max(np.abs(own_motion / (primary * own_motion - spring**2))))


def by_simplex(z1: float, m: float) -> np.ndarray:
    """scipy's Nelder-Mead from Den Hartog's tuning."""
    from scipy.optimize import minimize

    start = [float(one) for one in den_hartog(np.asarray(m))[:2]]
    found = minimize(
        lambda v: level(z1, m, *v), start, method="Nelder-Mead",
        options={"xatol": 1e-12, "fatol": 1e-14, "maxfev": 400},
    )  # fmt: skip
    return np.array([*found.x, found.fun - 1.0 if z1 > 0.4 else found.fun])


def by_grid(z1: float, m: float) -> np.ndarray:
    """The source's grid of .001 in k and in eps2 on the absorber's own frequency, near the best."""
    best = minimax(z1, m)
    k0 = float(best.stiffness_ratio)
    own_ratio = float(own_damping_ratio(Absorber(z1, m, k0, float(best.secondary_damping))))
    found = (np.inf, 0.0, 0.0)
    for i in range(max(0, round(1e3 * k0) - 3), round(1e3 * k0) + 4):
        for j in range(max(0, round(1e3 * own_ratio) - 3), round(1e3 * own_ratio) + 4):
            z2 = float(damping_from_own_ratio(1e-3 * j, m, 1e-3 * i))
            found = min(found, (level(z1, m, 1e-3 * i, z2), 1e-3 * i, z2))
    return np.array([found[1], found[2], found[0] - 1.0 if z1 > 0.4 else found[0]])


def by_den_hartog(z1: float, m: float) -> np.ndarray:
    k, z2 = (float(one) for one in den_hartog(np.asarray(m))[:2])
    height = level(z1, m, k, z2)
    return np.array([k, z2, height - 1.0 if z1 > 0.4 else height])


def tuning(name: str, z1: float, m: float, truth: Numbers | None = None) -> HardCase:
    return HardCase(
        name, lambda: condition(z1, m),
        (lambda: truth) if truth is not None else (lambda: truth_of(z1, m)),
        lambda: own(z1, m),
        (Way("grid of .001 in k, eps2 and x", lambda: by_grid(z1, m)),
         Way("Nelder-Mead on a grid of x", lambda: by_simplex(z1, m), loose=True),
         Way("Den Hartog's closed form", lambda: by_den_hartog(z1, m))),
    )  # fmt: skip


@cache
def one_half() -> Numbers:
    """e1 = mu = 1/2: k = 1/27, h = 3 / (2 sqrt 2), eps2 = 1/sqrt 6 on the own frequency."""
    with mpmath.workdps(60):
        # z2 = eps2 m sqrt(k / m); above the floor 1
        damping = mp.sqrt(mpf(1) / 6) * mpf(1) / 2 * mp.sqrt(mpf(2) / 27)
        return [mpf(1) / 27, damping, 3 / (2 * mp.sqrt(2)) - 1]


def own_viscous(m: float) -> Bounded:
    found = pure_viscous(0.0, m)
    return Bounded(
        np.array([found.value, found.largest]), np.array([found.value_error, found.largest_error])
    )


def viscous_formula(m: mpf) -> Numbers:
    return [m / mp.sqrt(2 * (1 + m) * (2 + m)), 1 + 2 / m]


def viscous_truth(m: float) -> Numbers:
    """Closed form: z2 = m / sqrt(2 (1 + m) (2 + m)) / 1 with the largest response 1 + 2 / m."""
    with mpmath.workdps(40):
        return viscous_formula(mpf(m))


def viscous() -> HardCase:
    m = 0.1

    def in_the_square() -> np.ndarray:
        """Best of the square 0 < k, eps2 <= 1 along its edge of weak springs."""
        k = 1e-3
        tried = [(level(0.0, m, k, float(damping_from_own_ratio(e, m, k))), e)
                 for e in np.linspace(1e-3, 1.0, 1000)]  # fmt: skip
        least, ratio = min(tried)
        return np.array([float(damping_from_own_ratio(ratio, m, k)), least])

    return HardCase(
        "k = 0, a damper without a spring: eps2 is infinite there",
        lambda: condition_of(viscous_formula, m), lambda: viscous_truth(m),
        lambda: own_viscous(m),
        (Way("the square of k and eps2 up to 1", in_the_square),),
    )  # fmt: skip


LIGHT = Absorber(1e-9, 1e-3, 0.999e-3, 1e-13)


def exact_light(ratios: list[float]) -> Numbers:
    """Frequency and height of both peaks in many digits."""
    z1, m, k, z2 = ratios
    with mpmath.workdps(100):
        found = exact_peaks(tree(z1, [m], [k], [z2]), *KIND)
        assert len(found.frequency) == 2
        return [*sum(zip(found.frequency, found.magnitude, strict=True), ())]


@cache
def light_truth() -> Numbers:
    return exact_light([1e-9, 1e-3, 0.999e-3, 1e-13])


def own_light() -> Bounded:
    found = peaks(LIGHT)
    value = np.column_stack([found.frequency[:2], found.magnitude[:2]]).ravel()
    # a frequency is good to the rounding of its polish; what it does to the height is in that
    error = np.column_stack([1e-15 * found.frequency[:2], found.error[:2]]).ravel()
    return Bounded(value, error)


def light_roots() -> np.ndarray:
    """numpy.roots on the derivative of |H|^2 as a quotient of expanded polynomials."""
    z1, m, k, z2 = (float(np.asarray(one)) for one in LIGHT)
    top = np.array([m * m, 4 * z2 * z2 - 2 * k * m, k * k])
    den = np.array([m, 2 * (z2 * (1 + m) + z1 * m), k * (1 + m) + m + 4 * z1 * z2,
                    2 * (z1 * k + z2), k])  # fmt: skip
    real, odd = np.array([den[0], -den[2], den[4]]), np.array([-den[1], den[3]])
    below = np.polyadd(np.polymul(real, real), np.polymul([1.0, 0.0], np.polymul(odd, odd)))
    slope = np.polysub(np.polymul(np.polyder(top), below), np.polymul(top, np.polyder(below)))
    root = np.roots(slope)
    u = np.sort(root[(np.abs(root.imag) < 1e-6) & (root.real > 0.1)].real)
    u = u[np.argsort(-np.polyval(top, u) / np.abs(np.polyval(below, u)))[:2]]
    u.sort()
    height = np.sqrt(np.abs(np.polyval(top, u) / np.polyval(below, u)))
    return np.column_stack([np.sqrt(u), height]).ravel()


def light_grid() -> np.ndarray:
    x = np.arange(900_000, 1_100_000) * 1e-6
    z1, m, k, z2 = (float(np.asarray(one)) for one in LIGHT)
    s = 1j * x
    spring = k + 2 * z2 * s
    own_motion = m * s * s + spring
    size = np.abs(own_motion / ((s * s + 2 * z1 * s + 1 + spring) * own_motion - spring**2))
    place = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1
    return np.column_stack([x[place], size[place]]).ravel()[:4]


def light() -> HardCase:
    return HardCase(
        "both peaks of a nearly undamped pair (z1 = 1e-9)", light_condition,
        light_truth, own_light,
        (Way("numpy.roots of the expanded quotient", light_roots, loose=True),
         Way("grid of 1e-6 in x", light_grid)),
    )  # fmt: skip


def no_mass() -> HardCase:
    return HardCase(
        "mu = 0", singular, None,
        lambda: own(0.1, 0.0),
        (Way("Den Hartog's closed form", lambda: by_den_hartog(0.1, 1e-300)),),
    )  # fmt: skip


def light_condition() -> float:
    """By z1 and z2, which hold the peaks, and by k, which places them."""
    base, total = light_truth(), 0.0
    for place in (0, 2, 3):
        ratios = [1e-9, 1e-3, 0.999e-3, 1e-13]
        ratios[place] *= 1.0 + 2.0**-40
        moved = exact_light(ratios)
        total += max(float(abs(b / a - 1)) for a, b in zip(base, moved, strict=True)) * 2.0**40
    return total


def cases() -> tuple[HardCase, ...]:
    return (
        tuning("e1 = 1/sqrt 2 - 1e-8: k = 2e-16", NEARBY, 0.1),
        tuning("e1 = .1, mu = .01", 0.1, 0.01),
        tuning("e1 = mu = 1/2", 0.5, 0.5, one_half()),
        tuning("e1 = 0, mu = 1e-6: narrow peaks 1e-3 apart", 0.0, 1e-6),
        viscous(),
        light(),
        no_mass(),
    )  # fmt: skip

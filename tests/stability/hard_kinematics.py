"""Hard cases of the slider-crank: long cranks, high orders, sums that cancel.

Ong (2000), eq. 2.15 and appendix I; his hard cases are R/L from 1e-3 to .999999 and orders to 200.
With lam for R/L, kappa for the pole and C for coefficients of s/R.
"""

from collections.abc import Callable
from functools import cache

import mpmath
import numpy as np
from shipped_cases import CASES
from stability.hard_case import HardCase, Way, condition_of, singular

from vibecalc.core.study.execute import load_checked
from vibecalc.kinematics.harmonics import harmonics_with_error
from vibecalc.kinematics.slider_crank import piston_motion
from vibecalc.kinematics.truncated_series import truncated_harmonics
from vibecalc.numerics.bounded import Bounded

ONG = 0.5 / 2.375


def sampled(ratio: mpmath.mpf, orders: tuple[int, ...]) -> list[mpmath.mpf]:
    """-n^2 C_n by the trapezoidal rule, so fine and long that no order is taken for another."""
    pole = ratio / (1 + mpmath.sqrt((1 - ratio) * (1 + ratio)))
    decay = -mpmath.log(pole)
    count = 2 * max(orders) + int(60 / decay) + 8
    with mpmath.workdps(int(max(orders) * decay / mpmath.log(10)) + 40):
        angle = [2 * mpmath.pi * j / count for j in range(count)]
        path = [mpmath.sqrt(1 / ratio**2 - mpmath.sin(a) ** 2) for a in angle]
        wave = [mpmath.cos(a) for a in angle]
        return [
            -2 * n * n * sum(s * wave[n * j % count] for j, s in enumerate(path)) / count
            for n in orders
        ]


def closed(ratio: mpmath.mpf, orders: tuple[int, ...]) -> list[mpmath.mpf]:
    """The same by the hypergeometric function of mpmath."""
    pole = ratio / (1 + mpmath.sqrt((1 - ratio) * (1 + ratio)))
    return [
        -(n**2)
        * mpmath.binomial(mpmath.mpf(1) / 2, n // 2)
        * pole ** (n - 1)
        * mpmath.hyp2f1(-0.5, mpmath.mpf(n - 1) / 2, n // 2 + 1, pole**4)
        for n in orders
    ]


def by_samples(ratio: float, orders: tuple[int, ...], count: int) -> np.ndarray:
    """FFT of the plain formula at evenly spaced crank angles."""
    angle = 2.0 * np.pi * np.arange(count) / count
    path = np.sqrt(1.0 / ratio**2 - np.sin(angle) ** 2)
    spectrum = 2.0 * np.fft.rfft(path).real / count
    return -(np.array(orders) ** 2.0) * spectrum[list(orders)]


def by_plain_formula(ratio: float, orders: tuple[int, ...]) -> np.ndarray:
    """The closed form in plain floats, with the textbook formula for kappa and scipy's 2F1."""
    from scipy.special import binom, hyp2f1

    n = np.array(orders, dtype=float)
    kappa = (1.0 - np.sqrt(1.0 - ratio * ratio)) / ratio
    value = -(n**2) * binom(0.5, n / 2) * kappa ** (n - 1.0)
    return np.asarray(value * hyp2f1(-0.5, (n - 1.0) / 2, n / 2 + 1.0, kappa**4))


def own(ratio: float, orders: tuple[int, ...]) -> Bounded:
    found = harmonics_with_error(ratio, max(orders), derivative=2)
    place = list(orders)
    return Bounded(found.values[place].real, found.error[place])


def harmonics_case(
    name: str,
    ratio: float,
    orders: tuple[int, ...],
    truth: Callable[[mpmath.mpf, tuple[int, ...]], list[mpmath.mpf]],
    samples: int = 1024,
) -> HardCase:
    """Acceleration harmonics with the three ways that come to mind."""

    @cache
    def exact() -> list[mpmath.mpf]:
        with mpmath.workdps(40):
            return truth(mpmath.mpf(ratio), orders)

    return HardCase(
        name,
        lambda: condition_of(lambda lam: closed(lam, orders), ratio),
        exact,
        lambda: own(ratio, orders),
        (
            Way(f"FFT of {samples} samples", lambda: by_samples(ratio, orders, samples),
                loose=True),
            Way("eq. 2.15, 40 terms", lambda: cut_series(ratio, orders)),
            Way("closed form, plain floats", lambda: by_plain_formula(ratio, orders),
                loose=True),
        ),
    )  # fmt: skip


def cut_series(ratio: float, orders: tuple[int, ...]) -> np.ndarray:
    return truncated_harmonics(ratio, 40, max(orders), derivative=2)[list(orders)].real


def even(first: int, last: int, step: int = 2) -> tuple[int, ...]:
    return tuple(range(first, last + 1, step))


SHARP = 1.0 - 1e-9
NEARBY = np.pi / 2 + np.array([0.0, 1e-6, -1e-3])


@cache
def sharp_truth() -> list[mpmath.mpf]:
    with mpmath.workdps(60):
        found = []
        for angle in NEARBY.tolist():
            lam, a = mpmath.mpf(SHARP), mpmath.mpf(angle)
            sine, cosine = mpmath.sin(a), mpmath.cos(a)
            rod = mpmath.sqrt(1 - (lam * sine) ** 2)
            found.append(-lam * cosine + (lam * sine) ** 2 / rod - (lam * cosine) ** 2 / rod**3)
        return found


def sharp_own() -> Bounded:
    found = piston_motion(NEARBY, SHARP, 1.0)
    return Bounded(found.acceleration, found.acceleration_error)


def sharp_plain() -> np.ndarray:
    sine, cosine = np.sin(NEARBY), np.cos(NEARBY)
    rod = np.sqrt(1.0 - (SHARP * sine) ** 2)
    return np.asarray(
        -SHARP * cosine - SHARP**2 * (cosine**2 - sine**2) / rod
        - (SHARP**2 * sine * cosine) ** 2 / rod**3
    )  # fmt: skip


def sharp_differences() -> np.ndarray:
    step = 1e-4
    path = [SHARP * np.cos(a) + np.sqrt(1.0 - (SHARP * np.sin(a)) ** 2)
            for a in (NEARBY - step, NEARBY, NEARBY + step)]  # fmt: skip
    return np.asarray((path[0] - 2.0 * path[1] + path[2]) / step**2)


def sharp_condition() -> float:
    """By R/L, at 90 degrees."""

    def acceleration(lam: mpmath.mpf) -> list[mpmath.mpf]:
        return [lam**2 / mpmath.sqrt((1 - lam) * (1 + lam))]

    return condition_of(acceleration, SHARP)


def as_case() -> Bounded:
    """The generator with a rod as long as its crank."""
    load_checked([CASES["generator"]], ['machine.crank_train.rod_length="60 mm"'])
    return Bounded(np.zeros(1), np.zeros(1))


def cases() -> tuple[HardCase, ...]:
    limit = even(2, 20)
    return (
        harmonics_case("R/L = .001, orders 2 to 10", 1e-3, even(2, 10), sampled),
        harmonics_case("R/L of appendix I, orders 2 to 80", ONG, even(2, 80), sampled),
        harmonics_case("R/L = .1, orders 150 to 200 (1e-190 to 1e-255)", 0.1, even(150, 200, 10),
                       sampled),
        harmonics_case("R/L = .9, orders 2 to 200", 0.9, even(2, 200, 22), sampled),
        harmonics_case("R/L = .99, orders 2 to 200", 0.99, even(2, 200, 22), sampled),
        harmonics_case("R/L = .999999, orders 2 to 200", 0.999999, even(2, 200, 22), closed, 4096),
        HardCase(
            "R/L = .01, order 200 (1e-455, below every double)",
            lambda: condition_of(lambda lam: closed(lam, (200,)), 0.01),
            lambda: [mpmath.mpf(0)], lambda: own(0.01, (200,)),
            (Way("FFT of 1024 samples", lambda: by_samples(0.01, (200,), 1024)),),
        ),
        HardCase(
            "R/L = 1 - 1e-9, acceleration at and next to 90 degrees", sharp_condition,
            sharp_truth, sharp_own,
            (Way("textbook formula, plain floats", sharp_plain, loose=True),
             Way("second differences, 1e-4 rad", sharp_differences)),
        ),
        HardCase(
            "R/L = 1 in a case", singular, None, as_case,
            (Way("FFT of 1024 samples", lambda: by_samples(1.0, limit, 1024)),),
        ),
        HardCase(
            "R/L = 1: the acceleration jumps at 90 degrees", singular, None,
            lambda: own(1.0, limit),
            (Way("FFT of 1024 samples", lambda: by_samples(1.0, limit, 1024)),
             Way("eq. 2.15, 40 terms", lambda: cut_series(1.0, limit))),
        ),
    )  # fmt: skip

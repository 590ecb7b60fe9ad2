"""Topics of the kinematics: every harmonic of the piston acceleration to its own size.

An engineer reads harmonics in decibels, so each is measured against its own magnitude: the values
are the harmonics over the true magnitudes, all of size 1.
"""

import math
from typing import Any

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.fourier_samples import harmonics_of_samples, transform_work
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.poles import pole, series_terms
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.kinematics.truncated_series import truncated_harmonics
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.kinematics import PistonMotion

MOST_ORDERS = 80
#: multiplications that stand for a sine, a cosine, a root and what joins them at one angle
ONE_ANGLE = 45
#: digits beyond those that the smallest harmonic lies below the first
GUARD_DIGITS = 35


def topics(scene: Scene) -> list[Topic]:
    """The harmonics of the acceleration from order 1 on, those that are not zero."""
    motion: PistonMotion = scene.handed_on["motion"]
    train, options = scene.parts.crank_train, scene.case.kinematics
    ratio = train.crank_radius / train.rod_length
    offset = train.wrist_pin_offset / train.crank_radius
    highest = min(max(motion.kept, 2), MOST_ORDERS)
    orders = np.arange(1, highest + 1)
    if offset == 0.0:
        orders = orders[(orders == 1) | (orders % 2 == 0)]
    cut = None
    if options is not None and options.series == "truncated":
        cut = options.terms or 1
    return [_topic(ratio, offset, orders, cut)]


def _topic(ratio: float, offset: float, orders: np.ndarray, cut: int | None) -> Topic:
    highest = int(orders[-1])
    size = np.abs(motion_harmonics(ratio, highest, offset, derivative=2))[orders]
    half = highest // 2 + 1

    def shown(harmonics: np.ndarray, work: float) -> Answer:
        return Answer(harmonics[orders] / size, work)

    def exact(_: float) -> Answer:
        near = pole(np.asarray(ratio), np.asarray(abs(offset)))
        square = near.radius * near.radius
        # a step of the series: two divisions and two multiplications for each half order
        work = 4 * half * series_terms(square * square, "harmonics") + 8 * half
        if offset != 0.0:
            count = series_terms(square, "harmonics")
            work = 5 * (highest + count) + (highest + 1) * count
        return shown(motion_harmonics(ratio, highest, offset, derivative=2), work)

    def truncated(terms: float) -> Answer:
        found = truncated_harmonics(ratio, int(terms), highest, derivative=2)
        reached = min(int(terms), highest // 2) + 1
        return shown(found, 2.0 * reached * terms)

    def sampled(count: float) -> Answer:
        angle = 2.0 * np.pi * np.arange(int(count)) / int(count)
        path = piston_path(angle, ratio, 1.0, ratio * offset)
        found = harmonics_of_samples(path.acceleration / ratio, highest)
        return shown(found, ONE_ANGLE * count + 4.0 * transform_work(int(count)))

    ladders = [
        Ladder(
            "exact harmonics",
            "hypergeometric closed form (with an offset: a product of two root series)",
            "",
            NOTHING_TO_SET,
            exact,
            default=1.0 if cut is None else None,
            citation="cf. Biezeno and Grammel (1953), ch. XI",
        )
    ]
    if offset == 0.0:
        terms = sorted({1, 2, 4, 10, 20, 40, highest // 2 + 40} | ({cut} if cut else set()))
        ladders.append(
            Ladder(
                "truncated series",
                "binomial series of the root, cut after some terms",
                "terms",
                tuple(float(x) for x in terms),
                truncated,
                default=None if cut is None else float(cut),
                theory="geometric",
                citation="Ong (2000), equation 2.15 with 40 terms; Gibson (2008) with one",
            )
        )
    counts = sorted({8 << k for k in range(6)} | {4 * highest, 16 * highest})
    ladders.append(
        Ladder(
            "FFT of samples",
            "closed form of the acceleration at N angles, Fourier transform",
            "samples",
            tuple(float(x) for x in counts),
            sampled,
            theory="geometric, down to rounding of the largest harmonic",
        )
    )
    return Topic(
        stage="kinematics",
        name="harmonics of the acceleration",
        words=f"{len(orders)} harmonics of the piston acceleration, orders 1 to {highest}, each "
        f"over its own true magnitude, at R/L = {ratio:.4g}",
        quantity="kinematics/acceleration_harmonics",
        unit="",
        work="multiplications",
        reference=lambda: _reference(ratio, offset, orders, size),
        ladders=tuple(ladders),
        default_extra=3.0,
        default_why="the same kernel serves every R/L below 1, where the cut series does not end, "
        "and wrist pin offsets",
    )


def _reference(ratio: float, offset: float, orders: np.ndarray, size: np.ndarray) -> Reference:
    """A Fourier sum in as many digits as the smallest harmonic needs, and Gauss's series."""
    import mpmath

    lost = -math.log10(float(size.min()) / float(size.max()))
    highest = int(orders[-1])
    radius = float(pole(np.asarray(ratio), np.asarray(abs(offset))).radius)
    with mpmath.workdps(int(lost) + GUARD_DIGITS):
        lam, shift = mpmath.mpf(ratio), mpmath.mpf(offset) * mpmath.mpf(ratio)
        points = 2 * highest + math.ceil(36.0 / -math.log10(radius))
        sampled = _fourier_sum(lam, shift, orders, points)
        if offset == 0.0:
            other, words = _gauss(lam, orders), "Gauss's hypergeometric series in mpmath"
        else:
            other = _fourier_sum(lam, shift, orders, points + 37)
            words = "the same sum over another number of points"
        values = np.array([complex(x / mpmath.mpf(s)) for x, s in zip(sampled, size, strict=True)])
        apart = max(
            float(abs(x - y) / mpmath.mpf(s)) for x, y, s in zip(sampled, other, size, strict=True)
        )
        digits = mpmath.mp.dps
    return Reference(
        values, apart, f"Fourier sum of {points} samples in {digits} digits against {words}"
    )


def _fourier_sum(lam: Any, shift: Any, orders: np.ndarray, points: int) -> list[Any]:
    """-n^2 C_n from samples of the rod's projection, over the crank radius."""
    import mpmath

    waves = [mpmath.expjpi(mpmath.mpf(2 * k) / points) for k in range(points)]
    rod = [mpmath.sqrt(1 - (lam * wave.imag - shift) ** 2) / lam for wave in waves]
    found = []
    for order in orders.tolist():
        total = mpmath.mpc(
            mpmath.fdot(rod, (waves[order * k % points].real for k in range(points))),
            -mpmath.fdot(rod, (waves[order * k % points].imag for k in range(points))),
        )
        amplitude = 2 * total / points + (1 if order == 1 else 0)
        found.append(-(order**2) * amplitude)
    return found


def _gauss(lam: Any, orders: np.ndarray) -> list[Any]:
    """-n^2 C_n without an offset, as `kinematics.centred_harmonics` has them in doubles."""
    import mpmath

    kappa = lam / (1 + mpmath.sqrt(1 - lam * lam))
    half = mpmath.mpf(1) / 2
    found = []
    for order in orders.tolist():
        k = order // 2
        if order == 1:
            found.append(mpmath.mpf(-1))
            continue
        series = mpmath.hyp2f1(-half, k - half, k + 1, kappa**4)
        found.append(-(order**2) * mpmath.binomial(half, k) * kappa ** (2 * k - 1) * series)
    return found

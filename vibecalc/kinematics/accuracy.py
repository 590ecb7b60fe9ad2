"""Questions of the kinematics: every harmonic of the piston's acceleration to its own size."""

import math
from typing import Any

import numpy as np

from vibecalc.core.accuracy.kinds import TURN, harmonics
from vibecalc.core.accuracy.topic import Answer, Ask, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.kinematics.harmonics import motion_harmonics, pole, series_terms
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.kinematics.truncated_series import truncated_harmonics

MOST_ORDERS = 80
#: multiplications that stand for a sine, a cosine, a root and what joins them at one angle
ONE_ANGLE = 45.0


def kinematics_topics(scene: Scene) -> list[Topic]:
    """The harmonics of the acceleration from order 1 on, those that are not zero.

    Decibels are read, so that each is measured over its own true magnitude.
    """
    motion: PistonMotion = scene.handed_on["motion"]
    train, options = scene.parts.crank_train, scene.case.kinematics
    ratio = train.crank_radius / train.rod_length
    offset = train.wrist_pin_offset / train.crank_radius
    highest = min(max(motion.highest_order, 2), MOST_ORDERS)
    orders = np.arange(1, highest + 1)
    if offset == 0.0:
        orders = orders[(orders == 1) | (orders % 2 == 0)]
    highest = int(orders[-1])
    size = np.abs(motion_harmonics(ratio, highest, offset, derivative=2))[orders]
    cut = None
    if options is not None and options.series == "truncated":
        cut = float(options.terms or 1)

    def exact(_: float) -> Answer:
        near, half = pole(np.asarray(ratio), np.asarray(abs(offset))), highest // 2 + 1
        square = near.radius * near.radius
        # of each half order two divisions and two multiplications a term, over those at an angle
        work = 4.0 * half * series_terms(square * square, "harmonics") + 8 * half
        if offset != 0.0:
            count = series_terms(square, "harmonics")
            work = 5.0 * (highest + count) + (highest + 1) * count
        found = motion_harmonics(ratio, highest, offset, derivative=2)
        return Answer(found[orders] / size, work / ONE_ANGLE)

    def truncated(terms: float) -> Answer:
        found = truncated_harmonics(ratio, int(terms), highest, derivative=2)
        work = 2.0 * (min(int(terms), highest // 2) + 1) * terms
        return Answer(found[orders] / size, work / ONE_ANGLE)

    solvers = [Solver("exact harmonics", exact, default=1.0 if cut is None else None)]
    if offset == 0.0:
        # the source has 40 terms (Ong 2000, equation 2.15) or one (Gibson 2008)
        terms = (1, 2, 4, 10, 20, 40, highest // 2 + 40)
        solvers.append(Solver("truncated series", truncated, "terms", terms, cut, "geometric"))
    ask = Ask("harmonics of the acceleration",
              f"{len(orders)} of the piston acceleration to order {highest}, relative",
              "kinematics/acceleration_harmonics", 3.0,
              "one kernel serves every R/L below 1, where a truncated series does not end, and "
              "offsets")  # fmt: skip
    counts = sorted({*(8.0 * 2**k for k in range(6)), 16.0 * highest})
    return [harmonics(
        ask, solvers,
        lambda angle: piston_path(angle, ratio, 1.0, ratio * offset).acceleration / ratio, orders,
        np.array([0.0, TURN]), size, counts, lambda: _reference(ratio, offset, orders, size),
    )]  # fmt: skip


def _reference(ratio: float, offset: float, orders: np.ndarray, size: np.ndarray) -> Reference:
    """A Fourier sum in as many digits as the smallest harmonic needs, over two counts of points."""
    import mpmath

    lost = -math.log10(float(size.min()) / float(size.max()))
    radius = float(pole(np.asarray(ratio), np.asarray(abs(offset))).radius)
    with mpmath.workdps(int(lost) + 35):
        lam, shift = mpmath.mpf(ratio), mpmath.mpf(offset) * mpmath.mpf(ratio)
        points = 2 * int(orders[-1]) + math.ceil(36.0 / -math.log10(radius))
        one, other = (
            np.array(_fourier_sum(lam, shift, orders, points + more)) / size for more in (0, 37)
        )
        apart = float(max(abs(one - other)))
        words = f"Fourier sums of {points} and {points + 37} samples in {mpmath.mp.dps} digits"
    return Reference(one.astype(complex), apart, words)


def _fourier_sum(lam: Any, shift: Any, orders: np.ndarray, points: int) -> list[Any]:
    """-n^2 C_n from samples of the rod's projection, over the crank radius."""
    import mpmath

    waves = [mpmath.expjpi(mpmath.mpf(2 * k) / points) for k in range(points)]
    rod = [mpmath.sqrt(1 - (lam * wave.imag - shift) ** 2) / lam for wave in waves]
    found = []
    for order in orders.tolist():
        total = mpmath.fdot(rod, (mpmath.conj(waves[order * k % points]) for k in range(points)))
        found.append(-(order**2) * (2 * total / points + (1 if order == 1 else 0)))
    return found

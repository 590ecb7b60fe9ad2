"""Accuracy of the piston motion: its harmonics, its acceleration over a turn, orders left out."""

import math
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import harmonics_of_samples, transform_work
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.kinematics.harmonics import dropped_acceleration, motion_harmonics, pole, series_terms
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.kinematics.truncated_series import truncated_harmonics, truncated_motion
from vibecalc.parts.crank_train import CrankTrain

# ----------------------------------------------------------------------------
# Topic of the kinematics: the acceleration that the orders beyond the last one kept would add.
# ----------------------------------------------------------------------------

#: the topic needs a tail that doubles can show
SMALLEST_TAIL = 1e-290


def dropped_topic(ratio: float, offset: float, kept: int) -> Topic:
    """What the orders above `kept` add at most; `ratio` is R/L, `offset` e/R."""
    near = pole(np.asarray(ratio), np.asarray(abs(offset)))
    tail = series_terms(near.radius, "sum of the dropped orders", limit=10**9)

    def after(count: float) -> Answer:
        found = motion_harmonics(ratio, kept + int(count), offset, derivative=2)
        total = np.sum(np.abs(found[kept + 1 :])[::-1])
        if not total > SMALLEST_TAIL:
            raise NumericalFailure(f"the next {count:.0f} orders after {kept} are all zero")
        return Answer(np.array([total]), count)

    def default(_: float) -> Answer:
        return Answer(np.array([float(dropped_acceleration(ratio, kept, offset))]), tail)

    def measured(points: float) -> Answer:
        angle = 2.0 * np.pi * (np.arange(int(points)) + 0.5) / points
        found = motion_harmonics(ratio, kept, offset, derivative=2)
        cut = (np.exp(1j * np.multiply.outer(angle, np.arange(kept + 1))) @ found).real
        exact = piston_path(angle, ratio, 1.0, ratio * offset).acceleration / ratio
        return Answer(np.array([np.max(np.abs(exact - cut))]), points * (kept + 1))

    steps = tuple(float(x) for x in (2, 4, 8, 16, 32, 64) if x < tail)
    return Topic(
        stage="kinematics",
        name="dropped acceleration",
        words=f"most that the orders above {kept} add to the acceleration, over R w^2",
        quantity="kinematics/dropped_acceleration",
        unit="",
        work="orders",
        reference=lambda: _dropped_reference(ratio, offset, kept),
        solvers=(
            Solver(
                "dropped_acceleration",
                "sum of the tail to the order below which rounding hides the rest",
                "",
                NOTHING_TO_SET,
                default,
                default=1.0,
                citation="docs/theory.md",
            ),
            Solver(
                "the next orders",
                "magnitudes of the next N orders added",
                "orders",
                steps,
                after,
                theory="geometric",
            ),
            Solver(
                "exact minus kept",
                "largest difference of closed form and kept orders at N angles",
                "angles",
                (8.0, 32.0, 128.0, 512.0),
                measured,
            ),
        ),
        default_extra=3.0,
        default_why="its number of orders is safe for every R/L, wherever the kept orders end",
    )


def _dropped_reference(ratio: float, offset: float, kept: int) -> Reference:
    """Closed form of the whole sum less the kept orders in many digits, and the tail itself.

    The acceleration's sum of magnitudes is the second derivative of the rod's projection at the
    angle nearest to the pole, y / sqrt(1 - y^2) with y = (R + |e|)/L.
    """
    import mpmath

    small = float(dropped_acceleration(ratio, kept, offset))
    digits = 40 + int(max(-np.log10(small), 0.0))
    with mpmath.workdps(digits):
        lam, shift = mpmath.mpf(ratio), mpmath.mpf(ratio) * abs(mpmath.mpf(offset))
        radius = float(pole(np.asarray(ratio), np.asarray(abs(offset))).radius)
        points = 4 * (kept + 8 + int(digits / max(-np.log10(radius), 0.02)))
        waves = [mpmath.expjpi(mpmath.mpf(2 * k) / points) for k in range(points)]
        rod = [mpmath.sqrt(1 - (lam * wave.imag - shift) ** 2) / lam for wave in waves]
        kept_sum = mpmath.mpf(0)
        for order in range(1, kept + 1):
            part = mpmath.fdot(rod, (waves[order * k % points] for k in range(points)))
            kept_sum += order**2 * 2 * abs(part) / points
        reach = lam + shift
        total = reach / mpmath.sqrt(1 - reach * reach)
        value = float(total - kept_sum)
    agreement = abs(small / value - 1.0)
    return Reference(
        np.array([value]),
        agreement,
        f"closed form of the whole sum less {kept} orders in {digits} digits (mpmath), against "
        "the sum of the tail in doubles",
    )


# ----------------------------------------------------------------------------
# Topics of the kinematics: the acceleration over a turn, and what leaving out orders costs it.
# ----------------------------------------------------------------------------

ANGLES = 24
#: a sine, cosine or root counts as ten multiplications
LONG = 10


class _Crank(NamedTuple):
    """Crank radius, rod length and wrist pin offset, m."""

    radius: float
    length: float
    offset: float

    @property
    def ratios(self) -> tuple[float, float]:
        """R/L and e/R."""
        return self.radius / self.length, self.offset / self.radius


def kinematics_motion_topics(scene: Scene) -> list[Topic]:
    """The curve where the case has one; the dropped orders where the series is the exact one."""
    motion: PistonMotion = scene.handed_on["motion"]
    crank, options = _crank(scene.parts.crank_train), scene.case.kinematics
    found = []
    cut = None
    if options is not None:
        cut = (options.terms or 1) if options.series == "truncated" else None
        found.append(_curve(crank, cut))
    ratio, offset = crank.ratios
    if cut is None and dropped_acceleration(ratio, motion.highest_order, offset) > SMALLEST_TAIL:
        found.append(dropped_topic(*crank.ratios, motion.highest_order))
    return found


def _crank(train: CrankTrain) -> _Crank:
    return _Crank(train.crank_radius, train.rod_length, train.wrist_pin_offset)


def _curve(crank: _Crank, cut: int | None) -> Topic:
    angle = 2.0 * np.pi * (np.arange(ANGLES) + 0.37) / ANGLES
    radius, length, offset = crank.radius, crank.length, crank.offset
    ratio, shift = crank.ratios

    def closed(_: float) -> Answer:
        path = piston_path(angle, radius, length, offset)
        return Answer(path.acceleration, ANGLES * (3 * LONG + 15))

    def summed(highest: float) -> Answer:
        count = int(highest)
        harmonics = radius * motion_harmonics(ratio, count, shift, derivative=2)
        used = np.flatnonzero(harmonics)
        waves = np.exp(1j * np.multiply.outer(angle, used))
        return Answer((waves @ harmonics[used]).real, ANGLES * len(used) * (2.0 * LONG + 2))

    def series(terms: float) -> Answer:
        found = truncated_motion(angle, radius, length, int(terms))
        return Answer(found.acceleration, ANGLES * (2.0 * LONG + 6 * terms + 12))

    def differences(step: float) -> Answer:
        ahead, here, behind = (
            piston_path(angle + k * step, radius, length, offset).position for k in (1, 0, -1)
        )
        values = (ahead - 2.0 * here + behind) / (step * step)
        return Answer(values, ANGLES * (3 * (3 * LONG + 4) + 4))

    orders = sorted({1, 2, 4, 6, 8, 12, 16, 24})
    solvers = [
        Solver(
            "closed form",
            "derivatives of the exact motion at each angle",
            "",
            NOTHING_TO_SET,
            closed,
            default=1.0 if cut is None else None,
            citation="docs/theory.md",
        ),
        Solver(
            "exact harmonics summed",
            "orders 1 to N of the exact motion",
            "orders",
            tuple(float(x) for x in orders),
            summed,
            theory="geometric",
        ),
        Solver(
            "differences",
            "central differences of the exact position",
            "step [rad]",
            (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4, 1e-6),
            differences,
            theory="order 2",
        ),
    ]
    if offset == 0.0:
        terms = sorted({1, 2, 4, 8, 16, 40} | ({cut} if cut else set()))
        solvers.append(
            Solver(
                "truncated series",
                "binomial series of the root, cut after some terms",
                "terms",
                tuple(float(x) for x in terms),
                series,
                default=None if cut is None else float(cut),
                theory="geometric",
                citation="Gibson (2008), equation 5; Ong (2000), equation 2.15",
            )
        )
    return Topic(
        stage="kinematics",
        name="acceleration over a turn",
        words=f"piston acceleration over crank speed squared at {ANGLES} angles"
        + ("" if cut is None else "; the case asks for the cut series of its source"),
        quantity="kinematics/acceleration",
        unit="m",
        work="multiplications (a sine or root as ten)",
        reference=lambda: _curve_reference(crank, angle),
        solvers=tuple(solvers),
        default_extra=1.0 if cut is None or cut < 3 else 1.0 + 0.15 * cut,
        default_why="" if cut is None or cut < 3 else "the case asks for the cut series",
    )


def _curve_reference(crank: _Crank, angle: np.ndarray) -> Reference:
    import mpmath

    with mpmath.workdps(60):
        radius, length, offset = (mpmath.mpf(x) for x in (crank.radius, crank.length, crank.offset))

        def position(t: Any) -> Any:
            across = radius * mpmath.sin(t) - offset
            return radius * mpmath.cos(t) + mpmath.sqrt(length**2 - across**2)

        def acceleration(t: Any) -> Any:
            sine, cosine = mpmath.sin(t), mpmath.cos(t)
            across, lever = radius * sine - offset, radius * cosine
            rod = mpmath.sqrt(length**2 - across**2)
            return -lever + across * radius * sine / rod - (lever * length) ** 2 / rod**3

        values = [acceleration(mpmath.mpf(float(t))) for t in angle]
        step = mpmath.mpf(10) ** -15
        apart = mpmath.mpf(0)
        for t, value in zip(angle.tolist(), values, strict=True):
            at = mpmath.mpf(t)
            slope = (position(at + step) - 2 * position(at) + position(at - step)) / step**2
            apart = max(apart, abs(slope - value))
        largest = max(abs(value) for value in values)
        agreement = float(apart / largest)
    return Reference(
        np.array([float(value) for value in values]),
        agreement,
        "closed form in 60 digits (mpmath) against second differences of the position there",
    )


# ----------------------------------------------------------------------------
# Topics of the kinematics: every harmonic of the piston acceleration to its own size.
#
# An engineer reads harmonics in decibels, so each is measured against its own magnitude: the values
# are the harmonics over the true magnitudes, all of size 1.
# ----------------------------------------------------------------------------

MOST_ORDERS = 80
#: multiplications that stand for a sine, a cosine, a root and what joins them at one angle
ONE_ANGLE = 45
#: digits beyond those that the smallest harmonic lies below the first
GUARD_DIGITS = 35


def kinematics_harmonics_topics(scene: Scene) -> list[Topic]:
    """The harmonics of the acceleration from order 1 on, those that are not zero."""
    motion: PistonMotion = scene.handed_on["motion"]
    train, options = scene.parts.crank_train, scene.case.kinematics
    ratio = train.crank_radius / train.rod_length
    offset = train.wrist_pin_offset / train.crank_radius
    highest = min(max(motion.highest_order, 2), MOST_ORDERS)
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

    solvers = [
        Solver(
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
        solvers.append(
            Solver(
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
    solvers.append(
        Solver(
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
        solvers=tuple(solvers),
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

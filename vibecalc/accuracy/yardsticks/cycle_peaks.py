"""The peak of a periodic signal over its cycle: a topic that several stages have."""

from collections.abc import Callable
from typing import Any

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.cycle_signals import (
    Signal,
    equal_maxima,
    lengths,
    newton_maximum,
    turned,
)
from vibecalc.accuracy.yardsticks.grids import cyclic_parabola_maximum
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.cycle_peak import SAMPLES_PER_ORDER, kept_orders, vector_cycle_peak

__all__ = ["Signal", "peak_topic"]

#: of a step, how far beside a point of a grid the summit lies: on average a grid that knows
#: nothing misses it by so much, while one from dead centre on may meet it by luck
MISSED = 0.25
#: with more equal maxima the signal is as good as constant, and has no place
MOST_EQUALS = 8
#: so is one whose length changes by less than this share
FLAT = 1e-9
#: what `cycle_peak` evaluates beside its samples: Taylor polynomials of about two cells
TAYLOR = 30
PROOF = "no maximum can be missed: every order above rounding is sampled twelvefold, however small"
#: what a reader of the ladders has to know
LAID = "laid a quarter of a step beside the known summit, as far off as on average"


def peak_topic(
    stage: str, name: str, words: str, quantity: str, unit: str, signal: Signal
) -> Topic:
    """A topic on the largest length of `signal` over the cycle, with its crank angle.

    Work is counted in evaluations of the sum at one crank angle. Of several equal maxima the
    nearest counts as the place; a signal that is the same all around has none.
    """
    used = np.any(signal.harmonics != 0.0, axis=0) & (signal.orders > 0)
    signal = Signal(signal.harmonics[:, used], signal.orders[used])
    known = vector_cycle_peak(signal.harmonics, signal.orders)
    value, first = float(known.value), float(known.angle)
    equals = equal_maxima(signal, first, value)
    around = lengths(signal, _angles(first, 64))
    placed = len(equals) <= MOST_EQUALS and bool(around.min() < value * (1.0 - FLAT))
    highest = int(signal.orders.max()) // max(int(np.gcd.reduce(signal.orders)), 1)
    step = max(int(np.gcd.reduce(signal.orders)), 1)
    kept = int(kept_orders(signal.harmonics[None], signal.orders // step)[0][0])
    own_work = SAMPLES_PER_ORDER * kept + TAYLOR if highest > 1 else 1

    def answer(height: float, angle: float, work: float) -> Answer:
        nearest = min(equals, key=lambda place: abs(turned(angle - place)))
        position = equals[0] + turned(angle - nearest) if placed else None
        return Answer(np.array([height]), work, position)

    def proven(_: float) -> Answer:
        peak = vector_cycle_peak(signal.harmonics, signal.orders)
        return answer(float(peak.value), float(peak.angle), own_work)

    def grid(points: float) -> Answer:
        angle = _angles(first, int(points))
        height = lengths(signal, angle)
        best = int(np.argmax(height))
        return answer(float(height[best]), float(angle[best]), points)

    def parabola(points: float) -> Answer:
        begin = float(_angles(first, int(points))[0])
        best = cyclic_parabola_maximum(
            lambda angle: lengths(signal, begin + angle), 2.0 * np.pi, int(points)
        )
        return answer(best.value, begin + best.position, points)

    def newton(points: float) -> Answer:
        angle = _angles(first, int(points))
        place = float(angle[int(np.argmax(lengths(signal, angle)))])
        height, place, work = newton_maximum(signal, place)
        return answer(height, place, points + work)

    def bounded(points: float) -> Answer:
        return _bounded(signal, _angles(first, int(points)), answer)

    coarse = tuple(float(8 << k) for k in range(0, 12, 2))
    ladders = (
        Ladder(
            "cycle_peak",
            "samples that cannot miss, Taylor polynomials, Newton in concave cells",
            "",
            NOTHING_TO_SET,
            proven,
            default=1.0,
            citation="M. Riesz (1914); Ehlich and Zeller (1964)",
        ),
        Ladder(
            "grid", f"highest of N crank angles, {LAID}", "angles", coarse, grid, theory="order 2"
        ),
        Ladder(
            "grid with parabola",
            f"parabola through the best of N angles and its neighbours, {LAID}",
            "angles",
            coarse,
            parabola,
        ),
        Ladder(
            "Newton from a grid",
            "Newton's method for the slope from the best of N angles",
            "angles",
            tuple(float(8 << k) for k in range(6)),
            newton,
            theory="exact once the start lies on the highest summit",
        ),
        Ladder(
            "scipy minimize_scalar",
            "bounded Brent search around the best of N angles",
            "angles",
            tuple(float(8 << k) for k in range(6)),
            bounded,
        ),
    )
    least = float(ladders[3].settings[0] + 7.0)
    extra = max(1.0, float(np.ceil(own_work / least)))
    return Topic(
        stage=stage,
        name=name,
        words=words,
        quantity=quantity,
        unit=unit,
        work="evaluations of the sum at one angle",
        reference=lambda: _exact(signal, first, value, placed),
        ladders=ladders,
        position="crank angle [rad]" if placed else "",
        default_extra=extra,
        default_why=PROOF if extra > 1.0 else "",
    )


def _angles(summit: float, points: int) -> np.ndarray:
    """A grid over one turn that misses the summit as a grid does on average."""
    step = 2.0 * np.pi / points
    return np.asarray(summit + step * (MISSED + np.arange(points)))


def _bounded(
    signal: Signal, angle: np.ndarray, answer: Callable[[float, float, float], Answer]
) -> Answer:
    from scipy.optimize import minimize_scalar

    step = 2.0 * np.pi / len(angle)
    best = float(angle[int(np.argmax(lengths(signal, angle)))])
    found = minimize_scalar(
        lambda place: -float(lengths(signal, np.array([place]))[0]),
        bounds=(best - step, best + step),
        method="bounded",
        options={"xatol": 1e-10},
    )
    if not found.success:
        raise NumericalFailure(f"minimize_scalar gave up: {found.message}")
    return answer(-float(found.fun), float(found.x), len(angle) + float(found.nfev))


def _exact(signal: Signal, first: float, value: float, placed: bool) -> Reference:
    """The highest summit in 40 digits, held against a dense grid and the value in doubles."""
    import mpmath

    with mpmath.workdps(40):
        rows = [[mpmath.mpc(complex(x)) for x in row] for row in signal.harmonics]
        orders = [int(n) for n in signal.orders]

        def jet(angle: Any) -> tuple[Any, ...]:
            waves = [mpmath.expj(n * angle) for n in orders]
            square = slope = bend = mpmath.mpf(0)
            for row in rows:
                parts = [x * wave for x, wave in zip(row, waves, strict=True)]
                x = mpmath.fsum(part.real for part in parts)
                v = mpmath.fsum(-n * part.imag for n, part in zip(orders, parts, strict=True))
                a = mpmath.fsum(-n * n * part.real for n, part in zip(orders, parts, strict=True))
                square, slope, bend = square + x * x, slope + x * v, bend + v * v + x * a
            return mpmath.sqrt(square), slope, bend

        angle = mpmath.mpf(first)
        for _ in range(6 if placed else 0):
            _, slope, bend = jet(angle)
            if not bend < 0:
                break
            angle -= slope / bend
        height = float(jet(angle)[0])
        place = float(angle)
    points = 96 * int(signal.orders.max())
    dense = float(lengths(signal, 2.0 * np.pi * np.arange(points) / points).max())
    over = max(dense / height - 1.0, 0.0)
    agreement = max(abs(value / height - 1.0), over)
    return Reference(
        np.array([height]),
        agreement,
        f"summit in 40 digits (mpmath); none of {points} angles is higher, cycle_peak agrees to "
        f"{agreement:.1e}",
        place if placed else None,
    )

"""All motions that levels of one harmonic allow, exactly or as local minima of least squares."""

from collections.abc import Iterator
from itertools import combinations, islice
from math import comb
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.cone_ends import ends
from vibecalc.measurement.level_fit import Fit, refine
from vibecalc.measurement.quadratic import Line, least_determined, quadratic_rank
from vibecalc.measurement.rigid_plate import scaled, span_of
from vibecalc.measurement.spread import Spread, level_spread
from vibecalc.numerics.typing import ComplexArray, FloatArray

#: independent levels that leave no more than two motions
NEEDED = 5
#: sets of five levels, of more, from whose motions the search starts
_MOST_STARTS = 24
#: second moments nearer than this, relative to the largest, are one motion
_SAME = 1e-6
#: dB; a larger residual of five levels says that no motion has them
_MISSED = 1e-7


class LevelMotion(NamedTuple):
    """One motion, in SI: complex (3,), zero-phase at the reference row, roll with a phase >= 0.

    `residual` (r,) in dB is computed less read; `misfit` the least factor by which the half
    widths of the readings would have to grow for such a motion to lie within all of them (to first
    order; 0 where the levels are met exactly); `clipped` marks five levels that no motion has.
    """

    motion: ComplexArray
    residual: FloatArray
    cost: float
    misfit: float
    clipped: bool
    spread: Spread


def level_motions(
    rows: FloatArray,
    amplitudes: FloatArray,
    half_widths: FloatArray,
    reference: FloatArray,
    deviations: FloatArray,
) -> list[LevelMotion]:
    """Motions whose amplitudes at `rows` (r, 3) are `amplitudes` (r,) > 0, the best first.

    `half_widths` (r,) in dB are how far a reading may be off, `deviations` its standard
    uncertainty; `reference` (3,) is the row whose phase is zero. Levels leave a common phase and
    the sign of all phases open: one of each pair is given.

    Raises
    ------
    NumericalFailure : fewer than five independent levels; or just five (or as many as are
        independent) that contradict each other by more than their half widths, said in dB.
    """
    span = span_of(rows)
    plain, size = scaled(rows, span), float(np.max(amplitudes))
    rank = quadratic_rank(plain)
    if rank < NEEDED:
        raise NumericalFailure(
            f"the levels determine {rank} of the {NEEDED} numbers of the motion: "
            "more points or differences have to be read"
        )
    heights = amplitudes / size
    fits: list[Fit] = []
    for start in (motion for line in lines(plain, heights) for motion in ends(line)):
        try:
            fit = refine(plain, heights, half_widths, start)
        except NumericalFailure:
            continue
        if not any(_same(fit.motion, other.motion) for other in fits):
            fits.append(fit)
    if not fits:
        raise NumericalFailure("the motion of the plate: least squares in dB did not converge")
    found = [
        _motion(fit, plain, half_widths, scaled(reference, span), deviations, size, span)
        for fit in sorted(fits, key=lambda fit: fit.cost)
    ]
    exact = [motion for motion in found if not motion.clipped]
    if len(rows) == NEEDED:
        found = exact or found[:1]
        _refuse_contradiction(found[0], half_widths)
    return found


def lines(rows: FloatArray, amplitudes: FloatArray) -> Iterator[Line]:
    """The line that all levels leave, then those that five of them leave; rows (r, 3) scaled."""
    yield least_determined(rows, amplitudes)
    count = len(rows)
    if count == NEEDED:
        return
    stride = max(1, comb(count, NEEDED) // _MOST_STARTS)
    for chosen in islice(combinations(range(count), NEEDED), 0, None, stride):
        some = list(chosen)
        if quadratic_rank(rows[some]) == NEEDED:
            yield least_determined(rows[some], amplitudes[some])


def _motion(
    fit: Fit,
    rows: FloatArray,
    half_widths: FloatArray,
    reference: FloatArray,
    deviations: FloatArray,
    size: float,
    span: float,
) -> LevelMotion:
    spread = level_spread(fit, reference, half_widths, deviations)
    motion, flipped = _phased(fit.motion, reference)
    units = size / np.array([1.0, span, span])
    clipped = bool(np.max(np.abs(fit.residual)) > _MISSED) and len(rows) == NEEDED
    weighed = np.abs(fit.residual) / half_widths
    total = float(np.sum(weighed))
    misfit = fit.cost / total if total > 0.0 else 0.0
    turned = spread.turned(np.conj(_turn(fit.motion, reference)), flipped)
    return LevelMotion(
        motion * units, fit.residual, fit.cost, misfit, clipped, turned.in_units(units)
    )


def _turn(motion: ComplexArray, reference: FloatArray) -> complex:
    signal = complex(reference @ motion)
    if abs(signal) == 0.0:
        raise NumericalFailure(
            "the reading that phases refer to is zero: name another reference position"
        )
    return signal / abs(signal)


def _phased(motion: ComplexArray, reference: FloatArray) -> tuple[ComplexArray, bool]:
    """The motion with phase zero at the reference and a roll that leads it; whether conjugated."""
    turned = motion * np.conj(_turn(motion, reference))
    sides = turned.imag[[1, 2, 0]]
    meant = np.flatnonzero(np.abs(sides) > 1e-12 * np.max(np.abs(turned)))
    flipped = bool(meant.size and sides[meant[0]] < 0.0)
    return (np.conj(turned) if flipped else turned), flipped


def _same(one: ComplexArray, other: ComplexArray) -> bool:
    moments = [np.real(np.multiply.outer(u, np.conj(u))) for u in (one, other)]
    apart = float(np.max(np.abs(moments[0] - moments[1])))
    return apart <= _SAME * float(np.max(np.abs(moments[0])))


def _refuse_contradiction(best: LevelMotion, half_widths: FloatArray) -> None:
    if best.clipped and best.misfit > 1.0:
        least = best.misfit * float(np.max(half_widths))
        raise NumericalFailure(
            "the levels contradict each other: no rigid plate moves so, unless a reading is off "
            f"by {least:.2g} dB or more, and {float(np.max(half_widths)):.2g} dB is granted"
        )

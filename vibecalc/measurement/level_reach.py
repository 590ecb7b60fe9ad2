"""How far the amplitudes of a motion may be off while its levels are off by their rounding.

Five levels leave a line of second moments, and a motion where it leaves the semidefinite ones. The
place of that end is a concave or convex function of the squared amplitudes read, so that the
largest change of any squared amplitude is at a corner of the rounding, or bounded by the tangent.
If the line of some corner misses the semidefinite matrices, signals come into line within the
rounding (the fold): both motions are then one family, and no slope tells how large it is. Its size
is that of `level_family`, and so it is for more than five levels.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.measurement.cone_ends import ends
from vibecalc.measurement.level import DECIBEL
from vibecalc.measurement.level_family import extremes
from vibecalc.measurement.level_motions import NEEDED, LevelMotion
from vibecalc.measurement.quadratic import least_determined
from vibecalc.measurement.rigid_plate import scaled, span_of
from vibecalc.measurement.spread import level_gradient
from vibecalc.numerics.typing import ComplexArray, FloatArray

#: dB; a bound of one motion of five levels beyond this is compared with that of its family
_WIDE = 0.5
#: a bound of so many times that of first order says that first order does not hold
_HOLDS = 3.0


class Reach(NamedTuple):
    """What bounds the motions of one set of levels: rows (r, 3), amplitudes and half widths (r,).

    `folded` says that signals come into line within the half widths. Otherwise `corners` holds,
    for five levels, the motions (2, 32, 3) of the two ends with all readings at the ends of theirs.
    """

    rows: FloatArray
    amplitudes: FloatArray
    half_widths: FloatArray
    folded: bool
    corners: ComplexArray

    def bound(self, motion: LevelMotion, targets: FloatArray) -> FloatArray:
        """Largest error (m,) in dB of the levels of a motion at rows (m, 3).

        Infinite where the amplitude may be zero. Where more than five levels contradict each other
        beyond their half widths nothing bounds anything: then it is that of first order.
        """
        if self.folded or len(self.rows) > NEEDED:
            family = self._family(motion, targets)
            return self._tangent(motion, targets)[0] if family is None else family
        bound = np.maximum(self._tangent(motion, targets)[1], self._corner(motion, targets))
        wide = bound > _WIDE
        if np.any(wide):
            family = self._family(motion, targets[wide])
            if family is not None:
                bound[wide] = np.minimum(bound[wide], family)
        return bound

    def deviation(self, motion: LevelMotion, targets: FloatArray) -> FloatArray:
        """Standard uncertainty (m,) in dB of the levels of a motion at rows (m, 3).

        That of first order; where this does not hold, the bound over the root of three, as for an
        error of which nothing but its limits is known (JCGM 100:2008, 4.3.7).
        """
        gradient = level_gradient(targets, motion.motion)
        bound, first = self.bound(motion, targets), motion.spread.bound(gradient)
        holds = (not self.folded) & (bound <= _HOLDS * first)
        return np.where(holds, motion.spread.deviation(gradient), bound / 3.0**0.5)

    def _family(self, motion: LevelMotion, targets: FloatArray) -> FloatArray | None:
        span = span_of(self.rows)
        found = extremes(
            scaled(self.rows, span), self.amplitudes, self.half_widths, scaled(targets, span)
        )
        if found is None:
            return None
        size = np.abs(targets @ motion.motion)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.maximum(np.log(found.high / size), np.log(size / found.low)) * DECIBEL
        return np.where(np.isfinite(off), np.maximum(off, 0.0), np.inf)

    def _tangent(self, motion: LevelMotion, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Bounds (m,) of first order in dB, and of the tangent in squared amplitudes."""
        first = motion.spread.bound(level_gradient(targets, motion.motion))
        slopes = motion.spread.slopes
        if not np.isfinite(slopes).all():
            return first, first
        share = level_gradient(targets, motion.motion) @ slopes
        grown, shrunk = (np.expm1(side * self.half_widths * 2.0 / DECIBEL) for side in (1, -1))
        above = 1.0 + np.sum(np.maximum(share * grown, share * shrunk), axis=-1)
        below = 1.0 + np.sum(np.minimum(share * grown, share * shrunk), axis=-1)
        up = 0.5 * DECIBEL * np.log(above)
        down = np.full_like(up, np.inf)
        np.log(below, out=down, where=below > 0.0)
        down = np.where(below > 0.0, -0.5 * DECIBEL * down, np.inf)
        return first, np.maximum(up, down)

    def _corner(self, motion: LevelMotion, targets: FloatArray) -> FloatArray:
        """Largest change (m,) in dB over the corners, of the end that the motion is."""
        branch = min(self.corners, key=lambda one: _apart(motion.motion, one[0]))
        size, moved = np.abs(targets @ motion.motion), np.abs(branch[1:] @ targets.T)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = DECIBEL * np.abs(np.log(moved / size))
        return np.asarray(np.max(np.where(np.isfinite(off), off, 0.0), axis=0))


def reach(rows: FloatArray, amplitudes: FloatArray, half_widths: FloatArray) -> Reach:
    """What bounds the motions that levels allow: rows (r, 3), amplitudes > 0, half widths in dB."""
    none = np.zeros((0, 0, 3), dtype=complex)
    plain = Reach(rows, amplitudes, half_widths, False, none)
    if len(rows) > NEEDED:
        return plain
    span = span_of(rows)
    size = float(np.max(amplitudes))
    found = []
    # the readings themselves come first
    for signs in ((0.0,) * NEEDED, *product((1.0, -1.0), repeat=NEEDED)):
        moved = amplitudes * np.exp(np.array(signs) * half_widths / DECIBEL) / size
        both = ends(least_determined(scaled(rows, span), moved))
        if len(both) < 2:
            return plain._replace(folded=True)
        found.append(np.stack(both) * size / np.array([1.0, span, span]))
    return plain._replace(corners=np.stack(found, axis=1))


def _apart(one: ComplexArray, other: ComplexArray) -> float:
    moments = [np.real(np.multiply.outer(u, np.conj(u))) for u in (one, other)]
    scale = np.sqrt(np.outer(*(2 * [np.abs(one) ** 2 + np.abs(other) ** 2])))
    return float(np.max(np.abs(moments[0] - moments[1]) / np.maximum(scale, 1e-300)))

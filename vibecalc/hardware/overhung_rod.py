"""Bending and whirling frequencies of an overhung rod with a body on its end, without elements.

Euler and Bernoulli's beam, by the determinant of `overhung_determinant`; its roots are bracketed
around those of beam elements.

A rod that *oscillates* about its axis, as that of a rig for torsional vibration, has no mean spin:
its gyroscopic moments are products of two small motions, and the frequencies are those at W = 0.
The spin is a parameter for shafts that turn.

Left out: shear and the rotary inertia of the rod itself, which lower the frequency of mode n by
some (n pi r / L)^2, r the radius of gyration; flexible supports; axial forces.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.hardware.overhung_determinant import determinant
from vibecalc.hardware.overhung_elements import element_frequencies
from vibecalc.hardware.overhung_parts import EndBody, OverhungRod
from vibecalc.hardware.overhung_roots import closed_in
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray

_MOST_MODES = 6
#: first half width of a bracket over its start, and by how much it grows
_FIRST_WIDTH, _GROWTH = 1e-4, 4.0

#: overhang over span below which the elements that start the search are made this long
_SHORT = 1e-3


class Whirl(NamedTuple):
    """Angular frequencies (..., modes) in rad/s, ascending: whirl with and against the spin."""

    forward: WithError
    backward: WithError


def bending_frequencies(rod: OverhungRod, body: EndBody, modes: int = 2) -> WithError:
    """Natural frequencies (..., modes) in rad/s of the rod that does not spin. Broadcasts.

    Raises NumericalFailure as `whirl_frequencies`.
    """
    return whirl_frequencies(rod, body, 0.0, modes).forward


def whirl_frequencies(rod: OverhungRod, body: EndBody, spin: ArrayLike, modes: int = 2) -> Whirl:
    """Frequencies of the first modes with the body spinning at `spin` (rad/s, >= 0). Broadcasts.

    Raises NumericalFailure for more than six modes, or where a root cannot be told from its
    neighbour.
    """
    if modes > _MOST_MODES:
        raise NumericalFailure(f"{modes} modes of a rod asked for; {_MOST_MODES} are computed")
    turning = np.asarray(spin, dtype=float)
    span = np.asarray(rod.span, dtype=float)
    longer = rod._replace(overhang=np.maximum(np.asarray(rod.overhang), _SHORT * span))
    # elements that follow one mode more than asked for, whose gap tells how far to look
    starts = element_frequencies(longer, body, turning, *start_elements(modes))
    forward, backward = (start[..., : modes + 1] for start in starts)
    with_spin = _roots(rod, body, turning, forward)
    if not np.any(turning * np.asarray(body.polar_inertia)):
        return Whirl(with_spin, with_spin)
    return Whirl(with_spin, _roots(rod, body, -turning, backward))


def start_elements(modes: int) -> tuple[int, int]:
    """Elements on span and overhang that place so many modes, and one more."""
    return 2 * modes, modes


def _roots(rod: OverhungRod, body: EndBody, spin: FloatArray, starts: FloatArray) -> WithError:
    """Roots w > 0 of the determinant next to `starts` (..., modes + 1), without the last."""
    start = starts[..., :-1]
    gap = np.diff(starts, axis=-1)
    below = np.concatenate([start[..., :1], gap[..., :-1]], axis=-1)
    reach = 0.5 * np.minimum(below, gap)
    width = np.minimum(_FIRST_WIDTH * start, reach)
    for _ in range(60):
        low, high = start - width, start + width
        at_low, at_high = (
            determinant(rod, body, spin, low)[0],
            determinant(rod, body, spin, high)[0],
        )
        apart = at_low * at_high <= 0.0
        if np.all(apart | (width >= reach)):
            break
        width = np.where(apart, width, np.minimum(_GROWTH * width, reach))
    if not np.all(apart):
        raise NumericalFailure("two bending frequencies of the rod lie too close to be told apart")

    def value(frequency: FloatArray) -> FloatArray:
        return determinant(rod, body, spin, frequency)[0]

    root, _ = closed_in(value, low, high, at_low, at_high)
    step = np.minimum(1e-5 * root, np.minimum(root - low, high - root) + 1e-9 * root)
    after, noise = determinant(rod, body, spin, root + step)
    before = determinant(rod, body, spin, root - step)[0]
    slope = np.abs(after - before) / (2.0 * step)
    return WithError(root, noise / slope + 4.0 * UNIT_ROUNDOFF * root)

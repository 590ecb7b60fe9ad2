"""A mass that dry friction drags along, Lanchester's damper: first harmonic of all it does.

What carries it moves as theta = Y sin(w t). A mass J2 next to it, on which friction of the
size F acts, is dragged along. With t = F / (J2 w^2 Y) it

- slips all the time up to t = 1 / sqrt(1 + pi^2 / 4): its speed rises and falls in straight lines;
- slips for a part of each half turn, and sticks for the other, up to t = 1;
- sticks for good beyond.

The first harmonic of the friction acts on the carrier as an inertia `inertia` J2 and as a damper
`damping` J2 w (`FrictionShares`). Where it always slips these are 2 t^2 and
(4 / pi) t sqrt(1 - (pi t / 2)^2), whose work in a cycle, 4 F Y sqrt(1 - (pi t / 2)^2), is largest
for t = sqrt(2) / pi: (4 / pi) J2 w^2 Y^2. Source: J. P. Den Hartog, Mechanical Vibrations (1956);
where it sticks, the integrals of docs/theory_absorber.md.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import FloatArray

#: friction over inertia times acceleration up to which the mass slips all the time, and that of the
#: largest work in a cycle
ALWAYS_SLIPS, MOST_WORK = 1.0 / np.sqrt(1.0 + np.pi**2 / 4.0), np.sqrt(2.0) / np.pi
#: steps to the end of a slip, and to a response
_SLIP_STEPS, _STEPS = 16, 44
#: t at which a response is looked up, from nearly free to sticking
_SHARES = np.concatenate([np.geomspace(1e-9, 0.02, 40), np.linspace(0.02, 1.0, 120)[1:]])


class FrictionShares(NamedTuple):
    """What the mass is to its carrier (...): inertia over its own, damping over J2 w."""

    inertia: FloatArray
    damping: FloatArray


def shares(friction: ArrayLike) -> FrictionShares:
    """First harmonic of friction (...) over inertia times acceleration, t = F / (J2 w^2 Y)."""
    t = np.asarray(friction, dtype=float)
    slow = np.minimum(0.5 * np.pi * t, 1.0)
    inertia, damping = 2.0 * t * t, 4.0 / np.pi * t * np.sqrt(1.0 - slow * slow)
    inertia, damping = np.where(t < 1.0, inertia, 1.0), np.where(t < 1.0, damping, 0.0)
    some = (t > ALWAYS_SLIPS) & (t < 1.0)
    if not np.any(some):
        return FrictionShares(inertia, damping)
    # it slips from the angle `a` of the motion, where the carrier slows down faster than friction
    # can make it, to `b`, where both have one speed: root of a concave function, from beyond it
    t = t[some]
    a = np.arcsin(t)
    b = a + np.pi
    for _ in range(_SLIP_STEPS):
        slope = np.minimum(np.sin(b) - t, -1e-300)
        b = b - (np.cos(a) - t * (b - a) - np.cos(b)) / slope
    stuck = (a + np.pi - b) - 0.5 * (np.sin(2.0 * a) - np.sin(2.0 * b))
    inertia[some] = (stuck + 2.0 * t * (np.cos(a) - np.cos(b))) / np.pi
    work = np.sin(b) ** 2 - np.sin(a) ** 2 + 2.0 * t * (np.sin(a) - np.sin(b))
    damping[some] = work / np.pi
    return FrictionShares(inertia, damping)


def settled(
    stiffness: Callable[[FloatArray], FloatArray], friction: ArrayLike, moved: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Amplitudes (n,) of the carrier and t (n,), 1 where the mass sticks.

    `stiffness` gives for t (n,) or (k, 1) the force that an amplitude of 1 takes, with a force of 1
    acting; `friction` (n,) is in units of that force, `moved` (n,) J2 w^2 in those of stiffness.
    Of several motions the largest is given; infinite where friction takes too little.
    """
    f = np.broadcast_to(np.asarray(friction, dtype=float), moved.shape)
    with np.errstate(divide="ignore"):
        stuck = 1.0 / stiffness(np.ones_like(moved))
    # force at each t over what acts, less 1
    enough = stiffness(_SHARES[:, None]).T * f[:, None] <= moved[:, None] * _SHARES
    place = np.argmax(enough, axis=1)
    high, low = _SHARES[place], _SHARES[np.maximum(place - 1, 0)]
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        less = stiffness(middle) * f <= moved * middle
        low, high = np.where(less, low, middle), np.where(less, middle, high)
    sticks = (f >= moved * stuck) & ~np.any(enough[:, :-1], axis=1)
    slips = np.where(place > 0, f / np.where(moved > 0.0, moved, 1.0) / high, np.inf)
    return np.asarray(np.where(sticks, stuck, slips)), np.asarray(np.where(sticks, 1.0, high))

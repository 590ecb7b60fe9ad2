"""The torque at which a pendulum jumps: where its steady motion folds back.

On a circle a pendulum falls below its order as it swings further. The torque that it balances
rises with the swing to a greatest value and falls again: beyond that torque the motion that grew
out of rest is gone, and the pendulum jumps to one in step with the torque, which makes the rotor
move more than it would without it.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.pendulum.model import Pendulum
from vibecalc.response.pendulum.order import largest_swing
from vibecalc.response.pendulum.steady import steady_motion

#: first sines tried, as shares of the largest swing of the path
_SCAN = np.linspace(0.0, 0.9, 37)[1:]
_BLOCK = 4

#: points of the polynomial through the torque around its greatest value
_POINTS = 13


class Jump(NamedTuple):
    """Torque over the square of the mean speed (kg m^2); largest angle of swing over the cycle and
    first sine of the swing (rad), which differ by the other sines.
    """

    torque: WithError
    swing: WithError
    first_sine: WithError


def jump(pendulum: Pendulum, rotor_inertia: float, order: float) -> Jump:
    """Greatest torque of an order that the motion out of rest can carry; one pendulum at a time.

    Raises NumericalFailure where the torque grows as far as steady motions are found.
    """
    end = float(largest_swing(pendulum))
    swings, torques = _rise(pendulum, rotor_inertia, order, end)
    top = int(np.argmax(torques))
    if top in (0, len(torques) - 1):
        raise NumericalFailure(
            f"no jump: the torque grows with the swing as far as steady motions are found "
            f"(first sine {swings[-1]:.4g} rad of {end:.4g})"
        )
    low, high = swings[top - 1], swings[top + 1]
    node = np.cos(np.pi * (np.arange(_POINTS) + 0.5) / _POINTS)
    found = steady_motion(
        pendulum, rotor_inertia, order, 0.5 * (low + high) + 0.5 * (high - low) * node
    )
    fits = [
        np.polynomial.Chebyshev.fit(
            node[:: 1 + skip], np.abs(found.torque.value[:: 1 + skip]), degree
        )
        for skip, degree in ((0, _POINTS - 1), (1, _POINTS // 2))
    ]
    good, rough = (_greatest(fit) for fit in fits)
    noise = float(np.max(found.torque.error))
    half = 0.5 * (high - low)
    bend = abs(float(fits[0].deriv(2)(good[0])))
    doubt = abs(good[0] - rough[0]) + np.sqrt(2.0 * noise / bend)
    reach = np.polynomial.Chebyshev.fit(node, found.largest.value, _POINTS - 1)
    off = abs(float(reach.deriv()(good[0]))) * doubt + 2.0 * float(np.max(found.largest.error))
    return Jump(
        WithError(np.asarray(good[1]), np.asarray(abs(good[1] - rough[1]) + 2.0 * noise)),
        WithError(np.asarray(reach(good[0])), np.asarray(off)),
        WithError(np.asarray(0.5 * (low + high) + half * good[0]), np.asarray(half * doubt)),
    )


def _rise(
    pendulum: Pendulum, rotor_inertia: float, order: float, end: float
) -> tuple[FloatArray, FloatArray]:
    """Swings and torques until the torque falls, or until no motion is found."""
    swings, torques = np.zeros(1), np.zeros(1)
    for start in range(0, len(_SCAN), _BLOCK):
        block = end * _SCAN[start : start + _BLOCK]
        try:
            torque = steady_motion(pendulum, rotor_inertia, order, block, 16).torque.value
        except NumericalFailure:
            break
        swings = np.concatenate([swings, block])
        torques = np.concatenate([torques, np.abs(torque)])
        if np.any(np.diff(torques) < 0.0):
            last = int(np.argmax(np.diff(torques) < 0.0)) + 2
            return swings[:last], torques[:last]
    return swings, torques


def _greatest(fit: np.polynomial.Chebyshev) -> tuple[float, float]:
    """Place in [-1, 1] and value of the greatest value of a polynomial."""
    roots = fit.deriv().roots()
    inside = roots.real[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1.0)]
    places = np.concatenate([inside, [-1.0, 1.0]])
    values = fit(places)
    best = int(np.argmax(values))
    return float(places[best]), float(values[best])

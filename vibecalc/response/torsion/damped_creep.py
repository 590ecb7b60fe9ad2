"""Slow real poles of elements damped so strongly that they all but lock: near -k / c.

The two halves of the line beside such an element turn against each other as rigid bodies, and an
eigenvalue solver loses so small a number beside the large ones. Here it is the root of a quadratic.
"""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray
from vibecalc.response.torsion.graph import walk
from vibecalc.response.torsion.line import Line

#: a root is one of the line if bending of its halves moves it by less than this share
_SURE = 1e-9


def creep_poles(line: Line) -> list[tuple[complex, ComplexArray, float]]:
    """Poles in rad/s with shapes (n,) and absolute errors, of those elements that have one.

    With halves of moments J1 and J2 the pole is the smaller root of s^2 J + s c + k = 0, 1 / J =
    1 / J1 + 1 / J2, or J = J1 where the other half is held to ground. The torques that bend the
    halves change it in second order; that is the error, and an element where it is large is left
    out, as are halves with absolute damping, and elements that do not part the line.
    """
    found = []
    for element in np.flatnonzero((line.damping > 0.0) & (line.stiffness > 0.0)).tolist():
        near = _half(line, element)
        if near is None or np.any(line.absolute_damping):
            continue
        held = [bool(np.any(line.ground_stiffness[side])) for side in (near, ~near)]
        if all(held):
            continue
        shape = np.where(near, 1.0, 0.0) if not held[0] else np.where(near, 0.0, -1.0)
        if not any(held):
            shape -= float(line.inertia[near].sum() / line.inertia.sum())
        inertia = float(line.inertia @ shape**2)
        k, c = float(line.stiffness[element]), float(line.damping[element])
        if inertia == 0.0 or 8.0 * inertia * k > c**2:
            continue
        pole = -2.0 * k / (c + float(np.sqrt(c**2 - 4.0 * inertia * k)))
        torque = pole**2 * float(line.inertia @ np.abs(shape))
        others = np.delete(line.stiffness + pole * line.damping, element)
        others = np.concatenate([others, line.ground_stiffness[line.ground_stiffness > 0.0]])
        if np.any(others == 0.0):
            continue
        bent = float(np.sum(1.0 / np.abs(others))) * torque**2
        error = 2.0 * bent / abs(2.0 * pole * inertia + c) + 16.0 * EPSILON * abs(pole)
        if error < _SURE * abs(pole):
            top = shape[np.argmax(np.abs(shape))]
            found.append((complex(pole), (shape / top).astype(complex), error))
    return found


def _half(line: Line, element: int) -> BoolArray | None:
    """Freedoms (n,) on the first end's side of an element; None where another way leads across."""
    joined: dict[int, dict[int, float]] = {s: {} for s in range(len(line.inertia))}
    for place, (a, b) in enumerate(zip(line.first.tolist(), line.second.tolist(), strict=True)):
        if place != element and (line.stiffness[place] or line.damping[place]):
            joined[a][b] = joined[b][a] = 1.0
    near = np.zeros(len(line.inertia), dtype=bool)
    near[list(walk(joined, int(line.first[element])))] = True
    far = walk(joined, int(line.second[element]))
    # one piece: nothing else that would stand still
    whole = int(near.sum()) + len(far) == len(near)
    return near if whole and not near[int(line.second[element])] else None

"""Panels of crank angle: on each one the gas force is a straight line and the drive is smooth.

The motion inside a step is a power series of degree DEGREE in local time. A panel is short enough
for the series of the drive, a step short enough for that of the contacts (see `series.py`), so
that what the series leave out is below rounding.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.impact.model import Drive, GasForce

#: degree of the power series of every gap
DEGREE = 22

#: highest order times half the width of a panel, for the moments of `spectrum.py`
_HALF_PHASE = 5.0
_MOST_PANELS = 20_000


class Panels(NamedTuple):
    """Start, width (rad), gas force at the start (N) and its slope (N/rad) of each panel (p,)."""

    start: FloatArray
    width: FloatArray
    gas: FloatArray
    gas_slope: FloatArray


def make_panels(drive: Drive, gas: GasForce, highest_order: int, subdivision: int = 1) -> Panels:
    """Panels over one turn from crank angle 0, each node of the gas table between two of them.

    `subdivision` cuts every panel into that many, to show that nothing depends on them.
    Raises NumericalFailure for a drive that would need more than 20 000.
    """
    node, force = _gas_nodes(gas)
    widest = min(_drive_width(drive), 2.0 * _HALF_PHASE / max(highest_order, 1))
    pieces = np.ceil(np.diff(node) / widest * (1.0 - 1e-12)).astype(np.int64) * subdivision
    if np.sum(pieces) > _MOST_PANELS:
        raise NumericalFailure(
            f"one revolution would need {np.sum(pieces)} panels, more than {_MOST_PANELS}: the "
            f"motion of the crank pin has harmonics too high, or too many orders are kept"
        )
    starts, gas_starts, slopes = [], [], []
    for k, count in enumerate(pieces.tolist()):
        width, slope = node[k + 1] - node[k], (force[k + 1] - force[k]) / (node[k + 1] - node[k])
        local = width * np.arange(count) / count
        starts.append(node[k] + local)
        gas_starts.append(force[k] + slope * local)
        slopes.append(np.full(count, slope))
    start = np.concatenate(starts)
    width = np.diff(np.append(start, 2.0 * np.pi))
    return Panels(start, width, np.concatenate(gas_starts), np.concatenate(slopes))


def gas_force(gas: GasForce, angle: FloatArray) -> FloatArray:
    """Gas force, N, at crank angles of any shape, rad."""
    node, force = _gas_nodes(gas)
    return np.asarray(np.interp(np.mod(angle, 2.0 * np.pi), node, force))


def _gas_nodes(gas: GasForce) -> tuple[FloatArray, FloatArray]:
    """The table over one turn from 0 to 2 pi, with nodes at both ends."""
    turn = 2.0 * np.pi
    angle = np.asarray(gas.angle, dtype=np.float64)
    force = np.asarray(gas.force, dtype=np.float64)
    if not angle.size:
        return np.array([0.0, turn]), np.zeros(2)
    if angle.size > 1 and angle[-1] - angle[0] > turn * (1.0 - 1e-12):
        angle, force = angle[:-1], force[:-1]
    angle = np.mod(angle, turn)
    order = np.argsort(angle, kind="stable")
    angle, force = angle[order], force[order]
    at_zero = float(np.interp(0.0, angle, force, period=turn))
    inside = (angle > 1e-12) & (angle < turn - 1e-12)
    node = np.concatenate([[0.0], angle[inside], [turn]])
    return node, np.concatenate([[at_zero], force[inside], [at_zero]])


def _drive_width(drive: Drive) -> float:
    """Widest panel, rad, whose series of degree DEGREE of the drive's motion is exact to rounding.

    The first term left out of sum |a_n| (n width)^k / k! stays below rounding of sum |a_n|.
    """
    width = 2.0 * np.pi
    series = [(np.asarray(drive.orders), np.square(drive.orders) * np.abs(drive.displacement))]
    if drive.rod_tangent is not None and drive.tangent_orders is not None:
        series.append((np.asarray(drive.tangent_orders), np.abs(drive.rod_tangent)))
    # k = DEGREE - 1 is the first term that the acceleration leaves out
    term = DEGREE - 1
    factorial = float(np.prod(np.arange(1.0, term + 1.0)))
    for orders, size in series:
        total = float(np.sum(size))
        highest = float(np.sum(size * orders.astype(np.float64) ** term)) / factorial
        if highest > 0.0:
            width = min(width, (UNIT_ROUNDOFF * total / highest) ** (1.0 / term))
    return width

"""The largest readings over the range of speeds, at speeds found continuously.

A coarse grid of speeds only says where to look. Each local maximum is followed to where its slope
by speed vanishes, and narrow resonances, which a grid may miss, are looked up from the damped
poles of the line with this damper.
"""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray
from vibecalc.optimisation.damper.follow import LEVEL, Summits, about, follow, same_branch
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.optimisation.damper.rank_one import Table, map_readings, table
from vibecalc.optimisation.damper.relative import System
from vibecalc.optimisation.damper.rivals import rivals

#: half width over speed of a resonance without damping, and how far it stands out
_UNDAMPED, _UNBOUNDED = 1e-9, 1e6


def summits(
    system: System, found: Table, damper: Damper, scale: FloatArray, share: float,
    tolerance: float = LEVEL,
) -> Summits:  # fmt: skip
    """All maxima over speed: sections that reach `share` of the worst one, heat and travel.

    Readings are compared over `scale` (e + 3,); rows of infinite scale are left out. Heat and
    travel count from `share` of their scale, the limit. `tolerance` as in `follow`. The ring
    inertia is that of the table.
    """
    coarse = map_readings(
        system, found, np.array([damper.stiffness]), np.array([damper.damping])
    )[0] / scale  # fmt: skip
    grid = found.speed
    padded = np.pad(coarse, ((1, 1), (0, 0)), constant_values=-np.inf)
    local = (coarse >= padded[:-2]) & (coarse > padded[2:])
    place, row = np.nonzero(local & np.isfinite(scale))
    last = grid.size - 1
    low, high = grid[np.maximum(place - 1, 0)], grid[np.minimum(place + 1, last)]
    value = coarse[place, row]
    narrow = narrow_resonances(system, damper, grid)
    if narrow.size:
        rows = np.flatnonzero(np.isfinite(scale))
        speed, width = np.repeat(narrow[:, 0], rows.size), np.repeat(narrow[:, 1], rows.size)
        added = np.tile(rows, len(narrow))
        own = map_readings(
            system, table(system, damper, narrow[:, 0], bounded=False),
            np.array([damper.stiffness]), np.array([damper.damping]),
        )[0]  # fmt: skip
        seen = (own[:, rows] / scale[rows]).ravel()
        undamped = (width <= _UNDAMPED * speed) & (added < scale.size - 3)
        if np.any(seen[undamped] > _UNBOUNDED * np.max(coarse[:, :-3])):
            first = speed[undamped][int(np.argmax(seen[undamped]))]
            raise NumericalFailure(
                f"a mode that the damper does not reach is excited without damping at "
                f"{first:.6g} rad/s: no tuning bounds it"
            )
        low = np.append(low, np.maximum(speed - 3.0 * width, grid[0]))
        high = np.append(high, np.minimum(speed + 3.0 * width, grid[-1]))
        row, value = np.append(row, added), np.append(value, seen)
    # a reading on the grid may lie below its summit: a wide net first, the exact share after
    kept = _high_enough(system, row, value, 0.85 * share)
    result = follow(system, damper, row[kept], low[kept], high[kept], tolerance)
    level = result.value / scale[result.row]
    result = _single(system, result.some(_high_enough(system, result.row, level, share)))
    which, phase = rivals(system, damper, result.speed, result.row, result.phase)
    if which.size == 0:
        return result
    low, high = about(result, system.problem.speed, grid[1] - grid[0])
    beside = follow(system, damper, result.row[which], low[which], high[which], tolerance, phase)
    result = result.joined(beside)
    level = result.value / scale[result.row]
    return _single(system, result.some(_high_enough(system, result.row, level, share)))


def _high_enough(system: System, row: IntArray, level: FloatArray, share: float) -> BoolArray:
    """Which levels reach a share of the worst section, or of the limit of heat and travel."""
    section = row < system.twist.shape[0]
    kept: BoolArray = level >= share * np.where(section, np.max(level[section]), 1.0)
    return kept


def narrow_resonances(system: System, damper: Damper, grid: FloatArray) -> FloatArray:
    """Speeds (r, 2) in rad/s, with half widths, of resonances narrower than two steps of the grid.

    From the poles p of the line with its damper: an order q meets one at Im p / q, its half width
    is |Re p| / q.
    """
    mass = system.mass + damper.inertia * np.outer(system.ring, system.ring)
    spring, loss = system.spring.copy(), system.loss.copy()
    spring[-1, -1] += damper.stiffness
    loss[-1, -1] += damper.damping
    n = mass.shape[0]
    top = np.hstack([np.zeros((n, n)), np.eye(n)])
    low = np.hstack([-np.linalg.solve(mass, spring), -np.linalg.solve(mass, loss)])
    pole = np.linalg.eigvals(np.vstack([top, low]))
    pole = pole[pole.imag > 1e-6 * np.max(np.abs(pole))]
    order = np.asarray(system.problem.order, dtype=float)
    speed = (pole.imag[:, None] / order).ravel()
    width = (np.abs(pole.real)[:, None] / order).ravel()
    width = np.maximum(width, _UNDAMPED * speed)
    step = np.interp(speed, grid[1:], np.diff(grid))
    kept = (speed > grid[0]) & (speed < grid[-1]) & (width < 2.0 * step)
    return np.stack([speed[kept], width[kept]], axis=-1)


def _single(system: System, found: Summits) -> Summits:
    """Without what two brackets found twice."""
    kept: list[int] = []
    for i in np.argsort(-found.value, kind="stable"):
        twin = (
            (found.row[kept] == found.row[i])
            & (np.abs(found.speed[kept] / found.speed[i] - 1.0) < 1e-7)
            & same_branch(system, found.phase[kept], found.phase[i])
        )
        if not np.any(twin):
            kept.append(int(i))
    return found.some(np.array(kept, dtype=np.int64))

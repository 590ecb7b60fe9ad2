"""Is a tuning optimal: which peaks are active, and is there a direction that lowers them all?"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.nonnegative import nonnegative_least_squares
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.optimisation.absorber.minimax_points import Slopes, reduced, tunings
from vibecalc.response.absorber.coefficients import Coupling
from vibecalc.response.absorber.excess import ALL, excess
from vibecalc.response.absorber.model import Absorber, Transfer, transfer_of
from vibecalc.response.absorber.peaks import Peaks, peaks

#: peaks this close, relative to the excess over the floor, are one height
_EQUAL = 1e-9
#: slopes of ln (excess) that balance to this are balanced
_BALANCED = 1e-6

#: what was found: `VERDICTS[certificate.verdict]`
VERDICTS = ("isolated", "boundary", "set", "not_optimal")
ISOLATED, BOUNDARY, SET, NOT_OPTIMAL = range(4)


class Certificate(NamedTuple):
    """All (...), or (..., 4) per peak in the order of `peaks`.

    `largest`: the true supremum of |H|, from all stationary points and both ends. `active`: peaks
    that reach it; `weight`: their weights in the balance. `residual`: length of the shortest
    convex combination of their slopes by (ln k, ln z2), over the longest slope: zero where no
    small change of k and z2 lowers them all; at k = 0 or z2 = 0 only changes inwards count, by
    k / m or z2 / m. `curvature` of the common level along the line of equal heights, positive
    where the optimum is isolated; for a single active peak the smaller curvature of its level;
    infinite where the boundary leaves no direction. `verdict`: index into `VERDICTS`;
    set: the supremum is a limit at x = 0 or infinity that no absorber changes.
    """

    largest: np.ndarray
    active: np.ndarray
    weight: np.ndarray
    residual: np.ndarray
    curvature: np.ndarray
    verdict: np.ndarray


def certify(
    absorber: Absorber, excitation: str = "force", response: str = "displacement",
    equal: float = _EQUAL,
) -> Certificate:  # fmt: skip
    """Check tunings (...) against the first- and second-order conditions of the minimax.

    Independent of how the tuning was found: peaks come from the stationarity polynomial. `equal`
    is the relative difference in excess below which peaks count as equal. The check is local in
    (k, z2) and complete in frequency. Infinite k or z2 are not judged: not_optimal.
    """
    transfer = transfer_of(excitation, response)
    z1, m, k, z2 = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in absorber))
    shape = m.shape
    found = peaks(Absorber(z1, m, k, z2), excitation, response)
    z1, m, k, z2 = (np.array(a).reshape(-1) for a in (z1, m, k, z2))
    flat = Peaks(*(np.reshape(a, (m.size, *a.shape[len(shape) :])) for a in found))
    points = tunings(z1, m, transfer)
    floor = np.sqrt(points.weights.floor_squared)
    top = np.max(np.where(flat.found, flat.excess, -np.inf), axis=1)
    usable = np.isfinite(k) & np.isfinite(z2) & np.isfinite(flat.largest) & (k + z2 > 0.0)
    on_floor = (top <= 0.0) & (floor > 0.0) & (flat.largest <= floor * (1.0 + 8.0 * UNIT_ROUNDOFF))
    usable &= ~on_floor & np.isfinite(top) & (top > 0.0)
    active = flat.found & (flat.excess >= top[:, None] * (1.0 - equal)) & usable[:, None]

    weight = np.zeros(active.shape)
    residual, curvature = np.full(m.size, np.inf), np.full(m.size, -np.inf)
    for row in np.flatnonzero(usable):
        which = np.flatnonzero(active[row])
        y = 2.0 * np.log(flat.frequency[row, which])
        slope, bend = _derivatives(z1[row], m[row], k[row], z2[row], y, transfer)
        inward = np.array([k[row] == 0.0, z2[row] == 0.0])
        shares, residual[row] = _shortest(slope, inward)
        weight[row, which] = shares
        curvature[row] = _curvature(slope, bend, shares, inward)
    verdict = np.where(residual <= _BALANCED, ISOLATED, NOT_OPTIMAL)
    edge = (k == 0.0) | (z2 == 0.0)
    verdict = np.where((verdict == ISOLATED) & edge, BOUNDARY, verdict)
    verdict = np.where((verdict != NOT_OPTIMAL) & ~(curvature > 0.0), NOT_OPTIMAL, verdict)
    verdict = np.where(on_floor, SET, verdict)
    residual, curvature = np.where(on_floor, 0.0, residual), np.where(on_floor, 0.0, curvature)
    columns = (flat.largest, active, weight, residual, curvature, verdict)
    return Certificate(*(a.reshape((*shape, *a.shape[1:])) for a in columns))


def _derivatives(
    z1: float, m: float, k: float, z2: float, y: np.ndarray, transfer: Transfer
) -> tuple[np.ndarray, np.ndarray]:
    """Slopes (peaks, 2) and curvatures (peaks, 3) of ln (excess), the frequencies following.

    By ln k and ln z2; by k / m and z2 / m where these are zero.
    """
    same = tunings(np.full(len(y), z1), np.full(len(y), m), transfer)
    g1 = 2.0 * z2
    one = np.ones(len(y))
    parts = Coupling(
        same.primary_damping, same.mass_ratio, m * one, k * one, g1 * one, np.zeros(len(y), int)
    )
    u = np.exp(y)
    seen = excess(parts, same.weights, u, ALL)
    unit = [k if k > 0.0 else m, g1 if g1 > 0.0 else 2.0 * m]
    scale = [1.0, u, u * u, unit[0], unit[1], u * unit[0], u * unit[1],
             unit[0] ** 2, unit[0] * unit[1], unit[1] ** 2]  # fmt: skip
    a, q = (
        np.stack([part * factor for part, factor in zip(side / side[0], scale, strict=True)])
        for side in (seen.above, seen.below)
    )
    first = a - q
    pairs = ((2, 1, 1), (5, 1, 3), (6, 1, 4), (7, 3, 3), (8, 3, 4), (9, 4, 4))
    second = [a[i] - a[j] * a[n] - q[i] + q[j] * q[n] for i, j, n in pairs]
    # only a derivative by a logarithm gains the first one
    log_k, log_z = float(k > 0.0), float(g1 > 0.0)
    whole = reduced(
        Slopes(
            first[0], first[1], second[0] + first[1], first[3:5], np.stack(second[1:3]),
            np.stack([second[3] + log_k * first[3], second[4], second[5] + log_z * first[4]]),
        )
    )  # fmt: skip
    return whole.p.T, whole.pp.T


def _shortest(slope: np.ndarray, inward: np.ndarray) -> tuple[np.ndarray, float]:
    """Weights (sum 1) of the shortest convex combination of slopes, and its relative length.

    A component along which only inward changes are allowed counts where it falls inwards.
    """
    size = max(float(np.max(np.linalg.norm(slope, axis=1))), 1e-300)
    columns = [slope.T / size, -np.eye(2)[:, inward]]
    table = np.concatenate(columns, axis=1)
    heavy = 1e6
    table = np.vstack([table, heavy * (np.arange(table.shape[1]) < len(slope))])
    solved = nonnegative_least_squares(table, np.array([0.0, 0.0, heavy]))
    shares = _settled(np.concatenate(columns, axis=1), solved > 0.0, len(slope))
    if shares is None:
        shares = solved[: len(slope)] / np.sum(solved[: len(slope)])
    left = slope.T @ shares / size
    left = np.where(inward, np.minimum(left, 0.0), left)
    return shares, float(np.linalg.norm(left))


def _settled(columns: np.ndarray, held: np.ndarray, count: int) -> np.ndarray | None:
    """Weights with the sum 1 on the columns that are `held`, to full precision.

    The heavy row that keeps the sum costs digits; with the right columns known one weight follows
    from the others. None where these would be negative.
    """
    which = np.flatnonzero(held[:count])
    if not len(which):
        return None
    last, rest = which[-1], [*which[:-1], *(count + np.flatnonzero(held[count:]))]
    shares = np.zeros(columns.shape[1])
    if rest:
        base = np.where(np.array(rest) < count, 1.0, 0.0) * columns[:, last, None]
        shares[rest] = np.linalg.lstsq(columns[:, rest] - base, -columns[:, last], rcond=None)[0]
    shares[last] = 1.0 - np.sum(shares[which[:-1]])
    return shares[:count] if np.all(shares >= 0.0) else None


def _curvature(
    slope: np.ndarray, bend: np.ndarray, shares: np.ndarray, inward: np.ndarray
) -> float:
    """Curvature of the weighted level along what the active peaks and the boundary leave free."""
    kk, kz, zz = shares @ bend
    table = np.array([[kk, kz], [kz, zz]])
    held = [slope[i] - slope[0] for i in range(1, len(slope))]
    pull = slope.T @ shares
    # a boundary that is pressed against leaves no direction of its own
    held += [np.eye(2)[i] for i in range(2) if inward[i] and pull[i] > 1e-6]
    if not held:
        return float(np.min(np.linalg.eigvalsh(table)))
    _, sizes, rows = np.linalg.svd(np.array(held))
    rank = int(np.sum(sizes > 1e-10 * max(float(sizes[0]), 1e-300)))
    free = rows[rank:]
    if not len(free):
        return float("inf")
    return float(np.min(np.linalg.eigvalsh(free @ table @ free.T)))

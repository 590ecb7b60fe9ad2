"""What a mistuned absorber loses, and how the optimum moves with the primary system."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.several_peaks import several_slopes
from vibecalc.absorber.transfer import Absorber, transfer_of
from vibecalc.absorber.tuning.several_search import OptimalPoint, TuningProblem, hold, usual_size
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded

# ----------------------------------------------------------------------------
# What a mistuned absorber loses: the largest response with k and z2 off by a few per cent.
# ----------------------------------------------------------------------------

#: relative errors examined unless others are given
SHARES = (0.01, 0.05, 0.10)


class Mistuning(NamedTuple):
    """Relative increase of the largest |H|, peak / peak of the tuned absorber - 1.

    `stiffness` and `damping` (..., share, 2): one ratio off, too small and too large; `corner`
    (..., share): the worst of the four with both off. Each with its absolute error. Negative where
    the absorber was not at its optimum.
    """

    share: np.ndarray
    stiffness: Bounded
    damping: Bounded
    corner: Bounded


def mistuning(
    absorber: Absorber, excitation: str = "force", response: str = "displacement",
    shares: tuple[float, ...] = SHARES,
) -> Mistuning:  # fmt: skip
    """Loss of tuned absorbers (...) from relative errors `shares` of k and z2, of both signs.

    Raises NumericalFailure where the tuned peak is infinite or zero.
    """
    z1, m, k, z = (
        np.asarray(a)[..., None, None] for a in np.broadcast_arrays(
            *(np.asarray(part, dtype=float) for part in absorber)
        )
    )  # fmt: skip
    share = np.asarray(shares, dtype=float)
    # columns: tuned, k - +, z - +, both -- -+ +- ++
    signs_k = np.array([0, -1, 1, 0, 0, -1, -1, 1, 1])
    signs_z = np.array([0, 0, 0, -1, 1, -1, 1, -1, 1])
    off = share[:, None]
    moved = Absorber(z1, m, k * (1.0 + off * signs_k), z * (1.0 + off * signs_z))
    tops = peaks(moved, excitation, response)
    tuned = tops.largest[..., :1]
    if not np.all(np.isfinite(tuned) & (tuned > 0.0)):
        raise NumericalFailure(
            f"the largest {response} under {excitation!r} of the tuned absorber is not finite: no "
            "loss can be determined"
        )
    with np.errstate(invalid="ignore"):
        ratio = tops.largest / tuned
        uncertainty = tops.largest_error / tuned + ratio * tops.largest_error[..., :1] / tuned
    loss = ratio - 1.0
    error = np.where(np.isfinite(ratio), uncertainty + 4e-16, np.inf)
    worst = np.argmax(loss[..., 5:], axis=-1)[..., None]
    corner = [np.take_along_axis(a[..., 5:], worst, axis=-1)[..., 0] for a in (loss, error)]
    return Mistuning(
        share, Bounded(loss[..., 1:3], error[..., 1:3]),
        Bounded(loss[..., 3:5], error[..., 3:5]), Bounded(*corner),
    )  # fmt: skip


# ----------------------------------------------------------------------------
# How an optimum moves with primary damping and mass ratio: derivatives of its own conditions.
# ----------------------------------------------------------------------------

#: curvature, in units of `usual_size`, below which the optimum has no definite place
_FLAT = 1e-9


class Sensitivity(NamedTuple):
    """Derivatives by primary damping (first) and by each mass ratio (then): (1 + n,) columns.

    `peak` (1 + n,), `stiffness_ratio`, `secondary_damping` (n, 1 + n); zero where a bound holds
    the ratio or the absorber is fastened rigidly. Errors are absolute.
    """

    peak: np.ndarray
    stiffness_ratio: np.ndarray
    secondary_damping: np.ndarray
    peak_error: np.ndarray
    stiffness_error: np.ndarray
    damping_error: np.ndarray


def sensitivity(
    primary_damping: float, mass_ratio: ArrayLike, stiffness_ratio: ArrayLike,
    secondary_damping: ArrayLike, parent: tuple[int, ...] = (0,), excitation: str = "force",
    response: str = "displacement",
) -> Sensitivity:  # fmt: skip
    """Derivatives of the minimax optimum at which the given k (n) and z2 (n) stand.

    The conditions (levels of the active peaks equal, their weighted slopes zero) are differentiated
    implicitly, with the second derivatives of each peak. The peak itself moves as its own
    derivative at fixed ratios says, weighted (envelope theorem).
    Raises NumericalFailure where the point is no optimum, or one of a set.
    """
    m = np.atleast_1d(np.asarray(mass_ratio, dtype=float))
    start = np.concatenate([
        np.atleast_1d(np.asarray(stiffness_ratio, dtype=float)),
        np.atleast_1d(np.asarray(secondary_damping, dtype=float)),
    ])  # fmt: skip
    n = len(m)
    locked = np.isinf(start[:n]) | np.isinf(start[n:])
    fixed = np.concatenate([locked, locked])
    start = np.where(fixed, 0.0, start)
    problem = TuningProblem(
        float(primary_damping), m, parent, excitation, response, np.zeros(2 * n),
        np.where(fixed, 0.0, np.inf), locked=tuple(bool(one) for one in locked),
    )  # fmt: skip
    scale = usual_size(problem)
    held = hold(problem, start, scale)
    if held is None or not np.all(held.rows.moves[held.active]):
        raise NumericalFailure(
            "sensitivity: the given stiffness and damping are not an optimum held by its peaks, or "
            "its peaks stand too little above an end of the frequency range to tell"
        )
    if float(np.max(np.abs(held.ratios - start) / scale)) > 1e-3:
        raise NumericalFailure(
            "sensitivity: the optimum lies elsewhere, at stiffness ratios "
            f"{held.ratios[:n]} and dampings {held.ratios[n:]}"
        )
    table, right, free, slope = _conditions(problem, held, scale)
    if held.curvature < _FLAT:
        raise NumericalFailure("sensitivity: the optimum is one of a set and has no derivative")
    solution = -np.linalg.solve(table, right)
    # what a residual and rounding may change, by the condition of the system
    grown = np.abs(np.linalg.inv(table)) @ (np.abs(right) + np.abs(table) @ np.abs(solution))
    uncertainty = (held.residual + held.step + 4.0 * float(np.max(held.rows.error))) * grown
    moved, error = np.zeros((2 * n, 1 + n)), np.zeros((2 * n, 1 + n))
    count = int(np.sum(free))
    moved[free], error[free] = solution[:count], uncertainty[:count]
    moved, error = moved * scale[:, None], error * scale[:, None]
    weight = held.weight[held.active]
    peak = float(np.exp(0.5 * np.max(held.rows.level[held.active])))
    change = 0.5 * peak * (weight @ slope)
    roughness = 0.5 * peak * (held.residual + 1e-12) * np.max(np.abs(slope), axis=0)
    shift = 0.5 * peak * held.residual * np.sum(np.abs(moved / scale[:, None]), axis=0)
    return Sensitivity(
        change, moved[:n], moved[n:], roughness + shift + 1e-13 * np.abs(change), error[:n],
        error[n:],
    )  # fmt: skip


def _conditions(
    problem: TuningProblem, held: OptimalPoint, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Matrix of the conditions, their derivatives by the data, free unknowns, slopes by the data.

    Unknowns: ratios in units of `scale`, weights, level.
    """
    size, count = len(scale), int(np.sum(held.active))
    slopes = several_slopes(
        problem.system(held.ratios), held.rows.frequency[held.active],
        transfer_of(problem.excitation, problem.response),
    )  # fmt: skip
    weight = held.weight[held.active]
    free = ~(held.on_lower | held.on_upper)
    bend = np.tensordot(weight, slopes.second, 1)
    block = (scale[:, None] * bend[:size, :size] * scale)[np.ix_(free, free)]
    slope = (slopes.first[:, :size] * scale)[:, free]
    width = int(np.sum(free))
    table = np.zeros((width + count + 1, width + count + 1))
    table[:width, :width] = block
    table[:width, width:-1], table[width:-1, :width] = slope.T, slope
    table[width:-1, -1], table[-1, width:-1] = -1.0, 1.0
    data = slopes.first[:, size:]
    right = np.zeros((width + count + 1, data.shape[1]))
    right[:width] = (scale[:, None] * bend[:size, size:])[free]
    right[width:-1] = data
    return table, right, free, data

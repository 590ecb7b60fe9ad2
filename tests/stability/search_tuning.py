"""Contests on absorbers: peaks by two polynomials, tunings against neighbours, mean squares."""

import mpmath
import numpy as np
from exact_mean_square import exact_mean_square
from stability.search import Contest
from stability.search_machines import between, worst

from vibecalc.absorber.mean_square import mean_square
from vibecalc.absorber.modal import fitted, highest, one_mode
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.minimax import BALANCED, minimax

KINDS = (
    ("force", "displacement"), ("force", "velocity"), ("base", "displacement"),
    ("force", "transmitted_force"), ("unbalance", "displacement"),
)  # fmt: skip


def ratios(point: np.ndarray) -> tuple[float, float, float, float]:
    """z1, m, k, z2 over many decades, k near m where the pair is tuned."""
    m = between(point[1], 1e-8, 10.0)
    k = m * (between(point[2], 1e-4, 1e4) if point[4] < 0.5 else 1.0 + 0.2 * (point[2] - 0.5))
    return between(point[0], 1e-12, 2.0), m, k, m * between(point[3], 1e-10, 100.0)


def absorber_peaks(point: np.ndarray) -> float:
    """Peaks of one absorber by its own polynomial and by the matrices of several."""
    z1, m, k, z2 = ratios(point)
    kind = KINDS[int(point[5] * (len(KINDS) - 0.01))]
    one = peaks(Absorber(z1, m, k, z2), *kind)
    read = "travel" if kind[1] == "relative_displacement" else kind[1]
    height, error, _ = highest(fitted(one_mode(z1), m, k, z2), kind[0], read)
    if np.isinf(one.largest) and np.isinf(height[0]):
        return 0.0
    return worst(one.largest - height[0], one.largest_error + error[0])


def absorber_grid(point: np.ndarray) -> float:
    """Peaks from the polynomial against |H| at many frequencies: none may lie above."""
    from two_masses import with_error

    ratio = Absorber(*ratios(point))
    kind = KINDS[int(point[5] * (len(KINDS) - 0.01))]
    found = peaks(ratio, *kind)
    if np.isinf(found.largest):
        return 0.0
    own = float(np.sqrt(np.asarray(ratio.stiffness_ratio) / np.asarray(ratio.mass_ratio)))
    near = np.concatenate([found.frequency[found.present], [1.0, own, float(found.where)]])
    near = near[np.isfinite(near)]
    step = np.concatenate([-np.geomspace(1e-12, 0.5, 150), [0.0], np.geomspace(1e-12, 0.5, 150)])
    x = np.concatenate([np.outer(near, 1.0 + step).ravel(), np.geomspace(1e-3, 1e3, 2000)])
    seen, off = with_error(ratio, x[x > 0.0], *kind)
    above = np.abs(seen) - float(found.largest)
    return max(0.0, float(np.max(above / (off + float(found.largest_error)))))


def tuning(point: np.ndarray) -> float:
    """The minimax against 400 tunings round it: none may have a lower largest response."""
    z1 = 0.0 if point[0] < 0.1 else between(point[0], 1e-10, 0.7071)
    if point[0] > 0.9:
        z1 = 2**-0.5 - between(point[3], 1e-12, 1e-2)
    m = between(point[1], 1e-4, 10.0)
    found = minimax(z1, m)
    if found.outcome != BALANCED:
        return 0.0
    random = np.random.default_rng(int(point[2] * 1e5))
    away = np.exp(random.normal(size=(2, 400)) * 10.0 ** random.uniform(-10.0, -0.3, 400))
    tried = peaks(
        Absorber(z1, m, found.stiffness_ratio * away[0], found.secondary_damping * away[1])
    )
    lower = float(found.largest) - tried.largest
    return max(0.0, float(np.max(lower / (tried.largest_error + float(found.largest_error)))))


def squares(point: np.ndarray) -> float:
    """Closed form of the mean square against moments in long arithmetic."""
    z1, m, k, z2 = ratios(point)
    found = mean_square(Absorber(z1, m, k, z2))
    with mpmath.workdps(80):
        exact = exact_mean_square("displacement", z1, m, k, z2)
        return float(abs(mpmath.mpf(float(found.value)) - exact) / mpmath.mpf(float(found.error)))


TUNINGS = (
    Contest("absorber peaks", "polynomial of one against matrices of several", 6, absorber_peaks),
    Contest("absorber grid", "polynomial against a grid of frequencies", 6, absorber_grid),
    Contest("tuning", "minimax against its neighbours", 4, tuning),
    Contest("mean square", "closed form against long arithmetic", 5, squares),
)

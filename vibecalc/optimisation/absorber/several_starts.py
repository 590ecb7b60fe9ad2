"""Where to start: a few tunings made by rule, then points that fill the usual range evenly."""

import numpy as np

from vibecalc.optimisation.absorber.several_problem import Problem

_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37)


def usual_size(problem: Problem) -> np.ndarray:
    """Size (q,) of stiffness, damping and share: m, m sqrt(sum m), 1, within finite bounds."""
    m = problem.mass_ratio
    whole = float(np.sum(m))
    # an absorber far heavier than the primary system is stopped by stiffness of order one
    soft = m / (1.0 + whole) ** 2
    drag = m * np.sqrt(whole / (1.0 + whole) ** 3)
    shares = np.ones(len(problem.lower) - 2 * len(m))
    size = np.concatenate([soft, drag, shares])
    upper = np.where(problem.upper > 0.0, problem.upper, np.inf)
    return np.asarray(np.minimum(np.maximum(size, problem.lower), upper))


def starts(problem: Problem, count: int) -> list[np.ndarray]:
    """`count` points (q,) in units of `usual_size`."""
    n, size = len(problem.mass_ratio), len(problem.lower)
    equal = np.full(size - 2 * n, 1.0 / n)
    whole = float(np.sum(problem.mass_ratio))
    found = []
    middle = np.arange(n) - 0.5 * (n - 1)
    for sense in (1.0, -1.0)[: 1 if n == 1 else 2]:
        # neighbours a bandwidth apart, each with its part of the damping
        apart = 1.0 + sense * 1.2 * np.sqrt(whole / (1.0 + whole)) / n * middle
        found.append(np.concatenate([apart**2, np.full(n, 0.61 / np.sqrt(n)), equal]))
    if n > 1:  # one does the work, the others hang on as a stiff or a heavily damped rest
        found.append(np.concatenate([np.ones(n), np.geomspace(0.1, 0.6, n), equal]))
        found.append(np.concatenate([np.ones(n), np.geomspace(0.6, 0.1, n), equal]))
    index = 1
    while len(found) < count:
        unit = np.array([_radical_inverse(index, _PRIMES[i % 12]) for i in range(size)])
        stiff = 0.2 * 10.0 ** unit[:n]
        drag = 0.05 * 30.0 ** unit[n : 2 * n]
        share = unit[2 * n :] / max(float(np.sum(unit[2 * n :])) * 1.05, 1.0)
        found.append(np.concatenate([stiff, drag, np.clip(share, 0.05, 0.95)]))
        index += 1
    return found[:count]


def _radical_inverse(index: int, base: int) -> float:
    """Digits of `index` mirrored at the point (J. H. Halton, 1960)."""
    result, part = 0.0, 1.0 / base
    while index:
        index, digit = divmod(index, base)
        result += digit * part
        part /= base
    return result

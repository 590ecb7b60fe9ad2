"""Trials of methods against each other: which nothing beats, which is cheapest for an error."""

from collections.abc import Sequence

import numpy as np


def on_front(error: Sequence[float], cost: Sequence[float]) -> list[bool]:
    """Whether none is cheaper and as accurate, or as cheap and better; never without an error."""
    e, c = np.asarray(error, dtype=float), np.asarray(cost, dtype=float)
    no_worse = (c[:, None] <= c) & (e[:, None] <= e)
    better = no_worse & ((c[:, None] < c) | (e[:, None] < e))
    return [bool(one) for one in np.isfinite(e) & ~np.any(better & np.isfinite(e)[:, None], axis=0)]


def cheapest(error: Sequence[float], cost: Sequence[float], target: float) -> int | None:
    """Place of the cheapest with an error of at most `target`; of equals the more accurate."""
    reaching = [(cost[k], error[k], k) for k in range(len(error)) if error[k] <= target]
    return min(reaching)[2] if reaching and np.isfinite(target) else None


def extra(error: Sequence[float], cost: Sequence[float], default: Sequence[bool]) -> float:
    """Cost of the default over the least of any as accurate: 1 on the front or without a default.

    Of several defaults the worst counts; infinite where one has no error.
    """
    worst = 1.0
    for place in np.flatnonzero(default).tolist():
        best = cheapest(error, cost, error[place])
        if best is None:
            return float("inf")
        worst = max(worst, cost[place] / cost[best] if cost[best] > 0.0 else 1.0)
    return worst

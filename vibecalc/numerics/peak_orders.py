"""Which orders of a periodic signal its peak cannot tell from rounding."""

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray

#: highest orders kept are 2^k or 3 2^k, so that rows fall into few groups
_STEPS = np.sort(np.concatenate([2 ** np.arange(40), 3 * 2 ** np.arange(39)]))


def kept_orders(rows: ComplexArray, orders: IntArray) -> tuple[IntArray, FloatArray]:
    """Highest order to keep of each row (r, component, n), and the sum (r,) of those above it.

    The sum stays below the unit roundoff of the row's largest harmonic, and so of its peak. What
    is kept follows from the row and the largest of `orders` alone; one order above zero stays.
    """
    size = np.abs(rows).sum(axis=1)
    below = UNIT_ROUNDOFF * size.max(axis=-1)
    highest = int(orders.max())
    if np.all(size[:, orders == highest].sum(axis=-1) > below):
        return np.full(len(rows), highest), np.zeros(len(rows))
    rank = np.argsort(orders, kind="stable")
    onwards = np.cumsum(size[:, rank[::-1]], axis=1)[:, ::-1]
    needed = np.max(np.where(onwards > below[:, None], orders[rank], 0), axis=1)
    needed = np.maximum(needed, int(orders[orders > 0].min()))
    kept = np.minimum(_STEPS[np.searchsorted(_STEPS, needed)], highest)
    return kept, np.sum(np.where(orders > kept[:, None], size, 0.0), axis=1)

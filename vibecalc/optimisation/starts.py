"""Starting points: a low-discrepancy sequence that is fixed here, so that it never changes."""

import numpy as np


def spread(count: int, dimension: int) -> np.ndarray:
    """Spread points evenly over the unit cube, each prefix of the sequence as well as possible.

    Parameters
    ----------
    count : int
        Number of points.
    dimension : int
        Number of coordinates.

    Returns
    -------
    points : (count, dimension) array in (0, 1)

    Notes
    -----
    Additive recurrence with the generalised golden ratio, the root of g^(d+1) = g + 1:
    point k is the fractional part of 1/2 + k (1/g, 1/g^2, ..., 1/g^d), k = 1, 2, ...
    (M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
    """
    ratio = 2.0
    for _ in range(64):  # a contraction with a factor below 1/3
        ratio = (1.0 + ratio) ** (1.0 / (dimension + 1))
    steps = ratio ** -np.arange(1.0, dimension + 1)
    return (0.5 + np.arange(1.0, count + 1)[:, None] * steps) % 1.0

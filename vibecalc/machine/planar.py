"""The motions that a model of isolation keeps of a rigid body, as indices into x y z rx ry rz."""

import numpy as np
from numpy.typing import NDArray

from vibecalc.machine.frame import DIRECTIONS

#: a coupling below this share of what it couples is the round-off of none
TOLERANCE = 1e-9


def kept_freedoms(model: str, axis: str) -> NDArray[np.intp]:
    """All six of `rigid_body`; of `planar` the two translations and the turn in the crank plane.

    The crank plane is square to the crankshaft `axis`: pistons, rods and throws move in it.
    """
    if model != "planar":
        return np.arange(6)
    along = DIRECTIONS.index(axis)
    return np.array([*(place for place in range(3) if place != along), 3 + along])

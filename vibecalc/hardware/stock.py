"""The parts of a list in the order of how near they come to a value that is wanted."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.hardware.spring_couple import couple_stiffness
from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.typing import FloatArray, IntArray


class Ranking(NamedTuple):
    """Positions in the list, nearest first; what each offers over what is wanted, in that order."""

    order: IntArray
    ratio: FloatArray


def rank(offered: ArrayLike, wanted: float) -> Ranking:
    """Parts by |log(offered / wanted)|, equals in the order of the list.

    A part that offers nothing stands last with ratio 0. Raises NumericalFailure for an empty list
    or a value that is not above zero.
    """
    (values,) = floats(offered)
    if values.size == 0 or wanted <= 0.0:
        raise NumericalFailure("the nearest part needs a list of parts and a value above zero")
    ratio = values / wanted
    distance = np.where(ratio > 0.0, np.abs(np.log(np.where(ratio > 0.0, ratio, 1.0))), np.inf)
    order = np.argsort(distance, kind="stable")
    return Ranking(order, ratio[order])


def nearest_springs(
    rates: ArrayLike, stiffness: float, count: float, radius: float, angle: float
) -> Ranking:
    """Springs of rates (n,) in N/m by the torsional stiffness in N m/rad of `count` of them."""
    return rank(couple_stiffness(rates, count, radius, angle).value, stiffness)

"""A coarse map over ln k and ln c (and ln J), and where its valleys are."""

from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.problem import Limits, Problem
from vibecalc.optimisation.damper.rank_one import map_readings
from vibecalc.optimisation.damper.survey import Survey, survey


class Chart(NamedTuple):
    """On axes `inertia` (j,), `stiffness` (k,), `damping` (c,): arrays (j, k, c).

    `worst` largest weighted half range on the grid of speeds and cycle samples, `heat` in W and
    `travel` in rad at their worst speeds: a picture, not the values of the design.
    """

    inertia: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    worst: FloatArray
    heat: FloatArray
    travel: FloatArray


def chart(problem: Problem, limits: Limits, points: int = 41, speeds: int = 161) -> Chart:
    """Map of `points` values of each of J, k and c whose bounds differ."""
    return chart_of(survey(problem, limits, speeds), points)


def chart_of(prepared: Survey, points: int) -> Chart:
    """The same from a prepared survey."""
    axes = [
        np.geomspace(low, high, points) if high > low else np.array([low])
        for low, high in prepared.bounds
    ]
    inertia, stiffness, damping = axes
    k, c = (a.ravel() for a in np.meshgrid(stiffness, damping, indexing="ij"))
    shape = (inertia.size, stiffness.size, damping.size)
    worst, heat, travel = np.empty(shape), np.empty(shape), np.empty(shape)
    for index, value in enumerate(inertia):
        found = prepared.table(float(value))
        seen = np.max(map_readings(prepared.system, found, k, c), axis=1)
        worst[index] = np.max(seen[:, :-3], axis=1).reshape(shape[1:])
        heat[index] = seen[:, -3].reshape(shape[1:])
        travel[index] = np.max(seen[:, -2:], axis=1).reshape(shape[1:])
    return Chart(inertia, stiffness, damping, worst, heat, travel)


def valleys(prepared: Survey, found: Chart, most: int) -> FloatArray:
    """Variables (b, v) of all local minima of the map, lowest first, at most `most`.

    Outside the limits the excess counts in units of the largest value, so that the least violated
    place is a valley too.
    """
    limits = prepared.limits
    over = np.maximum(found.heat / limits.heat, found.travel / limits.travel) - 1.0
    price = limits.inertia_price * found.inertia[:, None, None]
    level = found.worst + price
    level = np.where(over > 0.0, np.max(level) * (1.0 + over), level)
    padded = np.pad(level, 1, constant_values=np.inf)
    shape = level.shape
    lowest = np.ones(shape, dtype=bool)
    for shift in product((0, 1, 2), repeat=3):
        part = tuple(slice(s, s + n) for s, n in zip(shift, shape, strict=True))
        lowest &= level <= padded[part]
    places = np.argwhere(lowest)
    places = places[np.argsort(level[lowest], kind="stable")][:most]
    axes = (found.inertia, found.stiffness, found.damping)
    values = np.stack([axes[i][places[:, i]] for i in prepared.moving], axis=-1)
    return np.log(values)

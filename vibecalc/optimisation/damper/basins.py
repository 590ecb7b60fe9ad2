"""How far descents ended from the optima of their own basins."""

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.active import Held
from vibecalc.optimisation.damper.descend import BROKEN, Place, foreseen
from vibecalc.optimisation.damper.settle import settle
from vibecalc.optimisation.damper.survey import Survey

#: an end this close, in logarithms and in height, belongs to the optimum already held
_SAME, _AS_HIGH = 0.03, 1e-3
#: a foreseen step below which an end counts as the optimum of its basin
_SETTLED = 0.01
#: height over that of the optimum up to which another basin is worth its own proof
_RIVAL = 1.05


def basin_errors(prepared: Survey, held: Held, ends: list[Place]) -> tuple[FloatArray, FloatArray]:
    """Errors (b, 3) of J, k, c and (b,) of the objective of all ends.

    The way to the optimum that Newton's method finds from an end. Where none proves one, and in
    basins far above the best one, the step that a linear program would still take and its gain.
    """
    away, above = np.zeros((len(ends), 3)), np.zeros(len(ends))
    known = [held]
    for place, end in enumerate(ends):
        found = next((one for one in known if _belongs(prepared, one, end)), None)
        step, above[place] = foreseen(prepared, end)
        # Newton's method costs as much as a descent: not where nothing more is to be had
        rival = end.over <= BROKEN and end.merit < _RIVAL * _merit(prepared, held)
        if found is None and rival and np.max(step, initial=0.0) > _SETTLED:
            found = settle(prepared, end)
            if found is not None:
                known.append(found)
        if found is not None:
            step = np.abs(found.variables - end.variables) + found.variable_error
            above[place] = abs(_merit(prepared, found) - end.merit) + found.level_error
        values = np.array(prepared.damper(end.variables))[prepared.moving]
        away[place, prepared.moving] = values * step
    return away, above


def _merit(prepared: Survey, held: Held) -> float:
    price = prepared.limits.inertia_price * prepared.damper(held.variables).inertia
    return held.level + price


def _belongs(prepared: Survey, held: Held, end: Place) -> bool:
    near = np.max(np.abs(held.variables - end.variables), initial=0.0) < _SAME
    high = _merit(prepared, held)
    return bool(near and abs(end.merit - high) < _AS_HIGH * high)

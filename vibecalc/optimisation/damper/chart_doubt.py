"""How far a map that is read on a grid of speeds lies from the summits between them."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.chart import Chart
from vibecalc.optimisation.damper.gain import performance
from vibecalc.optimisation.damper.problem import Damper, Problem

#: what the worst of all places may have beyond the worst of those looked at
_BEYOND = 2.0


def chart_error(problem: Problem, drawn: Chart) -> FloatArray:
    """Errors (3,) of worst section, heat and travel anywhere on the map of the first inertia.

    The summits are followed at the corners, where rings are all but locked or free and resonances
    narrow, in the middle and where the map is highest; the largest difference there, twice.
    """
    maps = (drawn.worst[0], drawn.heat[0], drawn.travel[0])
    rows, columns = maps[0].shape
    places = {(i, j) for i in (0, rows - 1) for j in (0, columns - 1)}
    places |= {(rows // 2, columns // 2)}
    places |= {divmod(int(np.argmax(one)), columns) for one in maps}
    error = np.zeros(3)
    for i, j in sorted(places):
        damper = Damper(float(drawn.inertia[0]), float(drawn.stiffness[i]), float(drawn.damping[j]))
        try:
            seen = performance(problem, damper)
        except NumericalFailure:
            # a mode that this ring leaves undamped: no summit to compare with
            continue
        exact = (seen.worst, seen.heat, seen.travel)
        error = np.maximum(error, [abs(a - one[i, j]) for a, one in zip(exact, maps, strict=True)])
    if not np.any(error):
        raise NumericalFailure("no place on the map of dampers has a summit to compare it with")
    return _BEYOND * error

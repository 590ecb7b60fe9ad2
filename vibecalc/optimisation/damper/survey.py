"""A design problem made ready for search: its variables are logarithms of what may move."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.optimisation.damper.follow import LEVEL, Summits
from vibecalc.optimisation.damper.problem import Damper, Limits, Problem, check
from vibecalc.optimisation.damper.rank_one import Table, table
from vibecalc.optimisation.damper.relative import System, system_of
from vibecalc.optimisation.damper.worst import summits

#: tables kept, one for each ring inertia
_KEPT = 8


class Survey(NamedTuple):
    """`bounds` (3, 2) of J, k, c; `moving` (v,) which of them are searched; `grid` (s,) of speeds;
    `scale` (e + 3,) of the readings: 1 for sections, the limits for heat and travel, infinite for
    what is not asked."""

    system: System
    limits: Limits
    bounds: FloatArray
    moving: IntArray
    grid: FloatArray
    scale: FloatArray
    tables: dict[float, Table]

    def damper(self, variables: FloatArray) -> Damper:
        """From logarithms (v,) of the moving values; the others stand at their bounds."""
        values = self.bounds[:, 0].copy()
        values[self.moving] = np.exp(variables)
        # a variable on its bound gives the bound itself, not the exponential of its logarithm
        for side in (0, 1):
            at_bound = np.abs(variables - self.logarithms[:, side]) < 1e-14
            values[self.moving[at_bound]] = self.bounds[self.moving[at_bound], side]
        values = np.clip(values, self.bounds[:, 0], self.bounds[:, 1])
        return Damper(*(float(value) for value in values))

    def table(self, inertia: float) -> Table:
        """Of this ring inertia, solved once."""
        if inertia not in self.tables:
            if len(self.tables) >= _KEPT:
                self.tables.pop(next(iter(self.tables)))
            middle = np.sqrt(self.bounds[1:, 0] * self.bounds[1:, 1])
            nominal = Damper(inertia, float(middle[0]), float(middle[1]))
            self.tables[inertia] = table(self.system, nominal, self.grid, bounded=False)
        return self.tables[inertia]

    def summits(self, damper: Damper, share: float, tolerance: float = LEVEL) -> Summits:
        """See `worst.summits`."""
        found = self.table(damper.inertia)
        return summits(self.system, found, damper, self.scale, share, tolerance)

    @property
    def logarithms(self) -> FloatArray:
        """Bounds (v, 2) of the variables."""
        return np.log(self.bounds[self.moving])


def survey(problem: Problem, limits: Limits, speeds: int = 161) -> Survey:
    """Raises NumericalFailure for a problem without meaning; `speeds` only guides the search."""
    check(problem, limits)
    system = system_of(problem)
    bounds = limits.bounds
    weight = np.asarray(problem.weight, dtype=float)
    scale = np.append(
        np.where(weight > 0.0, 1.0, np.inf), [limits.heat, limits.travel, limits.travel]
    )
    return Survey(
        system, limits, bounds, np.flatnonzero(bounds[:, 1] > bounds[:, 0]),
        np.linspace(*problem.speed, speeds), scale, {},
    )  # fmt: skip


def worst_section(seen: Summits, sections: int) -> float:
    """Largest weighted half range among summits."""
    return float(np.max(seen.value[seen.row < sections]))

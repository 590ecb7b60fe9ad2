"""What is made small with several absorbers, its limits, and all peaks at a point with slopes."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.response.absorber.model import transfer_of
from vibecalc.response.absorber.several import Several
from vibecalc.response.absorber.several_peaks import several_peaks
from vibecalc.response.absorber.several_slopes import several_slopes

#: peaks lower than the largest by this share of it are left out
_LOW = 1e-3


class Travel(NamedTuple):
    """The motion of `absorber` (from 1) against what it hangs on may not exceed `limit`."""

    absorber: int
    limit: float


class Problem(NamedTuple):
    """min over k (n) and z (n) within bounds of the largest |H| over frequency.

    `lower`, `upper` (q,): k first, then z; infinite for none. `travel`: largest spring travels,
    in the unit in which displacement is measured (see `transfer_of`). With `shares` the unknowns
    go on with the shares of the first n - 1 masses in the sum of `mass_ratio`. Absorbers marked in
    `locked` are fastened rigidly; their k and z count for nothing.
    """

    primary_damping: float
    mass_ratio: np.ndarray
    parent: tuple[int, ...]
    excitation: str
    response: str
    lower: np.ndarray
    upper: np.ndarray
    travel: tuple[Travel, ...] = ()
    absorber: int = 1
    shares: bool = False
    locked: tuple[bool, ...] = ()

    def system(self, ratios: np.ndarray) -> Several:
        """The system at a point (q,)."""
        count = len(self.mass_ratio)
        k, z = ratios[:count], ratios[count : 2 * count]
        if any(self.locked):
            k = np.where(self.locked, np.inf, k)
        return Several(self.primary_damping, self.masses(ratios), k, z, self.parent)

    def masses(self, ratios: np.ndarray) -> np.ndarray:
        """Mass ratios (n,) at a point. Raises NumericalFailure where the last is used up."""
        if not self.shares:
            return self.mass_ratio
        part = ratios[2 * len(self.mass_ratio) :]
        if np.sum(part) >= 1.0:
            raise NumericalFailure("the shares of the masses leave nothing for the last")
        return np.asarray(np.sum(self.mass_ratio) * np.append(part, 1.0 - np.sum(part)))

    def onto(self) -> np.ndarray:
        """(q, 3 n + 1): which ratios, in the order of `several_slopes`, each unknown moves."""
        count = len(self.mass_ratio)
        table = np.eye(3 * count + 1)[: 2 * count]
        if not self.shares:
            return table
        masses = np.eye(3 * count + 1)[2 * count + 1 :]
        return np.concatenate([table, np.sum(self.mass_ratio) * (masses[:-1] - masses[-1])])


class Rows(NamedTuple):
    """Levels log |H|^2 (r,) with slopes (r, q) and second derivatives; kind 0 is the objective.

    Kind j > 0 is travel limit j, its level taken against the limit. An end of the frequency range
    (x zero or infinite) has no slope. `shoulder` rows are points of a curve beside its peaks where
    a peak may arise; their frequency stays. `frequency` (r,).
    """

    level: np.ndarray
    slope: np.ndarray
    bend: np.ndarray
    kind: np.ndarray
    frequency: np.ndarray
    error: np.ndarray
    shoulder: np.ndarray

    @property
    def moves(self) -> np.ndarray:
        """Peaks, which a change of ratios moves, against the ends of the frequency range."""
        return np.asarray((self.frequency > 0.0) & np.isfinite(self.frequency))

    def some(self, chosen: np.ndarray) -> "Rows":
        """The chosen rows."""
        return Rows(*(part[chosen] for part in self))


def rows_at(problem: Problem, ratios: np.ndarray) -> Rows:
    """Every peak that counts, of the response and of each limited travel.

    Raises NumericalFailure where a peak is infinite.
    """
    parts = [_of(problem, ratios, problem.response, problem.absorber, 1.0, 0)]
    for number, travel in enumerate(problem.travel, start=1):
        parts.append(
            _of(problem, ratios, "relative_displacement", travel.absorber, travel.limit, number)
        )
    return Rows(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _of(
    problem: Problem, ratios: np.ndarray, response: str, absorber: int, unit: float, kind: int
) -> Rows:
    system, size = problem.system(ratios), len(ratios)
    found = several_peaks(system, problem.excitation, response, absorber)
    if not np.isfinite(found.largest):
        raise NumericalFailure(
            f"the largest {response} under {problem.excitation!r} is infinite: it grows with "
            "frequency without bound"
        )
    transfer = transfer_of(problem.excitation, response)
    kept = found.magnitude > _LOW * found.largest
    x, beside = found.frequency[kept], found.shoulder
    top = several_slopes(system, x, transfer, absorber)
    side = several_slopes(system, beside, transfer, absorber, follow=False)
    ends = [
        (height, where)
        for height, where in ((found.at_zero, 0.0), (found.at_infinity, np.inf))
        if height > _LOW * found.largest
    ]
    flat = len(ends)
    level = np.concatenate(
        [2.0 * np.log(found.magnitude[kept]), side.level, [2.0 * np.log(h) for h, _ in ends]]
    )
    onto = problem.onto()
    slope = np.concatenate([top.first @ onto.T, side.first @ onto.T, np.zeros((flat, size))])
    bend = np.concatenate(
        [onto @ top.second @ onto.T, onto @ side.second @ onto.T, np.zeros((flat, size, size))]
    )
    doubt = 2.0 * found.error[kept] / found.magnitude[kept]
    count = len(level)
    return Rows(
        level - 2.0 * np.log(unit), slope, bend, np.full(count, kind),
        np.concatenate([x, beside, [place for _, place in ends]]),
        np.concatenate([doubt, np.full(count - len(x), 1e-15)]),
        (np.arange(count) >= len(x)) & (np.arange(count) < len(x) + len(beside)),
    )  # fmt: skip


def largest(rows: Rows) -> tuple[float, float]:
    """Level of the objective, and by how much the worst travel exceeds its limit (0 if none)."""
    over = float(np.max(rows.level[rows.kind > 0], initial=0.0))
    return float(np.max(rows.level[rows.kind == 0])), max(over, 0.0)

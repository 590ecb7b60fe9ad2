"""Machines within tolerances of a candidate: mean and deviation of its results.

All candidates are held against the same machines, drawn once: points of a scrambled Sobol sequence,
turned into deviations of the keys that scatter. What differs between two candidates is then what
they are and not what was drawn, and mean plus deviations stays as smooth as the results are.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.case.raw import field_unit, parse_key
from vibecalc.core.case.search_checks import share_or_size
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Axis
from vibecalc.core.results.select import Side, Where, select, uncertainty, worst
from vibecalc.core.run.columns import Column
from vibecalc.core.study.sweep.at_once import Part, unsupported
from vibecalc.core.study.sweep.sampling import deviation, drawn, mean

if TYPE_CHECKING:
    from vibecalc.core.case.study_tables import Robust
    from vibecalc.core.results.record import Record
    from vibecalc.schema import Case

#: between the seeds of two of them
_STRIDE = 1_000_003

# ----------------------------------------------------------------------------
# The machines that are drawn, as deviations of keys.
# ----------------------------------------------------------------------------


class Scatter(NamedTuple):
    """Keys that scatter, and what is added to them in each machine: `steps` (samples, keys).

    A step is in SI, or a share of the value where `shares` (keys,) says so.
    """

    keys: tuple[str, ...]
    steps: np.ndarray
    shares: np.ndarray
    sigmas: float

    def values(self, written: Mapping[str, float]) -> dict[str, np.ndarray]:
        """The values (samples,) of each key in the machines about a candidate."""
        return {
            key: written[key] + self.steps[:, i] * (written[key] if self.shares[i] else 1.0)
            for i, key in enumerate(self.keys)
        }


def scatter_of(robust: "Robust", draw: int = 0) -> Scatter:
    """The machines of a case; another `draw` has others of the same distribution."""
    from scipy.special import ndtri

    count = robust.samples
    keys = tuple(one.key for one in robust.tolerances)
    seed = (robust.seed + draw * _STRIDE) % 2**31
    unit = drawn("sobol", np.arange(count), len(keys), count, seed)
    steps, shares = np.empty_like(unit), np.zeros(len(keys), dtype=bool)
    for i, one in enumerate(robust.tolerances):
        evenly = one.half_width is not None
        given = one.half_width if one.half_width is not None else one.deviation
        size, shares[i] = share_or_size(given or 0.0, field_unit(one.key))
        steps[:, i] = size * (2.0 * unit[:, i] - 1.0 if evenly else ndtri(unit[:, i]))
    return Scatter(keys, steps, shares, robust.sigmas)


def by_arrays(case: "Case", keys: tuple[str, ...], wanted: frozenset[str]) -> bool:
    """Whether all machines are computed at once."""
    return unsupported(case, [parse_key(key) for key in keys], wanted) is None


# ----------------------------------------------------------------------------
# Results of all machines, the worst entry of each, and what mean and deviation they have.
# ----------------------------------------------------------------------------


class Machines(NamedTuple):
    """Some results of all machines about a candidate, as columns and as single runs."""

    size: int
    parts: list[Part]
    alone: list[tuple[int, "Record"]]

    def moments(self, path: str, where: Where, side: Side) -> tuple[float, float, float]:
        """Mean and deviation of the worst entries of a result, one for each machine, and the
        numerical error of both together."""
        values, errors = np.empty(self.size), np.empty(self.size)
        for part in self.parts:
            found = _worst(path, part.columns[path], where, side)
            values[part.places], errors[part.places] = found
        for place, record in self.alone:
            values[place], _ = worst(record[path], where, side)
            errors[place] = uncertainty(record[path], where)
        middle, apart = mean(values, errors), deviation(values, errors)
        return float(middle.value), float(apart.value), float(middle.error + apart.error)


def _worst(path: str, column: Column, where: Where, side: str) -> tuple[np.ndarray, np.ndarray]:
    count = len(column.values)
    axes = (Axis(name="sample", values=np.arange(count)), *column.axes)
    whole = CATALOGUE[path].quantity(column.values, axes=axes)
    values = np.asarray(select(whole, where).values)
    rows = (np.abs(values) if np.iscomplexobj(values) else values).reshape(count, -1)
    chosen = rows.max(axis=1) if side == "max" else rows.min(axis=1)
    return chosen, column.errors + select(whole, where).curving

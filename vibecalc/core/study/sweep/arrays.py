"""Points of a sweep by array calls, and the few that need it by single runs."""

from collections.abc import Sequence

import numpy as np

from vibecalc.array_path import Part, compute
from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.raw import parse_key
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.layout import DONE
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.run.columns import Column
from vibecalc.core.study.sweep.blocks import Block, BlockQuantity, joined_axes, make_block, padded
from vibecalc.core.study.sweep.design import Design
from vibecalc.core.study.sweep.evaluate import Evaluator, Quantities
from vibecalc.numerics.rounding import IntArray


class ArrayEvaluator(Evaluator):
    """From point numbers to results, where `pipeline.arrays.support` has nothing against it.

    A point that fails, or may fail, is run alone: its status and message are those of that run.
    """

    def __init__(self, loaded: LoadedCase, design: Design, keep: Sequence[str]):
        super().__init__(loaded, design, keep)
        self._paths = {key: parse_key(key) for key in design.keys}

    def run_points(self, indices: np.ndarray) -> Block:
        """As `Evaluator.run_points`."""
        numbers = np.asarray(indices, dtype=np.int64)
        settings = self._design.columns(numbers)
        varied = {self._paths[key]: values for key, values in settings.items()}
        count, keep = len(numbers), frozenset(self._keep)
        parts, left = compute(self._loaded.case, varied, count, keep)
        alone = [
            self.run_point({key: values[place].item() for key, values in settings.items()})
            for place in left
        ]
        status = np.full(count, DONE, dtype=np.int8)
        message = [""] * count
        for place, (code, text, _) in zip(left, alone, strict=True):
            status[place], message[place] = code, text
        if not parts:
            return make_block(numbers, status, message, [one[2] for one in alone], self._keep)
        single = [one[2] for one in alone]
        results = {path: _joined(path, parts, left, single, count) for path in self._keep}
        return Block(numbers, status, tuple(message), results)


def _joined(
    path: str, parts: Sequence[Part], left: IntArray, alone: Sequence[Quantities], count: int
) -> BlockQuantity:
    """One quantity of all parts and single runs; a point without it is NaN."""
    single = [
        (place, results[path])
        for place, results in zip(left, alone, strict=True)
        if path in results
    ]
    rows: list[tuple[IntArray, Column]] = [(part.places, part.columns[path]) for part in parts]
    rows += [(np.array([place]), _as_column(quantity)) for place, quantity in single]
    axes: tuple[Axis, ...] = rows[0][1].axes
    for _, column in rows:
        joined = joined_axes(axes, column.axes)
        if isinstance(joined, str):
            raise ValueError(f"{path}: {joined}")
        axes = joined
    shape = tuple(len(axis.values) for axis in axes)
    dtype = np.result_type(*(column.values.dtype for _, column in rows))
    values, errors = np.full((count, *shape), np.nan, dtype=dtype), np.full(count, np.nan)
    for places, column in rows:
        values[places] = padded(column.values, (len(places), *shape))
        errors[places] = column.errors
    entry = CATALOGUE[path]
    return BlockQuantity(values, errors, None, axes, entry.unit, entry.long_name, entry.amplitude)


def _as_column(quantity: Quantity) -> Column:
    return Column(
        np.asarray(quantity.values)[None], np.array([quantity.error_estimate]), quantity.axes
    )

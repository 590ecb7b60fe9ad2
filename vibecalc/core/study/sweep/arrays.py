"""Points of a sweep by array calls, and the few that need it by single runs."""

from collections.abc import Sequence

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.raw import parse_key
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.layout import DONE
from vibecalc.core.study.sweep.at_once import Part, compute
from vibecalc.core.study.sweep.blocks import (
    Block,
    BlockQuantity,
    at_one_point,
    laid_out,
    make_block,
)
from vibecalc.core.study.sweep.design import Design
from vibecalc.core.study.sweep.evaluate import Evaluator, Quantities
from vibecalc.numerics.rounding import IntArray

# ----------------------------------------------------------------------------
# Points of a sweep: their numbers from the design, their results as a block.
# ----------------------------------------------------------------------------


class ArrayEvaluator(Evaluator):
    """From point numbers to results, where `unsupported` has nothing against it.

    A point that fails, or may fail, is run alone: its status and message are those of that run.
    """

    def __init__(self, loaded: LoadedCase, design: Design, keep: Sequence[str]):
        super().__init__(loaded, design, keep)
        self._paths = {key: parse_key(key) for key in design.keys}

    def run_points(self, indices: np.ndarray) -> Block:
        """As `Evaluator.run_points`."""
        numbers = np.asarray(indices, dtype=np.int64)
        settings = self._design.columns(numbers)
        varied = {self._paths[key]: np.asarray(v, dtype=float) for key, v in settings.items()}
        count, keep = len(numbers), frozenset(self._keep)
        parts, left = compute(self._loaded.case, varied, count, keep, cache=self._cache)
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
        results = {path: _joined(path, parts, left, single, numbers) for path in self._keep}
        return Block(numbers, status, tuple(message), results)


def _joined(
    path: str,
    parts: Sequence[Part],
    left: IntArray,
    alone: Sequence[Quantities],
    numbers: np.ndarray,
) -> BlockQuantity:
    """One quantity of all parts and single runs; a point without it is NaN."""
    entry = CATALOGUE[path]
    told = (entry.unit, entry.long_name, entry.amplitude)
    columns = [(part.places, part.columns[path]) for part in parts]
    pieces = [(places, BlockQuantity(one.values, one.errors, None, one.axes, *told))
              for places, one in columns]  # fmt: skip
    pieces += [
        (np.array([place]), at_one_point(results[path]))
        for place, results in zip(left, alone, strict=True)
        if path in results
    ]
    whole = laid_out(pieces, numbers)
    if isinstance(whole, str):
        raise ValueError(f"{path}: {whole}")
    return whole

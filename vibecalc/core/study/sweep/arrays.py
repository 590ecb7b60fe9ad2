"""Points of a sweep by array calls, and the few that need it by single runs."""

from collections.abc import Sequence

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.raw import parse_key
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.layout import DONE
from vibecalc.core.study.sweep.at_once import compute
from vibecalc.core.study.sweep.blocks import Block, columns_of, combined
from vibecalc.core.study.sweep.design import Design
from vibecalc.core.study.sweep.evaluate import Evaluator


class ArrayEvaluator(Evaluator):
    """From point numbers to results, where `unsupported` has nothing against it.

    A point that fails, or may fail, is run alone: its status and message are those of that run.
    """

    def __init__(self, loaded: LoadedCase, design: Design, keep: Sequence[str]):
        super().__init__(loaded, design, keep)
        self._paths = {key: parse_key(key) for key in design.keys}

    def __call__(self, indices: np.ndarray) -> Block:
        """As an `Evaluator`."""
        numbers = np.asarray(indices, dtype=np.int64)
        columns = self._design.columns(numbers)
        varied = {self._paths[key]: np.asarray(v, dtype=float) for key, v in columns.items()}
        keep = frozenset(self._keep)
        parts, left = compute(self._loaded.case, varied, len(numbers), keep, cache=self._cache)
        blocks = [
            Block(
                numbers[places],
                np.full(len(places), DONE, dtype=np.int8),
                ("",) * len(places),
                {
                    name: column
                    for path in self._keep
                    for name, column in zip(columns_of(path), found[path][:2], strict=False)
                },
                {path: CATALOGUE[path].quantity([], axes=found[path].axes) for path in self._keep},
            )
            for places, found in parts
        ]
        some = {key: column[left] for key, column in columns.items()}
        return combined([*blocks, *self.one_by_one(numbers[left], some)], numbers, self._keep)

"""Points of a sweep: each a case that is checked and run, or many of them by array calls."""

import traceback
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.case.load import LoadedCase, resolve, validate
from vibecalc.core.case.raw import NOT_COMPUTED, case_at, parse_key
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.layout import BUG, DONE, FAILED, REFUSED
from vibecalc.core.results.record import Quantity
from vibecalc.core.results.sweep_file import columns_of
from vibecalc.core.run.run import StageCache, checked_case, run_case
from vibecalc.core.study.sweep.at_once import compute
from vibecalc.core.study.sweep.blocks import Block, combined, one_point
from vibecalc.core.study.sweep.design import Design
from vibecalc.errors import CaseError, NumericalFailure, Problem, UsageError, dotted

Quantities = Mapping[str, Quantity]

#: axis of results -> key of a case that is its one entry, unless the case lists several
REPEATS = {"clearance": "machine.joints.wrist_pin.clearance"}


class Evaluator:
    """From point numbers to results; what one point shares with another is computed once.

    A case with [optimisation] is optimised at each point. Limits are not examined: a limit that
    is broken is a result.
    """

    def __init__(self, loaded: LoadedCase, design: Design, keep: Sequence[str]):
        self._loaded, self._design = loaded, design
        self._keep = tuple(keep)
        self._varied = frozenset(design.keys)
        self._cache = StageCache()
        self._base = loaded.base(design.keys)

    def __call__(self, indices: np.ndarray) -> Block:
        """Results, or why there are none, at points (n,) in ascending order; never raises for one.

        The statuses are those of `vibecalc.core.results.layout`: done, input refused, numerical
        failure, or an error in the program, whose message is its traceback.
        """
        return combined(self.one_by_one(indices), indices, self._keep)

    def one_by_one(self, indices: np.ndarray) -> list[Block]:
        """The points one by one."""
        rows = self._design.settings_of(indices)
        return [
            one_point(number, *self.run_point(settings))
            for number, settings in zip(indices.tolist(), rows, strict=True)
        ]

    def run_point(self, settings: Mapping[str, Any]) -> tuple[int, str, Quantities]:
        """Status, message and the kept results with some keys of the case set."""
        try:
            return DONE, "", self._computed(settings)
        except CaseError as error:
            return REFUSED, refusal(error.problems), {}
        except UsageError as error:
            return REFUSED, str(error), {}
        except NumericalFailure as failure:
            return FAILED, str(failure), {}
        except Exception:
            return BUG, traceback.format_exc(), {}

    def _computed(self, settings: Mapping[str, Any]) -> Quantities:
        if self._loaded.case.optimisation is not None:
            return self._optimised(settings)
        case = checked_case(self._base, settings, self._cache)
        record = run_case(case, wanted=frozenset(self._keep), cache=self._cache)
        return {path: self._stackable(record[path]) for path in self._keep if path in record}

    def _stackable(self, quantity: Quantity) -> Quantity:
        """A result without the axis of one entry that repeats a key of this sweep."""
        repeated = [
            place
            for place, axis in enumerate(quantity.axes)
            if len(axis.values) == 1 and REPEATS.get(axis.name) in self._varied
        ]
        if not repeated:
            return quantity
        axes = tuple(axis for place, axis in enumerate(quantity.axes) if place not in repeated)
        return replace(quantity, values=quantity.values.squeeze(tuple(repeated)), axes=axes)

    def _optimised(self, settings: Mapping[str, Any]) -> Quantities:
        from vibecalc.core.study.execute import physics_problems
        from vibecalc.core.study.optimise import optimise

        without = [name for name in NOT_COMPUTED if name not in ("optimisation", "limit")]
        case = validate(case_at(self._base, settings, without))
        # the case of one point has no text of its own
        bare: dict[str, Any] = {
            "text": "",
            "overrides": (),
            "origins": {},
            "files": {},
            "freed": None,
        }
        loaded = replace(self._loaded, case=case, resolved=resolve(case), **bare)
        problems = physics_problems(loaded)
        if problems:
            raise CaseError(problems)
        record = optimise(loaded, timings={})
        if record.failure:
            raise NumericalFailure("; ".join((record.failure, *record.warnings[:1])))
        return {path: record[path] for path in self._keep if path in record}


class ArrayEvaluator(Evaluator):
    """The same where `unsupported` has nothing against it.

    A point that fails, or may fail, is run alone: its status and message are those of that run.
    """

    def __call__(self, indices: np.ndarray) -> Block:
        """As an `Evaluator`."""
        values = self._design.value_of(indices).T
        varied = dict(zip(map(parse_key, self._design.keys), values, strict=True))
        keep = frozenset(self._keep)
        parts, left = compute(self._loaded.case, varied, len(indices), keep, cache=self._cache)
        blocks = [
            Block(
                indices[places],
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
        return combined([*blocks, *self.one_by_one(indices[left])], indices, self._keep)


def refusal(problems: Sequence[Problem]) -> str:
    """All problems of one input in one line."""
    parts = (
        (
            f"{dotted(one.path)}: {one.message}" if one.path else one.message,
            one.found and f"found {one.found}",
            one.allowed and f"allowed: {one.allowed}",
        )
        for one in problems
    )
    return "; ".join(", ".join(filter(None, part)) for part in parts)

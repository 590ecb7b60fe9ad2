"""Files of parts of one sweep put together in one file."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from vibecalc.errors import UsageError
from vibecalc.results.files import fresh_output
from vibecalc.results.sweep_file import Failures, StackedQuantity, SweepResult, open_sweep
from vibecalc.results.sweep_layout import NOT_RUN
from vibecalc.study.sweep.assemble import Assembled, assembled
from vibecalc.study.sweep.block import Block, BlockQuantity
from vibecalc.study.sweep.joining import join
from vibecalc.study.sweep.stacked_file import write_stacked
from vibecalc.study.sweep.stacking import look_through

_AT_ONCE = 1 << 13  # points
_ENTRIES = 1 << 20  # of all quantities of these points


def merge(
    parts: Sequence[Path | str],
    output: Path | str,
    provenance: Mapping[str, str | int | float] | None = None,
) -> Assembled:
    """Write one file with the points of all parts, and say which points none of them has.

    `provenance` replaces that of the first part. Raises UsageError for parts of different sweeps
    and for a point that two parts have with different results, ResultError for a file that cannot
    be read; an old output is then as it was.
    """
    if not parts:
        raise UsageError("there are no parts to merge")
    target = fresh_output(output)
    with ExitStack() as stack:
        opened = [stack.enter_context(open_sweep(part)) for part in parts]
        for other in opened[1:]:
            _check_same_sweep(opened[0], other)
        head = opened[0].head
        if provenance is not None:
            result = replace(head.result, provenance=dict(provenance), timings={})
            head = replace(head, result=result)
        whole = _Parts(opened)
        stacking = look_through(whole.blocks(), head.kept, opened[0].count)
        write_stacked(target, head, stacking, whole.blocks())
    return assembled(target, stacking)


def _check_same_sweep(first: SweepResult, other: SweepResult) -> None:
    one, two = first.head, other.head
    if one.identity == two.identity and one.shape == two.shape:
        return
    pair = f"{first.path} and {other.path} are not parts of one sweep"
    if one.result.version != two.result.version:
        why = f"vibecalc {one.result.version} wrote one, {two.result.version} the other"
    elif one.base != two.base:
        why = "their cases are not the same"
    elif one.design != two.design:
        why = "they have other points"
    elif set(one.kept) != set(two.kept):
        why = "they keep other quantities"
    else:
        why = "their cases are not the same"
    raise UsageError(f"{pair}: {why}")


class _Parts:
    """Open parts of one sweep, read together a few points at a time."""

    def __init__(self, parts: Sequence[SweepResult]) -> None:
        self.parts = parts
        self.failures: list[Failures] = [part.failures() for part in parts]
        self.left_out: dict[str, str] = {}
        for part in parts:
            self.left_out = {**part.left_out, **self.left_out}
        entries = max(
            sum(
                math.prod(len(axis.values) for axis in one.axes) for one in part.quantities.values()
            )
            for part in parts
        )
        self.step = max(1, min(_AT_ONCE, _ENTRIES // max(entries, 1)))

    def blocks(self) -> Iterator[Block]:
        """All points that a part has, ascending; UsageError where two parts do not agree."""
        count = self.parts[0].count
        for first in range(0, count, self.step):
            last = min(first + self.step, count)
            found = [
                (part, number)
                for number, part in enumerate(self.parts)
                if np.any(part.status_of(first, last) != NOT_RUN)
            ]
            if found:
                whole = self._block(*found[0], first, last)
                for part, number in found[1:]:
                    whole = join(whole, self._block(part, number, first, last), part.path)
                yield whole

    def _block(self, part: SweepResult, number: int, first: int, last: int) -> Block:
        failures = self.failures[number]
        message = [""] * (last - first)
        low, high = np.searchsorted(failures.points, [first, last])
        for row in range(low, high):
            message[failures.points[row] - first] = failures.texts[failures.causes[row]]
        return Block(
            indices=np.arange(first, last),
            status=part.status_of(first, last),
            message=tuple(message),
            quantities={
                path: _stacked(quantity, first, last)
                for path, quantity in part.quantities.items()
                if path not in self.left_out
            },
            left_out=self.left_out,
        )


def _stacked(quantity: StackedQuantity, first: int, last: int) -> BlockQuantity:
    return BlockQuantity(
        values=quantity.points(first, last),
        errors=quantity.errors_of(first, last),
        standard_errors=quantity.standard_errors_of(first, last),
        axes=quantity.axes,
        unit=quantity.unit,
        long_name=quantity.long_name,
        amplitude=quantity.amplitude,
    )

"""First look at the blocks of a sweep: which quantities can be stacked, and what went wrong."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from vibecalc.results.record import Axis
from vibecalc.results.sweep_layout import DONE, NOT_RUN
from vibecalc.study.sweep.block import Block, BlockQuantity, joined_axes

MOST_CAUSES = 10_000
_LONGEST_CAUSE = 4_000  # characters
_OTHER_CAUSE = "another cause: a file keeps the words of the first ten thousand only"


@dataclass(kw_only=True)
class Stack:
    """What all blocks together say of one quantity; errors are the largest of all points."""

    axes: tuple[Axis, ...]
    unit: str
    long_name: str
    amplitude: str | None
    is_complex: bool = False
    error: float = 0.0
    standard_error: float | None = None


@dataclass(kw_only=True)
class Stacking:
    """How a sweep is stacked.

    `causes` number the words about points without a result, `counts` says how many points have
    which status, `missing` the points (first, last) that were not run.
    """

    stacks: dict[str, Stack] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    causes: dict[str, int] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    missing: list[tuple[int, int]] = field(default_factory=list)
    seen: int = 0

    @property
    def failed(self) -> int:
        """Points that were run and have no result."""
        return sum(many for status, many in self.counts.items() if status not in (NOT_RUN, DONE))

    def cause(self, message: str) -> int:
        """Number of the words about a point."""
        return self.causes.get(_kept_words(message), self.causes.get(_OTHER_CAUSE, 0))


def look_through(blocks: Iterable[Block], kept: Iterable[str], count: int) -> Stacking:
    """Go through all blocks of a sweep of `count` points, ascending, one at a time.

    Quantities come in the order of `kept`; those that no point has are not among them.
    """
    stacking = Stacking()
    found: dict[str, Stack] = {}
    for block in blocks:
        stacking.left_out = {**block.left_out, **stacking.left_out}
        for path, quantity in block.quantities.items():
            if path in stacking.left_out:
                continue
            reason = _take(found, path, quantity)
            if reason:
                stacking.left_out[path] = reason
        _count(stacking, block)
    _miss(stacking, stacking.seen, count)
    stacking.stacks = {
        path: found[path] for path in kept if path in found and path not in stacking.left_out
    }
    return stacking


def failures(block: Block) -> np.ndarray:
    """Rows of a block that were run and have no result."""
    return np.flatnonzero((block.status != DONE) & (block.status != NOT_RUN))


def _count(stacking: Stacking, block: Block) -> None:
    first = int(block.indices[0])
    _miss(stacking, stacking.seen, first)
    for row in np.flatnonzero(block.status == NOT_RUN):
        _miss(stacking, first + int(row), first + int(row) + 1)
    stacking.seen = int(block.indices[-1]) + 1
    for status in np.unique(block.status[block.status != NOT_RUN]):
        many = int(np.count_nonzero(block.status == status))
        stacking.counts[int(status)] = stacking.counts.get(int(status), 0) + many
    for row in failures(block):
        words = _kept_words(block.message[row])
        if words not in stacking.causes:
            words = words if len(stacking.causes) < MOST_CAUSES else _OTHER_CAUSE
            stacking.causes.setdefault(words, len(stacking.causes))


def _miss(stacking: Stacking, first: int, after: int) -> None:
    """Note that the points from `first` up to `after` were not run."""
    if first >= after:
        return
    stacking.counts[NOT_RUN] = stacking.counts.get(NOT_RUN, 0) + after - first
    if stacking.missing and stacking.missing[-1][1] == first - 1:
        first, _ = stacking.missing.pop()
    stacking.missing.append((first, after - 1))


def _take(found: dict[str, Stack], path: str, quantity: BlockQuantity) -> str:
    """Join what a block has of a quantity to what is known; the reason if that cannot be."""
    if path not in found:
        found[path] = Stack(
            axes=quantity.axes,
            unit=quantity.unit,
            long_name=quantity.long_name,
            amplitude=quantity.amplitude,
        )
    known = found[path]
    axes = joined_axes(known.axes, quantity.axes)
    if isinstance(axes, str):
        return axes
    if (known.unit, known.amplitude) != (quantity.unit, quantity.amplitude):
        return "its unit or kind of amplitude is not the same at all points"
    known.axes = axes
    known.is_complex |= np.iscomplexobj(quantity.values)
    known.error = _largest(known.error, quantity.errors)
    if quantity.standard_errors is not None:
        known.standard_error = _largest(known.standard_error or 0.0, quantity.standard_errors)
    return ""


def _largest(known: float, errors: np.ndarray) -> float:
    """Largest error; points without the quantity are NaN."""
    return float(np.max(errors, initial=known, where=~np.isnan(errors)))


def _kept_words(message: str) -> str:
    """What a file can hold of a message."""
    plain = message.replace("\0", "").encode("utf-8", "replace").decode()
    cut = len(plain) > _LONGEST_CAUSE
    return f"{plain[:_LONGEST_CAUSE]} ..." if cut else plain or "no reason is known"

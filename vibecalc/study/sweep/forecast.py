"""What a sweep will be, before it is: points tried, shapes, time and size."""

import math
import time
from dataclasses import dataclass

import numpy as np

from vibecalc.results.sweep_layout import DONE
from vibecalc.study.sweep.options import processors
from vibecalc.study.sweep.prepare import Prepared

_PATIENCE = 2.0  # seconds for points that are only tried
_TRIED = 5


@dataclass(frozen=True, kw_only=True)
class Kept:
    """A kept quantity: its own axes, each with its length; no axes are known if no point has it."""

    path: str
    unit: str
    axes: tuple[tuple[str, int], ...] | None
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """Size, kept quantities, and time (s, with `jobs` processes) and size (bytes) as estimated.

    `failures` are the words of those of the `tried` points that came to nothing.
    """

    kept: tuple[Kept, ...]
    tried: int
    failures: tuple[str, ...]
    jobs: int
    seconds: float
    size: int


def forecast(prepared: Prepared, jobs: int | None) -> Forecast:
    """Compute a few points, spread over the sweep, and multiply."""
    design = prepared.design
    evaluate = prepared.start()()
    numbers = np.unique(np.linspace(0, design.count - 1, _TRIED).astype(np.int64))
    evaluate(numbers[:1])  # imports, and what all points share
    many = prepared.strategy.kind == "array"
    if many:
        numbers = np.arange(min(design.count, prepared.strategy.chunk_size))
    started = time.perf_counter()
    blocks, tried = [], 0
    for some in [numbers] if many else np.split(numbers, len(numbers)):
        blocks.append(evaluate(some))
        tried += len(some)
        if time.perf_counter() - started > _PATIENCE:
            break
    each = (time.perf_counter() - started) / tried
    busy = jobs or (1 if prepared.is_short else processors())
    kept = []
    size = 1  # the status
    for path in prepared.keep:
        reasons = [block.left_out[path] for block in blocks if path in block.left_out]
        found = [block.quantities[path] for block in blocks if path in block.quantities]
        if reasons or not found:
            reason = reasons[0] if reasons else "no point that was tried has it"
            kept.append(Kept(path=path, unit="", axes=None, reason=reason))
            continue
        largest = max(found, key=lambda one: one.values[0].size)
        axes = tuple((axis.name, len(axis.values)) for axis in largest.axes)
        kept.append(Kept(path=path, unit=largest.unit, axes=axes))
        own = math.prod(length for _, length in axes)
        size += own * largest.values.itemsize + (16 if largest.standard_errors is not None else 8)
    failures = [
        words
        for block in blocks
        for status, words in zip(block.status, block.message, strict=True)
        if status != DONE
    ]
    return Forecast(
        kept=tuple(kept),
        tried=tried,
        failures=tuple(failures),
        jobs=busy,
        seconds=each * design.count / busy,
        size=size * design.count,
    )

"""What `sweep` says before it starts and after it ends, in words and as plain objects."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.sweep.failures import causes, example
from vibecalc.report.sweep.limits import judge
from vibecalc.report.sweep.view import SweepView
from vibecalc.report.tables import pairs
from vibecalc.results.sweep_layout import STATUS_WORDS

if TYPE_CHECKING:
    from vibecalc.study.sweep.forecast import Forecast, Kept
    from vibecalc.study.sweep.prepare import Prepared

_UNITS = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))


def forecast_object(prepared: "Prepared", found: "Forecast", chunks: int) -> dict[str, Any]:
    """What `--dry-run --json` prints; seconds and bytes are estimates."""
    design, strategy = prepared.design, prepared.strategy
    return {
        "case": prepared.loaded.name,
        "points": design.count,
        "shape": list(design.shape),
        "sampling": design.sampling,
        "axes": [{"name": axis.name, "keys": list(axis.keys)} for axis in design.axes],
        "strategy": strategy.kind,
        "reason": strategy.reason,
        "chunks": chunks,
        "chunk_size": strategy.chunk_size,
        "kept": [
            {
                "quantity": one.path,
                "unit": one.unit,
                "axes": None if one.axes is None else dict(one.axes),
                "reason": one.reason or None,
            }
            for one in found.kept
        ],
        "tried": found.tried,
        "failed": len(found.failures),
        "processes": found.jobs,
        "seconds": found.seconds,
        "bytes": found.size,
        "identity": prepared.identity.sweep,
    }


def render_forecast(prepared: "Prepared", found: "Forecast", chunks: int, output: Path) -> str:
    """The same as text."""
    design, strategy = prepared.design, prepared.strategy
    sizes = " x ".join(str(size) for size in design.shape)
    shape = f", a grid of {sizes}" if design.sampling == "grid" else f", {design.sampling} sampling"
    tried = (
        f"from {_count(found.tried, 'point')} that {'was' if found.tried == 1 else 'were'} tried"
    )
    size = f"{strategy.chunk_size} points each" if chunks > 1 else "all points"
    rows = [
        ("points", f"{design.count}{shape}"),
        ("strategy", f"{strategy.kind}: {strategy.reason}"),
        ("chunks", f"{chunks}, {size}"),
        ("time", f"about {duration(found.seconds)} with {_count(found.jobs, 'process', 'es')}, "
                 f"{tried}"),
        ("file", f"about {_bytes(found.size)}, {output}"),
    ]  # fmt: skip
    if found.failures:
        rows.append(("failed", f"{len(found.failures)} of those tried: {found.failures[0]}"))
    lines = [f"{prepared.loaded.path}: {prepared.loaded.case.title}", *pairs(rows, 10), "", "kept"]
    lines += pairs([(one.path, _shape(one)) for one in found.kept], 48)
    return "\n".join([*lines, "", "nothing was written"])


def outcome_object(
    sweep: SweepView, output: Path, counts: Mapping[int, int], taken_up: int, seconds: float
) -> dict[str, Any]:
    """What `--json` prints of a finished sweep."""
    limits, _ = judge(sweep)
    return {
        "case": sweep.name,
        "result": str(output),
        "points": sweep.count,
        "shape": list(sweep.shape),
        "statuses": {STATUS_WORDS[status]: many for status, many in sorted(counts.items())},
        "taken_up": taken_up,
        "failures": [
            {
                "status": STATUS_WORDS[cause.status],
                "message": cause.words,
                "points": int(cause.points.size),
                "example": int(cause.points[0]),
            }
            for cause in causes(sweep)
        ],
        "quantities": {
            path: {"unit": one.unit, "axes": [axis.name for axis in one.axes]}
            for path, one in sweep.kept.items()
        },
        "left_out": dict(sweep.left_out),
        "limits": [
            {
                "quantity": limit.quantity,
                "where": dict(limit.where),
                limit.side: limit.bound,
                "unit": limit.unit,
                "kept": int(np.count_nonzero(limit.kept & sweep.done)),
                "broken": int(np.count_nonzero(limit.broken)),
                "undecided": int(np.count_nonzero(sweep.done & ~limit.kept & ~limit.broken)),
            }
            for limit in limits
        ],
        "seconds": seconds,
    }


def failure_words(sweep: SweepView, most: int = 5) -> list[str]:
    """One line for each of the most frequent causes of failure, for stderr."""
    found = causes(sweep)
    lines = [
        f"  {_count(cause.points.size, 'point')}: {cause.title}; as at "
        + " ".join(example(sweep, int(cause.points[0]), 10_000).split())
        for cause in found[:most]
    ]
    if len(found) > most:
        lines.append(f"  and {len(found) - most} other causes, see the report")
    return lines


def duration(seconds: float) -> str:
    """A time for a person: 0.3 s, 12 s, 2.5 h."""
    if not math.isfinite(seconds):
        return "unknown time"
    size, name = next(((s, n) for s, n in _UNITS if seconds >= 1.5 * s), (1.0, "s"))
    return f"{seconds / size:.2g} {name}"


def _shape(one: "Kept") -> str:
    if one.axes is None:
        return one.reason
    axes = " x ".join(f"{name} ({length})" for name, length in one.axes)
    return f"{axes or 'one number'}{f', {one.unit}' if one.unit else ''}"


def _bytes(size: int) -> str:
    for power, name in ((9, "GB"), (6, "MB"), (3, "kB")):
        if size >= 10**power:
            return f"{size / 10**power:.3g} {name}"
    return f"{size} bytes"


def _count(number: int, what: str, plural: str = "s") -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}{plural}"


def missing_words(missing: Sequence[tuple[int, int]], most: int = 4) -> str:
    """Gaps of a sweep in words: 12 to 40, 77."""
    gaps = [str(first) if first == last else f"{first} to {last}" for first, last in missing[:most]]
    more = f" and {len(missing) - most} other gaps" if len(missing) > most else ""
    return ", ".join(gaps) + more

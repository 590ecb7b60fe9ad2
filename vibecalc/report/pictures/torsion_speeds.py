"""Load of the sections of a shaft line against speed, with and without dampers, with limits."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels, speed_of
from vibecalc.report.numbers import rpm
from vibecalc.report.pictures import torsion_summits as summits
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas, plain_log
from vibecalc.report.pictures.reference_points import draw_points
from vibecalc.report.pictures.torsion_excitation import misfire_words
from vibecalc.report.references import ReferenceRow, judge_references
from vibecalc.report.sections.torsion_terms import (
    MEGA,
    MILLI,
    TORSION,
    names,
    place_of,
    vector,
    worst_section,
)
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KILO = 1e-3
_MOST = 6
#: ratio of the curves from which on the axis is logarithmic
_FAR = 4.0
#: of the highest value, the least that a logarithmic axis shows
_DEEP = 1e-3
#: points of room for the names of maxima between the axes and their title
_ROOM = 38.0
_SHADES = (
    ("barred", "#E69F00", 0.25, "barred range"),
    ("hammering", "#CC79A7", 0.15, "teeth of a gear hammer"),
    ("masked", "#f3c6cc", 1.0, "nothing damps the line"),
)
#: the same line otherwise: where it stands, and its look
_OTHERS = (
    ("bare/", QUIET, "--", "without dampers"),
    ("healthy/", COLOURS[2], "-.", "all cylinders fire"),
)


def picture(result: Result) -> "Figure | None":
    """The most loaded section on top, then torque and twist of all; None without a range."""
    record = result.record
    torque = having(record, TORSION + "speeds/torque_half_range", "section", "speed")
    section = worst_section(record)
    if torque is None or section is None or place_of(torque, section) is None:
        return None
    words = ", ".join(["half range of all orders together, against speed", *misfire_words(result)])
    figure = canvas(result, words, 10.0, 9.8)
    above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=[1.7, 1.0, 1.0])
    speed = np.asarray(torque.axes[1].values, dtype=float)
    rows = judge_references(result)
    _top(result, above, section, speed, rows)
    _all(record, middle, torque, _KILO, "torque in kN m", rows)
    twist = having(record, TORSION + "speeds/twist_half_range", "section", "speed")
    if twist is not None:
        _all(record, below, twist, MILLI, "twist in mrad", rows, rings=False)
    below.set_xlabel("crank speed in rpm")
    below.set_xlim(rpm(speed[0]), rpm(speed[-1]))
    for axes in (middle, below):
        _shades(record, axes)
    return figure


def _row(record: Record, path: str, section: str) -> np.ndarray | None:
    """Values over the speed of one section, None if there are none."""
    quantity = having(record, TORSION + path, "section", "speed")
    place = place_of(quantity, section)
    if quantity is None or place is None:
        return None
    row: np.ndarray = np.asarray(quantity.values, dtype=float)[place]
    return row


def _top(
    result: Result, axes: "Axes", section: str, speed: np.ndarray, rows: list[ReferenceRow]
) -> None:
    """Stress where it is known, else torque, with all that is told of this section."""
    record = result.record
    torque, stress = (
        _row(record, f"speeds/{load}_half_range", section) for load in ("torque", "stress")
    )
    assert torque is not None  # or there is no picture
    factor, words = _KILO, "torque in kN m"
    if stress is not None:
        # both are half ranges over one section modulus
        known = np.isfinite(torque) & (torque > 0.0)
        scale = float(np.median(stress[known] / torque[known])) if np.any(known) else 1.0
        factor, words = MEGA * scale, "stress in N/mm$^2$"
    others = []
    for root, colour, style, label in _OTHERS:
        other = _row(record, f"{root}speeds/torque_half_range", section)
        if other is not None and np.any(other > 0.0):
            top = summits.top_of(record, section, root=root)
            x, y = summits.through(speed, other, top)
            axes.plot(rpm(1.0) * x, factor * y, color=colour, linewidth=1.2, linestyle=style,
                      label=label)  # fmt: skip
            others.append(factor * y)
    label = "with dampers" if names(record, "damper/heat", "damper") else "half range"
    points = summits.points_of(record, section)
    x, y = summits.through(speed, torque, points)
    axes.plot(rpm(1.0) * x, factor * y, color=TOTAL, linewidth=2.0, label=label)
    shown = [factor * y]
    for name, scale in (("torque", factor), ("stress", MEGA)):
        quantity = having(record, f"{TORSION}speeds/{name}_half_range", "section", "speed")
        if quantity is not None and (name == "torque" or stress is not None):
            shown.append(draw_points(rows, axes, quantity, entry=section, turning=rpm(1.0),
                                     factor=scale, colour=LIMIT))  # fmt: skip
    if stress is not None:
        shown += _limits(record, axes, section, rpm(1.0) * speed)
    if _undamped(record):
        _endless(axes, shown[:1])
    else:
        _heights(axes, shown, others)
    operating = speed_of(result)
    if operating is not None and speed[0] <= operating <= speed[-1]:
        axes.axvline(rpm(operating), color=LIMIT, linewidth=1.0, linestyle=":",
                     label="operating speed")  # fmt: skip
    summits.name(axes, points, factor, (rpm(speed[0]), rpm(speed[-1])))
    _shades(record, axes)
    axes.set_ylabel(words)
    axes.set_title(f"section {section}", loc="left", fontsize=10,
                   pad=_ROOM if points.speed.size else None)  # fmt: skip
    axes.legend(loc="upper left", bbox_to_anchor=(1.005, 1.0), fontsize=9)


def _heights(axes: "Axes", shown: list[np.ndarray], others: list[np.ndarray]) -> None:
    """The axis up to the highest curve, logarithmic where others are far above those shown."""
    high, far = _highest(*shown) or 1.0, _highest(*shown, *others) or 1.0
    low = min(-_highest(-one[one > 0.0]) for one in [*shown, *others] if one.size)
    low = max(low, _DEEP * far)
    if far > _FAR * high and low > 0.0:
        plain_log(axes, 0.5 * low, 1.3 * far)
    else:
        axes.set_ylim(0.0, 1.06 * far)


def _limits(record: Record, axes: "Axes", section: str, turning: np.ndarray) -> list[np.ndarray]:
    """Curves of the limits that are held against this section."""
    held = vector(record, "limit/section", "limit")
    own = names(record, "speeds/torque_half_range", "section").index(section) + 1
    drawn = []
    for name, style in (("allowed", "-"), ("transient", "-.")):
        limit = having(record, f"{TORSION}limit/{name}", "limit", "speed")
        if limit is None:
            continue
        for i, row in enumerate(MEGA * np.asarray(limit.values, dtype=float)):
            other = held is not None and int(held[i]) != own
            if other or not np.isfinite(row).any():
                continue
            words = f"limit {i + 1}" + (", passing through" if name == "transient" else "")
            axes.plot(turning, _gaps(row), style, color=LIMIT, linewidth=1.4, label=words)
            drawn.append(_gaps(row))
    return drawn


def _all(
    record: Record,
    axes: "Axes",
    quantity: Quantity,
    factor: float,
    words: str,
    rows: list[ReferenceRow],
    rings: bool = True,
) -> None:
    """All sections, or the most loaded ones of many."""
    values = np.asarray(quantity.values, dtype=float)
    speed = np.asarray(quantity.axes[1].values, dtype=float)
    load = quantity.path.rsplit("/", 1)[-1]
    hung = [] if rings else names(record, "damper/travel", "damper")
    # a ring's spring may have another name than the damper
    hung += [] if rings else _springs(record)
    named = labels(quantity.axes[0])
    tops = np.array([np.max(row[np.isfinite(row)], initial=0.0) for row in values])
    chosen = [int(i) for i in np.argsort(-tops, kind="stable") if named[i] not in hung][:_MOST]
    high = []
    for place, i in enumerate(sorted(chosen)):
        colour = COLOURS[place % len(COLOURS)]
        x, y = summits.through(speed, values[i], summits.top_of(record, named[i], load))
        axes.plot(rpm(1.0) * x, factor * y, color=colour, linewidth=1.3, label=named[i])
        points = draw_points(rows, axes, quantity, entry=named[i], turning=rpm(1.0), factor=factor,
                             colour=colour)  # fmt: skip
        high.append(np.concatenate([factor * y, points]))
    axes.set_ylabel(words)
    left = len([one for one in named if one not in hung])
    title = None if left <= len(chosen) else f"the most loaded,\nof {left}:"
    axes.legend(loc="upper left", bbox_to_anchor=(1.005, 1.0), fontsize=8, title=title,
                title_fontsize=8)  # fmt: skip
    if _undamped(record):
        _endless(axes, high)
        return
    _heights(axes, sorted(high, key=_highest)[: -(-len(high) // 2)], high)


def _springs(record: Record) -> list[str]:
    """Sections that only the line with its dampers has."""
    bare = names(record, "bare/speeds/torque_half_range", "section")
    own = names(record, "speeds/torque_half_range", "section")
    return [one for one in own if one not in bare] if bare else []


def _shades(record: Record, axes: "Axes") -> None:
    """Barred ranges, hammering gears, and speeds at which nothing damps the line."""
    for name, colour, alpha, words in _SHADES:
        low, high = (vector(record, f"{name}/{end}", name) for end in ("from", "to"))
        if low is None or high is None:
            continue
        for i, (start, stop) in enumerate(zip(low, high, strict=True)):
            axes.axvspan(
                rpm(start), rpm(stop), color=colour, alpha=alpha, linewidth=0.8, zorder=0,
                label=None if i else words,
            )  # fmt: skip


def _undamped(record: Record) -> bool:
    """Whether the curves have flanks without end."""
    return vector(record, "masked/from", "masked") is not None


def _endless(axes: "Axes", curves: list[np.ndarray]) -> None:
    """A logarithmic axis where the flanks of undamped criticals go up without end."""
    usual = float(
        np.median(np.concatenate([one[np.isfinite(one) & (one > 0.0)] for one in curves]))
    )
    plain_log(axes, 0.05 * usual, 1e3 * usual)


def _highest(*curves: np.ndarray) -> float:
    """The largest finite value, 0 if there is none."""
    found = [float(np.max(one[np.isfinite(one)])) for one in curves if np.isfinite(one).any()]
    return max(found, default=0.0)


def _gaps(values: np.ndarray) -> np.ndarray:
    """Gaps where a value is infinite."""
    return np.where(np.isfinite(values), values, np.nan)

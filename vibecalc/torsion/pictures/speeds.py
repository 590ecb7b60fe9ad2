"""Pictures of the sections of a shaft line against speed, with and without dampers."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    canvas,
    dotted,
    gaps,
    keep_apart,
    operating_line,
    plain_log,
)
from vibecalc.core.report.curves import draw_points
from vibecalc.core.report.sections import having, labels
from vibecalc.core.report.verdicts import ReferenceRow, judge_references
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.pictures.excitation import misfire_words
from vibecalc.torsion.report.limits import limits_of, rule_of
from vibecalc.torsion.report.line import (
    MEGA,
    MILLI,
    TORSION,
    names,
    order_text,
    place_of,
    torque_unit,
    vector,
    worst_section,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Maxima of the curves of a shaft line: points that the curves go through, and their names.
# ----------------------------------------------------------------------------

#: of the width of the axes, the least distance of two names
_APART = 0.03
#: of the range, how near to its ends a maximum is at one
_AT_END = 1e-6
#: of the highest maximum, and of its own height above the curve next to it, what has a name
_HIGH, _STANDS = 0.1, 0.03
#: maxima that are named at most
_NAMED = 8


class Points(NamedTuple):
    """Maxima of a section: speed in rad/s, height in SI, mode and order (0: none)."""

    speed: np.ndarray
    height: np.ndarray
    mode: np.ndarray
    order: np.ndarray


def top_of(record: Record, section: str, load: str = "torque_half_range", root: str = "") -> Points:
    """The highest of a section at any speed, as far as it is known and has an end."""
    parts = [_entry(record, f"{root}largest/{name}", section)
             for name in ("speed", load, "mode", "half_order")]  # fmt: skip
    known = bool(parts[0].size and parts[1].size and np.isfinite(parts[1]).all())
    speed, height, mode, order = (
        (one if one.size else np.zeros(1)) if known else np.zeros(0) for one in parts
    )
    return Points(speed, height, mode, order)


def points_of(record: Record, section: str) -> Points:
    """All maxima of the torque of a section that are reported, by rising speed."""
    found = [vector(record, f"peak/{name}", "peak")
             for name in ("speed", "torque_half_range", "mode", "half_order")]  # fmt: skip
    held = vector(record, "peak/section", "peak")
    top = top_of(record, section)
    listed = names(record, "speeds/torque_half_range", "section")
    if held is None or section not in listed or any(one is None for one in found):
        return top
    speed, height, mode, order = (np.asarray(one, dtype=float) for one in found)
    own = (held == listed.index(section) + 1) & np.isfinite(height)
    # the highest is a maximum between the ends of the range, or at one of them
    new = not np.any(np.isclose(speed[own], top.speed, rtol=1e-6)) if top.speed.size else False
    more = top if new else Points(*(np.zeros(0),) * 4)
    joined = [
        np.concatenate([one[own], other])
        for one, other in zip((speed, height, mode, order), more, strict=True)
    ]
    rising = np.argsort(joined[0], kind="stable")
    return Points(*(one[rising] for one in joined))


def through(
    speed: np.ndarray, curve: np.ndarray, points: Points, factor: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """A curve over speeds (rad/s) with the points in it; gaps where it is infinite."""
    fresh = ~np.isin(points.speed, speed)
    x = np.concatenate([speed, points.speed[fresh]])
    y = np.concatenate([curve, factor * points.height[fresh]])
    rising = np.argsort(x, kind="stable")
    return x[rising], gaps(y[rising])


def main_of(points: Points, speed: np.ndarray, curve: np.ndarray) -> Points:
    """Maxima that stand out of a curve over speeds in rad/s; of one mode and order the highest."""
    tops = np.where(np.isfinite(points.height), points.height, 0.0)
    kept: list[int] = []
    for i in np.argsort(-tops, kind="stable"):
        if tops[i] < _HIGH * tops.max() or any(
            points.mode[i] and points.mode[i] == points.mode[j]
            and points.order[i] == points.order[j] for j in kept
        ):  # fmt: skip
            continue
        between = [
            curve[(speed >= min(points.speed[i], points.speed[j]))
                  & (speed <= max(points.speed[i], points.speed[j]))]
            for j in kept
        ]  # fmt: skip
        valley = max((float(np.nanmin(one)) for one in between if one.size), default=0.0)
        if tops[i] - valley >= _STANDS * tops[i]:
            kept.append(int(i))
    return Points(*(one[sorted(kept[:_NAMED])] for one in points))


def name_maxima(axes: "Axes", points: Points, factor: float, ends: tuple[float, float]) -> None:
    """Dots, and above the axes the mode / order of each with a line to it; `ends` in rpm."""
    if not points.speed.size:
        return
    at, height = rpm(1.0) * points.speed, factor * points.height
    axes.plot(at, height, "o", color=COLOURS[0], zorder=6, label="maximum, with mode / order")
    for x, y, place, mode, order in zip(
        at, height, spread(at, ends), points.mode, points.order, strict=True
    ):
        axes.annotate(
            _words(float(x), float(mode), float(order), ends), (x, y), xytext=(place, 1.012),
            textcoords=axes.get_xaxis_transform(), rotation=90, ha="center", va="bottom",
            fontsize=8, color=COLOURS[0], annotation_clip=False,
            arrowprops={"arrowstyle": "-", "linewidth": 0.6, "linestyle": ":", "shrinkA": 0.0,
                        "shrinkB": 3.0, "relpos": (0.5, 0.0), "color": COLOURS[0]},
        )  # fmt: skip


def spread(at: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Places near `at` (ascending) within the ends that leave room for a name each."""
    room = min(_APART, 1.0 / max(len(at) - 1, 1)) * (ends[1] - ends[0])
    steps = room * np.arange(len(at))
    return np.asarray(np.clip(keep_apart(at, room), ends[0] + steps, ends[1] - steps[::-1]))


def _words(at: float, mode: float, order: float, ends: tuple[float, float]) -> str:
    """`2 / 3`, or why there is none."""
    if mode and order:
        return f"{int(mode)} / {order_text(order)}"
    near = _AT_END * (ends[1] - ends[0])
    return "end" if at - ends[0] <= near or ends[1] - at <= near else "several"


def _entry(record: Record, path: str, section: str) -> np.ndarray:
    """One entry of a quantity by section as an array of one, empty if it is not there."""
    quantity = having(record, TORSION + path, "section")
    place = place_of(quantity, section)
    if quantity is None or place is None:
        return np.zeros(0)
    return np.asarray(quantity.values, dtype=float)[place : place + 1]


# ----------------------------------------------------------------------------
# Load of the sections of a shaft line against speed, with and without dampers, with limits.
# ----------------------------------------------------------------------------

#: curves of a panel; fewer where undamped criticals make spikes of them
_MOST, _MOST_SPIKY = 6, 3
#: ratio of the curves from which on the axis is logarithmic
_FAR = 4.0
#: of the highest value, the least that a logarithmic axis shows
_DEEP = 1e-3
#: points of room for the names of maxima between the axes and their title
_ROOM = 38.0
#: more bands than these are drawn as a strip at the foot, which is as high
_BARCODE, _STRIP = 12, 0.05
_SHADES = (
    ("barred", "#E69F00", 0.25, "barred range"),
    ("hammering", "#CC79A7", 0.15, "teeth of a gear hammer"),
    ("masked", "#f3c6cc", 1.0, "undamped critical"),
)
#: the same line otherwise: where it stands, and its look
_OTHERS = (
    ("bare/", QUIET, "--", "without dampers"),
    ("healthy/", COLOURS[2], "-.", "all cylinders fire"),
)


def draw_torsion_speeds(result: Result) -> "Figure | None":
    """The most loaded section on top, then torque and twist of all; None without a range."""
    record = result.record
    torque = having(record, TORSION + "speeds/torque_half_range", "section", "speed")
    section = worst_section(record)
    if torque is None or section is None or place_of(torque, section) is None:
        return None
    words = ", ".join(["half range of all orders together, against speed", *misfire_words(result)])
    figure = canvas(result, words, 9.8)
    above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=[1.7, 1.0, 1.0])
    speed = np.asarray(torque.axes[1].values, dtype=float)
    rows = judge_references(result)
    unit = torque_unit(record)
    _top(result, above, section, speed, rows, unit)
    _all(record, middle, torque, unit[0], f"torque in {unit[1]}", rows)
    twist = having(record, TORSION + "speeds/twist_half_range", "section", "speed")
    if twist is not None:
        _all(record, below, twist, MILLI, "twist in mrad", rows, rings=False)
    below.set_xlabel("crank speed in rpm")
    below.set_xlim(rpm(speed[0]), rpm(speed[-1]))
    for axes in (above, middle, below):
        _shades(record, axes)
    above.legend(loc="upper left", bbox_to_anchor=(1.005, 1.0))
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
    result: Result, axes: "Axes", section: str, speed: np.ndarray, rows: list[ReferenceRow],
    unit: tuple[float, str],
) -> None:  # fmt: skip
    """Stress where it is known, else torque, with all that is reported of this section."""
    record = result.record
    torque, stress = (
        _row(record, f"speeds/{load}_half_range", section) for load in ("torque", "stress")
    )
    assert torque is not None  # or there is no picture
    factor, words = unit[0], f"torque in {unit[1]}"
    if stress is not None:
        # both are half ranges over one section modulus
        known = np.isfinite(torque) & (torque > 0.0)
        scale = float(np.median(stress[known] / torque[known])) if np.any(known) else 1.0
        factor, words = MEGA * scale, "stress in N/mm$^2$"
    others = []
    for root, colour, style, label in _OTHERS:
        other = _row(record, f"{root}speeds/torque_half_range", section)
        if other is not None and np.any(other > 0.0):
            top = top_of(record, section, root=root)
            x, y = through(speed, other, top)
            axes.plot(rpm(1.0) * x, factor * y, color=colour, linewidth=1.2, linestyle=style,
                      marker=dotted(len(speed)), label=label)  # fmt: skip
            others.append(factor * y)
    label = "with dampers" if names(record, "damper/heat", "damper") else "half range"
    points = points_of(record, section)
    x, y = through(speed, torque, points)
    axes.plot(rpm(1.0) * x, factor * y, color=TOTAL, linewidth=1.0 if _undamped(record) else 2.0,
              marker=dotted(len(speed)), label=label)  # fmt: skip
    shown = [factor * y]
    for name, scale in (("torque", factor), ("stress", MEGA)):
        quantity = having(record, f"{TORSION}speeds/{name}_half_range", "section", "speed")
        if quantity is not None and (name == "torque" or stress is not None):
            shown.append(draw_points(rows, axes, quantity, entry=section,
                                     factor=scale, colour=LIMIT))  # fmt: skip
    if stress is not None:
        shown += _limits(result, axes, section, rpm(1.0) * speed)
    if _undamped(record):
        _endless(axes, shown[:1])
    else:
        _heights(axes, shown, others)
    operating_line(axes, result, speed[0], speed[-1])
    points = main_of(points, x, y)
    name_maxima(axes, points, factor, (rpm(speed[0]), rpm(speed[-1])))
    axes.set_ylabel(words)
    axes.set_title(f"section {section}", loc="left", pad=_ROOM if points.speed.size else None)


def _heights(axes: "Axes", shown: list[np.ndarray], others: list[np.ndarray]) -> None:
    """The axis up to the highest curve, logarithmic where others are far above those shown."""
    high, far = _highest(*shown) or 1.0, _highest(*shown, *others) or 1.0
    low = min(-_highest(-one[one > 0.0]) for one in [*shown, *others] if one.size)
    low = max(low, _DEEP * far)
    if far > _FAR * high and low > 0.0:
        plain_log(axes, 0.5 * low, 1.3 * far)
    else:
        axes.set_ylim(0.0, 1.06 * far)


def _limits(result: Result, axes: "Axes", section: str, turning: np.ndarray) -> list[np.ndarray]:
    """Curves of the limits that are held against this section, named after their rules."""
    record = result.record
    rules = [f"limit ({rule_of(one).name})" for one in limits_of(result)]
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
            words = rules[i] + (", passing through" if name == "transient" else "")
            axes.plot(turning, gaps(row), style, color=LIMIT, linewidth=1.4, label=words)
            drawn.append(gaps(row))
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
    attached = [] if rings else names(record, "damper/travel", "damper")
    # a ring's spring may have another name than the damper
    attached += [] if rings else _springs(record)
    named = labels(quantity.axes[0])
    tops = np.array([np.max(row[np.isfinite(row)], initial=0.0) for row in values])
    chosen = [int(i) for i in np.argsort(-tops, kind="stable") if named[i] not in attached]
    chosen = chosen[: _MOST_SPIKY if _undamped(record) else _MOST]
    high = []
    for place, i in enumerate(sorted(chosen)):
        colour = COLOURS[place % len(COLOURS)]
        x, y = through(speed, values[i], top_of(record, named[i], load))
        axes.plot(rpm(1.0) * x, factor * y, color=colour, label=named[i],
                  linewidth=0.8 if _undamped(record) else 1.3, marker=dotted(len(x)))  # fmt: skip
        points = draw_points(rows, axes, quantity, entry=named[i], factor=factor,
                             colour=colour)  # fmt: skip
        high.append(np.concatenate([factor * y, points]))
    axes.set_ylabel(words)
    left = len([one for one in named if one not in attached])
    title = None if left <= len(chosen) else f"the most loaded,\nof {left}:"
    axes.legend(loc="upper left", bbox_to_anchor=(1.005, 1.0), title=title, title_fontsize=8)
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
        upto = _STRIP if len(low) > _BARCODE else 1.0
        for i, (start, stop) in enumerate(zip(low, high, strict=True)):
            axes.axvspan(
                rpm(start), rpm(stop), 0.0, upto, color=colour, alpha=alpha, linewidth=0.8,
                zorder=0, label=None if i else words,
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


# ----------------------------------------------------------------------------
# Twist of every section of a shaft line against speed next to that of the same line otherwise.
# ----------------------------------------------------------------------------

_LOAD = "twist_half_range"
_COLUMNS, _MOST_PANELS = 3, 9
#: letters of a name next to which there is room for two values
_SHORT = 16


def draw_torsion_dampers(result: Result) -> "Figure | None":
    """A panel for each section, at most nine; None where there is nothing to compare with."""
    record = result.record
    own = having(record, f"{TORSION}speeds/{_LOAD}", "section", "speed")
    nearby: list[tuple[Quantity, str, str, str, str]] = []
    for root, *look in _OTHERS:
        other = having(record, f"{TORSION}{root}speeds/{_LOAD}", "section", "speed")
        if other is not None:
            nearby.append((other, root, look[0], look[1], look[2]))
    if own is None or not nearby:
        return None
    known = {name for one in nearby for name in labels(one[0].axes[0])}
    attached = names(record, "damper/travel", "damper")
    sections = [name for name in labels(own.axes[0]) if name in known and name not in attached]
    values = np.asarray(own.values, dtype=float)
    tops = {name: _highest(values[place_of(own, name) or 0]) for name in sections}
    most = sorted(sections, key=lambda name: -tops[name])[:_MOST_PANELS]
    shown = [name for name in sections if name in most]
    if not shown:
        return None
    speed = np.asarray(own.axes[1].values, dtype=float)
    rows = -(-len(shown) // _COLUMNS)
    words = ["twist of the sections against speed, half range of all orders",
             *misfire_words(result)]  # fmt: skip
    figure = canvas(result, ", ".join(words), 1.4 + 2.7 * rows)
    grid = figure.subplots(rows, min(_COLUMNS, len(shown)), sharex=True, sharey=True, squeeze=False)
    damped = "with dampers" if any(one[1] == "bare/" for one in nearby) else "as it is"
    if misfire_words(result) and damped == "as it is":
        damped = misfire_words(result)[0]
    own_curves, highest = [], []
    for axes, name in zip(grid.ravel(), shown, strict=False):
        curves = [np.zeros(1)]
        for quantity, root, colour, style, label in nearby:
            place = place_of(quantity, name)
            if place is not None:
                curve = np.asarray(quantity.values, dtype=float)[place]
                x, y = through(speed, curve, top_of(record, name, _LOAD, root))
                axes.plot(rpm(1.0) * x, MILLI * y, style, color=colour, linewidth=1.2, label=label)
                curves.append(MILLI * y)
        x, y = through(speed, values[place_of(own, name) or 0], top_of(record, name, _LOAD))
        axes.plot(rpm(1.0) * x, MILLI * y, color=TOTAL, linewidth=1.6, marker=dotted(len(speed)),
                  label=damped)  # fmt: skip
        reported = f"{name}\nlargest {show(_highest(MILLI * y), digits=3)}"
        bare = top_of(record, name, _LOAD, "bare/").height
        if bare.size and len(name) <= _SHORT:
            reported += f", without {show(MILLI * float(bare[0]), digits=3)}"
        axes.set_title(reported, loc="left", fontsize=8)
        own_curves.append(MILLI * y)
        highest.append(np.concatenate(curves))
        operating_line(axes, result, speed[0], speed[-1])
        axes.set_xlim(rpm(speed[0]), rpm(speed[-1]))
    lower = sorted(own_curves, key=_highest)[: -(-len(own_curves) // 2)]
    _heights(grid[0, 0], lower, highest)
    for place, axes in enumerate(grid.ravel()):
        axes.set_visible(place < len(shown))
        if place + grid.shape[1] >= len(shown):
            axes.set_xlabel("crank speed in rpm")
            axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel("twist in mrad")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure

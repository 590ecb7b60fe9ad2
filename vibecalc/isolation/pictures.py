"""Pictures of a body on its mounts: forces over a turn, modes, run-up."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    EDGES,
    LIMIT,
    PLATE,
    QUIET,
    TOTAL,
    TRIAD,
    arc_about,
    bounds_of,
    canvas,
    corners,
    crank_angle_axis,
    draw_points,
    gaps,
    limit_line,
    natural_frequencies,
    note,
    order_name,
    plain_ticks,
    project,
    unit_words,
    usual,
    waves,
)
from vibecalc.core.report.sections import along, having, labels, scalar_of, speed_of, table_of
from vibecalc.core.report.verdicts import judge_references
from vibecalc.core.report.writing import hertz, rpm, show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.response.report import main_coordinates

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# The couple over the lever during one turn, body held still and on its mounts.
# ----------------------------------------------------------------------------

_PANELS = (("rigid", "without isolation: body held still"), ("steady", "through the mounts"))
_DRAWN = 2


def draw_force_over_cycle(result: Result) -> "Figure | None":
    """Two panels with primary, secondary and total force; None without lever force."""
    found = []
    for name, words in _PANELS:
        hit = along(result.record, f"isolation/lever_force/{name}_harmonics", "order")
        if hit is not None and hit[1].size:
            found.append((name, words, *hit))
    if not found:
        return None
    figure = canvas(result, "couple over the lever during one turn", 1.2 + 2.9 * len(found))
    panels = figure.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, words, quantity, orders) in zip(panels, found, strict=True):
        _curves(axes, quantity, orders)
        path = f"isolation/lever_force/{name}_peak"
        peak = scalar_of(result.record, path)
        title = words if peak is None else f"{words}, peak {show(peak, digits=4)} {quantity.unit}"
        axes.set_title(title, loc="left")
        axes.set_ylabel(f"force in {quantity.unit}")
        for text, bound in bounds_of(result, path):
            limit_line(axes, bound, text)
            axes.axhline(-bound, color=LIMIT, linestyle="--", linewidth=1.3)
    panels[0].legend(loc="upper center", ncols=4, bbox_to_anchor=(0.5, -0.02))
    crank_angle_axis(panels[-1])
    return figure


def _curves(axes: "Axes", quantity: Quantity, orders: np.ndarray) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    parts = np.real(np.asarray(quantity.values)[:, None] * waves(orders, angle))
    degrees = np.degrees(angle)
    for order, colour in zip((1, 2), COLOURS, strict=False):
        for part in parts[np.asarray(orders) == order]:
            axes.plot(degrees, part, color=colour, label=order_name(order))
    words = "total" if len(orders) <= _DRAWN else f"total of {len(orders)} orders"
    axes.plot(degrees, parts.sum(axis=0), color=TOTAL, linewidth=2.0, label=words)


# ----------------------------------------------------------------------------
# Couple of the cylinders' torque on the body, and the load of every support, over the cycle.
# ----------------------------------------------------------------------------

_ROOT = "isolation/torque_reaction/"
#: of the largest order of a couple, what the last has to reach for ripples to be seen
_RIPPLE = 2e-3
_STATIC = "isolation/support_force/static"
_DASHES = ("-", "--", "-.", ":")


def draw_engine_mounts(result: Result) -> "Figure | None":
    """Couple above, loads about their means below; None without a torque reaction."""
    record = result.record
    couple = having(record, f"{_ROOT}couple", "half_order")
    force = having(record, f"{_ROOT}support_force", "mount", "direction", "half_order")
    if couple is None or force is None:
        return None
    orders = np.asarray(couple.axes[0].values, dtype=float)
    turns = 2 if np.any(orders % 1.0) else 1
    count = max(721, int(16.0 * turns * orders.max()) + 1)
    angle = np.linspace(0.0, 2.0 * np.pi * turns, count)
    kind = table_of(result.case, "machine").get("kind") or "engine"
    title = f"torque reaction: {kind} on its mounts, orders {orders[0]:g} to {orders[-1]:g}"
    size = np.abs(np.asarray(couple.values))
    if size[-1] > _RIPPLE * size.max():
        title += "; ripples stand for those left out"
    figure = canvas(result, title, 7.4)
    above, below = figure.subplots(2, 1, sharex=True)
    _couple(above, record, couple, angle, orders)
    _loads(below, result, force, angle, orders)
    below.set_xlim(0.0, 360.0 * turns)
    below.set_xticks(range(0, 360 * turns + 1, 90 * turns // 2))
    below.set_xlabel("crank angle in deg")
    return figure


def _couple(
    axes: "Axes", record: Record, couple: Quantity, angle: np.ndarray, orders: np.ndarray
) -> None:
    given = having(record, f"{_ROOT}mean_couple")
    mean = 0.0 if given is None else float(given.values)
    course = mean + np.real(np.asarray(couple.values) @ waves(orders, angle))
    axes.plot(np.degrees(angle), course, color=TOTAL)
    axes.axhline(mean, color=QUIET, linestyle="--", linewidth=1.2)
    words = f"couple on the body about the crankshaft, mean {show(mean, digits=4)} N m (dashed)"
    axes.set_title(words, loc="left")
    axes.set_ylabel(f"couple in {unit_words(couple.unit)[1]}")


def _loads(
    axes: "Axes", result: Result, force: Quantity, angle: np.ndarray, orders: np.ndarray
) -> None:
    """What each support carries about its mean load, downwards; where that is zero it lifts."""
    record = result.record
    up = "xyz".index(str(table_of(result.case, "isolation").get("up") or "z"))
    weight = having(record, _STATIC, "mount")
    mean = having(record, f"{_ROOT}mean_support_force", "mount", "direction")
    courses, still = [], []
    for place, name in enumerate(labels(force.axes[0])):
        load = 0.0 if weight is None else float(weight.values[place])
        load -= 0.0 if mean is None else float(mean.values[place, up])
        course = -np.real(np.asarray(force.values)[place, up] @ waves(orders, angle))
        courses.append(course)
        still.append(load)
        axes.plot(
            np.degrees(angle),
            course,
            color=COLOURS[place % len(COLOURS)],
            linestyle=_DASHES[place // len(COLOURS) % len(_DASHES)],
            label=f"{name}: {show(load, digits=4)}",
        )
    axes.axhline(0.0, color=QUIET, linewidth=0.8)
    lowest = min((float(np.min(one)) for one in courses), default=0.0)
    for place, load in enumerate(still):
        if load + float(np.min(courses[place])) < 0.0 or -load > 1.2 * lowest:
            colour = COLOURS[place % len(COLOURS)]
            axes.axhline(-load, color=colour, linestyle=":", linewidth=1.2)
            note(axes, f"{labels(force.axes[0])[place]} carries nothing", (0.0, -load), (4, 2),
                xycoords=axes.get_yaxis_transform(), color=LIMIT)  # fmt: skip
    axes.set_title("load on each support about its mean: torque and shaking, downwards", loc="left")
    axes.set_ylabel(f"load in {force.unit}")
    axes.legend(title=f"support: mean\nin {force.unit}", loc="center left",
                bbox_to_anchor=(1.0, 0.5))  # fmt: skip


# ----------------------------------------------------------------------------
# Transmissibility of the pitch model against the frequency ratio, with the orders marked.
# ----------------------------------------------------------------------------

_BASE = "isolation/pitch/"
#: Orders named in the legend; a long rod ratio has 70, which no picture has room for.
_NAMED = 8


def draw_transmissibility(result: Result) -> "Figure | None":
    """Magnitude in dB and phase; None without a pitch model.

    The curve comes from `transmissibility_curve` (axis `frequency_ratio`); without it the
    orders alone are marked.
    """
    hit = along(result.record, _BASE + "transmissibility", "order")
    natural = scalar_of(result.record, _BASE + "natural_frequency")
    speed = speed_of(result)
    if hit is None or not natural or speed is None:
        return None
    quantity, orders = hit
    ratios = np.asarray(orders, dtype=float) * speed / natural
    figure = canvas(result, "transmissibility of the mounts, pitch", 6.2)
    level, phase = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    curve = along(result.record, _BASE + "transmissibility_curve", "frequency_ratio")
    if curve is not None:
        level.plot(curve[1], _decibel(curve[0].values), color=TOTAL)
        phase.plot(curve[1], np.degrees(np.angle(curve[0].values)), color=TOTAL)
    for i, (order, ratio, value) in enumerate(zip(orders, ratios, quantity.values, strict=True)):
        colour = COLOURS[i % len(COLOURS)]
        decibel = float(_decibel(value))
        words = f"order {int(order)}: {decibel:.1f} dB" if i < _NAMED else None
        level.plot([ratio], [decibel], "o", color=colour, label=words)
        phase.plot([ratio], [float(np.degrees(np.angle(value)))], "o", color=colour)
    if len(orders) > _NAMED:
        level.plot([], [], " ", label=f"and up to order {int(orders[-1])}")
    level.axhline(0.0, color=QUIET, linewidth=1.0)
    level.axvline(np.sqrt(2.0), color=QUIET, linestyle=":", linewidth=1.2)
    note(level, "isolates beyond $\\sqrt{2}$", (np.sqrt(2.0), 1.0), (5, -12),
        xycoords=level.get_xaxis_transform(), color=QUIET)  # fmt: skip
    level.set_xscale("log")
    level.xaxis.set_major_formatter("{x:g}")
    level.xaxis.set_minor_formatter("")
    level.margins(y=0.12)
    level.set_ylabel("|force out / force in| in dB")
    level.legend(loc="lower left")
    phase.set_ylabel("phase in deg")
    phase.set_ylim(-185.0, 5.0)
    phase.set_yticks([-180, -90, 0])
    phase.set_xlabel("excitation frequency / natural frequency")
    return figure


def _decibel(values: Any) -> Any:
    """20 log10 |T|; what is zero or infinite is a gap."""
    size = np.abs(np.asarray(values))
    return 20.0 * np.log10(np.where((size > 0.0) & np.isfinite(size), size, np.nan))


# ----------------------------------------------------------------------------
# Which freedoms move in which mode of the body: shares of energy as stacked bars.
# ----------------------------------------------------------------------------

_PERCENT_WITH_TEXT = 8.0
#: Colours that need dark letters.
_LIGHT = (3, 4, 5)


def draw_modal_energy(result: Result) -> "Figure | None":
    """One bar for each mode, lowest on top; None without modes."""
    quantity = result.record.quantities.get("isolation/modes/energy_fraction")
    if quantity is None or [axis.name for axis in quantity.axes] != ["mode", "coordinate"]:
        return None
    modes, coordinates = (labels(axis) for axis in quantity.axes)
    shares = 100.0 * np.asarray(quantity.values, dtype=float)
    natural = along(result.record, "isolation/modes/natural_frequency", "mode")
    names = [f"mode {mode}" for mode in modes]
    if natural is not None:
        names = [
            f"{name}\n{show(hertz(float(value)), digits=4)} Hz"
            for name, value in zip(names, natural[0].values, strict=True)
        ]
    figure = canvas(result, "modes on the mounts: shares of energy", 1.8 + 0.62 * len(modes))
    axes = figure.subplots()
    place = np.arange(len(modes))
    # A share can be negative where coordinates are coupled by the mass: it is stacked leftwards.
    ends = {sign: np.zeros(len(modes)) for sign in (-1.0, 1.0)}
    for j, name in enumerate(coordinates):
        colour = COLOURS[j % len(COLOURS)]
        ink = "black" if j % len(COLOURS) in _LIGHT else "white"
        left = np.where(shares[:, j] < 0.0, ends[-1.0], ends[1.0])
        axes.barh(place, shares[:, j], left=left, color=colour, height=0.72, label=name)
        for i in np.flatnonzero(np.abs(shares[:, j]) >= _PERCENT_WITH_TEXT):
            middle = left[i] + 0.5 * shares[i, j]
            words = f"{name} {shares[i, j]:.0f} %"
            axes.text(middle, float(i), words, ha="center", va="center", color=ink, fontsize=8)
        for sign, end in ends.items():
            end += np.where(sign * shares[:, j] > 0.0, shares[:, j], 0.0)
    axes.set_yticks(place, names)
    axes.invert_yaxis()
    axes.set_xlim(min(0.0, float(ends[-1.0].min())), max(100.0, float(ends[1.0].max())))
    axes.set_xlabel("share of the energy of the mode in %")
    axes.grid(visible=False, axis="y")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=6)
    return figure


# ----------------------------------------------------------------------------
# The modes of the body as a box seen in perspective: where it goes and how it turns.
# ----------------------------------------------------------------------------

_COORDINATES = ("x", "y", "z", "rx", "ry", "rz")
_MOVES, _TURNS = COLOURS[0], COLOURS[1]
#: parts of a mode shorter than this share of its longest arrow are left out
_SHORT = 0.06
_ARROW = 1.25
#: behind the letters of the axes
#: how far the box is drawn aside, and by what angle, at an arrow of length 1
_ASIDE, _ANGLE = 0.45, 0.35


def draw_mode_shapes(result: Result) -> "Figure | None":
    """A panel for each mode; None without shapes and their shares of energy.

    Metres and radians have no common scale: each component is drawn as long as the square root of
    its share of the kinetic energy, with the sign of the shape.
    """
    record = result.record
    stem = "response/modes/"
    shape = having(record, stem + "shape", "mode", "coordinate")
    share = having(record, stem + "energy_fraction", "mode", "coordinate")
    natural = having(record, stem + "natural_frequency", "mode")
    if shape is None or share is None or natural is None:
        return None
    if tuple(str(name) for name in shape.axes[1].values) != _COORDINATES:
        return None
    length = np.sign(np.real(shape.values)) * np.sqrt(np.abs(np.asarray(share.values, dtype=float)))
    modes = len(length)
    columns = min(3, modes)
    rows = -(-modes // columns)
    subtitle = "modes of the body; arrows by their share of the energy"
    figure = canvas(result, subtitle, 1.2 + 3.0 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
        axes.set_aspect("equal")
    for i, vector in enumerate(length):
        _panel(panels[i], vector)
        frequency = show(hertz(float(natural.values[i])), digits=4)
        words = main_coordinates(share, i)
        panels[i].set_title(f"mode {i + 1}: {frequency} Hz\n{words}")
    _legend(figure)
    return figure


def _panel(axes: "Axes", vector: np.ndarray) -> None:
    """The box at rest, the box displaced, and the two arrows from its centre."""
    largest = float(np.max(np.abs(vector), initial=0.0))
    kept = np.where(np.abs(vector) >= _SHORT * largest, vector, 0.0)
    along, about = kept[:3], kept[3:]
    _box(axes, corners(), "#b0b0b0", 0.9)
    _box(axes, corners(_ASIDE * along, _ANGLE * about), "#444444", 1.4)
    for name, end in TRIAD:
        tip = project(end)
        axes.plot(*np.transpose([project(0.0 * end), tip]), color=QUIET, linewidth=0.8, ls=":")
        x, y = (float(value) for value in project(1.1 * end))
        text = axes.text(x, y, name, color=QUIET, ha="center", va="center", zorder=6)
        text.set_bbox(PLATE)
    if np.linalg.norm(along) > 0.0:
        _arrow(axes, np.zeros(3), _ARROW * along, _MOVES)
    size = float(np.linalg.norm(about))
    if size > 0.0:
        tip = _ARROW * about
        _arrow(axes, np.zeros(3), tip, _TURNS)
        path = np.array([project(point) for point in arc_about(tip, 0.2 + 0.35 * size)])
        axes.plot(path[:, 0], path[:, 1], color=_TURNS, linewidth=1.8)
        _head(axes, path[-4], path[-1], _TURNS)
    axes.set_xlim(-1.55, 1.55)
    axes.set_ylim(-1.4, 1.6)


def _box(axes: "Axes", points: np.ndarray, colour: str, width: float) -> None:
    flat = np.array([project(point) for point in points])
    for start, end in EDGES:
        axes.plot(flat[[start, end], 0], flat[[start, end], 1], color=colour, linewidth=width)


def _arrow(axes: "Axes", start: np.ndarray, end: np.ndarray, colour: str) -> None:
    first, last = project(start), project(end)
    axes.plot(*np.transpose([first, last]), color=colour, linewidth=2.2, zorder=4)
    _head(axes, first, last, colour)


def _head(axes: "Axes", first: np.ndarray, last: np.ndarray, colour: str) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": 0.0, "shrinkA": 0, "shrinkB": 0}
    tip, tail = ((float(point[0]), float(point[1])) for point in (last, first))
    axes.annotate("", tip, tail, arrowprops={**style, "mutation_scale": 15}, zorder=5)


def _legend(figure: "Figure") -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=_MOVES, linewidth=2.2, label="moves along"),
        Line2D([], [], color=_TURNS, linewidth=2.2, label="turns about (right-handed)"),
        Line2D([], [], color="#b0b0b0", label="at rest"),
        Line2D([], [], color="#444444", label="displaced, exaggerated"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)


# ----------------------------------------------------------------------------
# Marks of a run-up: orders on natural frequencies, speeds left out, where the axis begins.
# ----------------------------------------------------------------------------

_ORDERS = (1, 2)
#: Ratio of frequencies below which two marks have no room for words of their own.
_CLOSE = 1.18


def resonances(record: Record, axes: "Axes", speed: np.ndarray) -> None:
    """Dotted lines where an order meets a mode; lines of one order that lie close share words."""
    frequencies = rpm(1.0) * natural_frequencies(record)
    words: list[tuple[float, str]] = []
    for order in _ORDERS:
        groups: list[list[int]] = []
        for mode, natural in enumerate(frequencies):
            at = natural / order
            if not speed.min() < at < speed.max():
                continue
            axes.axvline(at, color=QUIET, linestyle=":", linewidth=1.0, zorder=0)
            if groups and natural < _CLOSE * frequencies[groups[-1][0]]:
                groups[-1].append(mode)
            else:
                groups.append([mode])
        for group in groups:
            name = f"order {order}" + (_modes(group) if len(frequencies) > 1 else "")
            words.append((float(frequencies[group[0]] / order), name))
    words.sort()
    free = 0.0
    for at, name in words:
        # next to the line, on its other side where the word before it stands
        right = at < free
        free = _CLOSE * at
        note(axes, name, (at, 0.98), (2 if right else -2, 0),
            xycoords=axes.get_xaxis_transform(), rotation=90, ha="left" if right else "right",
            va="top", color=QUIET, zorder=4,
            bbox=PLATE)  # fmt: skip


def _modes(group: list[int]) -> str:
    first, last = group[0] + 1, group[-1] + 1
    if first == last:
        return f", mode {first}"
    return f", modes {first}" + (f", {last}" if last == first + 1 else f" to {last}")


def lowest(record: Record, speed: np.ndarray) -> float:
    """Where the logarithmic axis begins: well below the first order resonance."""
    natural = rpm(1.0) * natural_frequencies(record)
    first = min(natural, default=float(speed.max())) / max(_ORDERS)
    return max(float(speed.min()), 0.25 * min(float(first), float(speed.max())))


def unbounded(record: Record) -> bool:
    """Whether speeds were left out because the forces have no bound there."""
    low = record.quantities.get("isolation/masked/low")
    return low is not None and low.values.size > 0


def window(
    speed: np.ndarray, values: np.ndarray, shown: tuple[float, float], bounds: list[float]
) -> tuple[float, float]:
    """Ends of a logarithmic force axis: decades around what is usual between the resonances."""
    largest = np.atleast_2d(values).max(axis=0)
    middle = usual(speed, np.where(np.isfinite(largest), largest, 0.0), *shown)
    return 1e-2 * middle, max([1e3 * middle, *(3.0 * bound for bound in bounds)])


def masked(record: Record, axes: "Axes") -> None:
    """Shade the intervals of speed that were left out."""
    low, high = (record.quantities.get(f"isolation/masked/{end}") for end in ("low", "high"))
    if low is None or high is None:
        return
    for start, stop in zip(np.atleast_1d(low.values), np.atleast_1d(high.values), strict=True):
        axes.axvspan(rpm(start), rpm(stop), color="#f3c6cc", linewidth=1.0)


# ----------------------------------------------------------------------------
# The run-up: at each speed the largest force over the cycle, with limits and resonances.
# ----------------------------------------------------------------------------

#: Room above the curves for those words, as a factor, for one mode and for several.
_ROOM = (1.2, 1.9)
_LEVER = "isolation/lever_force/run_up"
_SUPPORT = "isolation/support_force/run_up"


def draw_run_up(result: Result) -> "Figure | None":
    """One panel for the couple over the lever, one for the supports; None without a run-up."""
    record = result.record
    lever = along(record, _LEVER, "speed")
    support = record.quantities.get(_SUPPORT)
    count = (lever is not None) + (support is not None)
    if count == 0:
        return None
    figure = canvas(result, "run-up: largest force over the cycle", 1.5 + 3.0 * count)
    rows = judge_references(result)
    panels = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    if lever is not None:
        quantity, speed = lever[0], rpm(1.0) * lever[1]
        panels[0].plot(speed, gaps(quantity.values), color=TOTAL)
        draw_points(rows, panels[0], quantity, turning=rpm(1.0), colour=LIMIT)
        _finish(result, panels[0], quantity, speed, "couple over the lever")
    if support is not None:
        axes, speed = panels[-1], rpm(1.0) * np.asarray(support.axes[-1].values)
        _supports(axes, support, speed)
        for name in labels(support.axes[0]):
            draw_points(rows, axes, support, entry=name, turning=rpm(1.0), colour=LIMIT)
        _finish(result, axes, support, speed, "one support on the ground")
    panels[-1].set_xlabel("crank speed in rpm")
    plain_ticks(panels[-1].xaxis)
    return figure


def _supports(axes: "Axes", quantity: Quantity, speed: np.ndarray) -> None:
    rows = np.asarray(quantity.values)
    names = labels(quantity.axes[0])
    drawn: list[tuple[np.ndarray, list[str]]] = []
    # Next to a resonance without damping the force is a million times that of other speeds.
    largest = np.max(np.where(np.isfinite(rows), rows, 0.0), axis=0, initial=0.0)
    for name, row in zip(names, rows, strict=True):
        # Mounts that carry the same are one curve with several names.
        for other, members in drawn:
            if np.all(np.isclose(other, row, rtol=1e-6, atol=1e-9 * largest)):
                members.append(name)
                break
        else:
            drawn.append((row, [name]))
    for i, (row, members) in enumerate(drawn):
        words = ("mounts " if len(members) > 1 else "mount ") + ", ".join(members)
        axes.plot(speed, gaps(row), color=COLOURS[i % len(COLOURS)], label=words)
    # Forces are small at low speeds, and limits are named on the right.
    axes.legend(loc="center left", frameon=True, framealpha=0.9, edgecolor="none")


def _finish(
    result: Result, axes: "Axes", quantity: Quantity, speed: np.ndarray, words: str
) -> None:
    axes.set_ylabel(f"{words}\nforce in {quantity.unit}")
    values = np.asarray(quantity.values)
    finite = values[np.isfinite(values)]
    top = float(np.max(finite)) if finite.size else 1.0
    limits = bounds_of(result, quantity.path + "_peak")
    steady = bounds_of(result, quantity.path.removesuffix("run_up") + "steady_peak")
    for text, bound in limits:
        limit_line(axes, bound, f"run-up {text}")
    for text, bound in steady:
        _steady(result, axes, bound, text)
    highest = max([top, *(bound for _, bound in limits), *(bound for _, bound in steady)])
    several = natural_frequencies(result.record).size > 1
    axes.set_ylim(0.0, _ROOM[several] * highest)
    axes.set_xscale("log")
    axes.set_xlim(lowest(result.record, speed), float(speed.max()))
    if unbounded(result.record):
        # The flanks go up without end: in between, nothing would be left to see.
        bounds = [bound for _, bound in (*limits, *steady)]
        axes.set_yscale("log")
        axes.set_ylim(*window(speed, values, axes.get_xlim(), bounds))
    resonances(result.record, axes, speed)
    masked(result.record, axes)
    _peak(result.record, axes, quantity, speed, limits)


def _peak(
    record: Record,
    axes: "Axes",
    quantity: Quantity,
    speed: np.ndarray,
    limits: list[tuple[str, float]],
) -> None:
    """Mark the largest force, as refined between the speeds drawn, else as drawn."""
    values = np.asarray(quantity.values)
    peaks = record.quantities.get(quantity.path + "_peak")
    places = record.quantities.get(quantity.path + "_peak_speed")
    if peaks is not None and places is not None:
        top = int(np.argmax(peaks.values))
        peak, at = float(np.ravel(peaks.values)[top]), rpm(np.ravel(places.values)[top])
    else:
        peak = float(np.max(values, initial=0.0))
        at = float(speed[int(np.argmax(values)) % speed.size])
    if not np.isfinite(peak) or peak <= 0.0:
        return
    axes.plot([at], [peak], "o", color=LIMIT if _beyond(peak, limits) else TOTAL, markersize=5)
    left = at > 0.7 * float(speed.max())
    note(axes, f"{show(peak, digits=4)} {quantity.unit} at {show(at, digits=4)} rpm",
        (at, peak), (-8 if left else 8, 3), ha="right" if left else "left",
        bbox=PLATE)  # fmt: skip


def _steady(result: Result, axes: "Axes", bound: float, words: str) -> None:
    speed = speed_of(result)
    if speed is None:
        return
    axes.plot([rpm(speed)], [bound], marker="v", color=LIMIT, markersize=9, clip_on=False)
    note(axes, f"steady {words}", (rpm(speed), bound), (-4, 7), ha="right", color=LIMIT)


def _beyond(peak: float, limits: list[tuple[str, float]]) -> bool:
    return any(peak > bound for _, bound in limits)

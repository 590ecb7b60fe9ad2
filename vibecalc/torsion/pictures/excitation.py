"""Pictures of what the cylinders do to a shaft line: over a cycle, by order, as vectors."""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    TYPE,
    WIDTH,
    bars,
    canvas,
    note,
    ticks,
    waves,
)
from vibecalc.core.report.sections import along, having, labels, speed_of, table_of
from vibecalc.core.report.writing import fold, hertz, show
from vibecalc.core.results.record import Result
from vibecalc.torsion.report.line import (
    TORSION,
    asked,
    elastic_modes,
    entry,
    firing_words,
    joined,
    line_of,
    mode_names,
    order_text,
    place_of,
    speed_range,
    torque_unit,
    turns,
    vector,
    worst_section,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Pressure in one cylinder and torques on its throw over a cycle, and those of all cylinders.
# ----------------------------------------------------------------------------

EXCITATION = TORSION + "excitation/"
_TORQUES = (("gas_torque", "gas", COLOURS[0]), ("inertia_torque", "inertia", COLOURS[1]),
            ("total_torque", "both", TOTAL))  # fmt: skip
#: the second speed is so many times the operating one, if the range goes as far; at least the other
_TWICE, _LEAST = 2.0, 1.3


def torque_words(result: Result) -> str:
    """The one unit of torque in all pictures of a shaft line."""
    return torque_unit(result.record)[1].replace(" ", "*")


def draw_torsion_excitation(result: Result) -> "Figure | None":
    """Panels over the crank angle; None without a torque over the cycle.

    The orders of the case are drawn over the card and the torque that they come from; a table of
    tangential effort has no card. A second speed shows how the inertia torque grows: twice the
    operating one, or where the range ends.
    """
    record = result.record
    total = along(record, EXCITATION + "total_torque", "crank_angle")
    if total is None:
        return None
    speed, second = speed_of(result), _second(result)
    at = f" at {turns(speed)} rpm" if speed is not None else ""
    card = along(record, EXCITATION + "pressure", "crank_angle") is not None
    rows = 2 + card + (second is not None)
    factor, unit = torque_unit(record)
    what = f"{'gas pressure and ' * card}torques over one cycle{at}"
    figure = canvas(result, ", ".join([what, *misfire_words(result)]), 2.6 + 2.0 * rows)
    panels = list(figure.subplots(rows, 1, sharex=True))
    below = panels[-1]
    if card:
        above = panels.pop(0)
        _curve(result, above, "pressure", 1e-5, "card", COLOURS[3])
        _approximated(result, above, "pressure", 1e-5, "bar")
        above.set_ylabel("gauge pressure\nin bar")
        above.legend(loc="upper center", ncols=3)
    for axes, times, rpm_words in (
        (panels[0], 1.0, at),
        (panels[-2], second, f" at {turns((second or 0.0) * (speed or 0.0))} rpm"),
    ):
        if times is None:
            continue
        for name, label, colour in _TORQUES:
            _curve(result, axes, name, factor, label, colour, times)
        _approximated(result, axes, "total_torque", factor, unit, times)
        axes.set_ylabel(f"torque of one\ncylinder in {unit}")
        axes.legend(loc="upper right", ncols=4)
        axes.set_title(f"one cylinder from its firing on{rpm_words}", loc="left", fontsize=8)
        axes.axhline(0.0, color=QUIET, linewidth=0.8)
        _headroom(axes)
    _curve(result, below, "engine_torque", factor, "all cylinders", TOTAL)
    below.set_ylabel(f"torque of all\ncylinders in {unit}")
    mean = record.quantities.get(EXCITATION + "mean_torque")
    if mean is not None:
        level = factor * float(mean.values)
        below.axhline(level, color=QUIET, linestyle="--", linewidth=1.2,
                      label=f"mean {show(level, digits=4)} {unit}")  # fmt: skip
        below.legend(loc="upper right", ncols=2)
        _headroom(below)
    cycle = str(table_of(result.case, "machine").get("cycle") or "").replace("_", "-")
    order = firing_words(record, cycle)
    if order:
        ill = "".join(f"; {words}" for words in misfire_words(result))
        below.set_title(f"all cylinders{at}, {order}{ill}", loc="left", fontsize=8)
    below.axhline(0.0, color=QUIET, linewidth=0.8)
    top = float(np.degrees(total[1][-1]))
    below.set_xlim(0.0, top)
    ticks(below.xaxis, np.arange(0.0, top + 1.0, 90.0 if top > 400.0 else 45.0))
    below.set_xlabel("crank angle in deg")
    return figure


def silent(result: Result) -> list[str]:
    """Names of the cylinders that do not fire in this case."""
    given = asked(result).get("misfire")
    return [str(name) for name in given] if isinstance(given, list | tuple) else []


def misfire_words(result: Result) -> list[str]:
    """`cylinder 3 does not fire`, nothing for an engine that fires as it should."""
    found = silent(result)
    if not found:
        return []
    many = len(found) > 1
    return [f"cylinder{'s' if many else ''} {joined(found)} do{'' if many else 'es'} not fire"]


def _second(result: Result) -> float | None:
    """The second speed over the operating one; None without a range or with gas by speed."""
    speed, train = speed_of(result), table_of(result.case, "machine", "crank_train")
    effort = table_of(train, "tangential_effort")
    if not speed or train.get("gas_cards") or effort.get("over_speed"):
        return None
    if not table_of(result.case, "response", "torsion", "speeds"):
        return None
    times = min(_TWICE, speed_range(result)[1] / speed)
    return times if times >= _LEAST else None


def _values(result: Result, name: str, times: float = 1.0) -> tuple[np.ndarray, np.ndarray] | None:
    """A curve of the result and its angle; inertia goes with the square of the speed."""
    found = along(result.record, EXCITATION + name, "crank_angle")
    if found is None:
        return None
    drawn = np.asarray(found[0].values, dtype=float)
    if times != 1.0:
        inertia = along(result.record, EXCITATION + "inertia_torque", "crank_angle")
        part = 0.0 if inertia is None else np.asarray(inertia[0].values, dtype=float)
        share = {"inertia_torque": 1.0, "total_torque": 1.0}.get(name, 0.0)
        drawn = drawn + share * (times**2 - 1.0) * part
    return drawn, np.asarray(found[1], dtype=float)


def _curve(
    result: Result, axes: "Axes", name: str, factor: float, words: str, colour: str,
    times: float = 1.0,
) -> None:  # fmt: skip
    found = _values(result, name, times)
    if found is not None:
        axes.plot(np.degrees(found[1]), factor * found[0], color=colour, label=words)


def _approximated(
    result: Result, axes: "Axes", name: str, factor: float, unit: str, times: float = 1.0
) -> None:
    """What the orders of the case make of a curve, and by how much that misses it."""
    found = _values(result, name, times)
    total = having(result.record, EXCITATION + "total", "half_order")
    if found is None or total is None:
        return
    curve, angle = found
    order = np.asarray(total.axes[0].values, dtype=float)
    if name == "total_torque":
        amplitude = np.asarray(total.values)
        inertia = having(result.record, EXCITATION + "inertia", "half_order")
        if times != 1.0 and inertia is not None:
            amplitude = amplitude + (times**2 - 1.0) * np.asarray(inertia.values)
    else:
        # the card has no orders in the result: sums over its points, evenly over the cycle
        amplitude = 2.0 * np.mean(curve[:-1] * np.conj(waves(order, angle[:-1])), axis=1)
    made = float(np.mean(curve[:-1])) + np.real(amplitude @ waves(order, angle))
    label = f"of orders {order_text(order[0])} to {order_text(order[-1])}"
    axes.plot(np.degrees(angle), factor * made, color=COLOURS[4], linestyle="--", label=label)
    missed = factor * float(np.max(np.abs(made - curve)))
    axes.set_title(f"the orders miss it by {show(missed, digits=2)} {unit} at most", loc="right",
                   fontsize=8)  # fmt: skip


def _headroom(axes: "Axes") -> None:
    """Room for the legend above the curves."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.22 * (high - low))


# ----------------------------------------------------------------------------
# Vector diagrams: how the torques of the cylinders add up, by order, in the lowest modes.
# ----------------------------------------------------------------------------

_MODES, _STARS = 3, 6
_ALIKE = 1e-6
#: inches at the left for the names of the rows
_MARGIN = 0.45
#: of the side of a cell: the room between rows, a line of words in it, arrows of a star, heads
_ROOM, _LINE, _REACH, _HEAD = 0.22, 0.13, 0.24, 0.07


def draw_torsion_vectors(result: Result) -> "Figure | None":
    """Stars of the phases on top, below them shape times phase laid end to end for each mode.

    A cylinder that does not fire is left out of the sums, and drawn next to those that do.
    """
    record = result.record
    firing = having(record, TORSION + "excitation/firing_angle", "cylinder")
    shape = having(record, TORSION + "modes/shape", "mode", "station")
    total = having(record, TORSION + "excitation/total", "half_order")
    natural = having(record, TORSION + "modes/natural_frequency", "mode")
    line, modes = line_of(result), elastic_modes(result)[:_MODES]
    if firing is None or shape is None or total is None or natural is None or line is None:
        return None
    angle = np.asarray(firing.values, dtype=float)
    if angle.size < 2 or not modes:
        return None
    orders = np.asarray(total.axes[0].values, dtype=float)
    stars = alike(angle, orders, mirrored=not np.iscomplexobj(shape.values))[:_STARS]
    named = labels(firing.axes[0])
    fires = np.array([name not in silent(result) for name in named])
    mirrored = "" if np.iscomplexobj(shape.values) else " (mirror images count as equal)"
    words = (
        f"phase vectors of the cylinders by order{mirrored};\n"
        "below, each times the shape of a mode, end to end, over what all in line would be"
    )
    for ill in misfire_words(result):
        are, they = ("is", "it") if fires.sum() == len(named) - 1 else ("are", "they")
        words += f"\n{ill} and {are} not in the sums (dashed); all: if {they} did"
    wide = max(len(stars), 3)
    side = min(10.0 * (WIDTH - _MARGIN) / TYPE / wide, 2.2)
    room = _ROOM + _LINE * len(misfire_words(result))
    names_above = max(len(_order_words(group)) for group in stars) + 0.5
    high = (1.0 + room) * len(modes) + 1.0 + _LINE * names_above
    figure = canvas(result, words, side * high + 0.8 + 0.2 * words.count("\n"))
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set_xlim(-10.0 * _MARGIN / TYPE / side, wide)
    axes.set_ylim(-(1.0 + room) * len(modes), 1.0 + _LINE * names_above)
    values = hertz(1.0) * np.asarray(natural.values, dtype=float)
    known = mode_names(result)
    rows = [f"{known[mode]}\n{show(values[mode], digits=4)} Hz" for mode in modes]
    for place, name in enumerate(["phases", *rows]):
        axes.text(-0.06, 0.5 - (1.0 + room) * place, name, rotation=90, ha="right", va="center",
                  fontsize=8, multialignment="center")  # fmt: skip
    shapes = [np.asarray(shape.values)[mode][line.cylinder_station] for mode in modes]
    ways = [[_way(row, np.exp(-1j * group[0] * angle), fires) for row in shapes] for group in stars]
    largest = max(_reach(way) for column in ways for way in column)
    arrows: list[_Arrow] = []
    for column, group in enumerate(stars):
        turned = np.exp(-1j * group[0] * angle)
        centre = column + 0.5 + 0.5j
        listed = "\n".join(_order_words(group))
        axes.text(centre.real, 1.04, listed, ha="center", va="bottom", fontsize=8)
        arrows += _star(axes, centre - 0.08j, turned, named, fires)
        for way in ways[column]:
            centre -= 1j * (1.0 + room)
            arrows += _polygon(axes, centre, way, 1.0 / max(largest, 1e-300))
    _draw_arrows(axes, arrows)
    return figure


def _order_words(orders: list[float]) -> list[str]:
    """`order 0.5, 3.5, 6.5 ...` in lines as wide as a column."""
    listed = ", ".join(order_text(q) for q in orders[:4]) + (" ..." if len(orders) > 4 else "")
    return fold(f"order {listed}", 16)


def alike(angle: np.ndarray, order: np.ndarray, mirrored: bool = True) -> list[list[float]]:
    """Orders in groups of equal phases of the cylinders, each group ascending.

    The mirror image of a star gives the same sums where the shapes are real: `mirrored`.
    """
    groups: list[list[float]] = []
    stars: list[np.ndarray] = []
    for q in order:
        star = np.exp(-1j * q * (angle - angle[0]))
        for group, other in zip(groups, stars, strict=True):
            away = np.abs(star - other).max()
            if mirrored:
                away = min(away, np.abs(star.conj() - other).max())
            if away < _ALIKE:
                group.append(float(q))
                break
        else:
            groups.append([float(q)])
            stars.append(star)
    return groups


#: from, to, colour, width in points, whether dashed; phase zero points upwards
_Arrow = tuple[complex, complex, str, float, bool]


def _star(
    axes: "Axes", centre: complex, turned: np.ndarray, named: list[str], fires: np.ndarray
) -> list[_Arrow]:
    """An arrow for each direction, with the cylinders that share it; (3) does not fire."""
    members: list[tuple[complex, list[str], list[bool]]] = []
    for one, name, well in zip(turned, named, fires, strict=True):
        word = name if well else f"({name})"
        for other, together, alive in members:
            if abs(one - other) < _ALIKE:
                together.append(word)
                alive.append(bool(well))
                break
        else:
            members.append((complex(one), [word], [bool(well)]))
    arrows: list[_Arrow] = []
    for one, together, alive in members:
        up = 1j * one
        colour = COLOURS[0] if any(alive) else QUIET
        arrows.append((centre, centre + _REACH * up, colour, 1.3, not any(alive)))
        # several lines of names go away from the arrow
        side = "bottom" if up.imag > 0.9 else "top" if up.imag < -0.9 else "center"
        across = "center" if side != "center" else "left" if up.real > 0.0 else "right"
        at = centre + 1.12 * _REACH * up
        axes.text(at.real, at.imag, _wrapped(together), ha=across, va=side, fontsize=8)
    return arrows


def _wrapped(together: list[str]) -> str:
    """At most four names in a line."""
    return "\n".join(", ".join(together[i : i + 4]) for i in range(0, len(together), 4))


#: corners of the vectors that fire, laid end to end from 0, and of the others after them
_Way = tuple[np.ndarray, np.ndarray]


def _way(row: np.ndarray, turned: np.ndarray, fires: np.ndarray) -> _Way:
    """Vectors of what fires end to end, over what all were in line, and of what does not."""
    steps = 1j * row * turned / max(float(np.abs(row).sum()), 1e-300)
    way = np.concatenate([[0.0], np.cumsum(steps[fires])])
    # what is left out would go on from the end to the sum of all
    return way, way[-1] + np.concatenate([[0.0], np.cumsum(steps[~fires])])


def _reach(way: _Way) -> float:
    """The larger side of what a way covers."""
    corners = np.concatenate(way)
    return float(max(np.ptp(corners.real), np.ptp(corners.imag)))


def _polygon(axes: "Axes", centre: complex, way: _Way, scale: float) -> list[_Arrow]:
    """A way about the centre of its cell, all to one scale so that sums compare, and its sum."""
    every = np.concatenate(way)
    middle = 0.5 * complex(every.real.max() + every.real.min(), every.imag.max() + every.imag.min())
    (fired, rest), start = (scale * (one - middle) + centre for one in way), centre - scale * middle
    arrows: list[_Arrow] = []
    if abs(way[0][-1]) > 1e-3:
        arrows.append((start, fired[-1], LIMIT, 2.6, False))
    arrows += [(a, b, COLOURS[0], 1.3, False) for a, b in pairwise(fired)]
    arrows += [(a, b, QUIET, 1.3, True) for a, b in pairwise(rest)]
    words = f"sum {abs(way[0][-1]):.3f}"
    if way[1].size > 1:
        words += f"\nall {abs(way[1][-1]):.3f}"
    axes.text(centre.real, centre.imag - 0.54, words, ha="center", va="top", fontsize=8)
    axes.plot([start.real], [start.imag], "o", color=TOTAL, ms=3)
    return arrows


def _draw_arrows(axes: "Axes", arrows: list[_Arrow]) -> None:
    """All shafts in one, and all heads, which are shorter where the arrow is."""
    from matplotlib.collections import LineCollection, PolyCollection

    drawn = [one for one in arrows if abs(one[1] - one[0]) > 1e-9]
    start, stop = (np.array([one[i] for one in drawn]) for i in (0, 1))
    colours = [one[2] for one in drawn]
    long = np.abs(stop - start)
    along_ = (stop - start) / long
    back = stop - along_ * np.minimum(_HEAD, long)
    aside = 1j * along_ * np.minimum(_HEAD, long) / 3.0
    lines = np.stack([start, back], axis=1)
    heads = np.stack([stop, back + aside, back - aside], axis=1)
    shafts = LineCollection(
        _points(lines), colors=colours, linewidths=[one[3] for one in drawn],
        linestyles=["--" if one[4] else "-" for one in drawn],
    )  # fmt: skip
    axes.add_collection(shafts, autolim=False)
    axes.add_collection(PolyCollection(_points(heads), facecolors=colours), autolim=False)


def _points(places: np.ndarray) -> list[np.ndarray]:
    """Complex places (n, m) as n rows of points (m, 2)."""
    return list(np.stack([places.real, places.imag], axis=-1))


# ----------------------------------------------------------------------------
# Orders at the operating speed: torque of one cylinder, and torque in the most loaded section.
# ----------------------------------------------------------------------------

_MOST, _NAMED = 40, 5
_PARTS = (("gas", "gas", COLOURS[0]), ("inertia", "inertia", COLOURS[1]), ("total", "both", TOTAL))


def draw_torsion_orders(result: Result) -> "Figure | None":
    """Bars by order, 0-to-peak; None if the line was not driven."""
    record = result.record
    total = having(record, TORSION + "excitation/total", "half_order")
    torque = having(record, TORSION + "torque", "section", "half_order")
    section = worst_section(record)
    place = None if section is None else place_of(torque, section)
    if total is None or torque is None or section is None or place is None:
        return None
    speed = speed_of(result)
    at = f" at {turns(speed)} rpm" if speed is not None else ""
    factor, unit = torque_unit(record)
    figure = canvas(result, f"order spectrum{at}, amplitudes 0-to-peak", 7.0)
    above, below = figure.subplots(2, 1, sharex=True)
    order = np.asarray(total.axes[0].values, dtype=float)[:_MOST]
    step = float(order[1] - order[0]) if order.size > 1 else 1.0
    for number, (name, words, colour) in enumerate(_PARTS):
        part = having(record, f"{TORSION}excitation/{name}", "half_order")
        if part is not None:
            size = factor * np.abs(np.asarray(part.values))[:_MOST]
            shift = (number - 1) * 0.27 * step
            bars(above, order + shift, size, 0.25 * step, color=colour, label=words)
    above.set_ylabel(f"torque of one cylinder\nin {unit}")
    above.legend(loc="upper right")
    row = factor * np.abs(np.asarray(torque.values)[place])[:_MOST]
    major = vector(record, "excitation/major", "half_order")
    strong = np.zeros(row.size, bool) if major is None else major[:_MOST] > 0
    for chosen, colour, words in (
        (strong, COLOURS[1], "major order"),
        (~strong, COLOURS[0], "other order"),
    ):
        if np.any(chosen):
            bars(below, order[chosen], row[chosen], 0.6 * step, color=colour, label=words)
    _name(below, order, row)
    below.set_ylabel(f"torque in section\n{section} in {unit}")
    below.set_xlabel("order (multiple of crank speed)")
    half = entry(having(record, TORSION + "torque_half_range", "section"), section, factor, 4)
    if half:
        words = f"half range of all orders together: {half} {unit}"
        below.set_title(words, loc="left", fontsize=8, color=QUIET)
    below.legend(loc="upper right")
    below.set_xlim(order[0] - step, order[-1] + step)
    ticks(below.xaxis, np.arange(1.0, order[-1] + 0.5, max(1.0, round(order[-1] / 20.0))))
    return figure


def _name(axes: "Axes", order: np.ndarray, row: np.ndarray) -> None:
    for i in np.argsort(-row, kind="stable")[:_NAMED]:
        if row[i] > 0.0:
            note(axes, order_text(order[i]), (order[i], row[i]), (0, 2), ha="center", va="bottom")
    axes.set_ylim(0.0, 1.15 * float(np.max(row, initial=1e-300)))

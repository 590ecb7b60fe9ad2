"""Pictures of what the cylinders do to a shaft line: over a cycle, by order, as vectors."""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    PLATE,
    QUIET,
    TOTAL,
    TYPE,
    WIDTH,
    canvas,
    note,
    unit_words,
    waves,
)
from vibecalc.core.report.curves import Curve, Curves, Mark, Panel, Plot, level, operating, spans
from vibecalc.core.report.sections import having, labels, speed_of, table_of
from vibecalc.core.report.sources import Ends, Source, sourced
from vibecalc.core.report.writing import fold, hertz, rpm, show, turns
from vibecalc.core.results.record import Quantity, Result
from vibecalc.numerics.rounding import BoolArray
from vibecalc.torsion.report.line import (
    TORSION,
    at_speed,
    cell,
    elastic_modes,
    firing_words,
    joined,
    line_of,
    mode_names,
    order_text,
    orders_words,
    place_of,
    row_of,
    silent,
    speed_range,
    torque_unit,
    vector,
    worst_section,
)
from vibecalc.torsion.report.vibration import drawn, may_be_barred
from vibecalc.torsion.results import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Pressure in one cylinder and torques on its throw over a cycle, and those of all cylinders.
# ----------------------------------------------------------------------------

EXCITATION = TORSION + "excitation/"
#: the second speed is so many times the operating one, if the range goes as far; at least the other
_TWICE, _LEAST = 2.0, 1.3
_DASHED = {"color": COLOURS[4], "linestyle": "--", "marker": ""}


def torque_words(result: Result) -> str:
    """The one unit of torque in all pictures of a shaft line."""
    return torque_unit(result.record)[1]


def misfire_words(result: Result) -> list[str]:
    """`cylinder 3 does not fire`, nothing for an engine that fires as it should."""
    found = silent(result)
    many = len(found) > 1
    words = f"cylinder{'s' * many} {joined(found)} do{'' if many else 'es'} not fire"
    return [words] if found else []


def also(words: str) -> Callable[[Result], str]:
    """Words, and what does not fire."""
    return lambda result: ", ".join([words, *misfire_words(result)])


#: more bands than these are drawn as a strip at the foot
BARCODE = 12
_BARRED = (
    (True, "#E69F00", "barred for continuous operation"),
    (False, "#D55E00", "not acceptable: may not be barred"),
)


def barred_shades(named: bool = True) -> Iterator[Mark]:
    """Ranges barred for continuous operation, and those that may not be; `named` in the legend."""
    for permitted, colour, words in _BARRED:
        yield spans(
            f"{TORSION}barred",
            words * named,
            ("from", "to"),
            BARCODE,
            only=partial(_barred_where, permitted=permitted),
            color=colour,
            alpha=0.25,
        )


def _barred_where(result: Result, permitted: bool) -> BoolArray:
    return np.asarray(may_be_barred(result) == permitted)


def _second(result: Result) -> float | None:
    """The second speed over the operating one; None without a range or with gas by speed."""
    speed, train = speed_of(result), table_of(result.case, "machine", "crank_train")
    by_speed = train.get("gas_cards") or table_of(train, "tangential_effort").get("over_speed")
    if not speed or by_speed or not table_of(result.case, "response", "torsion", "speeds"):
        return None
    times = min(_TWICE, speed_range(result)[1] / speed)
    return times if times >= _LEAST else None


def _grown(name: str, times: float, inertia: str) -> Source:
    """A curve, or harmonics, at so many times the speed: inertia goes with the square of that."""

    def made(result: Result) -> Quantity | None:
        found = sourced(EXCITATION + name, result)
        part = sourced(EXCITATION + inertia, result)
        if found is None or part is None or times == 1.0:
            return found
        return replace(found, path="", values=found.values + (times**2 - 1.0) * part.values)

    return made


def _of_orders(curve: Source, harmonics: Source | None) -> Source:
    """What the orders of the case make of a curve over the cycle."""

    def made(result: Result) -> Quantity | None:
        found, total = sourced(curve, result), sourced(EXCITATION + "total", result)
        if found is None or total is None:
            return None
        values, angle = found.values, found.axes[0].values
        order = np.asarray(total.axes[0].values, dtype=float)
        made_of = None if harmonics is None else sourced(harmonics, result)
        # the card has no orders in the result: sums over its points, evenly over the cycle
        amplitude = 2.0 * np.mean(values[:-1] * np.conj(waves(order, angle[:-1])), axis=1)
        amplitude = amplitude if made_of is None else made_of.values
        values = np.mean(values[:-1]) + np.real(amplitude @ waves(order, angle))
        return replace(found, path="", values=values)

    return made


def _orders_words(result: Result) -> str:
    return f"of {orders_words(result.record[EXCITATION + 'total'].axes[0].values, step=False)}"


def _missed(plot: Plot) -> None:
    """By how much the orders miss the curve before them."""
    if len(plot.drawn) > 1:
        (_, curve), (_, made) = plot.drawn[-2:]
        missed = f"{show(float(np.max(np.abs(made - curve))), digits=2)} {plot.unit}"
        words = f"largest deviation of the orders {missed}"
        plot.axes.set_title(words, loc="right", fontsize=8)


def headroom(share: float) -> Callable[[Plot], Ends]:
    """Room for the legend above the curves, a share of their range."""

    def ends(plot: Plot) -> Ends:
        low, high = plot.axes.get_ylim()
        return low, high + share * (high - low)

    return ends


def _one_cylinder(result: Result, times: float) -> Panel:
    grown = partial(_grown, times=times, inertia="inertia_torque")
    total, harmonics = grown("total_torque"), _grown("total", times, "inertia")
    at = at_speed(result)
    if times != 1.0:
        which = "twice the operating speed" if times == _TWICE else "the end of the speed range"
        at = f" at {turns(times * (speed_of(result) or 0.0))} rpm, {which}"
    return Panel(
        "torque of one\ncylinder",
        (
            Curve(EXCITATION + "gas_torque", "gas", {"color": COLOURS[0]}),
            Curve(grown("inertia_torque"), "inertia", {"color": COLOURS[1]}),
            Curve(total, "total", {"color": TOTAL}),
            Curve(_of_orders(total, harmonics), _orders_words, _DASHED),
            _missed,
        ),
        f"one cylinder{at}",
        unit=torque_words,
        ends=headroom(0.22),
        legend={"loc": "upper right", "ncols": 4},
    )


def _over_cycle(result: Result) -> Sequence[Panel]:
    """The card, one cylinder at the operating speed and at a second one, and all cylinders."""
    card, second = EXCITATION + "pressure", _second(result)
    cycle = str(table_of(result.case, "machine").get("cycle") or "").replace("_", "-")
    order = firing_words(result.record, cycle)
    words = "; ".join([f"all cylinders{at_speed(result)}, {order}", *misfire_words(result)])
    return [
        Panel(
            "gauge pressure\n",
            (
                Curve(card, "card", {"color": COLOURS[3]}),
                Curve(_of_orders(card, None), _orders_words, _DASHED),
                _missed,
            ),
            unit="bar",
            legend={"loc": "upper center", "ncols": 3},
        ),
        *(_one_cylinder(result, times) for times in (1.0, second) if times),
        Panel(
            "torque of all\ncylinders",
            (
                Curve(EXCITATION + "engine_torque", "all cylinders", {"color": TOTAL}),
                level(EXCITATION + "mean_torque", "mean {}"),
            ),
            words if order else "",
            unit=torque_words,
            ends=headroom(0.22),
            legend={"loc": "upper right", "ncols": 2},
        ),
    ]


def _cycle_words(result: Result) -> str:
    card = "gas pressure and " * (EXCITATION + "pressure" in result.record)
    return also(f"{card}torques over one cycle{at_speed(result)}")(result)


#: the orders of the case are drawn over the card and the torque that they come from; a table of
#: tangential effort has no card
TORSION_EXCITATION = Curves(_cycle_words, _over_cycle, high=2.35)


# ----------------------------------------------------------------------------
# Vector diagrams: how the torques of the cylinders add up, by order, in the lowest modes.
# ----------------------------------------------------------------------------

_MODES, _STARS = 3, 6
_ALIKE = 1e-6
#: inches at the left for the names of the rows
_MARGIN = 0.45
#: of the side of a cell: the room between rows, a line of words in it, arrows of a star, heads
_ROOM, _LINE, _REACH, _HEAD = 0.22, 0.13, 0.24, 0.07
#: from, to, colour, width in points, whether dashed; phase zero points upwards
_Arrow = tuple[complex, complex, str, float, bool]
#: corners of the vectors that fire, laid end to end from 0, and of the others after them
_Way = tuple[np.ndarray, np.ndarray]


def draw_torsion_vectors(result: Result) -> "Figure | None":
    """Stars of the phases, next to them shape times phase laid end to end for each mode.

    Stars have a column each, fewer ones than modes a row. A cylinder that does not fire is left out
    of the sums, and drawn next to those that do.
    """
    record, line, modes = result.record, line_of(result), elastic_modes(result)[:_MODES]
    firing = having(record, TORSION + "excitation/firing_angle", "cylinder")
    shape = having(record, TORSION + "modes/shape", "mode", "station")
    total = having(record, TORSION + "excitation/total", "order")
    natural = having(record, TORSION + "modes/natural_frequency", "mode")
    if firing is None or shape is None or total is None or natural is None or line is None:
        return None
    angle, named = np.asarray(firing.values, dtype=float), labels(firing.axes[0])
    if angle.size < 2 or not modes:
        return None
    # the mirror image of a star gives the same sums where the shapes are real
    mirrored, order = not np.iscomplexobj(shape.values), np.asarray(total.axes[0].values)
    phases = np.exp(-1j * np.multiply.outer(order, angle - angle[0]))
    every, major = alike(phases, mirrored), vector(record, "excitation/major", "order")
    # those of the major orders, then of the lowest
    every.sort(key=lambda group: major is None or not np.any(np.asarray(major)[group] > 0))
    stars = sorted(every[:_STARS])
    fires = np.array([name not in silent(result) for name in named])
    words = f"phase vectors of the cylinders by order{' (mirror images taken as equal)' * mirrored}"
    words += ";\nby mode: vector sum weighted by the mode shape, relative to all in phase"
    for ill in misfire_words(result):
        words += f"\n{ill}: left out of the sums (dashed); all: as if all cylinders fired"
    values, known = hertz(1.0) * np.asarray(natural.values, dtype=float), mode_names(result)
    tops, sides = [_order_words(order[group]) for group in stars], ["phases"]
    sides += [f"{known[mode]}\n{show(values[mode])} Hz" for mode in modes]
    few = len(tops) < len(sides)
    tops, sides = (sides, tops) if few else (tops, sides)
    wide = max(len(tops), 3)
    side = min(10.0 * (WIDTH - _MARGIN) / TYPE / wide, 2.2)
    down = 1.0 + _ROOM + _LINE * len(misfire_words(result))
    above = 1.0 + _LINE * (max(one.count("\n") for one in tops) + 1.5)
    high = side * (down * (len(sides) - 1) + above) + 0.8 + 0.2 * words.count("\n")
    figure = canvas(result, words, high)
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set_xlim(-10.0 * _MARGIN / TYPE / side, wide)
    axes.set_ylim(-down * (len(sides) - 1), above)
    for place, name in enumerate(sides):
        axes.text(-0.06, 0.5 - down * place, name, rotation=90, ha="right", va="center",
                  fontsize=8, multialignment="center")  # fmt: skip
    for place, name in enumerate(tops):
        axes.text(place + 0.5, 1.04, name, ha="center", va="bottom", fontsize=8)
    turned = [np.exp(-1j * order[group[0]] * angle) for group in stars]
    shapes = [np.asarray(shape.values)[mode][line.cylinder_station] for mode in modes]
    ways = [[_way(row, one, fires) for row in shapes] for one in turned]
    largest = max(max(np.ptp(one.real), np.ptp(one.imag))
                  for column in ways for one in map(np.concatenate, column))  # fmt: skip
    arrows: list[_Arrow] = []
    for place, one in enumerate(turned):
        centre = 0.5 + 0.5j + (-1j * down * place if few else place)
        arrows += _star(axes, centre - 0.08j, one, named, fires)
        for way in ways[place]:
            centre += 1.0 if few else -1j * down
            arrows += _polygon(axes, centre, way, 1.0 / max(float(largest), 1e-300))
    _draw_arrows(axes, arrows)
    return figure


def _order_words(orders: np.ndarray) -> str:
    """`orders 0.5, 3.5, 6.5 ...` in lines as wide as a column."""
    listed = ", ".join(map(order_text, orders[:4])) + " ..." * (len(orders) > 4)
    return "\n".join(fold(f"order{'s' * (len(orders) > 1)} {listed}", 16))


def alike(rows: np.ndarray, mirrored: bool = False) -> list[list[int]]:
    """Places of equal rows of phases in groups; with `mirrored`, conjugate ones are equal."""
    groups: list[list[int]] = []
    for i, row in enumerate(rows):
        same = [row, row.conj()] if mirrored else [row]
        for group in groups:
            if min(np.abs(one - rows[group[0]]).max() for one in same) < _ALIKE:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _star(
    axes: "Axes", centre: complex, turned: np.ndarray, named: list[str], fires: np.ndarray
) -> list[_Arrow]:
    """An arrow for each direction, with the cylinders that share it; (3) does not fire."""
    words = [name if well else f"({name})" for name, well in zip(named, fires, strict=True)]
    arrows: list[_Arrow] = []
    for group in alike(turned[:, None]):
        up, fired = 1j * complex(turned[group[0]]), bool(fires[group].any())
        colour = COLOURS[0] if fired else QUIET
        arrows.append((centre, centre + _REACH * up, colour, 1.3, not fired))
        # several lines of names, at most four in a line, go away from the arrow
        side = "bottom" if up.imag > 0.9 else "top" if up.imag < -0.9 else "center"
        across = "center" if side != "center" else "left" if up.real > 0.0 else "right"
        at, lines = centre + 1.12 * _REACH * up, range(0, len(group), 4)
        text = "\n".join(", ".join(words[j] for j in group[i : i + 4]) for i in lines)
        axes.text(at.real, at.imag, text, ha=across, va=side, fontsize=8)
    return arrows


def _way(row: np.ndarray, turned: np.ndarray, fires: np.ndarray) -> _Way:
    """Vectors of what fires end to end, over what all were in line, and of what does not."""
    steps = 1j * row * turned / max(float(np.abs(row).sum()), 1e-300)
    way = np.concatenate([[0.0], np.cumsum(steps[fires])])
    # what is left out would go on from the end to the sum of all
    return way, way[-1] + np.concatenate([[0.0], np.cumsum(steps[~fires])])


def _polygon(axes: "Axes", centre: complex, way: _Way, scale: float) -> list[_Arrow]:
    """A way about the centre of its cell, all to one scale so that sums compare, and its sum."""
    real, imag = (part(np.concatenate(way)) for part in (np.real, np.imag))
    middle = 0.5 * complex(real.max() + real.min(), imag.max() + imag.min())
    (fired, rest), start = (scale * (one - middle) + centre for one in way), centre - scale * middle
    arrows: list[_Arrow] = []
    if abs(way[0][-1]) > 1e-3:
        arrows.append((start, fired[-1], LIMIT, 2.6, False))
    arrows += [(a, b, COLOURS[0], 1.3, False) for a, b in pairwise(fired)]
    arrows += [(a, b, QUIET, 1.3, True) for a, b in pairwise(rest)]
    words = f"sum {abs(way[0][-1]):.3f}" + f"\nall {abs(way[1][-1]):.3f}" * (way[1].size > 1)
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
    along = (stop - start) / long
    back = stop - along * np.minimum(_HEAD, long)
    aside = 1j * along * np.minimum(_HEAD, long) / 3.0
    lines, heads = (
        list(np.stack([places.real, places.imag], axis=-1))
        for places in (
            np.stack([start, back], axis=1),
            np.stack([stop, back + aside, back - aside], axis=1),
        )
    )
    shafts = LineCollection(
        lines, colors=colours, linewidths=[one[3] for one in drawn],
        linestyles=["--" if one[4] else "-" for one in drawn],
    )  # fmt: skip
    axes.add_collection(shafts, autolim=False)
    axes.add_collection(PolyCollection(heads, facecolors=colours), autolim=False)


# ----------------------------------------------------------------------------
# Orders at the operating speed: torque of one cylinder, and torque in the most loaded section.
# ----------------------------------------------------------------------------

_MOST, _NAMED = 40, 5


def _first_orders(of: Source, major: bool | None = None) -> Source:
    """Sizes of the first orders; of the `major` ones or of the others, if that is said."""

    def made(result: Result) -> Quantity | None:
        found = sourced(of, result)
        if found is None:
            return None
        found = replace(found, axes=(replace(found.axes[0], values=found.axes[0].values[:_MOST]),),
                        values=np.abs(found.values[:_MOST]))  # fmt: skip
        if major is None:
            return found
        strong = vector(result.record, "excitation/major", "order")
        chosen = np.zeros(_MOST, bool) if strong is None else strong[:_MOST] > 0
        own = np.where(chosen[: found.values.size] == major, found.values, 0.0)
        return replace(found, path="", values=own) if np.any(own) else None

    return made


def _in_section(result: Result) -> Quantity | None:
    return row_of(TORSION + "torque", worst_section(result.record))(result.record)


def _half_range(result: Result) -> str:
    """Of the most loaded section, in words."""
    half = having(result.record, TORSION + "torque_half_range", "section")
    place, (factor, unit) = place_of(half, worst_section(result.record)), torque_unit(result.record)
    if place is None:
        return ""
    words = f"{cell(half, place, factor)} {unit_words(unit)[1]}"
    return f"half range of all orders together: {words}"


def _strongest(plot: Plot) -> None:
    """Numbers of the largest orders."""
    order, row = plot.drawn[0][0], np.max([y for _, y in plot.drawn], axis=0)
    for i in np.argsort(-row, kind="stable")[:_NAMED]:
        if row[i] > 0.0:
            note(plot.axes, order_text(order[i]), (order[i], row[i]), (0, 2), ha="center",
                 va="bottom")  # fmt: skip


TORSION_ORDERS = Curves(
    lambda result: f"order spectrum{at_speed(result)}, amplitudes 0-to-peak",
    (
        Panel(
            "torque of one cylinder\n",
            tuple(
                Curve(_first_orders(EXCITATION + name), words, {"color": colour}, bars=True)
                for name, words, colour in (("gas", "gas", COLOURS[0]),
                    ("inertia", "inertia", COLOURS[1]), ("total", "total", TOTAL))
            ),
            unit=torque_words,
            legend={"loc": "upper right"},
            needs=(EXCITATION + "total", _in_section),
        ),
        Panel(
            lambda result: f"torque in section\n{worst_section(result.record)}",
            (
                Curve(_first_orders(_in_section, True), "major order", {"color": COLOURS[1]},
                      bars=True),
                Curve(_first_orders(_in_section, False), "other order", {"color": COLOURS[0]},
                      bars=True),
                _strongest,
            ),
            _half_range,
            unit=torque_words,
            ends=(0.0, None),
            legend={"loc": "upper right"},
            stacked=True,
            needs=(EXCITATION + "total",),
        ),
    ),
)  # fmt: skip


# ----------------------------------------------------------------------------
# Orders in thin lines with their number at the maximum, their sum thick, the sum of their
# magnitudes dashed; limits, barred ranges and measured points with them.
# ----------------------------------------------------------------------------

#: orders that are drawn at most, and of the largest one what they have at least
_ORDERS, _FAINT = 8, 0.03
#: panels of one picture; times the curves, from which on a limit is told and not drawn
_PANELS, _FAR_LIMIT = 8, 3.0
#: of the axis, how near to its ends a number stands inside
_EDGE = 0.03
_OF_SECTIONS, _OF_STATIONS = (
    [name for name, (axis, *_) in QUANTITIES.items() if axis == one]
    for one in ("section", "station")
)
_UNITS = {
    "stress": "N/mm^2",
    "angular_speed": "rad/s",
    "angular_acceleration": "rad/s^2",
}


def _named_panels(of: Collection[str], result: Result) -> Sequence[Panel]:
    """One for each of some quantities of each shaft or station."""
    found = [
        _named_panel(name, one)
        for name, quantity in drawn(result.record)
        if name in of
        for one in labels(quantity.axes[0])
    ]
    return found[:_PANELS]


TORSION_CURVES, TORSION_STATION_CURVES = (
    Curves(f"orders of named {what} against speed", partial(_named_panels, of), high=2.7, columns=2)
    for what, of in (("shafts", _OF_SECTIONS), ("stations", _OF_STATIONS))
)


def _named_panel(name: str, one: str) -> Panel:
    of_all = {"color": TOTAL, "linewidth": 2.0, "marker": ""}
    dashed = {"color": QUIET, "linestyle": "--", "linewidth": 1.1, "marker": ""}
    limit = {"color": LIMIT, "linewidth": 1.4, "marker": ""}
    parts: tuple[Mark, ...] = (
        Curve(_own(name, "sum", one), "sum of magnitudes", dashed),
        Curve(_own(name, "half_range", one), "half range of all orders", of_all),
        _orders(name, one),
        _measured(name, one),
        operating,
        *barred_shades(),
    )
    if name == "stress":
        lasting, passing = (_own(name, path, one, finite=True) for path in ("allowed", "transient"))
        parts += (
            Curve(lasting, "allowed, continuous operation", limit),
            Curve(passing, "allowed, passage", {**limit, "linestyle": "-."}),
        )
    words = name.replace("_", " ")
    return Panel("{}", parts, f"{one}: {words}", unit=_UNITS.get(name, ""), ends=_curve_ends)


def _curve_ends(plot: Plot) -> Ends:
    """From zero to above the sums, and above the limits where these are not far away."""
    sums, *others = (float(np.nanmax(y, initial=0.0)) for _, y in plot.drawn[:1] + plot.drawn[2:])
    top = max([sums, *plot.points])
    beyond = [one for one in others if one > _FAR_LIMIT * top]
    for one in beyond[:1]:
        words = f"allowed: {show(one, digits=3)} {plot.unit}"
        note(plot.axes, words, (0.98, 0.97), (0, 0), ha="right", va="top", color=LIMIT, bbox=PLATE,
             xycoords="axes fraction", fontsize=8, zorder=8)  # fmt: skip
    return 0.0, 1.12 * max([top, *(one for one in others if one not in beyond)]) or None


def _own(name: str, path: str, one: str, finite: bool = False) -> Source:
    """The curve of one shaft or station; none where it is `finite` nowhere."""

    row = row_of(f"{TORSION}curves/{name}/{path}", one)

    def made(result: Result) -> Quantity | None:
        found = row(result.record)
        known = found is not None and (not finite or np.isfinite(found.values).any())
        return found if known else None

    return made


def _orders(name: str, one: str) -> Mark:
    """The largest orders, each with its number at its maximum."""

    def draw(plot: Plot) -> None:
        found = plot.result.record.quantities.get(f"{TORSION}curves/{name}/order")
        place = place_of(found, one)
        if found is None or place is None:
            return
        sizes = np.abs(found.values[place])
        sizes = np.where(np.isfinite(sizes), sizes, np.nan)
        tops = np.nan_to_num(sizes).max(axis=1)
        x = rpm(1.0) * np.asarray(found.axes[-1].values, dtype=float)
        strong = np.argsort(-tops, kind="stable")[:_ORDERS]
        strong = strong[tops[strong] >= _FAINT * tops.max(initial=0.0)]
        for i in np.sort(strong):
            order, y = order_text(found.axes[1].values[i]), plot.factor * sizes[i]
            colour, _ = plot.colour(f"order {order}")
            plot.axes.plot(x, y, color=colour, linewidth=0.8, zorder=3)
            best = int(np.nanargmax(sizes[i]))
            side = "left" if best < _EDGE * len(x) else "center"
            side = "right" if best > (1.0 - _EDGE) * len(x) else side
            aside = {"left": 3, "center": 0, "right": -3}[side]
            note(plot.axes, order, (float(x[best]), float(y[best])), (aside, 2), ha=side,
                 va="bottom", color=colour, bbox=PLATE, zorder=6)  # fmt: skip

    return draw


def _measured(name: str, one: str) -> Mark:
    """Measured half ranges as hollow circles, measured orders as small squares."""

    def draw(plot: Plot) -> None:
        record, stem = plot.result.record, f"{TORSION}curves/{name}"
        value = record.quantities.get(f"{stem}/measured/value")
        found = record.quantities.get(f"{stem}/order")
        place = place_of(found, one)
        if value is None or found is None or place is None:
            return
        own, speed, order = (
            np.asarray(record[f"{stem}/measured/{part}"].values, dtype=float)
            for part in (found.axes[0].name, "speed", "order")
        )
        mine = own == place + 1
        for some, marker, words in (
            (mine & (order == 0.0), "o", "measured"),
            (mine & (order > 0.0), "s", "measured, one order"),
        ):
            height = plot.factor * np.asarray(value.values, dtype=float)[some]
            if height.size:
                plot.axes.scatter(
                    rpm(1.0) * speed[some], height, s=28.0, linewidths=1.3, zorder=7, label=words,
                    marker=marker, facecolors="none", edgecolors=TOTAL,
                )  # fmt: skip
                plot.points += list(height)

    return draw

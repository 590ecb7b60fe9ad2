"""Pictures of a body on its mounts: forces over a turn, modes, run-up."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    EDGES,
    LIMIT,
    ORDER_NAMES,
    PLATE,
    QUIET,
    TOTAL,
    TRIAD,
    arc_about,
    bounds_of,
    canvas,
    corners,
    note,
    palette,
    project,
    usual,
)
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Ends,
    Look,
    Mark,
    Panel,
    Plot,
    first_of,
    level,
    limits,
    over_turn,
    peak,
    resonances,
    sourced,
    spans,
)
from vibecalc.core.report.sections import along, having, labels, scalar_of, speed_of, table_of
from vibecalc.core.report.writing import hertz, rpm, show
from vibecalc.core.results.record import Quantity, Result
from vibecalc.response.report import main_coordinates

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# The couple over the lever during one turn, body held still and on its mounts.
# ----------------------------------------------------------------------------

_LEVER = "isolation/lever_force/"


def _total(path: str) -> Callable[[Result], str]:
    def words(result: Result) -> str:
        count = result.record[path].values.size
        return "total" if count <= len(ORDER_NAMES) else f"total of {count} orders"

    return words


def _with_peak(words: str, path: str) -> Callable[[Result], str]:
    def title(result: Result) -> str:
        peak = scalar_of(result.record, path)
        return words if peak is None else f"{words}, peak {show(peak, digits=4)} N"

    return title


def _over_cycle(name: str, words: str) -> Panel:
    path = f"{_LEVER}{name}_harmonics"
    orders = [
        Curve(over_turn(path, partial(np.equal, order)), said)
        for order, said in ORDER_NAMES.items()
    ]
    total = Curve(over_turn(path), _total(path), {"color": TOTAL, "linewidth": 2.0})
    peak = f"{_LEVER}{name}_peak"
    return Panel("force", (*orders, total, limits(peak, mirrored=True)), _with_peak(words, peak))


FORCE_OVER_CYCLE = Curves(
    "couple over the lever during one turn",
    (
        _over_cycle("rigid", "without isolation: body held still"),
        _over_cycle("steady", "through the mounts"),
    ),
)


# ----------------------------------------------------------------------------
# Couple of the cylinders' torque on the body, and the load of every support, over the cycle.
# ----------------------------------------------------------------------------

_ROOT = "isolation/torque_reaction/"
_FORCES = "isolation/support_force/steady_harmonics"
#: of the largest order of a couple, what the last has to reach for ripples to be seen
_RIPPLE = 2e-3


def _reaction(result: Result) -> str:
    couple = result.record[f"{_ROOT}couple"]
    kind = table_of(result.case, "machine").get("kind") or "engine"
    orders, size = couple.axes[0].values, np.abs(np.asarray(couple.values))
    title = f"torque reaction: {kind} on its mounts, orders {orders[0]:g} to {orders[-1]:g}"
    ripples = size[-1] > _RIPPLE * size.max()
    return title + ("; ripples stand for those left out" if ripples else "")


def _mean(result: Result) -> float:
    return scalar_of(result.record, f"{_ROOT}mean_couple") or 0.0


def _couple(result: Result) -> Quantity | None:
    """The couple with its mean."""
    found = sourced(over_turn(f"{_ROOT}couple"), result)
    return None if found is None else replace(found, values=found.values + _mean(result))


def _loads(result: Result) -> Quantity | None:
    """What each support carries about its mean load, downwards, with that load in its name."""
    found = sourced(over_turn(_FORCES), result) if _couple(result) is not None else None
    if found is None:
        return None
    up, still = _up(result), _still(result)
    named = zip(labels(found.axes[0]), still, strict=True)
    names = np.array([f"{name}: {show(load, digits=4)}" for name, load in named], dtype=object)
    mounts = replace(found.axes[0], values=names)
    return replace(found, values=-found.values[:, up], axes=(mounts, found.axes[2]))


def _up(result: Result) -> int:
    return "xyz".index(str(table_of(result.case, "isolation").get("up") or "z"))


def _still(result: Result) -> np.ndarray:
    """Mean load of each support."""
    weight = having(result.record, "isolation/support_force/static", "mount")
    mean = having(result.record, "isolation/support_force/mean", "mount", "direction")
    count = result.record[_FORCES].axes[0].values.size
    load = np.zeros(count) if weight is None else np.asarray(weight.values)
    return load - (0.0 if mean is None else np.asarray(mean.values)[:, _up(result)])


def _lifted(plot: Plot) -> None:
    """Where a support carries nothing, if one comes near it."""
    curves = [y for _, y in plot.drawn]
    names = labels(plot.result.record[_FORCES].axes[0])
    for name, load, (colour, _), y in zip(
        names, _still(plot.result), map(palette, range(len(names))), curves, strict=True
    ):
        if load + y.min() < 0.0 or -load > 1.2 * min(float(one.min()) for one in curves):
            plot.axes.axhline(-load, color=colour, linestyle=":", linewidth=1.2)
            note(plot.axes, f"{name} carries nothing", (0.0, -load), (4, 2), color=LIMIT,
                 xycoords=plot.axes.get_yaxis_transform())  # fmt: skip


ENGINE_MOUNTS = Curves(
    _reaction,
    (
        Panel(
            "couple",
            (Curve(_couple, look={"color": TOTAL}), level(_mean)),
            lambda result: (
                "couple on the body about the crankshaft, "
                f"mean {show(_mean(result), digits=4)} N m (dashed)"
            ),
            unit="N*m",
            needs=(_loads,),
        ),
        Panel(
            "load",
            (Curve(_loads, "{}", most=99), _lifted),
            "load on each support about its mean: torque and shaking, downwards",
            unit="N",
            legend={"title": "support: mean\nin N", "loc": "center left",
                    "bbox_to_anchor": (1.0, 0.5)},
        ),
    ),
    high=3.05,
)  # fmt: skip


# ----------------------------------------------------------------------------
# Transmissibility of the pitch model against the frequency ratio, with the orders marked.
# ----------------------------------------------------------------------------

_BASE = "isolation/pitch/"
#: Orders named in the legend; a long rod ratio has 70, which no picture has room for.
_NAMED = 8


def _decibel(values: Any) -> Any:
    """20 log10 |T|; what is zero or infinite is a gap."""
    size = np.abs(np.asarray(values))
    return 20.0 * np.log10(np.where((size > 0.0) & np.isfinite(size), size, np.nan))


def _degrees(values: Any) -> Any:
    return np.degrees(np.angle(values))


def _ratio(result: Result) -> float:
    """Crank speed over the natural frequency, 0 if one is not known."""
    natural = scalar_of(result.record, _BASE + "natural_frequency")
    return (speed_of(result) or 0.0) / natural if natural else 0.0


def _orders(plot: Plot, part: Callable[[Any], Any] = _decibel) -> None:
    """A dot for each order, named by its level."""
    found = having(plot.result.record, _BASE + "transmissibility", "order")
    if found is None:
        return
    named = _NAMED if part is _decibel else 0
    order, heights = found.axes[0].values, part(found.values)
    for i, (at, height) in enumerate(zip(_ratio(plot.result) * order, heights, strict=True)):
        words = f"order {int(order[i])}: {height:.1f} dB" if i < named else None
        plot.axes.plot([at], [height], "o", color=palette(i)[0], label=words)
    if len(order) > named > 0:
        plot.axes.plot([], [], " ", label=f"and up to order {int(order[-1])}")


def _isolates(plot: Plot) -> None:
    plot.axes.axhline(0.0, color=QUIET)
    plot.axes.axvline(np.sqrt(2.0), color=QUIET, linestyle=":", linewidth=1.2)
    note(plot.axes, "isolates beyond $\\sqrt{2}$", (np.sqrt(2.0), 1.0), (5, -12),
         xycoords=plot.axes.get_xaxis_transform(), color=QUIET)  # fmt: skip


TRANSMISSIBILITY = Curves(
    "transmissibility of the mounts, pitch",
    (
        Panel(
            "|force out / force in| in dB",
            (Curve(_BASE + "transmissibility_curve", part=_decibel, look={"color": TOTAL}),
             _orders, _isolates),
            log="x",
            height=2.0,
            legend={"loc": "lower left"},
        ),
        Panel(
            "phase in deg",
            (Curve(_BASE + "transmissibility_curve", part=_degrees, look={"color": TOTAL}),
             partial(_orders, part=_degrees)),
            log="x",
            ends=(-185.0, 5.0),
            below="excitation frequency / natural frequency",
        ),
    ),
    high=2.45,
)  # fmt: skip


# ----------------------------------------------------------------------------
# The run-up: at each speed the largest force over the cycle, with limits and resonances.
# ----------------------------------------------------------------------------

_NATURAL = ("isolation/modes/natural_frequency", "isolation/pitch/natural_frequency")
#: Room above the curves for the words of resonances, as a factor, for one mode and for several.
_ROOM = (1.2, 1.9)


def _run_up_ends(plot: Plot) -> Ends:
    """Speeds from well below the first resonance on; forces, where they have no bound, in decades.

    Flanks of an undamped resonance go up without end: in between, nothing would be left to see.
    """
    record, (speed, _) = plot.result.record, plot.drawn[0]
    natural = rpm(1.0) * first_of(record, *_NATURAL)
    first = 0.5 * min(natural, default=2.0 * float(speed.max()))
    low = max(float(speed.min()), 0.25 * min(first, float(speed.max())))
    plot.axes.set_xlim(low, float(speed.max()))
    masked = record.quantities.get("isolation/masked/low")
    if masked is None or not masked.values.size:
        tops = [float(np.nanmax(y, initial=0.0)) for _, y in plot.drawn]
        return 0.0, _ROOM[natural.size > 1] * max([*tops, *plot.points])
    curves = [np.nan_to_num(y) for _, y in plot.drawn]
    middle = usual(speed, np.max(curves, axis=0), low, float(speed.max()))
    plot.axes.set_yscale("log")
    return 1e-2 * middle, max([1e3 * middle, *(3.0 * one for one in plot.points)])


def _steady(path: str) -> Mark:
    """Limits of the steady state, at the operating speed."""

    def draw(plot: Plot) -> None:
        speed = speed_of(plot.result)
        for words, bound in bounds_of(plot.result, path) if speed is not None else ():
            at, height = rpm(speed or 0.0), plot.factor * bound
            plot.axes.plot([at], [height], "v", color=LIMIT, markersize=9, clip_on=False)
            note(plot.axes, f"steady {words}", (at, height), (-4, 7), ha="right", color=LIMIT)
            plot.points.append(height)

    return draw


def _run_up(path: str, label: str, look: Look, **more: Any) -> Panel:
    top = f"{path}/run_up_peak"
    return Panel(
        f"{label}\nforce",
        (
            Curve(f"{path}/run_up", "{each}", look),
            limits(top, "run-up"),
            _steady(f"{path}/steady_peak"),
            resonances(*_NATURAL),
            spans("isolation/masked"),
            peak(top, f"{top}_speed"),
        ),
        unit="N",
        log="x",
        ends=_run_up_ends,
        **more,
    )


RUN_UP = Curves(
    "run-up: largest force over the cycle",
    (
        _run_up("isolation/lever_force", "couple over the lever", {"color": TOTAL}),
        _run_up("isolation/support_force", "one support on the ground", {},
                legend={"loc": "center left", "frameon": True, "framealpha": 0.9,
                        "edgecolor": "none"}),
    ),
)  # fmt: skip

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
    if shape.values.shape[-1] != 6:
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

"""Pictures of impacts: force over time, over clearance, by order, and which force leads."""

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    PLATE,
    TOTAL,
    canvas,
    clearance_names,
    note,
    plain_ticks,
    spread_out,
)
from vibecalc.core.report.curves import Curve, Curves, Ends, Panel, Plot, entry_of
from vibecalc.core.report.sections import having
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.impact.report import standard_errors

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "response/impact/"
_MOST_HISTORIES = 3

# ----------------------------------------------------------------------------
# Force in the joint over the first turn from rest, with the contacts that can be reproduced.
# ----------------------------------------------------------------------------


def _contacts(plot: Plot, i: int, name: str) -> None:
    """Triangles at the foot, where contacts begin."""
    contacts = having(plot.result.record, _STEM + "first_contacts", "clearance", "contact")
    if contacts is None:
        return
    starts = np.degrees(np.asarray(contacts.values[i], dtype=float))
    starts = starts[np.isfinite(starts) & (starts <= plot.drawn[0][0][-1])]
    plot.axes.plot(starts, np.full(starts.size, 0.015), "^", color=LIMIT, markersize=6,
                   clip_on=False, transform=plot.axes.get_xaxis_transform())  # fmt: skip
    count = "contact" if starts.size == 1 else "contacts"
    plot.axes.set_title(f"{name}, triangles: the first {starts.size} {count}", loc="left")


def _histories(result: Result) -> list[Panel]:
    """A panel for each clearance, three at most."""
    path = _STEM + "first_turn_force"
    force = having(result.record, path, "clearance", "crank_angle")
    names = [] if force is None else clearance_names(force.axes[0])
    look = {"linewidth": 1.0, "color": COLOURS[0]}
    return [
        Panel(
            "force", (Curve(entry_of(path, i), look=look), partial(_contacts, i=i, name=names[i]))
        )
        for i in spread_out(len(names), _MOST_HISTORIES)
    ]


IMPACT_TIME = Curves(
    "joint force over the first turn, from rest in the joint", _histories, high=2.1
)


# ----------------------------------------------------------------------------
# Mean force in the joint against its clearance, with standard error and spread.
# ----------------------------------------------------------------------------

#: ratio of the largest to the smallest from which an axis is logarithmic
_WIDE = 8.0
_WORDS = 8


def _errors(plot: Plot) -> None:
    """Standard errors of the mean, and its numbers where they are few."""
    quantity, spread = (
        plot.result.record[_STEM + "mean_force"],
        standard_errors(plot.result.record, "mean_force"),
    )
    force = np.asarray(quantity.values, dtype=float)
    play = 1e3 * np.asarray(quantity.axes[0].values, dtype=float)
    rank = np.argsort(play)
    if spread is not None:
        # A bar that reaches below zero would have no end on a logarithmic axis.
        bars = np.array([np.minimum(spread, 0.9 * np.abs(force)), spread])[:, rank]
        plot.axes.errorbar(play[rank], force[rank], bars, fmt="o", color=COLOURS[0], capsize=5,
                           label="mean force and its standard error")  # fmt: skip
    # Above its point, or next to the band that a single point stands on.
    shift, align = ((0, 9), "center") if play.size > 1 else ((14, -4), "left")
    for x, y in zip(play, force, strict=True) if play.size <= _WORDS else ():
        note(plot.axes, f"{show(y, digits=3)} {quantity.unit}", (x, y), shift, ha=align)


def _wide(plot: Plot) -> Ends:
    """Where forces or clearances span decades their axis is logarithmic."""
    play, force = plot.drawn[0][0], np.concatenate([y for _, y in plot.drawn[-3:]])
    if play.min() > 0.0 and play.max() / play.min() > _WIDE:
        plot.axes.set_xscale("log")
        plot.axes.set_xlim(play.min() / 1.6, 1.6 * play.max())
    elif play.size > 1:
        plot.axes.margins(x=0.12)
        plot.axes.autoscale(axis="x")
    else:
        plot.axes.set_xlim(0.0, 2.0 * play[0])
    if force.min() > 0.0 and force.max() / force.min() > _WIDE:
        plot.axes.set_yscale("log")
        return force.min() / 2.0, 2.0 * force.max()
    plot.axes.margins(y=0.15)
    return 0.0, None


IMPACT_CLEARANCE = Curves(
    "force of impacts against clearance",
    (
        Panel(
            "force",
            (
                Curve(_STEM + "mean_force_low", "mean force, 5 to 95 % of turns",
                      {"color": COLOURS[5], "alpha": 0.35}, upto=_STEM + "mean_force_high"),
                Curve(_STEM + "mean_force", "", {"color": COLOURS[0], "marker": ""}),
                _errors,
                Curve(_STEM + "peak_force", "largest force of a turn, mean",
                      {"color": COLOURS[1], "marker": "s", "linestyle": "--"}),
                Curve(_STEM + "average_amplitude",
                      "mean of the joint force's spectrum over its orders",
                      {"color": COLOURS[2], "marker": "D", "linestyle": ":"}),
            ),
            ends=_wide,
            unit="N",
            needs=(_STEM + "mean_force",),
            below="clearance in mm",
        ),
    ),
    high=4.1,
    names=2,
)  # fmt: skip


# ----------------------------------------------------------------------------
# Spectrum of the joint force with the spread of single turns, next to the inertia force.
# ----------------------------------------------------------------------------

_AXES = ("clearance", "order")
_MOST_SPECTRA = 3
#: decades shown below the smallest of the bands
_BELOW = 0.3
#: inertia forces below this share of the largest are not drawn
_FAINT = 1e-9


def draw_impact_spectrum(result: Result) -> "Figure | None":
    """Linear above and logarithmic below, a column for each clearance; None without spectrum."""
    record = result.record
    spectrum = having(record, _STEM + "spectrum", *_AXES)
    if spectrum is None:
        return None
    names = clearance_names(spectrum.axes[0])
    chosen = spread_out(len(names), _MOST_SPECTRA)
    figure = canvas(result, "spectrum of the joint force", 6.6)
    grid = figure.subplots(2, len(chosen), squeeze=False, sharex=True)
    for column, i in zip(grid.T, chosen, strict=True):
        for axes in column:
            _curves(axes, record, spectrum, i)
        column[0].set_title(names[i], loc="left")
        _linear(column[0], record, spectrum, i)
        column[1].set_yscale("log")
        column[1].set_ylim(*_window(record, spectrum, i))
        column[1].set_xlabel("order")
    for axes in grid[:, 0]:
        axes.set_ylabel(f"amplitude in {spectrum.unit}")
    grid[0, 0].set_xlim(0.0, float(np.max(spectrum.axes[1].values)))
    handles, words = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=2)
    return figure


def _curves(axes: "Axes", record: Record, spectrum: Quantity, i: int) -> None:
    orders = np.asarray(spectrum.axes[1].values)
    low, high = _band(record)
    if low is not None and high is not None:
        axes.fill_between(
            orders,
            np.abs(low.values[i]),
            np.abs(high.values[i]),
            color=COLOURS[5],
            alpha=0.45,
            linewidth=0.0,
            label="5 to 95 % of turns",
        )
    mean = np.abs(spectrum.values[i])
    axes.plot(orders, mean, color=COLOURS[0], label="joint force, mean of turns")
    average = having(record, _STEM + "average_amplitude", "clearance")
    if average is not None:
        level = float(abs(average.values[i]))
        axes.axhline(
            level, color=LIMIT, linestyle="--", linewidth=1.2, label="its mean over the orders"
        )
    shaking = having(record, _STEM + "shaking", "order")
    if shaking is not None:
        values: Any = np.abs(shaking.values)
        acting = values > _FAINT * values.max()
        places, sizes = broken(np.asarray(shaking.axes[0].values), values, acting)
        axes.plot(places, sizes, "o-", color=TOTAL, linewidth=1.0, ms=4.0, label="inertia force")


def _linear(axes: "Axes", record: Record, spectrum: Quantity, i: int) -> None:
    """The joint force fills the linear axis; words say how high the inertia force goes beyond."""
    _, high = _band(record)
    top = 1.1 * float(np.max(np.abs((spectrum if high is None else high).values[i])))
    axes.set_ylim(0.0, top if top > 0.0 else 1.0)
    shaking = having(record, _STEM + "shaking", "order")
    if shaking is None or float(np.max(np.abs(shaking.values))) <= top:
        return
    axes.annotate(
        f"inertia force to {show(np.max(np.abs(shaking.values)), digits=3)} {shaking.unit}",
        (0.97, 0.97),
        xycoords="axes fraction",
        ha="right",
        va="top",
        fontsize=8,
        color=TOTAL,
    )


def _band(record: Record) -> tuple[Quantity | None, Quantity | None]:
    low, high = (having(record, f"{_STEM}spectrum_{end}", *_AXES) for end in ("low", "high"))
    return low, high


def _window(record: Record, spectrum: Quantity, i: int) -> tuple[float, float]:
    """Ends of the logarithmic axis: the joint force with its band; the inertia force leaves it."""
    low, high = _band(record)
    values = [np.abs(spectrum.values[i])]
    values += [np.abs(q.values[i]) for q in (low, high) if q is not None]
    shaking = having(record, _STEM + "shaking", "order")
    every = np.concatenate(values)
    positive = every[every > 0.0]
    bottom = float(positive.min()) if positive.size else 1e-3
    top = float(every.max()) if positive.size else 1.0
    if shaking is not None:
        top = max(top, float(np.max(np.abs(shaking.values))))
    return 10.0**-_BELOW * bottom, 3.0 * top


# ----------------------------------------------------------------------------
# Which force leads at which order: inertia of the piston, impacts, axial force of the motor.
# ----------------------------------------------------------------------------

_MOST_PANELS = 4
_MOTOR = "#8A5A00"


def draw_dominance(result: Result) -> "Figure | None":
    """Amplitudes against order on a logarithmic axis; None without both kinds of force.

    Of the impacts it is what the play adds to the inertia force that shakes the body.
    """
    record = result.record
    added = having(record, _STEM + "added_force", "clearance", "order")
    shaking = having(record, _STEM + "shaking", "order")
    if added is None or shaking is None:
        return None
    figure = canvas(result, "forces against order: which one leads", 5.8)
    axes = figure.subplots()
    axes.set_yscale("log")
    orders = np.asarray(added.axes[1].values)
    chosen = spread_out(len(added.values), _MOST_PANELS)
    names = clearance_names(added.axes[0])
    impacts = np.abs(np.asarray(added.values)[chosen])
    places = np.asarray(shaking.axes[0].values)
    _points(axes, places, np.abs(shaking.values), "inertia force of the piston", TOTAL, "o-")
    for i, row in zip(chosen, impacts, strict=True):
        colour = COLOURS[chosen.index(i)]
        acting = (row > 0.0) & (orders > 0)
        axes.plot(*broken(orders, row, acting), color=colour, label=f"impacts add, {names[i]}")
    motor = having(record, _STEM + "motor", "order")
    if motor is not None:
        own = np.asarray(motor.axes[0].values)
        _points(axes, own, np.abs(motor.values), "axial force of the motor", _MOTOR, "s:")
    positive = impacts[impacts > 0.0]
    bottom = float(positive.min()) if positive.size else 1e-3
    if motor is not None and np.any(np.abs(motor.values) > 0.0):
        size = np.abs(motor.values)
        bottom = min(bottom, float(size[size > 0.0].min()))
    top = max(float(impacts.max()), float(np.max(np.abs(shaking.values))))
    axes.set_ylim(0.3 * bottom, 30.0 * top)
    axes.set_xscale("log")
    plain_ticks(axes.xaxis)
    axes.set_xlim(0.85, 1.1 * float(max(orders[-1], 2)))
    _leads(axes, record, chosen, top)
    axes.set_xlabel("order")
    axes.set_ylabel(f"amplitude in {added.unit}")
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _points(
    axes: "Axes", orders: np.ndarray, values: Any, words: str, colour: str, style: str
) -> None:
    places, sizes = broken(orders, values, (np.asarray(values) > 0.0) & (orders > 0))
    axes.plot(places, sizes, style, color=colour, linewidth=1.1, ms=4.0, label=words)


def broken(
    orders: np.ndarray, values: np.ndarray, acting: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The acting orders and their values, with NaN between two that are not neighbours.

    A line does not cross an order that has no force.
    """
    kept = np.asarray(orders)[acting]
    apart = np.flatnonzero(np.diff(kept) > 1) + 1
    places = np.insert(kept.astype(float), apart, np.nan)
    return places, np.insert(np.asarray(values, dtype=float)[acting], apart, np.nan)


def _leads(axes: "Axes", record: Record, chosen: list[int], top: float) -> None:
    """A mark at the order from which impacts lead, at a height of its own for each clearance."""
    leads = having(record, _STEM + "dominant_from", "clearance")
    if leads is None:
        return
    for row, i in enumerate(chosen):
        order = int(leads.values[i])
        colour = COLOURS[row]
        height = top * 30.0 ** (0.92 - 0.23 * row)
        if order > 0:
            axes.vlines(order, 0.0, height, color=colour, linestyle=":", linewidth=1.2)
        words = f"these lead from order {order}" if order > 0 else "these lead nowhere"
        note(axes, words, (max(order, 1), height), (5, 0), color=colour, va="center", bbox=PLATE)

"""Pictures of impacts: force over time, over clearance, by order, and which force leads."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, PLATE, TOTAL, note, spread_out
from vibecalc.core.report.curves import Curve, Curves, Panel, Plot, level
from vibecalc.core.report.sections import having, table_of
from vibecalc.core.report.sources import Ends, Look, Source, entry_of, sourced
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Result
from vibecalc.core.results.verdicts import entries
from vibecalc.impact.report import standard_error
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STEM = "response/impact/"
#: clearances that a picture has room for
_HISTORIES, _SPECTRA, _AMPLITUDES = 3, 3, 4
#: of a clearance, how near another is the same
_SAME = 1e-6


def _drawn(result: Result, path: str, most: int) -> dict[int, str]:
    """Places and names of clearances: the case's own, those of references, and others between."""
    found = having(result.record, path, "clearance", "order") or having(
        result.record, path, "clearance", "crank_angle"
    )
    if found is None:
        return {}
    values = found.axes[0].values.astype(float)
    places = [row.get("where") or {} for row in entries(result, "reference")]
    asked = [row["clearance"] for row in places if "clearance" in row]
    own = table_of(result.case, "machine", "joints", "wrist_pin").get("clearance")
    asked += [] if own is None else [own]
    near = (np.abs(values - parse_quantity(one, "m")) <= _SAME * values for one in asked)
    chosen = spread_out(len(values), most, np.flatnonzero(np.any([*near], axis=0)).tolist())
    return {i: f"clearance {1e3 * values[i]:.4g} mm" for i in chosen}


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
    path, look = _STEM + "first_turn_force", {"linewidth": 1.0, "color": COLOURS[0]}
    return [
        Panel("force", (Curve(entry_of(path, i), look=look), partial(_contacts, i=i, name=name)))
        for i, name in _drawn(result, path, _HISTORIES).items()
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
    quantity, spread = plot.result.record[_STEM + "mean_force"], standard_error(plot.result.record)
    force, play = quantity.values, 1e3 * quantity.axes[0].values
    if spread is not None:
        # A bar that reaches below zero would have no end on a logarithmic axis.
        bars = np.array([np.minimum(spread.values, 0.9 * np.abs(force)), spread.values])
        plot.axes.errorbar(play, force, bars, fmt="o", color=COLOURS[0], capsize=5,
                           label="mean force and its standard error")  # fmt: skip
    # Above its point, or next to the band that a single point stands on.
    shift, align = ((0, 9), "center") if play.size > 1 else ((14, -4), "left")
    for x, y in zip(play, force, strict=True) if play.size <= _WORDS else ():
        note(plot.axes, f"{show(y, digits=3)} {quantity.unit}", (x, y), shift, ha=align)


def _wide(plot: Plot) -> Ends:
    """Where forces or clearances span decades their axis is logarithmic."""
    play, force = plot.drawn[0][0], np.concatenate([y for _, y in plot.drawn[-3:]])
    if play.min() > 0.0 and play.max() / play.min() > _WIDE:
        plot.axes.set(xscale="log", xlim=(play.min() / 1.6, 1.6 * play.max()))
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
            needs=(lambda result: having(result.record, _STEM + "mean_force", "clearance"),),
            below="clearance in mm",
        ),
    ),
    high=4.1,
    names=2,
)  # fmt: skip


# ----------------------------------------------------------------------------
# Spectrum of the joint force with the spread of single turns, next to the inertia force.
# ----------------------------------------------------------------------------

#: decades shown below the smallest of the bands
_BELOW = 0.3
#: inertia forces below this share of the largest are not drawn
_FAINT = 1e-9


def _acting(name: str, share: float = 0.0, place: int | None = None) -> Source:
    """A force by order where it acts, of the clearance at `place` where there are several."""

    def made(result: Result) -> Quantity | None:
        path = _STEM + name
        found = sourced(path if place is None else entry_of(path, place), result)
        if found is None:
            return None
        size, axis = np.abs(found.values).reshape(-1), found.axes[-1]
        acting = (size > share * size.max()) & (axis.values > 0)
        if not acting.any():
            return None
        places, sizes = broken(axis.values, size, acting)
        return replace(found, path="", values=sizes, axes=(replace(axis, values=places),))

    return made


def broken(
    orders: np.ndarray, values: np.ndarray, acting: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The acting orders and their values, with NaN between two that are not neighbours.

    A line does not cross an order that has no force.
    """
    kept = np.asarray(orders, dtype=float)[acting]
    apart = np.flatnonzero(np.diff(kept) > 1) + 1
    places = np.insert(kept, apart, kept[apart - 1] + 0.5)
    return places, np.insert(np.asarray(values, dtype=float)[acting], apart, np.nan)


_INERTIA: Look = {"color": TOTAL, "linewidth": 1.0, "marker": "o", "ms": 4.0}


def draw_impact_spectrum(result: Result) -> "Figure | None":
    """Linear above and logarithmic below, a column for each clearance; None without spectrum."""
    chosen = _drawn(result, _STEM + "spectrum", _SPECTRA)
    panels = [_spectrum(i, "" if log else name, i == next(iter(chosen)), log)
              for log in (False, True) for i, name in chosen.items()]  # fmt: skip
    words = "spectrum of the joint force"
    return Curves(words, tuple(panels), high=2.65, columns=len(chosen), names=2)(result)


def _spectrum(i: int, title: str, first: bool, log: bool) -> Panel:
    def average(result: Result) -> float | None:
        found = having(result.record, _STEM + "average_amplitude", "clearance")
        return None if found is None else abs(float(found.values[i]))

    low, high, mean = (entry_of(f"{_STEM}spectrum{end}", i) for end in ("_low", "_high", ""))
    band = {"color": COLOURS[5], "alpha": 0.45}
    parts = (
        Curve(low, "5 to 95 % of turns", band, upto=high),
        Curve(mean, "joint force, mean of turns", {"color": COLOURS[0], "marker": ""}),
        level(average, "mean over the orders", color=LIMIT),
        Curve(_acting("shaking", _FAINT), "inertia force", _INERTIA),
    )
    ends = _window if log else _linear
    label = "amplitude" if first else ""
    return Panel(
        label, parts, title, unit="N", log="y" * log, ends=ends, below="order", needs=(mean,)
    )


def _linear(plot: Plot) -> Ends:
    """The joint force fills the linear axis; words say how high the inertia force goes beyond."""
    tops = [float(np.nanmax(y)) for _, y in plot.drawn]
    inertia = sourced(_acting("shaking", _FAINT), plot.result) is not None
    top = 1.1 * max(tops[:-1] if inertia else tops) or 1.0
    if inertia and tops[-1] > top:
        words = f"inertia force to {show(tops[-1], digits=3)} N"
        note(plot.axes, words, (0.97, 0.97), (0, 0), xycoords="axes fraction", ha="right", va="top",
             color=TOTAL)  # fmt: skip
    return 0.0, top


def _window(plot: Plot) -> Ends:
    """The joint force with its band in full, the inertia force upwards."""
    joint = np.concatenate([y[y > 0.0] for _, y in plot.drawn[:3]])
    top = max(float(np.nanmax(y)) for _, y in plot.drawn)
    return (10.0**-_BELOW * float(joint.min()) if joint.size else 1e-3), 3.0 * top


# ----------------------------------------------------------------------------
# Which force leads at which order: inertia of the piston, impacts, axial force of the motor.
# ----------------------------------------------------------------------------

_MOTOR: Look = {"color": "#8A5A00", "linewidth": 1.1, "marker": "s", "ms": 4.0, "linestyle": ":"}


def _leading(result: Result) -> list[Panel]:
    """Amplitudes against order; of the impacts what the play adds to the inertia force."""
    added = _STEM + "added_force"
    chosen = _drawn(result, added, _AMPLITUDES)
    impacts = (
        Curve(_acting("added_force", place=i), f"impacts add, {name}",
              {"color": COLOURS[row], "marker": ""})
        for row, (i, name) in enumerate(chosen.items())
    )  # fmt: skip
    shaking = _acting("shaking")
    inertia = Curve(shaking, "inertia force of the piston", {**_INERTIA, "linewidth": 1.1})
    motor = Curve(_acting("motor"), "axial force of the motor", _MOTOR)
    parts = (inertia, *impacts, motor)
    return [Panel("amplitude", parts, unit="N", log="xy", ends=partial(_leads, chosen=[*chosen]),
                  needs=(shaking, added))]  # fmt: skip


def _leads(plot: Plot, chosen: list[int]) -> Ends:
    """A mark at the order from which impacts lead, at a height of its own for each clearance."""
    curves = [y[y > 0.0] for _, y in plot.drawn]
    top = max(float(y.max()) for y in curves[: 1 + len(chosen)])
    low = min(float(y.min()) for y in curves[1:] if y.size)
    plot.axes.set_xlim(0.85, 1.1 * max(2.0, *(float(x[-1]) for x, _ in plot.drawn)))
    leads = having(plot.result.record, _STEM + "dominant_from", "clearance")
    for row, i in enumerate(chosen if leads is not None else ()):
        assert leads is not None  # or none is chosen
        order, height = int(leads.values[i]), top * 30.0 ** (0.92 - 0.23 * row)
        if order > 0:
            plot.axes.vlines(order, 0.0, height, color=COLOURS[row], linestyle=":", linewidth=1.2)
        words = f"impacts dominant from order {order}" if order > 0 else "impacts nowhere dominant"
        note(plot.axes, words, (max(order, 1), height), (5, 0), color=COLOURS[row], va="center",
             bbox=PLATE)  # fmt: skip
    return 0.3 * low, 30.0 * top


DOMINANCE = Curves("forces by order: the dominant one", _leading, high=4.5, names=2)

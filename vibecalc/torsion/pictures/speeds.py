"""Pictures of a shaft line against speed: loads, dampers, limits, couplings, named orders."""

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, TOTAL, bounds_of, gaps
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Mark,
    Panel,
    Plot,
    draw_points,
    operating,
    spans,
    through,
)
from vibecalc.core.report.marks import name_above
from vibecalc.core.report.sections import having, labels
from vibecalc.core.report.sources import Ends, Look, Source, sourced
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.pictures.excitation import (
    BARCODE,
    also,
    barred_shades,
    misfire_words,
    torque_words,
)
from vibecalc.torsion.report.limits import limits_of, of_torque, rule_of
from vibecalc.torsion.report.line import (
    MILLI,
    TORSION,
    mode_names,
    names,
    order_text,
    place_of,
    row_of,
    vector,
    worst_section,
)
from vibecalc.torsion.study_results import COUPLING

# ----------------------------------------------------------------------------
# Maxima of the curves of a shaft line: points that the curves go through, and their names.
# ----------------------------------------------------------------------------

#: of the range, how near to its ends a maximum is at one
_AT_END = 1e-6
#: of the highest maximum, and of its own height above the curve next to it, what has a name
_HIGH, _STANDS = 0.1, 0.03
#: maxima that are named at most, and undamped criticals
_NAMED, _CRITICALS = 8, 14
_BY = ("mode", "order")


def top_of(
    record: Record, section: str, load: str = "torque_half_range", root: str = ""
) -> np.ndarray:
    """Speed in rad/s, height in SI, mode and order (0: none) of the highest of a section (n, 4).

    One row, or none where it is not known or has no end.
    """
    parts = []
    for name in ("speed", load, "mode", "order"):
        quantity = having(record, f"{TORSION}{root}largest/{name}", "section")
        place = place_of(quantity, section)
        parts.append(None if quantity is None or place is None else float(quantity.values[place]))
    if parts[0] is None or parts[1] is None or not np.isfinite(parts[1]):
        return np.zeros((0, 4))
    return np.array([[one or 0.0 for one in parts]])


def points_of(record: Record, section: str) -> np.ndarray:
    """All maxima of the torque of a section that are reported (n, 4), by rising speed."""
    columns = ("section", "speed", "torque_half_range", "mode", "order")
    found = [vector(record, f"peak/{name}", "peak") for name in columns]
    there = [np.asarray(one, dtype=float) for one in found if one is not None]
    top, listed = top_of(record, section), names(record, "speeds/torque_half_range", "section")
    if len(there) < len(found) or section not in listed:
        return top
    own = (there[0] == listed.index(section) + 1) & np.isfinite(there[2])
    peaks = np.stack(there[1:], axis=1)[own]
    # the highest is a maximum between the ends of the range, or at one of them
    if not np.any(np.isclose(peaks[:, 0], top[:, :1], rtol=1e-6)):
        peaks = np.concatenate([peaks, top])
    return np.asarray(peaks[np.argsort(peaks[:, 0], kind="stable")])


def main_of(points: np.ndarray, speed: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Maxima that stand out of a curve over speeds in rad/s; of one mode and order the highest."""
    at, tops = points[:, 0], np.where(np.isfinite(points[:, 1]), points[:, 1], 0.0)
    kept: list[int] = []
    for i in np.argsort(-tops, kind="stable").tolist():
        mode, *_ = same = points[i, 2:].tolist()
        named = mode and any(same == points[j, 2:].tolist() for j in kept)
        if named or tops[i] < _HIGH * tops.max():
            continue
        ends = [(min(at[i], at[j]), max(at[i], at[j])) for j in kept]
        between = [curve[(speed >= low) & (speed <= high)] for low, high in ends]
        valley = max((float(np.nanmin(one)) for one in between if one.size), default=0.0)
        if tops[i] - valley >= _STANDS * tops[i]:
            kept.append(i)
    return points[sorted(kept[:_NAMED])]


def name_maxima(plot: Plot, points: np.ndarray, curve: int) -> None:
    """Dots on the maxima that stand out, with their names."""
    x, y = plot.drawn[curve]
    points = main_of(points, x / rpm(1.0), y / plot.factor)
    if points.size:
        at, height = rpm(1.0) * points[:, 0], plot.factor * points[:, 1]
        plot.axes.plot(at, height, "o", color=COLOURS[0], zorder=6,
                       label="maximum, with mode / order")  # fmt: skip
        name_points(plot, points, height)


def name_points(plot: Plot, points: np.ndarray, height: np.ndarray | None = None) -> None:
    """The mode / order of each above the axes, with a line to its `height`, or to the edge."""
    if points.size:
        x, _ = plot.drawn[0]
        at, named = rpm(1.0) * points[:, 0], ["", *mode_names(plot.result)]
        each = zip(at.tolist(), points[:, 2:].tolist(), strict=True)
        words = [_words(where, named[int(mode)], order, (x[0], x[-1]))
                 for where, (mode, order) in each]  # fmt: skip
        name_above(plot, at, words, COLOURS[0], height)


def criticals_of(record: Record, section: str) -> np.ndarray:
    """Undamped criticals (n, 4) as `points_of`, without a height, by rising speed.

    Those at which the torque of the section would be highest with one damping ratio for all modes.
    """
    speed, mode, order = (
        vector(record, f"resonances_skipped/{one}", "resonance_skipped") for one in ("from", *_BY)
    )
    force = having(record, TORSION + "excitation/intensity", "mode", "order")
    share = having(record, TORSION + "modes/strain_energy_share", "mode", "section")
    inertia, natural = (vector(record, f"modes/{one}", "mode") for one in (
        "modal_inertia", "natural_frequency"))  # fmt: skip
    if speed is None or mode is None or order is None or inertia is None or natural is None:
        return np.zeros((0, 4))
    if force is None or share is None or section not in labels(share.axes[1]):
        return np.zeros((0, 4))
    column = labels(share.axes[1]).index(section)
    row, orders = mode.astype(int) - 1, force.axes[1].values
    place = np.minimum(np.searchsorted(orders, order), orders.size - 1)
    size = np.where(orders[place] == order, np.abs(force.values)[row, place], 0.0)
    high = size * np.sqrt(share.values[row, column] / inertia[row]) / natural[row]
    kept = np.sort(np.argsort(-high, kind="stable")[:_CRITICALS])
    return np.stack([speed, np.full(speed.shape, np.nan), mode, order], axis=1)[kept]


def _words(at: float, mode: str, order: float, ends: tuple[float, float]) -> str:
    """`1-node / 3`, or why there is none."""
    if mode and order:
        return f"{mode} / {order_text(order)}"
    near = _AT_END * (ends[1] - ends[0])
    return "end" if at - ends[0] <= near or ends[1] - at <= near else "several"


# ----------------------------------------------------------------------------
# Load of the sections of a shaft line against speed, with and without dampers, with limits.
# ----------------------------------------------------------------------------

#: curves of a panel; fewer where undamped criticals make spikes of them
_MOST, _MOST_SPIKY = 6, 3
#: ratio of the curves from which on the axis is logarithmic
_FAR = 4.0
#: of the highest value, the least that a logarithmic axis shows
_DEEP = 1e-3
_SHADES = (
    ("hammering", "#CC79A7", 0.15, "gear hammer"),
    ("resonances_skipped", "#f3c6cc", 1.0, "undamped critical"),
)
#: the same line otherwise: where it stands, its name and look
_OTHERS: tuple[tuple[str, str, Look], ...] = (
    ("without_dampers/", "without dampers", {"color": QUIET, "linestyle": "--", "linewidth": 1.2}),
    (
        "healthy/",
        "all firing",
        {"color": COLOURS[2], "linestyle": "-.", "linewidth": 1.2},
    ),
)
_TORQUE, _STRESS, _TWIST = (f"{name}_half_range" for name in ("torque", "stress", "twist"))
_BESIDE: Look = {"loc": "upper left", "bbox_to_anchor": (1.005, 1.0)}


def _sections(
    load: str, root: str = "", only: Collection[str] = (), every: bool = False,
    but: Collection[str] = (), scaled: tuple[float, str] = (1.0, ""),
) -> Source:  # fmt: skip
    """Sections against speed with the highest of each, or `every` maximum that is reported."""

    def made(result: Result) -> Quantity | None:
        record = result.record
        found = having(record, f"{TORSION}{root}speeds/{load}", "section", "speed")
        known = [] if found is None else labels(found.axes[0])
        chosen = [i for i, one in enumerate(known) if one not in but and (one in only or not only)]
        if found is None or not chosen:
            return None
        speed = np.asarray(found.axes[1].values, dtype=float)
        curves = [
            through(speed, np.asarray(found.values[i], dtype=float),
                    points_of(record, known[i]) if every else top_of(record, known[i], load, root))
            for i in chosen
        ]  # fmt: skip
        grid = np.unique(np.concatenate([x for x, _ in curves]))
        rows = np.array([np.interp(grid, x, y) for x, y in curves])
        for row, (x, y) in zip(rows, curves, strict=True):
            row[np.searchsorted(grid, x)] = y
        axes = (replace(found.axes[0], values=found.axes[0].values[chosen]),
                replace(found.axes[1], values=grid))  # fmt: skip
        # a scaled curve has references of its own
        path = "" if scaled[1] else found.path
        unit = scaled[1] or found.unit
        return replace(found, path=path, values=scaled[0] * rows, axes=axes, unit=unit)

    return made


def _row(record: Record, load: str, section: str) -> np.ndarray | None:
    """Values over the speed of one section, None if there are none."""
    found = row_of(f"{TORSION}speeds/{load}", section)(record)
    return None if found is None else np.asarray(found.values, dtype=float)


def _speeds(result: Result) -> list[Panel]:
    """The most loaded section on top, then torque and, where it tells more, twist of all."""
    section = worst_section(result.record)
    if section is None or _row(result.record, _TORQUE, section) is None:
        return []
    rings = names(result.record, "damper/travel", "damper") + _springs(result.record)
    panels = [_top(result, section), _all(result, _TORQUE, "torque", torque_words(result))]
    twisted = {*names(result.record, f"speeds/{_TWIST}", "section")} - {*rings}
    # of an undamped line the twist is the torque over the stiffness
    told = _undamped(result.record) or twisted <= {*_compared(result.record)[:_MOST_PANELS]}
    if not told:
        panels.append(_all(result, _TWIST, "twist", "mrad", rings))
    return panels


TORSION_SPEEDS = Curves(
    also("half range of all orders against speed"),
    _speeds,
    high=2.83,
)


def _top(result: Result, section: str) -> Panel:
    """Stress where it is known, else torque, with all that is reported of this section."""
    record = result.record
    torque, stress = (_row(record, load, section) for load in (_TORQUE, _STRESS))
    assert torque is not None  # or there is no picture
    scaled, unit = (1.0, ""), torque_words(result)
    if stress is not None:
        # both are half ranges over one section modulus
        known = np.isfinite(torque) & (torque > 0.0)
        scaled = (float(np.median(stress[known] / torque[known])) if known.any() else 1.0, "Pa")
        unit = "N/mm^2"
    nearby = []
    for root, words, look in _OTHERS:
        source = _sections(_TORQUE, root, [section], scaled=scaled)
        other = sourced(source, result)
        if other is not None and np.any(other.values > 0.0):
            nearby.append(Curve(source, words, look))
    words = "with dampers" if names(record, "damper/heat", "damper") else "half range"
    look = {"color": TOTAL, "linewidth": 1.0 if _undamped(record) else 2.0}

    def references(plot: Plot) -> None:
        for load, factor in ((_TORQUE, scaled[0]), (_STRESS, 1.0)):
            one = having(record, f"{TORSION}speeds/{load}", "section", "speed")
            if one is not None and (load == _TORQUE or stress is not None):
                points = draw_points(result, plot.axes, one, entry=section,
                                     factor=plot.factor * factor, colour=LIMIT)  # fmt: skip
                plot.points += list(points)
        if stress is not None:
            path = f"{TORSION}speeds/{_STRESS}"
            for limit, bound in bounds_of(result, path, {"section": [section]}):
                plot.limit(limit, bound)

    def maxima(plot: Plot) -> None:
        if _undamped(record):
            return name_points(plot, criticals_of(record, section))
        factors = np.array([1.0, scaled[0], 1.0, 1.0])
        return name_maxima(plot, factors * points_of(record, section), len(nearby))

    return Panel(
        "torque" if stress is None else "stress",
        (
            *nearby,
            Curve(_sections(_TORQUE, "", [section], every=True, scaled=scaled), words, look),
            references,
            *(_allowed(section) if stress is not None else ()),
            operating,
            maxima,
            *_shades(True),
        ),
        f"section {section}",
        unit=unit,
        ends=partial(_heights, own=slice(len(nearby), None)),
        height=1.7,
        legend=_BESIDE,
    )


def _allowed(section: str) -> Iterator[Curve]:
    """Curves of the limits that are held against a section, named after their rules."""
    for name, passing, style in (("allowed", "", "-"), ("transient", ", passage", "-.")):

        def made(result: Result, name: str = name, passing: str = passing) -> Quantity | None:
            limit = having(result.record, f"{TORSION}limit/{name}", "limit", "speed")
            if limit is None:
                return None
            held = vector(result.record, "limit/section", "limit")
            own = names(result.record, f"speeds/{_TORQUE}", "section").index(section) + 1
            there = np.isfinite(limit.values).any(axis=1)
            given = limits_of(result)
            # stresses of the pin are not those of the section
            there &= np.array([one.get("rule") != "iacs_m53" for one in given])
            kept = there if held is None else there & (np.asarray(held) == own)
            rules = [f"limit ({rule_of(one).name}){passing}" for one in given]
            axis = replace(limit.axes[0], values=np.array(rules, dtype=object)[kept])
            return replace(limit, values=limit.values[kept], axes=(axis, limit.axes[1]))

        look = {"color": LIMIT, "linestyle": style, "linewidth": 1.4, "marker": ""}
        yield Curve(made, "{}", look)


def _all(result: Result, load: str, label: str, unit: str, but: Collection[str] = ()) -> Panel:
    """All sections, or the most loaded ones of many."""
    undamped = _undamped(result.record)
    most = _MOST_SPIKY if undamped else _MOST
    look = {"linewidth": 0.8 if undamped else 1.3}
    left = len([one for one in names(result.record, f"speeds/{load}", "section") if one not in but])
    title = (
        {}
        if left <= most
        else {"title": f"the {most} most loaded\nof {left}:", "title_fontsize": 8}
    )
    curve = Curve(_sections(load, but=but), "{}", look, most=most)
    return Panel(
        label, (curve, *_shades(False)), unit=unit, ends=_heights, legend={**_BESIDE, **title}
    )


def _heights(plot: Plot, own: slice | None = None) -> Ends:
    """Ends about the `own` curves of a panel, the lower half of them if nothing is said."""
    heights = [y for _, y in plot.drawn]
    if own is not None:
        shown = [*heights[own], np.array(plot.points)]
    else:
        shown = sorted(heights, key=_highest)[: -(-len(heights) // 2)]
    if not _undamped(plot.result.record):
        return _scaled(plot, shown, [*heights, np.array(plot.points)])
    # flanks of undamped criticals go up without end
    every = np.concatenate(heights if own is None else shown[:1])
    usual = float(np.median(every[every > 0.0]))
    plot.axes.set_yscale("log")
    return 0.1 * usual, 1e2 * usual


def _scaled(plot: Plot, shown: list[np.ndarray], curves: list[np.ndarray]) -> Ends:
    """Up to the highest curve, logarithmic where others are far above those shown."""
    high, far = max(map(_highest, shown)) or 1.0, max(map(_highest, curves)) or 1.0
    low = max(min(float(np.min(y[y > 0.0], initial=far)) for y in curves if y.size), _DEEP * far)
    if (far > _FAR * high or "y" in plot.panel.log) and low > 0.0:
        if plot.axes.get_yscale() != "log":  # of all panels that share it
            plot.axes.set_yscale("log")
        return 0.5 * low, 1.3 * far
    return 0.0, 1.06 * far


def _highest(curve: np.ndarray) -> float:
    """The largest finite value, 0 if there is none."""
    return float(np.max(curve[np.isfinite(curve)], initial=0.0))


def _shades(named: bool) -> Iterator[Mark]:
    """Barred ranges, hammering gears, and speeds at which nothing damps the line."""
    yield from barred_shades(named)
    for name, colour, alpha, words in _SHADES if named else _SHADES[:-1]:
        yield spans(
            TORSION + name, words * named, ("from", "to"), BARCODE, color=colour, alpha=alpha
        )


def _springs(record: Record) -> list[str]:
    """Sections that only the line with its dampers has: a ring's spring may have its own name."""
    bare = names(record, f"without_dampers/speeds/{_TORQUE}", "section")
    own = names(record, f"speeds/{_TORQUE}", "section")
    return [one for one in own if one not in bare] if bare else []


def _undamped(record: Record) -> bool:
    """Whether the curves have flanks without end."""
    return vector(record, "resonances_skipped/from", "resonance_skipped") is not None


# ----------------------------------------------------------------------------
# Twist of every section of a shaft line against speed next to that of the same line otherwise.
# ----------------------------------------------------------------------------

_COLUMNS, _MOST_PANELS = 3, 9
#: letters of a name next to which there is room for two values
_SHORT = 16


def _compared(record: Record) -> list[str]:
    """Sections whose twist is also known of the same line otherwise."""
    path = f"speeds/{_TWIST}"
    known = {name for root, *_ in _OTHERS for name in names(record, root + path, "section")}
    known -= {*names(record, "damper/travel", "damper")}
    return [name for name in names(record, path, "section") if name in known]


def _twists(result: Result) -> list[Panel]:
    """A panel for each section, at most nine; none where there is nothing to compare with."""
    record, path = result.record, f"speeds/{_TWIST}"
    found = {name: sourced(_sections(_TWIST, "", [name]), result) for name in _compared(record)}
    tops = {name: MILLI * _highest(one.values) for name, one in found.items() if one is not None}
    most = sorted(tops, key=lambda name: -tops[name])[:_MOST_PANELS]
    ill = [*misfire_words(result), "as it is"]
    damped = "with dampers" if names(record, f"without_dampers/{path}", "section") else ill[0]
    panels = []
    shown = [name for name in tops if name in most]
    bare = {name: MILLI * float(top[0, 1]) for name in shown
            if (top := top_of(record, name, _TWIST, "without_dampers/")).size}  # fmt: skip
    far = any(top > _FAR * tops[name] for name, top in bare.items())
    for name in shown:
        title = f"{name}\nmax. {show(tops[name], digits=3)}"
        if name in bare and len(name) <= _SHORT:
            title += f", without {show(bare[name], digits=3)}"
        nearby = [Curve(_sections(_TWIST, root, [name]), words, {**look, "marker": ""})
                  for root, words, look in _OTHERS]  # fmt: skip
        curve = Curve(_sections(_TWIST, "", [name]), damped, {"color": TOTAL, "linewidth": 1.6})
        panels.append(Panel("", (*nearby, curve, operating), title, unit="mrad", log="y" * far,
                            ends=partial(_heights, own=slice(-1, None))))  # fmt: skip
    return panels


TORSION_TWISTS = Curves(
    also("twist of the sections in mrad, half range of all orders"),
    _twists,
    high=2.7,
    columns=3,
)


# ----------------------------------------------------------------------------
# Utilisation of each limit in the section or gear where it is largest.
#
# Where a case has limits of stresses by tables and UR M68 alone, these stand in the picture of the
# stresses against the speed, and there is none of these panels.
# ----------------------------------------------------------------------------


def _cross_section(record: Record, limit: int, place: int) -> float | None:
    """Stress of a section over its torque, of the cross-section that the limit counts.

    That may be another than that of the section.
    """
    here = having(record, f"{TORSION}limit/operating/stress", "limit", "section")
    whole = having(record, f"{TORSION}torque_half_range", "section")
    column = None if whole is None or here is None else np.flatnonzero(
        here.axes[1].values == whole.axes[0].values[place])  # fmt: skip
    if here is None or whole is None or column is None or not column.size:
        return None
    torque = float(whole.values[place])
    return float(here.values[limit, column[0]]) / torque if torque > 0.0 else None


def _used(limit: int, name: str) -> Source:
    """Load of largest use of a limit, counted from 0, over what is `allowed`, or `transient`."""

    def made(result: Result) -> Quantity | None:
        record, torques = result.record, bool(of_torque(result.record)[limit])
        use, at = (
            vector(record, f"limit/{one}", "limit") for one in ("largest_utilisation", "speed")
        )
        bound = record.quantities.get(f"{TORSION}limit/{'torque_' * torques}{name}")
        load, place = _loaded(record, limit)
        factor = 1.0 if torques or place is None else _cross_section(record, limit, place)
        if load is None or place is None or bound is None or use is None or at is None:
            return None
        if factor is None or not np.any(np.isfinite(bound.values[limit])):
            return None
        speed = np.asarray(load.axes[1].values, dtype=float)
        allowed = np.interp(speed, bound.axes[1].values, gaps(bound.values[limit]))
        values = factor * np.asarray(load.values[place], dtype=float) / allowed
        if name == "allowed" and np.isfinite(use[limit]):
            speed, values = through(speed, values, np.array([[at[limit], use[limit]]]))
        axes = (replace(load.axes[1], values=speed),)
        return replace(load, path="", values=values, unit="", axes=axes)

    return made


def _loaded(record: Record, limit: int) -> tuple[Quantity | None, int | None]:
    """Loads over the speed that a limit counts, and the place of the section or gear among them."""
    section, gear = (vector(record, f"limit/{name}", "limit") for name in ("section", "gear"))
    of_gear = gear is not None and bool(gear[limit])
    load = "gear_torque" if of_gear else "torque_half_range"
    place = gear if of_gear else section
    return record.quantities.get(f"{TORSION}speeds/{load}"), (
        None if place is None else int(place[limit]) - 1
    )


def _limit_panels(result: Result) -> list[Panel]:
    record, given = result.record, limits_of(result)
    own = any(one.get("rule") == "iacs_m53" for one in given) or np.any(of_torque(record))
    if f"{TORSION}limit/largest_utilisation" not in record or not own:
        return []
    words = []
    for i, one in enumerate(given):
        load, place = _loaded(record, i)
        name = "" if load is None or place is None else f" of {labels(load.axes[0])[place]}"
        words.append(f"limit {i + 1}{name}: {rule_of(one).name}")
    exceeded = spans(f"{TORSION}exceeded", "exceeded for continuous operation", ("from", "to"),
                     color="#E69F00", alpha=0.25)  # fmt: skip
    return [
        Panel(
            "utilisation",
            (*(Curve(_used(i, name), one) for i, one in enumerate(words)), *more, _permitted,
             operating),
            title,
            unit="%",
            ends=(0.0, None),
        )
        for name, title, more in (("allowed", "continuous operation", (exceeded,)),
                                  ("transient", "passage", ()))
    ]  # fmt: skip


TORSION_LIMITS = Curves(
    "half range of all orders, in % of each limit", _limit_panels, high=2.9, names=2
)


def _permitted(plot: Plot) -> None:
    """The line of all that is permitted."""
    plot.axes.axhline(100.0, color=LIMIT, linewidth=1.2, linestyle="--")


TORSION_COUPLINGS = Curves(
    also("couplings, utilisation against speed"),
    (
        Panel(
            "utilisation",
            (Curve(f"{COUPLING}/speeds/utilisation", "{}", most=14), _permitted, operating),
            unit="%",
            legend=_BESIDE,
        ),
        Panel(
            "vibratory torque",
            (Curve(f"{COUPLING}/speeds/vibratory_torque", "{}"), operating),
            "half range of all orders",
            legend=_BESIDE,
        ),
        Panel(
            "power loss",
            (Curve(f"{COUPLING}/speeds/power_loss", "{}"), operating),
            legend=_BESIDE,
        ),
    ),
)

"""Orders of named shafts and stations over a range of speeds, with their sums."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray, distinct
from vibecalc.numerics.synthesis import sum_error, synthesis
from vibecalc.torsion.adapters.critical import UndampedResonances, undamped_speeds
from vibecalc.torsion.adapters.curves import ROWS, bounded_orders, solved
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.signals import Signal, blocks, some_speeds, tops, with_narrow
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.critical_speeds import Maxima, Value
from vibecalc.torsion.curve_results import CURVES
from vibecalc.torsion.curve_tables import OF_SECTIONS, LineCurve, curves_of

# ----------------------------------------------------------------------------
# Adapter: every order of named shafts and stations against the speed.
#
# Sums over the orders are formed block by block of speeds. Which orders are kept is known when all
# speeds are through; the second time these alone are stored, so that memory holds no others.
# ----------------------------------------------------------------------------


class Sums(NamedTuple):
    """Over the cycle, (r, s): half range, largest magnitude, sum of magnitudes; infinite undamped.

    `top` (r, m) is the largest amplitude of each order among the speeds where all are bounded.
    """

    half_range: FloatArray
    peak: FloatArray
    total: FloatArray
    top: FloatArray


def run_torsion_curves(scene: Scene) -> None:
    """Emit the curves of each quantity that some shaft or station is asked for."""
    setup, line = setup_of(scene), scene.case.machine.shaft_line
    assert line is not None and setup.torsion.speeds is not None
    speed = line_speeds(setup.torsion.speeds)
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    for name, named in curves_of(line, setup.torsion.curves).items():
        known = setup.shaft.section_names if name in OF_SECTIONS else setup.shaft.station_names
        signal = Signal(name, np.array([known.index(one) for one in named]))
        _emit(scene, setup, signal, named, speed, undamped)
    scene.cite(
        "orders one by one and summed with phase at each speed",
        "curves of orders, synthesis and sum of magnitudes over the speeds",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )


def _emit(
    scene: Scene,
    setup: Setup,
    signal: Signal,
    named: tuple[str, ...],
    speed: FloatArray,
    undamped: UndampedResonances,
) -> None:
    """All of one quantity."""
    axis, place = "section" if signal.of_sections else "station", f"{CURVES}/{signal.name}"
    asked = [one for name in named for one in setup.torsion.curves if one.on == name]
    sums = summed(setup, signal, speed)
    kept = kept_orders(setup.drive.order, asked, sums.top, signal.name)
    order = setup.drive.order[kept]
    axes = {axis: named, "curve_order": order, "speed": speed}
    high = largest_orders(setup, signal, kept, speed, undamped)
    at = _telling(speed, sums, high)
    each, whole = uncertainty(setup, signal, kept, at)
    values = stored(setup, signal, kept, speed)
    scene.emit(f"{place}/order", values, each, axes)
    for name, rows in zip(("half_range", "peak", "sum"), sums[:3], strict=True):
        scene.emit(f"{place}/{name}", rows, whole, axes)
    shape = (len(named), len(kept))
    there = Bounded(high.value.reshape(shape), (high.value_error + each).reshape(shape))
    scene.emit(f"{place}/largest", there, axes=axes)
    scene.emit(f"{place}/largest_speed", high.speed.reshape(shape), high.speed_error, axes)
    if signal.name == "stress" and setup.torsion.limits:
        _limits(scene, setup, signal.place, speed, axes)
    if any(_points(one, signal.name) for one in asked):
        _measured(scene, setup, signal, asked)


def _limits(
    scene: Scene, setup: Setup, section: IntArray, speed: FloatArray, axes: dict[str, Any]
) -> None:
    """The strictest limits of the stress in sections (r,), for lasting and for passing through."""
    from vibecalc.torsion.adapters.bounds import bounds
    from vibecalc.torsion.adapters.limits import known

    allowed = np.full((2, len(section), len(speed)), np.inf)
    for bound in bounds(setup):
        row, column = np.nonzero(section[:, None] == bound.load)
        if bound.quantity != "stress":
            continue
        both = np.array([bound.continuous(speed).T[column], bound.transient(speed).T[column]])
        allowed[:, row] = np.minimum(allowed[:, row], both)
    for name, rows in zip(("allowed", "transient"), allowed, strict=True):
        scene.emit(f"{CURVES}/stress/{name}", known(rows), axes=axes)


def summed(setup: Setup, signal: Signal, speed: FloatArray) -> Sums:
    """Sums over all orders at speeds (s,)."""
    cycles, parts = setup.drive.cycles, []
    top = np.zeros((len(signal.place), len(cycles.own)))
    for part in blocks(setup.model, setup.drive, len(speed)):
        state = solved(setup.model, setup.drive, speed[part])
        values = np.moveaxis(signal.of(setup, state), -1, 0)  # (r, s, m)
        clear = ~np.any(state.masked, axis=-1)
        top = np.maximum(top, np.max(np.abs(values[:, clear]), axis=1, initial=0.0))
        total = synthesis(cycles, values)
        sums = (total.half_range, total.peak, total.upper_bound)
        parts.append([np.where(clear, one, np.inf) for one in sums])
    half, peak, whole = (np.concatenate(each, axis=1) for each in zip(*parts, strict=True))
    return Sums(half, peak, whole, top)


def kept_orders(order: FloatArray, asked: list[LineCurve], top: FloatArray, name: str) -> IntArray:
    """Places of the orders that some of the curves (r,) keep: named, measured, or of some share.

    `top` (r, m) are their largest amplitudes; an order is kept of all curves of a quantity.
    """
    kept = np.zeros(len(order), dtype=bool)
    for one, size in zip(asked, top, strict=True):
        named = [*one.orders]
        if one.measured is not None and getattr(one.measured, name):
            named += [number for number in one.measured.order if number]
        kept[_places(order, named)] = True
        if not one.orders:
            kept |= size >= one.share * np.max(size, initial=0.0)
    return np.flatnonzero(kept)


def _places(order: FloatArray, named: list[float]) -> IntArray:
    """Which orders (m,) have these numbers."""
    far = np.abs(order[:, None] - np.array(named, dtype=float))
    return np.argmin(far, axis=0) if len(named) else np.zeros(0, dtype=np.int64)


def stored(setup: Setup, signal: Signal, kept: IntArray, speed: FloatArray) -> ComplexArray:
    """The orders that are kept (r, k, s); infinite where nothing damps the order."""
    values = np.empty((len(signal.place), len(kept), len(speed)), dtype=np.complex128)
    for part in blocks(setup.model, setup.drive, len(speed)):
        state = solved(setup.model, setup.drive, speed[part], orders=kept)
        found = np.where(state.masked[..., None], np.inf, signal.of(setup, state))
        values[..., part] = np.transpose(found, (2, 1, 0))
    return values


def largest_orders(
    setup: Setup, signal: Signal, kept: IntArray, speed: FloatArray, undamped: UndampedResonances
) -> Maxima:
    """The largest amplitude of each order that is kept, rows (r k,), at any speed."""
    count = len(kept)
    grid = with_narrow(setup, speed, setup.drive.order[kept])
    curve = np.abs(stored(setup, signal, kept, grid)).reshape(-1, len(grid)).T
    clear = np.all(np.isfinite(curve), axis=1)
    endless = np.full(curve.shape[1], np.nan).reshape(-1, count)
    moved = list(zip(undamped.order, signal.moved(setup, undamped), strict=True))
    for order, (at, moves) in moved[::-1]:
        endless[np.ix_(moves, np.flatnonzero(setup.drive.order[kept] == order))] = at

    def make(rows: IntArray) -> Value:
        def value(at: FloatArray) -> FloatArray:
            found = np.empty(at.shape)
            for one in np.unique(rows % count):
                chosen = np.flatnonzero(rows % count == one)
                flat, place = np.unique(at[chosen], return_inverse=True)
                state = solved(setup.model, setup.drive, flat, orders=kept[one : one + 1])
                size = np.abs(signal.of(setup, state)[:, 0])
                column = np.repeat(rows[chosen] // count, at.shape[1])
                found[chosen] = size[place.ravel(), column].reshape(len(chosen), -1)
            return found

        return value

    return tops(make, curve[clear], grid[clear], undamped.speed, endless.ravel())


def _telling(speed: FloatArray, sums: Sums, high: Maxima) -> FloatArray:
    """Speeds at which errors are taken: some of the range, and those of the largest values."""
    some = some_speeds(speed)
    clear = np.all(np.isfinite(sums.half_range), axis=0)
    tops_of = speed[clear][np.argmax(sums.half_range[:, clear], axis=1)] if clear.any() else some
    return distinct(np.concatenate([some, tops_of, high.speed[np.isfinite(high.value)]]))


def uncertainty(
    setup: Setup, signal: Signal, kept: IntArray, at: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest errors at some speeds: of the orders that are kept, and of sums over all, numbers."""
    each, whole = np.zeros(()), np.zeros(())
    for start in range(0, len(at), ROWS):
        state = bounded_orders(setup, at[start : start + ROWS])
        clear = ~np.any(state.masked, axis=1)
        values = signal.of(setup, state)[clear]
        each = np.maximum(each, np.max(values[:, kept].error, initial=0.0))
        whole = np.maximum(whole, np.max(sum_error(values, axis=1), initial=0.0))
    return each, whole


# ----------------------------------------------------------------------------
# Adapter: measured points, and what is computed at their speeds.
# ----------------------------------------------------------------------------


def _points(curve: LineCurve, name: str) -> list[tuple[float, float, float]]:
    """Speed, order (0: all of them) and value of the measured points of a quantity."""
    points = curve.measured
    if points is None or not getattr(points, name):
        return []
    order = points.order or (0.0,) * len(points.speed)
    return list(zip(points.speed, order, getattr(points, name), strict=True))


def _measured(scene: Scene, setup: Setup, signal: Signal, asked: list[LineCurve]) -> None:
    """The points of all curves of a quantity, and the same computed."""
    rows = [(at, *one) for at, curve in enumerate(asked) for one in _points(curve, signal.name)]
    number, speed, order, value = (np.array(each) for each in zip(*rows, strict=True))
    every = setup.drive.order
    computed, error = np.zeros((2, len(rows)))
    for start in range(0, len(rows), ROWS):
        part = np.arange(start, min(start + ROWS, len(rows)))
        state = bounded_orders(setup, speed[part])
        own = signal.of(setup, state)[part - start, :, number[part]]  # (p, m)
        one = own[part - start, _places(every, order[part].tolist())]
        alone, endless = order[part] > 0.0, np.any(state.masked, axis=1)
        half = synthesis(setup.drive.cycles, own.value).half_range
        computed[part] = np.where(endless, np.inf, np.where(alone, np.abs(one.value), half))
        off = np.where(alone, abs(one).error, sum_error(own))
        error[part] = np.where(endless, 0.0, off)
    axis, place = "section" if signal.of_sections else "station", f"{CURVES}/{signal.name}/measured"
    axes = {"measured_point": np.arange(1, len(rows) + 1)}
    scene.emit(f"{place}/{axis}", number + 1, 0.0, axes)
    scene.emit(f"{place}/speed", speed, 0.0, axes)
    scene.emit(f"{place}/order", order, 0.0, axes)
    scene.emit(f"{place}/value", value, 0.0, axes)
    scene.emit(f"{place}/computed", computed, error, axes)

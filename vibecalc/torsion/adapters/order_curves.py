"""Orders of named shafts and stations over a range of speeds, and how evenly stations turn."""

from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, where
from vibecalc.numerics.rounding import FloatArray, IntArray, distinct
from vibecalc.torsion.adapters.critical import UndampedResonances, undamped_speeds
from vibecalc.torsion.adapters.motion import ROWS, Motion, Reading, blocks
from vibecalc.torsion.adapters.search import Search, moved, some_speeds
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.question_tables import OF_SECTIONS, LineCurve, curves_of
from vibecalc.torsion.results import CURVES, IRREGULARITY

# ----------------------------------------------------------------------------
# Adapter: every order of named shafts and stations against the speed.
# ----------------------------------------------------------------------------

#: sums over the cycle: of all orders, largest magnitude, sum of magnitudes
SUMS = {"half_range": "half_range", "peak": "peak", "sum": "bound"}


def run_torsion_curves(scene: Scene) -> None:
    """Emit the curves of each quantity that some shaft or station is asked for."""
    setup, line = setup_of(scene), scene.case.machine.shaft_line
    assert line is not None and setup.torsion.speeds is not None
    speed = line_speeds(setup.torsion.speeds)
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    for name, named in curves_of(line, setup.torsion.curves).items():
        sections = name in OF_SECTIONS
        known = setup.shaft.section_names if sections else setup.shaft.station_names
        place = np.array([known.index(one) for one in named])
        of = Reading(name, place, "amplitude", "section" if sections else "station", named)
        _emit(scene, setup, of, speed, undamped)
    scene.cite(
        "single orders and their sum with phase at each speed",
        "order curves, synthesis and sum of magnitudes over the speed range",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )


def _emit(
    scene: Scene, setup: Setup, of: Reading, speed: FloatArray, undamped: UndampedResonances
) -> None:
    """All of one quantity."""
    place, order = f"{CURVES}/{of.signal}", setup.drive.order
    asked = [one for name in of.names for one in setup.torsion.curves if one.on == name]
    values = np.empty((len(speed), len(order), len(of.place)), dtype=np.complex128)
    sums = {name: np.empty((len(speed), len(of.place))) for name in SUMS}
    for part in blocks(setup, len(speed)):
        motion = Motion(setup, speed[part])
        orders = motion.orders(of.signal, of.place)
        values[part] = np.where(motion.state.masked[..., None], np.inf, orders)
        for name, kind in SUMS.items():
            sums[name][part] = of._replace(kind=kind).of(motion).value
    clear = np.all(np.isfinite(sums["half_range"]), axis=1)
    top = np.max(np.abs(values[clear]), axis=0, initial=0.0).T
    kept = kept_orders(order, asked, top, of.signal)
    axes = {of.axis: of.names, "curve_order": order[kept], "speed": speed}
    search = Search([setup] * len(kept), speed, [{"order": of}] * len(kept), ["order"],
                    orders=[kept[k : k + 1] for k in range(len(kept))])  # fmt: skip
    endless = np.full((len(kept), len(of.place)), np.nan)
    rows = moved(setup, undamped, of.signal)[:, of.place]
    for at, number, moves in zip(
        undamped.speed[::-1], undamped.order[::-1], rows[::-1], strict=True
    ):
        endless[np.ix_(order[kept] == number, moves)] = at
    search.endless = endless
    high = search.found
    # errors at some speeds, and where something is largest
    tops = [speed[clear][np.argmax(sums["half_range"][clear], axis=0)]] if clear.any() else []
    some = [some_speeds(speed), *tops, high.speed[np.isfinite(high.value)]]
    each, whole = _errors(setup, of, kept, distinct(np.concatenate(some)))
    scene.emit(f"{place}/order", values[:, kept].transpose(2, 1, 0), each, axes)
    for name, curve in sums.items():
        scene.emit(f"{place}/{name}", curve.T, whole, axes)
    value, speeds = (one.reshape(len(kept), -1).T for one in (high.value, high.speed))
    error, off = (one.reshape(len(kept), -1).T for one in (high.value_error, high.speed_error))
    scene.emit(f"{place}/largest", Bounded(value, error + each), axes=axes)
    scene.emit(f"{place}/largest_speed", speeds, off, axes)
    if of.signal == "stress" and setup.torsion.limits:
        _limits(scene, setup, of.place, speed, axes)
    if any(_points(one, of.signal) for one in asked):
        _measured(scene, setup, of, asked)


def _errors(setup: Setup, of: Reading, kept: IntArray, at: FloatArray) -> tuple[float, float]:
    """Largest errors at some speeds: of the orders that are kept, and of sums over all."""
    each, whole = 0.0, 0.0
    for start in range(0, len(at), ROWS):
        motion = Motion(setup, at[start : start + ROWS], bounded=True)
        orders = motion.orders(of.signal, of.place)[~motion.masked]
        each = max(each, float(np.max(orders.errors[:, kept], initial=0.0)))
        half = of._replace(kind="half_range").of(motion)[~motion.masked]
        whole = max(whole, float(np.max(half.errors, initial=0.0)))
    return each, whole


def _limits(
    scene: Scene, setup: Setup, section: IntArray, speed: FloatArray, axes: dict[str, Any]
) -> None:
    """The strictest limits of the stress in sections (r,), for lasting and for passing through."""
    from vibecalc.torsion.adapters.bounds import bounds
    from vibecalc.torsion.adapters.limits import COURSES, known

    for name, course in COURSES.items():
        allowed = np.full((len(section), len(speed)), np.inf)
        for bound in bounds(setup):
            row, column = np.nonzero(section[:, None] == bound.load)
            if bound.quantity == "stress":
                here = bound.allowed(course, speed).T[column]
                allowed[row] = np.minimum(allowed[row], here)
        scene.emit(f"{CURVES}/stress/{name}", known(allowed), axes=axes)


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


def _measured(scene: Scene, setup: Setup, of: Reading, asked: list[LineCurve]) -> None:
    """The points of all curves of a quantity, and the same computed."""
    points = [(at, *one) for at, curve in enumerate(asked) for one in _points(curve, of.signal)]
    number, speed, order, value = (np.array(each) for each in zip(*points, strict=True))
    computed, error = np.zeros((2, len(points)))
    for start in range(0, len(points), ROWS):
        part = slice(start, start + ROWS)
        motion = Motion(setup, speed[part], bounded=True)
        row = np.arange(len(motion.speed))
        own = abs(motion.orders(of.signal, of.place)[row, :, number[part]])
        own = own[row, _places(setup.drive.order, order[part].tolist())]
        half = of._replace(kind="half_range").of(motion, row, number[part])
        alone, endless = order[part] > 0.0, motion.masked
        here = where(endless, np.inf, where(alone, own, half))
        computed[part], error[part] = here.value, np.where(endless, 0.0, here.errors)
    place, axes = (
        f"{CURVES}/{of.signal}/measured",
        {"measured_point": np.arange(1, len(points) + 1)},
    )
    for name, known in (
        (of.axis, number + 1),
        ("speed", speed),
        ("order", order),
        ("value", value),
    ):
        scene.emit(f"{place}/{name}", known, 0.0, axes)
    scene.emit(f"{place}/computed", computed, error, axes)


# ----------------------------------------------------------------------------
# Adapter: degree of unevenness, (highest - lowest) / mean of the angular speed over the cycle.
#
# A station with the speed ratio r turns at r W and vibrates with r phi_q; of its angular speed
# i q W r phi_q the mean r W cancels: the half range of the sum of i q phi_q, referred, is half the
# degree of unevenness. What the line does as a rigid body is in phi_q.
# ----------------------------------------------------------------------------


def degrees(setup: Setup) -> dict[str, Reading]:
    """Degrees of unevenness of the stations that the case names, and electrical angles."""
    asked = setup.torsion.irregularity
    names = tuple(one.on for one in asked)
    place = np.array([setup.shaft.station_names.index(one) for one in names])
    pairs = np.array([one.pole_pairs or 0 for one in asked])
    some = np.flatnonzero(pairs)
    found = {"degree": Reading("unevenness", place, "half_range", "station", names)}
    if len(some):

        def scale(speed: FloatArray) -> FloatArray:
            return np.broadcast_to(pairs[some].astype(float), (len(speed), len(some)))

        own = tuple(names[k] for k in some)
        found["electrical_angle"] = Reading(
            "angle", place[some], "half_range", "station", own, scale
        )
    return found


def run_torsion_irregularity(scene: Scene) -> None:
    """Emit degrees of unevenness and electrical angles of the stations of the case."""
    setup = setup_of(scene)
    known, motion = degrees(setup), Motion(setup, np.array([setup.speed]), bounded=True)

    def put(stem: str, name: str, value: Bounded, speed: FloatArray | None = None) -> None:
        axes = {"station": known[name].names, **({} if speed is None else {"speed": speed})}
        scene.emit(f"{IRREGULARITY}{stem}/{name}", value, axes=axes)

    for name, reading in known.items():
        put("", name, reading.of(motion)[0])
    if setup.torsion.speeds is not None:
        speed = line_speeds(setup.torsion.speeds)
        search = Search([setup], speed, [known], ["degree"])
        for name in known:
            put("/speeds", name, search.bounded_curves(name).T, speed)
        top = search.top("degree").of(0)
        put("/largest", "degree", top.value)
        scene.emit(
            f"{IRREGULARITY}/largest/speed", top.speed, axes={"station": known["degree"].names}
        )
    scene.cite(
        "twice the half range of the sum of order times angle",
        "cyclic irregularity",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )

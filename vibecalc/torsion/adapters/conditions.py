"""The worst of many conditions of the cylinders: all fire, each misfires, pressures differ."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import (
    CylinderTorque,
    cylinder_gas,
    phasor,
)
from vibecalc.numerics.bounded import Bounded, reshaped, rounded, stack, where
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray, IntArray, distinct
from vibecalc.numerics.synthesis import sum_error, synthesis
from vibecalc.torsion.adapters.bounds import Bound, bounds
from vibecalc.torsion.adapters.coupling_states import coupled
from vibecalc.torsion.adapters.couplings import largest_use, uses_of
from vibecalc.torsion.adapters.critical import undamped_speeds
from vibecalc.torsion.adapters.curves import (
    ROWS,
    bounded_orders,
    of_finite,
    solved,
)
from vibecalc.torsion.adapters.limits import emit_element, limit_corners
from vibecalc.torsion.adapters.loads import limits_gears
from vibecalc.torsion.adapters.setup import (
    PHASOR_ROUNDINGS,
    SPEED_ROUNDINGS,
    Drive,
    Setup,
    build_drive,
    line_speeds,
    motored_torque,
    placed,
)
from vibecalc.torsion.adapters.signals import (
    Signal,
    blocks,
    some_speeds,
    stations_of,
    tops,
    with_narrow,
)
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.critical_speeds import RIVAL, Maxima, Value
from vibecalc.torsion.curve_results import CONDITIONS
from vibecalc.torsion.curve_tables import condition_names
from vibecalc.torsion.rough_range import rough_range
from vibecalc.torsion.stress_limits import NO_BARRED_RANGE

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Conditions of the cylinders: the drive of all that fire with the gas of some changed.
# ----------------------------------------------------------------------------


class Condition(NamedTuple):
    """A name, and the torques that act then."""

    name: str
    drive: Drive


def conditions_of(case: "Case", setup: Setup) -> list[Condition]:
    """All cylinders firing first, then each misfiring, each out of balance, given pressures."""
    options, shaft = setup.torsion.conditions, setup.shaft
    assert options is not None
    well = build_drive(case, shaft, all_fire=True)
    names, scale = well.firing.names, np.asarray(well.firing.pressure_scale, dtype=float)
    count = len(names)
    each, nobody = np.eye(count, dtype=bool), np.zeros(count, dtype=bool)
    drives = [well]
    if options.misfire == "each":
        without = None
        if options.misfire_kind == "motored":
            without = motored_torque(case.machine, well)
        drives += [changed_drive(setup, well, scale, out, without) for out in each]
    less = [scale * np.where(one, 1.0 - options.imbalance, 1.0) for one in each
            if options.imbalance is not None]  # fmt: skip
    given = [scale * np.array(options.pressure_scale)] if options.pressure_scale else []
    drives += [changed_drive(setup, well, one, nobody, None) for one in (*less, *given)]
    called = condition_names(options, names)
    return [Condition(*both) for both in zip(called, drives, strict=True)]


def changed_drive(
    setup: Setup, drive: Drive, scale: FloatArray, out: BoolArray, motored: CylinderTorque | None
) -> Drive:
    """A drive whose cylinders have other factors (c,) on their gas pressure, or misfire.

    What the other cylinders and everything but gas do stays, and its errors with it.
    """
    shaft, one, firing = setup.shaft, drive.cylinder, drive.firing
    old = cylinder_gas(one, firing.pressure_scale)
    new = cylinder_gas(one, scale, misfiring=out, motored=motored)
    other = (out | (scale != firing.pressure_scale)).astype(float)
    gas, mean = (new[0] - old[0]) * other[:, None], (new[1] - old[1]) * other
    where = placed(np.searchsorted(drive.station, shaft.cylinder_station), len(drive.station))
    on = where * shaft.station_ratio[shaft.cylinder_station][:, None]
    turned = rounded(phasor(one.order, firing.angle).T, PHASOR_ROUNDINGS)
    more = reshaped(gas * turned, lambda part: np.swapaxes(part, -1, -2)) @ on
    return drive._replace(
        gas=drive.gas + more,
        mean=drive.mean + mean @ rounded(on, SPEED_ROUNDINGS),
    )


# ----------------------------------------------------------------------------
# Half ranges in all conditions. Where the line is the same in all of them it is eliminated once for
# each order and speed, with the torques of every condition on it; couplings that follow their load
# make another line of each. Of the sums over the cycle only those are formed that can be the
# largest.
# ----------------------------------------------------------------------------


def half_ranges(
    lines: list[Setup], signals: list[Signal], speed: FloatArray, every: BoolArray
) -> FloatArray:
    """Of the places of all signals (r,), in c conditions at speeds: (c, r, s); undamped inf.

    Those of places that `every` (r,) names, and the largest of the conditions of each other place;
    of the rest something lower.
    """
    first, parts = lines[0], []
    for part in blocks(first.model, first.drive, len(speed), len(lines)):
        values, endless = _solved_all(lines, signals, speed[part])
        low, high = rough_range(first.drive.order, values)
        needed = every[:, None] | (high >= low.max(axis=0))
        low[needed] = synthesis(first.drive.cycles, values[needed]).half_range
        parts.append(np.where(endless[:, None], np.inf, low))
    return np.concatenate(parts, axis=-1)


def _solved_all(
    lines: list[Setup], signals: list[Signal], speed: FloatArray
) -> tuple[ComplexArray, BoolArray]:
    """Orders (c, r, s, m) of the places of all signals, and where (c, s) they are infinite."""
    first = lines[0]
    if all(one.model is first.model for one in lines):
        load = np.stack([one.drive.load(speed) for one in lines])
        states = [(first, solved(first.model, first.drive, speed, load=load))]
    else:
        states = [(one, solved(one.model, one.drive, speed)) for one in lines]
    found = [
        np.concatenate([one.of(line, state) for one in signals], axis=-1) for line, state in states
    ]
    masked = [np.any(state.masked, axis=-1) for _, state in states]
    if len(states) == 1:
        values, endless = found[0], masked[0]
    else:
        values, endless = np.stack(found), np.stack(masked)
    # (c, s, m, r) with the orders last
    return np.ascontiguousarray(np.moveaxis(values, -1, 1)), endless


def uncertainty(own: Setup, signals: list[Signal], at: FloatArray) -> FloatArray:
    """Largest errors (r,) of sums over the orders of one condition, at some speeds."""
    found = np.zeros(sum(len(one.place) for one in signals))
    for start in range(0, len(at), ROWS):
        state = bounded_orders(own, at[start : start + ROWS])
        clear = ~np.any(state.masked, axis=1)
        off = [sum_error(one.of(own, state)[clear], axis=1) for one in signals]
        found = np.maximum(found, np.max(np.concatenate(off, axis=1), axis=0, initial=0.0))
    return found


# ----------------------------------------------------------------------------
# Adapter: all conditions at the operating speed, the worst of them over the range.
# ----------------------------------------------------------------------------


def run_torsion_conditions(scene: Scene) -> None:
    """Emit half ranges by condition at speed, and over the range the worst with its condition."""
    setup = setup_of(scene)
    found = conditions_of(scene.case, setup)
    shaft, at = setup.shaft, np.array([setup.speed])
    # gears stand behind the sections, as in the loads that limits are for
    gears = len(shaft.gears) if limits_gears(setup) else 0
    signals = [
        Signal("torque", np.arange(len(shaft.section_names))),
        *([Signal("gear", np.arange(gears))] if gears else []),
        Signal("angle", np.arange(len(shaft.station_names))),
    ]
    names: dict[str, Any] = {
        "condition": tuple(one.name for one in found),
        "section": shaft.section_names,
        "station": shaft.station_names,
        "limit": np.arange(1, len(setup.torsion.limits) + 1),
    }
    lines = [coupled(setup._replace(drive=one.drive)) for one in found]
    every = np.ones(sum(len(one.place) for one in signals), dtype=bool)
    half = half_ranges(lines, signals, at, every)[..., 0]
    error = np.array([uncertainty(one, signals, at) for one in lines])
    count, stations = len(shaft.section_names), len(shaft.station_names)
    every_one = Bounded(half, error)
    loads, angle = every_one[:, :-stations], every_one[:, -stations:]
    torque = loads[:, :count]
    scene.emit(f"{CONDITIONS}/torque_half_range", torque, axes=names)
    _stresses(scene, CONDITIONS, setup, torque, names)
    scene.emit(f"{CONDITIONS}/angle_half_range", angle, axes=names)
    mean = [one.drive.mean_torque(at).sum()[0] for one in lines]
    value, off = (np.array([getattr(one, part) for one in mean]) for part in ("value", "error"))
    scene.emit(f"{CONDITIONS}/mean_torque", value, off, names)
    if setup.torsion.irregularity:
        _irregularity(scene, lines, names)
    if setup.torsion.limits:
        share = shares([bounds(one) for one in lines], at)[..., 0]
        use = stack([_operating_use(loads, one) for one in np.moveaxis(share, 1, 0)])
        scene.emit(f"{CONDITIONS}/limit/operating_use", use, axes=names)
        worst = np.argmax(loads.value[:, None, : share.shape[2]] * share, axis=-1)
        stem, own = f"{CONDITIONS}/limit/operating_", _at(share, worst)
        emit_element(scene, stem, bounds(setup), worst, own, names)
    if shaft.couplings:
        _couplings(scene, lines, names)
    if setup.torsion.speeds is not None:
        search = Search(lines, signals, line_speeds(setup.torsion.speeds))
        _range(scene, search, names)
        if setup.torsion.limits:
            _largest_uses(scene, search, use, names)
    scene.cite(
        "one elimination for the torques of all conditions, each summed over the cycle",
        "worst of all cylinders firing, each misfiring, pressures out of balance",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )


def _irregularity(scene: Scene, lines: list[Setup], names: dict[str, Any]) -> None:
    """Degrees of unevenness of the stations that the case asks them of, at the operating speed."""
    setup = lines[0]
    asked, at = tuple(one.on for one in setup.torsion.irregularity), np.array([setup.speed])
    signals = [Signal("unevenness", stations_of(setup, asked))]
    half = half_ranges(lines, signals, at, np.ones(len(asked), dtype=bool))[..., 0]
    error = np.array([uncertainty(one, signals, at) for one in lines])
    axes = {**names, "station": asked}
    scene.emit(f"{CONDITIONS}/irregularity", Bounded(half, error), axes=axes)


def _couplings(scene: Scene, lines: list[Setup], names: dict[str, Any]) -> None:
    """Use of the limits of couplings in each condition, at the operating speed and at any."""
    setup = lines[0]
    every, at, place = uses_of(setup), np.array([setup.speed]), f"{CONDITIONS}/coupling"
    if not len(every.kept):
        return
    axes = {**names, **every.axes}
    use = stack([uses_of(one).at(at, bounded_orders)[..., 0] for one in lines], axis=0)
    scene.emit(f"{place}/use", use, axes=axes)
    if setup.torsion.speeds is not None:
        speed = with_narrow(setup, line_speeds(setup.torsion.speeds), setup.drive.order)
        _, most, where = zip(*(largest_use(one, speed) for one in lines), strict=True)
        scene.emit(f"{place}/largest_use", stack(list(most), axis=0), axes=axes)
        scene.emit(f"{place}/largest_use_speed", stack(list(where), axis=0), axes=axes)


def _stresses(
    scene: Scene, stem: str, setup: Setup, torque: Bounded, names: dict[str, Any]
) -> None:
    """Of own torques (c, e) where a section modulus is known."""
    modulus = setup.shaft.section_modulus
    some = np.flatnonzero(modulus > 0.0)
    if len(some):
        axes = {**names, "section": tuple(setup.shaft.section_names[e] for e in some)}
        stress = of_finite(torque[:, some], lambda one: one / modulus[some])
        scene.emit(f"{stem}/stress_half_range", stress, axes=axes)


class Top(NamedTuple):
    """The worst of places (r,): value, speed, condition from 0; infinite where undamped."""

    value: Bounded
    speed: Bounded
    condition: IntArray


class Search:
    """Half ranges of signals in all conditions over a range, and where they are largest."""

    def __init__(self, lines: list[Setup], signals: list[Signal], speed: FloatArray) -> None:
        self.lines, self.signals, self.speed = lines, signals, speed
        #: the limits in each condition, whose mean torque counts where a limit is a share of it
        self.held_by = [bounds(one) for one in lines]
        setup = lines[0]
        grid = with_narrow(setup, speed, setup.drive.order)
        if setup.torsion.limits:
            corners = limit_corners(setup, speed)
            last = NO_BARRED_RANGE * np.array([one.basis.rated_speed for one in bounds(setup)])
            last = last[(last > speed[0]) & (last < speed[-1])]
            grid = distinct(np.concatenate([grid, corners, last]))
        limited = np.zeros(sum(len(one.place) for one in signals), dtype=bool)
        for bound in bounds(setup):
            limited[bound.load] = True
        half = half_ranges(lines, signals, grid, limited)
        #: the worst (r, s) at the speeds of the sweep
        self.worst = half[..., np.isin(grid, speed)].max(axis=0)
        clear = np.all(np.isfinite(half), axis=(0, 1))
        self.grid, self.half = grid[clear], half[..., clear]
        self.undamped, self.endless = self._endless(speed)

    def _endless(self, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speeds (u,) at which nothing damps an order, and by condition and place (c, r)."""
        met, rows = [np.zeros(0)], []
        for own in self.lines:
            found = undamped_speeds(own, speed[0], speed[-1])
            met.append(found.speed)
            rows.append(np.concatenate([one.endless(own, found) for one in self.signals]))
        return distinct(np.concatenate(met)), np.array(rows)

    def make(self, condition: IntArray, place: IntArray) -> Callable[[IntArray], Value]:
        """Half ranges of rows, each of one condition and place, at speeds of their own."""

        def some(rows: IntArray) -> Value:
            def value(at: FloatArray) -> FloatArray:
                found = np.empty(at.shape)
                for one in np.unique(condition[rows]):
                    chosen = np.flatnonzero(condition[rows] == one)
                    flat, where = np.unique(at[chosen], return_inverse=True)
                    line = self.lines[one]
                    state = solved(line.model, line.drive, flat)
                    values = np.concatenate(
                        [signal.of(line, state) for signal in self.signals], axis=-1
                    )
                    column = np.repeat(place[rows[chosen]], at.shape[1])
                    own = values[where.ravel(), :, column]
                    half = synthesis(line.drive.cycles, own).half_range
                    found[chosen] = half.reshape(len(chosen), -1)
                return found

            return value

        return some

    def tops(self, condition: IntArray, place: IntArray) -> Maxima:
        """The largest of some rows (k,) at any speed."""
        curve = self.half[condition, place].T
        endless = self.endless[condition, place]
        return tops(self.make(condition, place), curve, self.grid, self.undamped, endless)

    def top_of_places(self) -> Top:
        """The worst of each place at any speed in any condition."""
        # where a maximum of the worst of all stands, one condition alone is the worst
        worst = self.half.max(axis=0)
        rival = worst >= RIVAL * worst.max(axis=1, keepdims=True, initial=0.0)
        there, at = np.nonzero(rival)
        pairs = np.zeros(self.half.shape[:2], dtype=bool)
        pairs[self.half[:, there, at].argmax(axis=0), there] = True
        condition, place = np.nonzero(pairs | np.isfinite(self.endless))
        high = self.tops(condition, place)
        rows = [np.flatnonzero(place == one) for one in range(len(worst))]
        best = np.array([own[np.argmax(high.value[own])] for own in rows])
        off = np.zeros(len(best))
        for one in np.unique(condition[best]):
            own = np.flatnonzero((condition[best] == one) & np.isfinite(high.value[best]))
            telling = distinct(high.speed[best[own]])
            if len(own):
                off[own] = uncertainty(self.lines[one], self.signals, telling)[own]
        value = Bounded(high.value[best], high.value_error[best] + off)
        speed = Bounded(high.speed[best], high.speed_error[best])
        return Top(value, speed, condition[best])


def _range(scene: Scene, search: "Search", names: dict[str, Any]) -> None:
    """The worst at each speed, and at any of them."""
    lines, signals, speed = search.lines, search.signals, search.speed
    setup = lines[0]
    top = search.top_of_places()
    count, modulus = len(setup.shaft.section_names), setup.shaft.section_modulus
    stations = slice(-len(setup.shaft.station_names), None)
    some = np.flatnonzero(modulus > 0.0)
    axes = {**names, "speed": speed}
    stressed = {**axes, "section": tuple(setup.shaft.section_names[e] for e in some)}
    telling = some_speeds(speed)
    most = int(np.argmax(np.bincount(top.condition[:count])))
    off = np.maximum(uncertainty(lines[most], signals, telling), top.value.error)
    worst = Bounded(search.worst, np.broadcast_to(off[:, None], search.worst.shape))
    place = f"{CONDITIONS}/speeds"
    scene.emit(f"{place}/torque_half_range", worst[:count], axes=axes)
    scene.emit(f"{place}/angle_half_range", worst[stations], axes=axes)
    place = f"{CONDITIONS}/largest"
    scene.emit(f"{place}/torque_half_range", top.value[:count], axes=axes)
    scene.emit(f"{place}/angle_half_range", top.value[stations], axes=axes)
    if len(some):
        over = f"{CONDITIONS}/speeds/stress_half_range"
        curve = of_finite(worst[some], lambda one: one / modulus[some, None])
        scene.emit(over, curve, axes=stressed)
        stress = of_finite(top.value[some], lambda one: one / modulus[some])
        scene.emit(f"{place}/stress_half_range", stress, axes=stressed)
    for name, part in (("section", slice(count)), ("station", stations)):
        scene.emit(f"{place}/{name}_speed", top.speed[part], axes=axes)
        scene.emit(f"{place}/{name}_condition", top.condition[part] + 1, 0.0, axes)


# ----------------------------------------------------------------------------
# Use of limits of stress and torque in each condition.
# ----------------------------------------------------------------------------


def shares(asked: list[list[Bound]], speed: FloatArray) -> FloatArray:
    """Use per own torque (c, l, loads, s) in 1/(N m); 0 where a limit says nothing."""
    loads = 1 + max((int(one.load.max(initial=-1)) for one in asked[0]), default=-1)
    found = np.zeros((len(asked), len(asked[0]), loads, len(speed)))
    for rows, limits in zip(found, asked, strict=True):
        for row, bound in zip(rows, limits, strict=True):
            row[bound.load] = 1.0 / (bound.modulus * bound.continuous(speed)).T
    return found


def _operating_use(loads: Bounded, share: FloatArray) -> Bounded:
    """Largest use (c,) of one limit, of own torques (c, loads) with shares of them."""
    held = np.flatnonzero(share.any(axis=0))
    if not len(held):
        return Bounded(*np.zeros((2, len(share))))
    return of_finite(loads[:, held], lambda one: one * share[:, held]).max()


def _at(share: FloatArray, load: IntArray) -> FloatArray:
    """Shares (c, l) of chosen loads (c, l)."""
    return np.take_along_axis(share, load[..., None], axis=2)[..., 0]


class _Uses(NamedTuple):
    """Largest use of each limit in each condition at any speed (c, l), and of which load."""

    use: Bounded
    speed: Bounded
    load: IntArray


def _largest_uses(scene: Scene, search: Search, operating: Bounded, names: dict[str, Any]) -> None:
    """The largest use of each limit in each condition, also of speeds that cannot be barred."""
    place = f"{CONDITIONS}/limit"
    top = _searched(search, search.grid)
    scene.emit(f"{place}/largest_use", top.use, axes=names)
    scene.emit(f"{place}/speed", top.speed, axes=names)
    at = shares(search.held_by, top.speed.value.ravel())
    row, limit = np.indices(top.load.shape)
    own = at[row, limit, top.load, np.arange(top.load.size).reshape(top.load.shape)]
    emit_element(scene, f"{place}/", search.held_by[0], top.load, own, names)
    # no range holds the operating speed, and a rule lets none be barred from a share of it on
    rated = np.array([one.basis.rated_speed for one in search.held_by[0]])
    high = search.grid[search.grid >= NO_BARRED_RANGE * rated.max()]
    if np.any(rated) and len(high):
        above = _searched(search, high).use
        larger = (rated > 0.0) & (above.value > operating.value)
        operating = where(larger, above, operating)
    scene.emit(f"{place}/unbarred_use", operating, axes=names)


def _searched(search: Search, grid: FloatArray) -> _Uses:
    """Searched from some of the speeds of the grid."""
    count, there = len(search.lines), np.isin(search.grid, grid)
    share = shares(search.held_by, grid)
    limits = share.shape[1]
    use = search.half[:, None, : share.shape[2], there] * share  # (c, l, loads, s)
    seen = use.max(axis=-1, initial=0.0)
    rival = (seen > 0.0) & (seen >= RIVAL * seen.max(axis=2, keepdims=True))
    condition, limit, section = np.nonzero(rival)
    value, speed = np.zeros((count, limits)), np.full((count, limits), grid[0])
    load, error, off = np.zeros((count, limits), dtype=np.int64), *np.zeros((2, count, limits))
    if len(condition):
        torque = search.make(condition, section)

        def make(rows: IntArray) -> Value:
            def per_limit(at: FloatArray) -> FloatArray:
                flat, where = np.unique(at, return_inverse=True)
                which = (np.repeat(x[rows], at.shape[1]) for x in (condition, limit, section))
                each = shares(search.held_by, flat)[(*which, where.ravel())]
                return torque(rows)(at) * each.reshape(at.shape)

            return per_limit

        endless = search.endless[condition, section]
        says = np.isfinite(endless) & (endless >= grid[0])
        per = shares(search.held_by, np.where(says, endless, grid[0]))
        held = per[condition, limit, section, np.arange(len(limit))] > 0.0
        endless = np.where(says & held, endless, np.nan)
        high = tops(make, use[rival].T, grid, search.undamped, endless)
        best = np.lexsort((-high.value, limit, condition))
        _, first = np.unique(condition[best] * limits + limit[best], return_index=True)
        for row in best[first]:
            at = condition[row], limit[row]
            value[at], speed[at], load[at] = high.value[row], high.speed[row], section[row]
            off[at], error[at] = high.speed_error[row], high.value_error[row]
        worst = best[first][np.argmax(high.value[best[first]])]
        if np.isfinite(high.value[worst]):
            # the errors of the torques are those of the worst condition at its speed
            own = np.array([high.speed[worst]])
            moved = uncertainty(search.lines[condition[worst]], search.signals, own)
            each = shares(search.held_by, own)[..., 0]
            error += moved[section[worst]] * each[condition[worst], limit[worst], section[worst]]
    return _Uses(Bounded(value, error), Bounded(speed, off), load)

"""A shaft line in motion: all orders at many speeds, what is read of them, with their errors."""

from collections.abc import Callable, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import (
    Bounded,
    bounded,
    concatenate,
    maximum,
    reshaped,
    rounded,
    square,
    where,
)
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.numerics.synthesis import OverCycle, over_cycle, sum_error, synthesis
from vibecalc.torsion.adapters.setup import Drive, Model, Setup, placed
from vibecalc.torsion.couplings import Moved
from vibecalc.torsion.forced import STIFFNESS_ROUNDINGS, steady_shares
from vibecalc.torsion.line import (
    complex_stiffness,
    damped_elements,
    hand_over,
    loss_stiffness,
    walk,
)
from vibecalc.torsion.model import ShaftLineModel

# ----------------------------------------------------------------------------
# Torque that each gear of a line transmits, referred, and the mean torques of the whole line.
# ----------------------------------------------------------------------------


def gear_shares(shaft: ShaftLineModel) -> tuple[FloatArray, FloatArray]:
    """Weights (e, g) of sections and (stations, g) of what else acts, in torques of gears.

    On the second wheel, referred. A gear with teeth of some stiffness is a section of the line;
    a rigid one carries what its side with less inertia needs, whose balance loses least.

    Raises NumericalFailure where rigid gears close a loop: statics does not tell their torques.
    """
    count, ends = len(shaft.station_names), shaft.section_ends
    of_sections = np.zeros((len(ends), len(shaft.gears)))
    of_stations = np.zeros((count, len(shaft.gears)))
    rigid = [gear for gear in shaft.gears if gear.element < 0]
    for place, gear in enumerate(shaft.gears):
        if gear.element >= 0:
            of_sections[gear.element, place] = 1.0
            continue
        joined: dict[int, dict[int, float]] = {station: {} for station in range(count)}
        for other in rigid:
            if other is not gear:
                joined[other.first][other.second] = joined[other.second][other.first] = 1.0
        first, second = (walk(joined, wheel) for wheel in (gear.first, gear.second))
        if gear.first in second:
            raise NumericalFailure(
                f"gear {gear.name!r}: rigid gears in a closed loop share their torque in a way "
                "that only the stiffness of the teeth tells; give each a mesh_stiffness"
            )
        inertia = shaft.station_values[0]
        lighter = inertia[list(second)].sum() <= inertia[list(first)].sum()
        sign, inside = (1.0, second) if lighter else (-1.0, first)
        side = np.isin(np.arange(count), list(inside)).astype(float)
        entering = np.where(ends[:, 1] >= 0, side[ends[:, 1]], 0.0)
        of_sections[:, place] = sign * (side[ends[:, 0]] - entering)
        of_stations[:, place] = -sign * side
    return of_sections, of_stations


def gear_torques(shaft: ShaftLineModel, drive: Drive, model: Model, state: "OrderSolution") -> Any:
    """On the second wheel of each gear (..., g), referred, from what the rest of its side needs.

    What damps the modes of `model` as such takes its part: it goes with the inertias.
    """
    of_sections, of_stations = gear_shares(shaft)
    through = state.torque @ of_sections
    if not np.any(of_stations):
        return through
    inertia, _, held = shaft.station_values
    damping = shaft.station_damping(state.speed[:, None])
    w = state.frequency[..., None]
    need = (held - w**2 * inertia + 1j * w * damping) * state.angle[..., shaft.freedom]
    need = need + inertia * modal_braking(model, state)[..., shaft.freedom]
    load = state.load @ placed(drive.station, len(of_stations))
    return through + (load - need) @ of_stations


def modal_braking(model: Model, state: "OrderSolution") -> Any:
    """Torque per inertia (..., n) that damping of the modes takes.

    Zero where the modes are damped by what the line itself has.
    """
    modal, line = model.modal, model.line
    if modal is None or any(
        np.any(part) for part in (line.damping, line.absolute_damping, line.loss_factor)
    ):
        return np.zeros(state.angle.shape, dtype=np.complex128)
    modes = modal.modes
    rate = 1j * (state.frequency[..., None] * modal.dashpot + modal.loss) / modes.modal_inertia
    lever = (modes.shape * line.inertia / modes.modal_inertia[:, None]).T
    return (rate * (state.angle @ lever)) @ modes.shape


class MeanTorques(NamedTuple):
    """Referred mean torques at speeds (s,): of sections (s, e) and of gears (s, g)."""

    section: Bounded
    gear: Bounded


def mean_torques(setup: Setup, speed: FloatArray) -> MeanTorques:
    """What sections and gears carry of mean torques, which the station of the load balances.

    The line stands as at the operating speed.
    """
    shaft, drive, count = setup.shaft, setup.drive, len(setup.shaft.station_names)
    taken = shaft.taken(speed)
    mean = drive.mean_torque(speed) @ placed(drive.station, count)
    mean = mean - rounded(taken, 4.0) @ placed(shaft.taken_station, count)
    # of each station, with the station of the load against it
    load = shaft.load_station
    found = steady_shares(setup.model.at(setup.speed)).T[shaft.freedom]
    # whole numbers, but for the error of what stiffnesses share
    shares = Bounded(found.value - found.value[load], found.error + found.error[load])
    if not shaft.gears:
        return MeanTorques(mean @ shares, mean[:, :0])
    of_sections, of_stations = gear_shares(shaft)
    through = shares.value @ of_sections + of_stations - of_stations[load]
    of_gears = Bounded(through, shares.error @ np.abs(of_sections))
    return MeanTorques(mean @ shares, mean @ of_gears)


def actual_per_referred(shaft: ShaftLineModel) -> FloatArray:
    """What referred torques of gears (g,) count on the shaft of the first wheel."""
    return np.asarray(
        1.0 / shaft.station_ratio[np.array([gear.first for gear in shaft.gears], dtype=int)]
    )


# ----------------------------------------------------------------------------
# All orders at some speeds, block by block: memory does not grow with speeds.
# ----------------------------------------------------------------------------

#: speeds of one block at least, and numbers (speeds times orders times freedoms) up to which it
#: may have more: short blocks cost as many calls as long ones
ROWS, ENTRIES = 128, 1 << 17


def blocks(setup: Setup, count: int, copies: int = 1) -> list[slice]:
    """Parts of so many speeds that are solved at once, for so many loads at once.

    They are of one length, as a short last one would cost as many calls as the others.
    """
    size = max(1, speeds_at_once(setup.model, setup.drive) // copies)
    size = max(1, -(-count // max(1, -(-count // size))))
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def speeds_at_once(model: Model, drive: Drive) -> int:
    """Speeds of one block of a sweep."""
    return max(ROWS, ENTRIES // (len(drive.order) * int(model.line.inertia.shape[-1])))


class OrderSolution(NamedTuple):
    """All orders (s, m, ...) at some speeds, referred: angles, twists, torques of sections.

    Complex arrays, or `Bounded` ones of `bounded_orders`; `load` are the torques that act;
    `speed` (s,) of the crank, in rad/s.
    """

    frequency: FloatArray
    angle: Any
    twist: Any
    torque: Any
    load: Any
    error: FloatArray
    masked: BoolArray
    speed: FloatArray


def solved(
    model: Model,
    drive: Drive,
    speed: FloatArray,
    estimate: bool = False,
    *,
    load: ComplexArray | None = None,
    orders: IntArray | slice = slice(None),
) -> OrderSolution:
    """Angles and torques at speeds (s,) in rad/s; `error` (s, m) of the angles, if asked for.

    `load` (..., s, m, k) takes the place of the drive's own torques; `orders` are places of some.
    """
    load = (drive.load(speed) if load is None else load)[..., orders, :]
    w = drive.frequency(speed)[:, orders]
    found = model.solve(speed, w, load, drive.freedom, estimate)
    line = model.at(speed[:, None], w)
    twist = found.angle[..., line.first] - found.angle[..., line.second]
    torque = complex_stiffness(line, w) * twist
    return OrderSolution(w, found.angle, twist, torque, load, found.error, found.masked, speed)


# ----------------------------------------------------------------------------
# Rounding of a solved shaft line, measured: what another solve would correct.
# ----------------------------------------------------------------------------

#: times the correction, which is itself as large as the error but no bound on it
CORRECTIONS = 4.0


def rounding_uncertainty(
    setup: Setup, speed: FloatArray, state: OrderSolution
) -> tuple[FloatArray, FloatArray]:
    """What rounding may move angles (s, m, n) and twists (s, m, e) by; 0 where masked.

    The torques that the equations of motion lack, with the angles found, are put on the line once
    more. Their own rounding is of the size of that of the first solve, and so is the answer. No
    more is reported than the bound of the solver, `state.error` (s, m), which one number for all
    angles makes far too large for the twists of a line that turns as a whole.
    """
    line = setup.model.at(speed[:, None])
    a, b = line.first, line.second
    bound = np.where(state.masked, 0.0, state.error)[..., None]
    size = np.abs(state.angle)
    least = EPSILON * (size[..., a] + size[..., b])
    moved = np.where(state.masked[..., None], 0.0, _correction(setup, speed, state))
    angle = CORRECTIONS * np.max(np.abs(moved), axis=-1, keepdims=True) + EPSILON * size
    twist = CORRECTIONS * np.abs(moved[..., a] - moved[..., b]) + least
    return np.minimum(angle, bound), np.minimum(twist, 2.0 * bound + least)


def _correction(setup: Setup, speed: FloatArray, state: OrderSolution) -> ComplexArray:
    """Angles (s, m, n) for what is left of the torques."""
    line, w = setup.model.at(speed[:, None], state.frequency), state.frequency[..., None]
    dynamic = line.ground_stiffness - w**2 * line.inertia + 1j * w * line.absolute_damping
    left = -dynamic * state.angle
    if setup.model.modal is not None:
        left -= line.inertia * modal_braking(setup.model, state)
    torque = complex_stiffness(line, state.frequency) * state.twist
    hand_over(np.moveaxis(left, -1, 0), line, np.moveaxis(torque, -1, 0))
    for place, freedom in enumerate(setup.drive.freedom):
        left[..., freedom] += state.load[..., place]
    every = np.arange(line.inertia.shape[-1])
    return setup.model.solve(speed, state.frequency, left, every, estimate=False).angle


# ----------------------------------------------------------------------------
# What the errors of the torques do to a shaft line, and to sums over its orders.
# ----------------------------------------------------------------------------


def data_uncertainty(setup: Setup, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What the errors of the torques may move angles (s, m, n) and twists (s, m, e) by.

    The cylinders have them in common, as they have a card, each turned to its own firing; what is
    each one's own has no common sign.
    """
    drive, model = setup.drive, setup.model
    torque, error = drive.torque(speed)
    one_by_one = error * np.eye(error.shape[-1])[:, None, None, :]
    moved = model.solve(
        speed, drive.frequency(speed), one_by_one.astype(np.complex128), drive.freedom, False
    ).angle
    size = np.abs(torque)
    turn = np.ascontiguousarray(np.moveaxis(torque / np.where(size > 0.0, size, 1.0), -1, 0))
    line, by_freedom = model.line, np.moveaxis(moved, -1, 0)

    def together(one: ComplexArray) -> FloatArray:
        """Of what each torque moves a freedom or an element by (k, s, m)."""
        parts = np.ascontiguousarray(one).view(np.float64)
        squares = np.sum(np.square(parts), axis=0)
        alone: FloatArray = np.sqrt(squares[..., ::2] + squares[..., 1::2])
        return np.asarray(np.abs(np.sum(turn * one, axis=0)) + alone)

    # one after the other: they stay in the cache, and few of them in memory
    angle = [together(one) for one in by_freedom]
    ends = zip(line.first.tolist(), line.second.tolist(), strict=True)
    twist = [together(by_freedom[a] - by_freedom[b]) for a, b in ends]
    none = np.zeros((0, *size.shape[:-1]))
    return np.moveaxis(np.array(angle), 0, -1), np.moveaxis(np.array([*none, *twist]), 0, -1)


def bounded_orders(setup: Setup, speed: FloatArray, moved: Moved | None) -> OrderSolution:
    """All orders at speeds (s,) with what the errors of the torques and rounding do to them.

    And, of couplings that follow what the line does, what errors of that have `moved`.
    """
    state = solved(setup.model, setup.drive, speed, estimate=True)
    data = data_uncertainty(setup, speed)
    rounding = rounding_uncertainty(setup, speed, state)
    angle, twist = (
        Bounded(value, one + other)
        for value, one, other in zip((state.angle, state.twist), data, rounding, strict=True)
    )
    stiffness = complex_stiffness(setup.model.at(speed[:, None], state.frequency), state.frequency)
    torque, load = rounded(stiffness, STIFFNESS_ROUNDINGS) * twist, setup.drive.torque(speed)
    if moved is not None:
        angle, twist, torque = (
            Bounded(one.value, one.error + more)
            for one, more in zip((angle, twist, torque), moved, strict=False)
        )
    return state._replace(angle=angle, twist=twist, torque=torque, load=load)


# ----------------------------------------------------------------------------
# What stations, sections and gears of a line show: sums over the cycle, actual, of own shafts.
# ----------------------------------------------------------------------------

#: all speeds of a motion, or all places of a reading
EVERY = slice(None)
#: rows of a motion or of a reading: all, or (k,) chosen ones
Rows = Any
#: signals of stations -> what of the angular frequency they are times the angle
_RATES: dict[str, Callable[[FloatArray, FloatArray], Any]] = {
    "angle": lambda w, speed: 1.0,
    "angular_speed": lambda w, speed: 1j * w,
    "angular_acceleration": lambda w, speed: -np.square(w),
    # twice the angular speed over the mean one
    "unevenness": lambda w, speed: 2j * w / speed,
}


class Motion:
    """All orders of a line at speeds (s,) in rad/s, each maybe of another one of many machines.

    `bounded`: with what rounding and the errors of the torques do to them, which sums then carry.
    `orders` are places of some, `load` (..., s, m, k) takes the place of the drive's own torques.
    """

    def __init__(
        self,
        setup: Setup,
        speed: FloatArray,
        bounded: bool = False,
        orders: IntArray | slice = EVERY,
        load: ComplexArray | None = None,
    ) -> None:
        self.setup, self.speed, self.bounded = setup, speed, bounded
        #: what is not known exactly of couplings
        self.moved: Moved | None = None
        if bounded:
            states = setup.model.couplings
            if states is not None and states.moved is not None:
                self.moved = states.moved(speed)
            self.state = bounded_orders(setup, speed, self.moved)
        else:
            self.state = solved(setup.model, setup.drive, speed, load=load, orders=orders)
        #: (s,) where nothing damps some order
        self.masked: BoolArray = np.any(self.state.masked, axis=-1)
        self._sums: dict[str, OverCycle] = {}

    @cached_property
    def mean(self) -> "MeanTorques":
        return mean_torques(self.setup, self.speed)

    @cached_property
    def gear(self) -> Any:
        return gear_torques(self.setup.shaft, self.setup.drive, self.setup.model, self.state)

    @cached_property
    def lossy(self) -> FloatArray:
        """Power (s, m, e) per squared twist of sections: w Im(k) / 2."""
        line = self.setup.model.at(self.speed[:, None], self.state.frequency)
        w = self.state.frequency
        return 0.5 * w[..., None] * loss_stiffness(line, w)

    def referred(self, signal: str) -> tuple[Any, FloatArray]:
        """Orders (s, m, r) of all places, and what is own over referred (r,)."""
        shaft, state = self.setup.shaft, self.state
        if signal == "twist":
            return state.twist, shaft.section_ratio
        if signal == "torque":
            return state.torque, 1.0 / shaft.section_ratio
        if signal == "stress":
            modulus = shaft.section_modulus
            per = np.divide(1.0, modulus, out=np.zeros_like(modulus), where=modulus > 0.0)
            return state.torque, per / shaft.section_ratio
        if signal == "gear":
            return self.gear, actual_per_referred(shaft)
        if signal == "load":  # sections, and gears behind them
            join = concatenate if self.bounded else np.concatenate
            both = join([state.torque, self.gear], axis=-1)
            return both, np.concatenate([1.0 / shaft.section_ratio, actual_per_referred(shaft)])
        rate = _RATES[signal](state.frequency[..., None], self.speed[:, None, None])
        own = np.sign(shaft.station_ratio) if signal == "unevenness" else shaft.station_ratio
        return state.angle[..., shaft.freedom] * rate, own

    def orders(self, signal: str, place: IntArray | slice = EVERY) -> Any:
        """Own orders (s, m, r) of places (r,), complex, 0-to-peak."""
        values, own = self.referred(signal)
        return values[..., place] * own[place]

    def rows(self, signal: str, place: IntArray, at: Rows = EVERY) -> Any:
        """Own orders of places (r,), the orders last: at all speeds (s, r, m) or each (r, m)."""
        values, own = self.referred(signal)
        if at is not EVERY:
            return values[at, :, place] * own[place][:, None]
        turned = reshaped(bounded(values[..., place]), lambda one: np.swapaxes(one, 1, 2))
        return (turned if self.bounded else turned.value) * own[place][:, None]

    def sums(self, signal: str, place: IntArray, at: Rows = EVERY) -> OverCycle:
        """Over the cycle: of places (r,) at all speeds (s, r), or of each at its own speed (r,)."""
        if at is not EVERY:
            return self._sum(self.rows(signal, place, at))
        if signal not in self._sums:
            self._sums[signal] = self._every(signal)
        return OverCycle(*(one[:, place] for one in self._sums[signal]))

    def _sum(self, orders: Any) -> OverCycle:
        """Of orders (..., m)."""
        if self.bounded:
            return over_cycle(self.setup.drive.cycles, orders)
        total = synthesis(self.setup.drive.cycles, orders)
        found = (total.peak, total.half_range, total.highest, total.lowest, total.upper_bound)
        return OverCycle(*map(bounded, found))

    def _every(self, signal: str) -> OverCycle:
        """Of all places (s, r)."""
        if signal == "load":
            both = (self._every(one) for one in ("torque", "gear"))
            return OverCycle(*(concatenate(pair) for pair in zip(*both, strict=True)))
        if signal == "torque" and not (self.bounded or self.setup.model.machines):
            return self._torques()
        values, own = self.referred(signal)
        # signals in front and orders last, as they lie in memory
        turned = reshaped(bounded(values), lambda one: np.moveaxis(one, -1, 0))
        return _own(self._sum(turned if self.bounded else turned.value), own)

    def _torques(self) -> OverCycle:
        """What nothing damps between its ends has a torque that is its stiffness times its twist at
        every order, so that one sum over the orders serves both."""
        ratio, damped = self.setup.shaft.section_ratio, damped_elements(self.setup.model.line)
        stiffness = self.setup.model.at(self.speed).stiffness / np.square(ratio)
        twist = self.sums("twist", np.arange(len(ratio)))
        apart = _own(
            self._sum(np.moveaxis(self.state.torque[..., damped], -1, 0)), 1.0 / ratio[damped]
        )
        found = [np.array(stiffness * one.value) for one in twist]
        for each, rows in zip(found, apart, strict=True):
            each[:, damped] = rows.value
        return OverCycle(*(bounded(one) for one in found))

    def heat(self, place: IntArray, at: Rows = EVERY) -> Bounded:
        """Mean power of dashpots and loss factors of sections (r,) in W, as `sums`.

        Of all orders: w Im(k) |twist|^2 / 2.
        """
        index = (at, EVERY, place)
        power = self.lossy[index] * square(abs(bounded(self.state.twist[index])))
        total = power.sum(axis=1)
        if self.moved is None:
            return total
        return Bounded(total.value, total.error + self.moved.heat[at, place])


def _own(total: OverCycle, factor: FloatArray) -> OverCycle:
    """Sums (r, s) of referred values as own ones (s, r): a factor below 0 changes the sides."""
    size, turned = np.abs(factor), factor < 0.0
    peak, half, high, low, whole = (one.T * size for one in total)
    return OverCycle(peak, half, where(turned, -low, high), where(turned, -high, low), whole)


#: what is a sum over the cycle itself
SUMMED = ("half_range", "peak", "bound")


class Reading(NamedTuple):
    """A quantity of places (r,) of a line, the entries `names` of an `axis` of results.

    `kind` says what it is of a `signal`: the "half_range", "peak" or "bound" of the sum over the
    cycle, the "peak_with_mean", the "least" in the sense of the mean, the "mean", or the "heat";
    for one order alone its "amplitude". It counts `scale` (s, r) at speeds (s,), known to
    `roundings`.
    """

    signal: str
    place: IntArray
    kind: str
    axis: str
    names: tuple[str, ...]
    scale: Callable[[FloatArray], FloatArray] | None = None
    roundings: float = 0.0

    def scales(self, speed: FloatArray) -> FloatArray:
        """What it counts (s, r) at speeds (s,)."""
        return np.ones((len(speed), len(self.place))) if self.scale is None else self.scale(speed)

    def of(self, motion: Motion, at: Rows = EVERY, row: Rows = EVERY) -> Bounded:
        """At all speeds (s, r), or of chosen rows (k,) each at a chosen speed.

        Infinite where nothing damps an order; the least of what has a sense is so below zero.
        """
        found = self._of(motion, at, self.place[row])
        clear = ~motion.masked[at]
        clear = clear[:, None] if at is EVERY else clear
        lost = -np.inf if self.kind == "least" else np.inf
        if self.scale is None:
            return found if self.kind == "mean" else where(clear, found, lost)
        scale = self.scales(motion.speed[at])
        if at is not EVERY:
            scale = np.take_along_axis(scale, row[:, None], axis=1)[:, 0]
        endless = np.where(scale > 0.0, lost, 0.0)
        return where(clear, found * rounded(scale, self.roundings), endless)

    def errors(self, motion: Motion) -> FloatArray:
        """Errors (s, r) at all speeds of a bounded motion; 0 where there is no bound."""
        if self.scale is None and self.kind in SUMMED:  # without forming the sum
            error = sum_error(motion.rows(self.signal, self.place))
            return np.where(motion.masked[:, None], 0.0, error)
        found = self.of(motion)
        return np.where(np.isfinite(found.value), found.errors, 0.0)

    def _of(self, motion: Motion, at: Rows, place: IntArray) -> Bounded:
        if self.kind == "heat":
            return motion.heat(place, at)
        if self.kind == "amplitude":
            values, own = motion.referred(self.signal)
            return abs(bounded(values[at, 0, place] * own[place]))
        if self.kind in SUMMED:
            found: Bounded = getattr(motion.sums(self.signal, place, at), self.kind)
            return found
        gears = self.signal == "gear"
        mean = (motion.mean.gear if gears else motion.mean.section)[at, place]
        mean = mean * motion.referred(self.signal)[1][place]
        if self.kind == "mean":
            return mean
        total = motion.sums(self.signal, place, at)
        combine = peak_of if self.kind == "peak_with_mean" else least_of
        return combine(mean, total.highest, total.lowest)


#: readings of every line
TORQUE, TWIST, STRESS = "torque_half_range", "twist_half_range", "stress_half_range"
ANGLE = "angle_half_range"
HALF = (TWIST, TORQUE, STRESS)


def readings_of(setup: Setup) -> dict[str, Reading]:
    """What sections, stations, dampers and gears of a line show, by the name of the result."""
    shaft = setup.shaft
    modulus = shaft.section_modulus
    stressed = np.flatnonzero(modulus)
    rings = np.array([one.element for one in shaft.dampers], dtype=np.int64)
    of = {
        "section": (np.arange(len(shaft.section_names)), shaft.section_names),
        "station": (np.arange(len(shaft.station_names)), shaft.station_names),
        "damper": (rings, tuple(one.name for one in shaft.dampers)),
        "gear": (np.arange(len(shaft.gears)), tuple(one.name for one in shaft.gears)),
    }
    every = (
        ("twist_half_range", "twist", "half_range", "section"),
        ("torque_half_range", "torque", "half_range", "section"),
        ("angle_half_range", "angle", "half_range", "station"),
        ("twist_peak", "twist", "peak", "section"),
        ("torque_peak", "torque", "peak_with_mean", "section"),
        ("travel", "twist", "peak", "damper"),
        ("heat", "twist", "heat", "damper"),
        ("gear_mean_torque", "gear", "mean", "gear"),
        ("gear_torque", "gear", "half_range", "gear"),
        ("gear_minimum_torque", "gear", "least", "gear"),
    )
    found = {
        name: Reading(signal, of[axis][0], kind, axis, of[axis][1])
        for name, signal, kind, axis in every
        if len(of[axis][0])
    }
    swing = np.array([one.swing_per_twist for one in shaft.dampers])
    if np.any(swing != 1.0):
        # of a pendulum its own angle to its arm
        found["travel"] = found["travel"]._replace(
            scale=lambda speed: np.broadcast_to(swing, (len(speed), len(swing))), roundings=4.0
        )
    if len(stressed):
        names, per = tuple(shaft.section_names[e] for e in stressed), 1.0 / modulus[stressed]
        found["stress_half_range"] = Reading(
            "torque", stressed, "half_range", "section", names,
            lambda speed: np.broadcast_to(per, (len(speed), len(stressed))), 2.0,
        )  # fmt: skip
    return found


def stress_of(setup: Setup, torque: Bounded) -> Bounded:
    """Stresses of sections that have a modulus, of torques (..., e) of all."""
    stressed = np.flatnonzero(setup.shaft.section_modulus)
    per = 1.0 / setup.shaft.section_modulus[stressed]
    return of_finite(torque[..., stressed], lambda one: one * per)


def emit_readings(
    scene: Scene,
    place: str,
    setup: Setup,
    found: Mapping[str, Bounded],
    axes: Mapping[str, Any],
    names: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Readings by name (r,), or (s, r) with `axes` of speeds; `names` are paths of some."""
    known = readings_of(setup)
    for name, value in found.items():
        each = known[name]
        along = value.T if axes else value
        scene.emit(f"{place}/{names.get(name, name)}", along, axes={**axes, each.axis: each.names})


def peak_of(mean: Bounded, high: Bounded, low: Bounded) -> Bounded:
    """The largest magnitude of a mean and the extremes of what alternates about it."""
    return maximum(abs(mean + high), abs(mean + low))


def least_of(mean: Bounded, high: Bounded, low: Bounded) -> Bounded:
    """The least in the sense of the mean.

    A mean that is zero to within its error has no sense: the lower of both counts.
    """
    up, down = maximum(high, low), maximum(-high, -low)
    unloaded = np.abs(mean.value) <= mean.error
    against = where(unloaded, maximum(up, down), where(mean.value < 0.0, up, down))
    return abs(mean) - against


def of_finite(value: Bounded, change: Callable[[Bounded], Bounded]) -> Bounded:
    """Changed values; infinite ones, of which nothing bounds the response, stay."""
    finite = np.isfinite(value.value)
    return where(finite, change(where(finite, value, 0.0)), np.inf)

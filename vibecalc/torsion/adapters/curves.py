"""Half ranges of the sections and gears of a shaft line against speed, with their errors."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded, where
from vibecalc.numerics.rounding import (
    EPSILON,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
)
from vibecalc.numerics.synthesis import sum_error, synthesis
from vibecalc.torsion.adapters.setup import Drive, Model, Setup, placed
from vibecalc.torsion.critical_speeds import Maxima, by_machine, machine_and_speed
from vibecalc.torsion.line import complex_stiffness, damped_elements, loss_stiffness
from vibecalc.torsion.model import Gearing, ShaftLineModel
from vibecalc.torsion.section_loads import STIFFNESS_ROUNDINGS, heat, steady_shares

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
        others = [other for other in rigid if other is not gear]
        first, second = (_reached(others, wheel) for wheel in (gear.first, gear.second))
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


def _reached(gears: list[Gearing], start: int) -> set[int]:
    """Stations that rigid gears hold together with one."""
    inside, grown = {start}, True
    while grown:
        touching = [g for g in gears if {g.first, g.second} & inside]
        more = {end for gear in touching for end in (gear.first, gear.second)}
        grown = not more <= inside
        inside |= more
    return inside


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
    shares = steady_shares(setup.model.at(setup.speed)).T[shaft.freedom]
    shares = shares - shares[load]
    if not shaft.gears:
        return MeanTorques(mean @ shares, mean[:, :0])
    of_sections, of_stations = gear_shares(shaft)
    return MeanTorques(
        mean @ shares, mean @ (shares @ of_sections + of_stations - of_stations[load])
    )


def actual_per_referred(shaft: ShaftLineModel) -> FloatArray:
    """What referred torques of gears (g,) count on the shaft of the first wheel."""
    return np.asarray(
        1.0 / shaft.station_ratio[np.array([gear.first for gear in shaft.gears], dtype=int)]
    )


# ----------------------------------------------------------------------------
# Half ranges of a shaft line against speed, block by block: memory does not grow with speeds.
#
# What is not damped between its ends has a torque that is its stiffness times its twist at every
# order, so that one sum over the orders serves both.
# ----------------------------------------------------------------------------

#: speeds of one block at least, and numbers (speeds times orders times freedoms) up to which it
#: may have more: short blocks cost as many calls as long ones
ROWS, ENTRIES = 128, 1 << 17


def speeds_at_once(model: Model, drive: Drive) -> int:
    """Speeds of one block of a sweep."""
    return max(ROWS, ENTRIES // (len(drive.order) * int(model.line.inertia.shape[-1])))


class Curves(NamedTuple):
    """Referred values against speed: half ranges, extremes of the torque, heat; (s, ...).

    `twist`, its largest magnitude `travel`, `torque`, `highest`, `lowest` (s, e), `angle` (s, n),
    `gear` with its extremes (s, g), `heat` (s, e) in W without that of absolute damping. `masked`
    (s,): some order is where nothing damps a mode; the values are infinite there.
    """

    twist: FloatArray
    travel: FloatArray
    torque: FloatArray
    highest: FloatArray
    lowest: FloatArray
    angle: FloatArray
    gear: FloatArray
    gear_highest: FloatArray
    gear_lowest: FloatArray
    heat: FloatArray
    masked: BoolArray


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


def sweep(
    model: Model, drive: Drive, speed: FloatArray, shaft: ShaftLineModel | None, angles: bool = True
) -> Curves:
    """The curves at speeds (s,); gears are those of `shaft`, none without it."""
    size = speeds_at_once(model, drive)
    # blocks of one length, as a short last one would cost as many calls as the others
    size = max(1, -(-len(speed) // max(1, -(-len(speed) // size))))
    parts = []
    for start in range(0, len(speed), size):
        parts.append(_block(model, drive, speed[start : start + size], shaft, angles))
    return Curves(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _block(
    model: Model, drive: Drive, speed: FloatArray, shaft: ShaftLineModel | None, angles: bool
) -> Curves:
    state = solved(model, drive, speed)
    damped = damped_elements(model.line)
    signals = [state.twist, state.torque[..., damped]]
    if angles:
        signals.append(state.angle)
    if shaft is not None and shaft.gears:
        signals.append(gear_torques(shaft, drive, model, state))
    ends = np.cumsum([one.shape[-1] for one in signals])[:-1]
    # signals in front and orders last, as they lie in memory
    stacked = np.concatenate([np.moveaxis(one, -1, 0) for one in signals])
    total = synthesis(drive.cycles, stacked)
    extremes = (total.half_range.T, total.highest.T, total.lowest.T)
    # by kind of signal, then half range, highest and lowest
    twist, apart, *others = zip(*(np.split(one, ends, axis=1) for one in extremes), strict=True)
    stiffness = np.broadcast_to(model.at(speed).stiffness, twist[0].shape)
    half, highest, lowest = (stiffness * one for one in twist)
    for each, damped_rows in zip((half, highest, lowest), apart, strict=True):
        each[:, damped] = damped_rows
    none = np.zeros((len(speed), 0))
    gears = others[-1] if len(others) > angles else (none, none, none)
    masked = np.any(state.masked, axis=-1)
    line = model.at(speed[:, None], state.frequency)
    power = np.zeros((len(speed), len(line.first)))
    if len(damped):
        twisted = state.twist[..., damped]
        factor = state.frequency[..., None] * loss_stiffness(line, state.frequency)[..., damped]
        squares = np.square(twisted.real) + np.square(twisted.imag)
        power[:, damped] = 0.5 * np.sum(factor * squares, axis=1)
    curves = (
        twist[0], np.maximum(np.abs(twist[1]), np.abs(twist[2])), half, highest, lowest,
        others[0][0] if angles else none,
        *gears,
        power,
    )  # fmt: skip
    blank = [np.where(masked[:, None], np.inf, one) for one in curves]
    return Curves._make([*blank, masked])


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
    for e, (first, second) in enumerate(zip(line.first, line.second, strict=True)):
        left[..., first] -= torque[..., e]
        left[..., second] += torque[..., e]
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


def bounded_orders(setup: Setup, speed: FloatArray) -> OrderSolution:
    """All orders at speeds (s,) with what the errors of the torques and rounding do to them."""
    state = solved(setup.model, setup.drive, speed, estimate=True)
    data = data_uncertainty(setup, speed)
    rounding = rounding_uncertainty(setup, speed, state)
    angle, twist = (
        Bounded(value, one + other)
        for value, one, other in zip((state.angle, state.twist), data, rounding, strict=True)
    )
    stiffness = complex_stiffness(setup.model.at(speed[:, None], state.frequency), state.frequency)
    torque, load = rounded(stiffness, STIFFNESS_ROUNDINGS) * twist, setup.drive.torque(speed)
    if setup.model.couplings is not None and setup.model.couplings.moved is not None:
        off = setup.model.couplings.moved(speed)
        angle, twist, torque = (
            Bounded(one.value, one.error + more)
            for one, more in zip((angle, twist, torque), off, strict=False)
        )
    return state._replace(angle=angle, twist=twist, torque=torque, load=load)


def of_finite(value: Bounded, change: Callable[[Bounded], Bounded]) -> Bounded:
    """Changed values; infinite ones, of which nothing bounds the response, stay."""
    finite = np.isfinite(value.value)
    return where(finite, change(where(finite, value, 0.0)), np.inf)


def section_heat(setup: Setup, speed: FloatArray, state: OrderSolution) -> Bounded:
    """Mean power (s, e) of dashpots and loss factors in W, all orders of bounded twists.

    Of twists without errors, as of a curve, it has none.
    """
    line = setup.model.at(speed[:, None], state.frequency)
    power = heat(line, state.frequency, state.twist).sum(axis=-2)
    couplings = setup.model.couplings
    if couplings is None or couplings.moved is None or not np.any(state.twist.error):
        return power
    return Bounded(power.value, power.error + couplings.moved(speed).heat)


# ----------------------------------------------------------------------------
# Error of the curves of a shaft line against speed, taken where they are largest and between.
# ----------------------------------------------------------------------------

#: speeds at equal steps, next to those of the largest values
SAMPLES = 16


class CurveUncertainty(NamedTuple):
    """Absolute errors, referred: twist (e,), torque (e,), angle (n,), gears (g,), heat (e,)."""

    twist: FloatArray
    torque: FloatArray
    angle: FloatArray
    gear: FloatArray
    heat: FloatArray


def curve_uncertainty(setup: Setup, speed: FloatArray, telling: FloatArray) -> CurveUncertainty:
    """Largest errors of sums over orders at some of the speeds (s,) and at those that tell (r,).

    Of p machines, with speeds (p, r) that tell, they have p in front.
    """
    some = speed[np.linspace(0, len(speed) - 1, min(SAMPLES, len(speed))).astype(int)]
    telling = telling.reshape(max(1, setup.model.machines), -1)
    at = np.concatenate([np.broadcast_to(some, (len(telling), len(some))), telling], axis=1)
    of = np.broadcast_to(np.arange(len(telling))[:, None], at.shape)
    at = np.unique(by_machine(of, at), return_index=True)[0]
    found = curve_errors_of(setup, at)
    first = np.searchsorted(at.real, np.arange(len(telling)))
    most = CurveUncertainty(*(np.maximum.reduceat(part, first, axis=0) for part in found))
    return most if setup.model.machines else CurveUncertainty(*(part[0] for part in most))


def section_uncertainty(
    setup: Setup, speed: FloatArray, section: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Errors (r,) of half ranges of twists and torques, each of one section at its own speed.

    0 where unbounded.
    """
    machine, own = setup.model.own(section)
    at, place = np.unique(by_machine(machine, speed), return_inverse=True)
    twist, torque, *_ = curve_errors_of(setup, at)
    return twist[place, own], torque[place, own]


def curve_errors_of(setup: Setup, at: ComplexArray) -> CurveUncertainty:
    """The same of speeds (s,) `by_machine`, block by block."""
    parts = [
        curve_errors(setup.of(machine), speed)
        for machine, speed in map(machine_and_speed, np.split(at, range(ROWS, len(at), ROWS)))
    ]
    return CurveUncertainty(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def curve_errors(setup: Setup, at: FloatArray) -> CurveUncertainty:
    """Errors of sums over orders at speeds (s,), each with s in front; 0 where unbounded."""
    state = bounded_orders(setup, at)
    gear = state.torque[..., :0]
    if len(setup.model.line.first) == len(setup.shaft.section_names):  # has its dampers
        gear = gear_torques(setup.shaft, setup.drive, setup.model, state)
    every = [sum_error(one, axis=1) for one in (state.twist, state.torque, state.angle, gear)]
    clear = ~np.any(state.masked, axis=1)[:, None]
    every.append(section_heat(setup, at, state).error)
    return CurveUncertainty(*(np.where(clear, one, 0.0) for one in every))


def at_largest(
    setup: Setup, top: Maxima, last: float, twists: bool = True
) -> tuple[Bounded, Bounded]:
    """Largest half ranges (e,) of referred torques, and those of the twists there, if asked for.

    Speeds go up to the `last` in rad/s. The torque of a section is flat where it is largest; its
    twist need not be, and moves by what the speed is off.
    """
    twist_error, torque_error = section_uncertainty(setup, top.speed, top.section)
    torque = Bounded(top.value, torque_error + top.value_error)
    if not twists:
        return torque, Bounded(np.zeros(len(top.section)), np.zeros(len(top.section)))
    off = np.where(top.speed + top.speed_error > last, -1.0, 1.0) * top.speed_error
    twist, moved = (_half_twist(setup, at, top.section) for at in (top.speed, top.speed + off))
    twist_error = twist_error + np.abs(moved - twist)
    twist = np.where(np.isfinite(top.value), twist, np.inf)
    return torque, Bounded(twist, twist_error)


def _half_twist(setup: Setup, speed: FloatArray, section: IntArray) -> FloatArray:
    """Half ranges (r,) of twists, each of one section at its own speed; 0 where unbounded."""
    half, (machine, own) = np.zeros(len(speed)), setup.model.own(section)
    for start in range(0, len(speed), ROWS):
        part = slice(start, start + ROWS)
        state = solved(setup.model.of(machine[part]), setup.drive, speed[part])
        twist = state.twist[np.arange(len(state.twist)), :, own[part]]
        clear = ~np.any(state.masked, axis=1)
        half[part] = np.where(clear, synthesis(setup.drive.cycles, twist).half_range, 0.0)
    return half

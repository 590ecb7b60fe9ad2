"""Half ranges of the sections and gears of a shaft line against speed, with their errors."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import (
    EPSILON,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    distinct,
)
from vibecalc.torsion.adapters.setup import Drive, Model, Setup
from vibecalc.torsion.line import complex_stiffness, damped_elements, loss_stiffness
from vibecalc.torsion.model import Gearing, ShaftLineModel
from vibecalc.torsion.synthesis import Synthesis, synthesis

# ----------------------------------------------------------------------------
# Torque that each gear of a line transmits, referred, and the mean torques of the whole line.
# ----------------------------------------------------------------------------


class Side(NamedTuple):
    """Stations (s,) that turn as one with a wheel of a rigid gear; sign 1 for the second wheel."""

    stations: BoolArray
    wheel: int
    sign: float


def sides(shaft: ShaftLineModel) -> list[Side]:
    """Of each rigid gear the side with less inertia: its balance loses least.

    Raises NumericalFailure where rigid gears close a loop: statics does not tell their torques.
    """
    all_sides = []
    rigid = [gear for gear in shaft.gears if gear.element < 0]
    for gear in rigid:
        others = [other for other in rigid if other is not gear]
        first, second = (_reached(others, wheel) for wheel in (gear.first, gear.second))
        if gear.first in second:
            raise NumericalFailure(
                f"gear {gear.name!r}: rigid gears in a closed loop share their torque in a way "
                "that only the stiffness of the teeth tells; give each a mesh_stiffness"
            )
        inertia = shaft.station_values[0]
        lighter = inertia[list(second)].sum() <= inertia[list(first)].sum()
        wheel, inside = (gear.second, second) if lighter else (gear.first, first)
        stations = np.isin(np.arange(len(shaft.station_names)), list(inside))
        all_sides.append(Side(stations, wheel, 1.0 if lighter else -1.0))
    return all_sides


def _reached(gears: list[Gearing], start: int) -> set[int]:
    """Stations that rigid gears hold together with one."""
    inside, grown = {start}, True
    while grown:
        touching = [g for g in gears if {g.first, g.second} & inside]
        more = {end for gear in touching for end in (gear.first, gear.second)}
        grown = not more <= inside
        inside |= more
    return inside


def gear_torques(
    shaft: ShaftLineModel,
    drive: Drive,
    model: "Model",
    frequency: FloatArray,
    angle: ComplexArray,
    section: ComplexArray,
    torque: ComplexArray,
) -> ComplexArray:
    """On the second wheel of each gear (..., g), referred, from what the rest of its side needs.

    `angle` (..., n), torque of sections (..., e) and of cylinders (..., k) at frequencies (...).
    What damps the modes of `model` as such takes its part: it goes with the inertias.
    """
    torques = np.empty((*angle.shape[:-1], len(shaft.gears)), dtype=np.complex128)
    rigid = iter(sides(shaft))
    w = np.asarray(frequency)
    for place, gear in enumerate(shaft.gears):
        if gear.element >= 0:
            torques[..., place] = section[..., gear.element]
            continue
        side, wheel, sign = next(rigid)
        inertia, damping, held = shaft.station_values[:, side].sum(axis=1)
        wheel_angle = angle[..., shaft.freedom[wheel]]
        value = (held - w**2 * inertia + 1j * w * damping) * wheel_angle
        value = value + inertia * modal_braking(model, w, angle)[..., shaft.freedom[wheel]]
        value = value + section @ _leaving(shaft, side)
        torques[..., place] = sign * (value - torque[..., side[drive.station]].sum(axis=-1))
    return torques


def gear_uncertainties(
    shaft: ShaftLineModel,
    drive: Drive,
    model: "Model",
    frequency: FloatArray,
    angle: FloatArray,
    section: FloatArray,
    torque: FloatArray,
) -> FloatArray:
    """Absolute errors (..., g) of those, from errors of the same shapes."""
    errors = np.empty((*angle.shape[:-1], len(shaft.gears)))
    rigid = iter(sides(shaft))
    w = np.asarray(frequency)
    for place, gear in enumerate(shaft.gears):
        if gear.element >= 0:
            errors[..., place] = section[..., gear.element]
            continue
        side, wheel, _ = next(rigid)
        inertia, damping, held = shaft.station_values[:, side].sum(axis=1)
        value = (held + w**2 * inertia + w * damping) * angle[..., shaft.freedom[wheel]]
        moved = modal_braking(model, w, angle, bound=True)[..., shaft.freedom[wheel]]
        value = value + inertia * np.abs(moved)
        value = value + section @ np.abs(_leaving(shaft, side))
        errors[..., place] = value + torque[..., side[drive.station]].sum(axis=-1)
    return errors


def modal_braking(
    model: "Model", frequency: FloatArray, angle: ComplexArray | FloatArray, bound: bool = False
) -> ComplexArray:
    """Torque per inertia (..., n) that damping of the modes takes, or a bound on it for errors.

    Zero where the modes are damped by what the line itself has.
    """
    modal, line = model.modal, model.line
    if modal is None or any(
        np.any(part) for part in (line.damping, line.absolute_damping, line.loss_factor)
    ):
        return np.zeros(angle.shape, dtype=np.complex128)
    modes = modal.modes
    shape, lever = modes.shape, modes.shape * line.inertia
    if bound:
        shape, lever = np.abs(shape), np.abs(lever)
    rate = 1j * (np.asarray(frequency)[..., None] * modal.dashpot + modal.loss)
    coordinate = angle @ (lever / modes.modal_inertia[:, None]).T
    return np.asarray((rate / modes.modal_inertia * coordinate) @ shape)


def steady_gears(shaft: ShaftLineModel, section: FloatArray, mean: FloatArray) -> FloatArray:
    """The same of mean torques: sections (..., e) and all that acts on stations (..., s)."""
    found = np.empty((*mean.shape[:-1], len(shaft.gears)))
    rigid = iter(sides(shaft))
    for place, gear in enumerate(shaft.gears):
        if gear.element >= 0:
            found[..., place] = section[..., gear.element]
        else:
            side, _, sign = next(rigid)
            through = section @ _leaving(shaft, side)
            found[..., place] = sign * (through - mean[..., side].sum(axis=-1))
    return found


def station_means(
    shaft: ShaftLineModel, drive: Drive, speed: FloatArray, operating: float
) -> tuple[FloatArray, FloatArray]:
    """Mean torques (s, stations) with what takes them up, referred, in balance, and errors (s,)."""
    mean = np.zeros((len(speed), len(shaft.station_names)))
    mean[:, drive.station] = drive.mean_torque(speed)
    taken = shaft.taken_torque * (speed[:, None] / operating) ** shaft.taken_exponent
    for place, station in enumerate(shaft.taken_station.tolist()):
        # it brakes, whichever way its shaft turns
        mean[:, station] -= taken[:, place] * abs(shaft.station_ratio[station])
    mean[:, shaft.load_station] -= mean.sum(axis=1)
    error = drive.mean_torque_error(speed).sum(axis=1)
    return mean, error + 4.0 * EPSILON * np.abs(mean).sum(axis=1)


def steady_uncertainties(
    shaft: ShaftLineModel, drive: Drive, speed: FloatArray, mean: FloatArray, shares: FloatArray
) -> FloatArray:
    """Absolute errors (s, g) of mean torques of gears, referred, from means (s, stations).

    `shares` say what the sections carry of them.
    """
    # what 1 N m at each station, taken up where the load is, sends through the gears
    unit = np.eye(len(shaft.station_names))
    unit[:, shaft.load_station] -= 1.0
    through = np.abs(steady_gears(shaft, by_freedom(shaft, unit) @ shares.T, unit))
    known = 4.0 * EPSILON * np.abs(mean)
    known[:, drive.station] += drive.mean_torque_error(speed)
    size = np.abs(mean)
    carried = by_freedom(shaft, size) @ np.abs(shares).T
    rounding = np.empty((len(speed), len(shaft.gears)))
    rigid = iter(sides(shaft))
    for place, gear in enumerate(shaft.gears):
        if gear.element >= 0:
            rounding[:, place] = carried[:, gear.element]
            continue
        side, _, _ = next(rigid)
        rounding[:, place] = carried @ np.abs(_leaving(shaft, side)) + size[:, side].sum(axis=1)
    return np.asarray(known @ through + 4.0 * EPSILON * rounding)


def by_freedom(shaft: ShaftLineModel, mean: FloatArray) -> FloatArray:
    """Sums (..., n) over the stations of each freedom."""
    on = (shaft.freedom[:, None] == np.arange(len(shaft.freedom_names))).astype(float)
    return np.asarray(mean @ on)


def actual_per_referred(shaft: ShaftLineModel) -> FloatArray:
    """What referred torques of gears (g,) count on the shaft of the first wheel."""
    firsts: list[Gearing] = list(shaft.gears)
    return 1.0 / shaft.station_ratio[[gear.first for gear in firsts]]


def _leaving(shaft: ShaftLineModel, side: BoolArray) -> FloatArray:
    """Weights (e,) of section torques: what goes out of one side, less what comes in."""
    out = side[shaft.section_ends[:, 0]].astype(float)
    second = shaft.section_ends[:, 1]
    return np.asarray(out - np.where(second >= 0, side[second], False).astype(float))


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
    return max(ROWS, ENTRIES // (len(drive.order) * len(model.line.inertia)))


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
    """All orders (s, m, ...) at some speeds, referred: angles, twists, torques of sections."""

    frequency: FloatArray
    angle: ComplexArray
    twist: ComplexArray
    torque: ComplexArray
    load: ComplexArray
    error: FloatArray
    masked: BoolArray


def solved(model: Model, drive: Drive, speed: FloatArray, estimate: bool = False) -> OrderSolution:
    """Angles and torques at speeds (s,) in rad/s; `error` (s, m) of the angles, if asked for."""
    load = drive.torque(speed)
    found = model.solve(speed, drive.order, load, drive.freedom, estimate)
    line = model.at(speed[:, None])
    w = speed[:, None] * drive.order
    twist = found.angle[..., line.first] - found.angle[..., line.second]
    torque = complex_stiffness(line, w) * twist
    return OrderSolution(w, found.angle, twist, torque, load, found.error, found.masked)


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
        signals.append(
            gear_torques(
                shaft, drive, model, state.frequency, state.angle, state.torque, state.load
            )
        )
    ends = np.cumsum([one.shape[-1] for one in signals])[:-1]
    # signals in front and orders last, as they lie in memory
    stacked = np.concatenate([np.moveaxis(one, -1, 0) for one in signals])
    total = synthesis(drive.order, stacked)
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
    line = model.at(speed[:, None])
    heat = np.zeros((len(speed), len(line.first)))
    if len(damped):
        twisted = state.twist[..., damped]
        factor = state.frequency[..., None] * loss_stiffness(line, state.frequency)[..., damped]
        square = np.square(twisted.real) + np.square(twisted.imag)
        heat[:, damped] = 0.5 * np.sum(factor * square, axis=1)
    curves = (
        twist[0], np.maximum(np.abs(twist[1]), np.abs(twist[2])), half, highest, lowest,
        others[0][0] if angles else none,
        *gears,
        heat,
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
    line, w = setup.model.at(speed[:, None]), state.frequency[..., None]
    dynamic = line.ground_stiffness - w**2 * line.inertia + 1j * w * line.absolute_damping
    left = -dynamic * state.angle
    if setup.model.modal is not None:
        left -= line.inertia * modal_braking(setup.model, state.frequency, state.angle)
    torque = complex_stiffness(line, state.frequency) * state.twist
    for e, (first, second) in enumerate(zip(line.first, line.second, strict=True)):
        left[..., first] -= torque[..., e]
        left[..., second] += torque[..., e]
    for place, freedom in enumerate(setup.drive.freedom):
        left[..., freedom] += state.load[..., place]
    every = np.arange(len(line.inertia))
    return setup.model.solve(speed, setup.drive.order, left, every, estimate=False).angle


# ----------------------------------------------------------------------------
# What the errors of the torques do to a shaft line, and to sums over its orders.
# ----------------------------------------------------------------------------


def data_uncertainty(setup: Setup, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What the errors of the torques may move angles (s, m, n) and twists (s, m, e) by.

    The cylinders have them in common, as they have a card, each turned to its own firing; what is
    each one's own has no common sign.
    """
    drive, model = setup.drive, setup.model
    error = drive.torque_error(speed)
    one_by_one = error * np.eye(error.shape[-1])[:, None, None, :]
    moved = model.solve(
        speed, drive.order, one_by_one.astype(np.complex128), drive.freedom, estimate=False
    ).angle
    torque = drive.torque(speed)
    size = np.abs(torque)
    turn = np.moveaxis(torque / np.where(size > 0.0, size, 1.0), -1, 0)[..., None]
    line = model.line
    twist = moved[..., line.first] - moved[..., line.second]
    angle, between = (
        np.abs((turn * one).sum(axis=0)) + np.sqrt(np.sum(np.square(np.abs(one)), axis=0))
        for one in (moved, twist)
    )
    return angle, between


def summed(order: FloatArray, amplitude: ComplexArray, error: FloatArray) -> Synthesis:
    """All orders over the cycle; the errors (..., m) of the orders have no common sign."""
    found = synthesis(order, amplitude)
    return found._replace(error=found.error + np.sqrt(np.sum(np.square(error), axis=-1)))


# ----------------------------------------------------------------------------
# Error of the curves of a shaft line against speed, taken where they are largest and between.
# ----------------------------------------------------------------------------

#: speeds at equal steps, next to those of the largest values
SAMPLES = 16


class CurveUncertainty(NamedTuple):
    """Absolute errors, referred: twist (e,), torque (e,), angle (n,), torque of gears (g,)."""

    twist: FloatArray
    torque: FloatArray
    angle: FloatArray
    gear: FloatArray


class SectionUncertainty(NamedTuple):
    """Absolute errors (r,), referred, of twist and torque, each of one section at one speed."""

    twist: FloatArray
    torque: FloatArray


def curve_uncertainty(setup: Setup, speed: FloatArray, telling: FloatArray) -> CurveUncertainty:
    """Largest errors of sums over orders at some of the speeds (s,) and at those that tell (r,)."""
    some = speed[np.linspace(0, len(speed) - 1, min(SAMPLES, len(speed))).astype(int)]
    found = _errors(setup, distinct(np.concatenate([some, telling])))
    return CurveUncertainty(*(np.max(part, axis=0, initial=0.0) for part in found))


def section_uncertainty(setup: Setup, speed: FloatArray, section: IntArray) -> SectionUncertainty:
    """Errors of half ranges of sections (r,), each at its own speed (r,); 0 where unbounded."""
    at, place = np.unique(speed, return_inverse=True)
    parts = [_errors(setup, at[k : k + ROWS])[:2] for k in range(0, len(at), ROWS)]
    if not parts:
        return SectionUncertainty(np.zeros(0), np.zeros(0))
    return SectionUncertainty(
        *(np.concatenate(part)[place, section] for part in zip(*parts, strict=True))
    )


def twist_uncertainty(setup: Setup, at: FloatArray) -> FloatArray:
    """Errors (s, m, e) of the twists of each order at speeds (s,)."""
    found = solved(setup.model, setup.drive, at, estimate=True)
    return data_uncertainty(setup, at)[1] + rounding_uncertainty(setup, at, found)[1]


def _errors(setup: Setup, at: FloatArray) -> CurveUncertainty:
    """Errors of sums over orders at speeds (s,), each with s in front; 0 where unbounded."""
    state = solved(setup.model, setup.drive, at, estimate=True)
    angle, twist = data_uncertainty(setup, at)
    rounded_angle, rounded_twist = rounding_uncertainty(setup, at, state)
    angle = angle + rounded_angle
    twist = twist + rounded_twist
    line = setup.model.at(at[:, None])
    torque = np.abs(complex_stiffness(line, state.frequency)) * twist
    torque = torque + 4.0 * EPSILON * np.abs(state.torque)
    sums = [(twist, state.twist), (torque, state.torque), (angle, state.angle)]
    if len(line.first) == len(setup.shaft.section_names):  # else the line without dampers
        known = setup.drive.torque_error(at)
        of_line = (setup.shaft, setup.drive, setup.model, state.frequency)
        gear = gear_torques(*of_line, state.angle, state.torque, state.load)
        sums.append((gear_uncertainties(*of_line, angle, torque, known), gear))
    else:
        sums.append((torque[..., :0], state.torque[..., :0]))
    clear = ~np.any(state.masked, axis=1)[:, None]
    return CurveUncertainty(*(np.where(clear, _summed(*one), 0.0) for one in sums))


def _summed(error: FloatArray, value: np.ndarray) -> FloatArray:
    """Over the orders (s, m, ...), without a common sign, with the rounding of that sum."""
    whole = np.sqrt(np.sum(np.square(error), axis=1))
    return np.asarray(whole + 8.0 * EPSILON * np.abs(value).sum(axis=1))


def shifted_twist(setup: Setup, speed: FloatArray, error: FloatArray) -> FloatArray:
    """What errors (e,) of the speeds of each section (e,) move the half ranges of its twist by.

    The torque of a section is flat where it is largest; its twist need not be.
    """
    section = np.arange(len(speed))
    half = []
    for at in (speed, speed + error):
        blocks = [solved(setup.model, setup.drive, at[k : k + ROWS]) for k in section[::ROWS]]
        twist = np.concatenate([one.twist for one in blocks])[section, :, section]
        clear = ~np.concatenate([np.any(one.masked, axis=1) for one in blocks])
        half.append(np.where(clear, synthesis(setup.drive.order, twist).half_range, 0.0))
    return np.asarray(np.abs(half[1] - half[0]))

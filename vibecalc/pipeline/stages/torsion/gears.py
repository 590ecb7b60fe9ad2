"""Torque that each gear of a line transmits, referred, and the mean torques of the whole line."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.machine.shaft_line import Gearing, ShaftLine
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray
from vibecalc.pipeline.stages.torsion.drive import Drive

if TYPE_CHECKING:
    from vibecalc.pipeline.stages.torsion.setup import Model


class Side(NamedTuple):
    """Stations (s,) that turn as one with a wheel of a rigid gear; sign 1 for the second wheel."""

    stations: BoolArray
    wheel: int
    sign: float


def sides(shaft: ShaftLine) -> list[Side]:
    """Of each rigid gear the side with less inertia: its balance loses least.

    Raises NumericalFailure where rigid gears close a loop: statics does not tell their torques.
    """
    found = []
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
        found.append(Side(stations, wheel, 1.0 if lighter else -1.0))
    return found


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
    shaft: ShaftLine,
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
    found = np.empty((*angle.shape[:-1], len(shaft.gears)), dtype=np.complex128)
    rigid = iter(sides(shaft))
    w = np.asarray(frequency)
    for place, gear in enumerate(shaft.gears):
        if gear.element >= 0:
            found[..., place] = section[..., gear.element]
            continue
        side, wheel, sign = next(rigid)
        inertia, damping, held = shaft.station_values[:, side].sum(axis=1)
        own = angle[..., shaft.freedom[wheel]]
        value = (held - w**2 * inertia + 1j * w * damping) * own
        value = value + inertia * modal_braking(model, w, angle)[..., shaft.freedom[wheel]]
        value = value + section @ _leaving(shaft, side)
        found[..., place] = sign * (value - torque[..., side[drive.station]].sum(axis=-1))
    return found


def gear_doubts(
    shaft: ShaftLine,
    drive: Drive,
    model: "Model",
    frequency: FloatArray,
    angle: FloatArray,
    section: FloatArray,
    torque: FloatArray,
) -> FloatArray:
    """Absolute errors (..., g) of those, from errors of the same shapes."""
    found = np.empty((*angle.shape[:-1], len(shaft.gears)))
    rigid = iter(sides(shaft))
    w = np.asarray(frequency)
    for place, gear in enumerate(shaft.gears):
        if gear.element >= 0:
            found[..., place] = section[..., gear.element]
            continue
        side, wheel, _ = next(rigid)
        inertia, damping, held = shaft.station_values[:, side].sum(axis=1)
        value = (held + w**2 * inertia + w * damping) * angle[..., shaft.freedom[wheel]]
        moved = modal_braking(model, w, angle, bound=True)[..., shaft.freedom[wheel]]
        value = value + inertia * np.abs(moved)
        value = value + section @ np.abs(_leaving(shaft, side))
        found[..., place] = value + torque[..., side[drive.station]].sum(axis=-1)
    return found


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


def steady_gears(shaft: ShaftLine, section: FloatArray, mean: FloatArray) -> FloatArray:
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
    shaft: ShaftLine, drive: Drive, speed: FloatArray, operating: float
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


def steady_doubts(
    shaft: ShaftLine, drive: Drive, speed: FloatArray, mean: FloatArray, shares: FloatArray
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


def by_freedom(shaft: ShaftLine, mean: FloatArray) -> FloatArray:
    """Sums (..., n) over the stations of each freedom."""
    on = (shaft.freedom[:, None] == np.arange(len(shaft.freedom_names))).astype(float)
    return np.asarray(mean @ on)


def own_of_gears(shaft: ShaftLine) -> FloatArray:
    """What referred torques of gears (g,) count on the shaft of the first wheel."""
    firsts: list[Gearing] = list(shaft.gears)
    return 1.0 / shaft.station_ratio[[gear.first for gear in firsts]]


def _leaving(shaft: ShaftLine, side: BoolArray) -> FloatArray:
    """Weights (e,) of section torques: what goes out of one side, less what comes in."""
    out = side[shaft.section_ends[:, 0]].astype(float)
    second = shaft.section_ends[:, 1]
    return np.asarray(out - np.where(second >= 0, side[second], False).astype(float))

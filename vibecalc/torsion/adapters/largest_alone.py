"""Largest torques of a shaft line over its speeds, where a study asks for little else."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray, distinct
from vibecalc.torsion.adapters.curves import curve_uncertainty, solved, speeds_at_once
from vibecalc.torsion.adapters.maxima import torque_value
from vibecalc.torsion.adapters.setup import Drive, Model, Setup
from vibecalc.torsion.critical_speeds import RIVAL
from vibecalc.torsion.hung import BareLine, bare_line, hung, ring_stiffness
from vibecalc.torsion.line import loss_stiffness
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.rough_range import rough_range
from vibecalc.torsion.synthesis import synthesis

# ----------------------------------------------------------------------------
# A study of many lines asks for a few numbers of each: the largest torques over the speeds, what a
# damper takes off them, its heat. Then no curve has to be known where it cannot be the largest, and
# where only the rings of dampers differ from line to line, the line without them is solved once.
# ----------------------------------------------------------------------------

HEAT = f"{ROOT}/speeds/heat"
REDUCTION = f"{ROOT}/reduction"
#: beginnings of results of the stage that want the curves themselves
_CURVES = tuple(
    f"{ROOT}/{name}"
    for name in (
        *("speeds/", "peak/", "limit/", "barred/", "exceeded/", "hammering/", "healthy/"),
        *("coupling/",),
    )
)
#: with a larger error, over the largest angle that the rings hang on, the line is solved itself
UNSURE = 1e-10
#: numbers of a line without its rings up to which they are kept
MOST = 1 << 22


def little_asked(scene: Scene, setup: Setup) -> bool:
    """Whether what is wanted of the speeds is no more than largest torques and heat of dampers."""
    if scene.wanted is None or setup.torsion.limits or setup.shaft.couplings:
        return False
    if setup.torsion.misfire or len(distinct(setup.drive.cycles.group)) > 1:
        return False
    return not any(path.startswith(_CURVES) for path in scene.wanted if path != HEAT)


class Highest(NamedTuple):
    """Half ranges (s, e) of referred torques: of those that are not the largest of their section,
    or near it, something that is not below them and less than `RIVAL` of it; `heat` (s, d) of the
    rings in W with its error (d,)."""

    torque: FloatArray
    heat: Bounded


def highest_torques(scene: Scene, setup: Setup, bare: Setup | None, speed: FloatArray) -> Highest:
    """At speeds (s,) in rad/s; infinite where nothing damps an order.

    `bare` is the line without its rings, where it has any.
    """
    orders, count = setup.drive.order, len(setup.model.line.first)
    torque = np.empty((len(speed), count))
    heat = np.empty((len(speed), len(setup.shaft.dampers)))
    wants_torque = not (scene.wanted or set()) <= {HEAT}
    best = np.zeros(count)
    known = None if bare is None else _kept_bare(scene, setup, bare, speed)
    size = speeds_at_once(setup.model, setup.drive) * (1 if known is None else 8)
    unsure = np.zeros(heat.shape[1])
    for start in range(0, len(speed), size):
        part = slice(start, start + size)
        state = _state(setup, speed[part], None if known is None else known.cut(part))
        if wants_torque:
            torque[part], best = _half_ranges(orders, setup.drive, state.torque, best)
            torque[part][state.masked] = np.inf
        heat[part] = np.where(state.masked[:, None], np.inf, state.heat)
        unsure = np.maximum(unsure, state.unsure)
    if wants_torque:
        # the largest ones themselves as any other run has them
        place, section = np.argmax(torque, axis=0), np.arange(count)
        finite = np.flatnonzero(np.isfinite(torque[place, section]))
        value = torque_value(setup.model, setup.drive, finite)(speed[place[finite], None])
        torque[place[finite], finite] = value[:, 0]
    error = np.zeros(heat.shape[1])
    if scene.wants(HEAT):
        rings = [one.element for one in setup.shaft.dampers]
        finite = np.where(np.isfinite(heat), heat, 0.0)
        telling = distinct(speed[np.argmax(finite, axis=0)])
        error = curve_uncertainty(setup, speed, telling).heat[rings]
        error = error + unsure
    return Highest(torque, Bounded(heat, error))


class _State(NamedTuple):
    """At some speeds: torques (e, s, m), heat (s, d), `masked` (s,).

    `unsure` (d,) is how much further off the heat may be than that of a line solved as a whole.
    """

    torque: ComplexArray
    heat: FloatArray
    masked: BoolArray
    unsure: FloatArray


def _state(setup: Setup, speed: FloatArray, bare: BareLine | None) -> _State:
    if bare is None:
        return _solved(setup, speed)
    model, shaft = setup.model, setup.shaft
    w = setup.drive.frequency(speed)
    # pendulums have springs that follow the speed
    line, first = model.at(speed[:, None], w), shaft.dampers[0].element
    rings = [ring_stiffness(line, one.element, w) for one in shaft.dampers]
    found = hung(bare, sum((stiffness for stiffness, _ in rings), np.zeros((), complex)))
    lossy = loss_stiffness(line, w)
    torque = np.empty((len(model.line.first), *w.shape), dtype=complex)
    torque[:first] = found.torque
    heat, unsure = np.empty((len(speed), len(rings))), np.zeros(len(rings))
    size = np.abs(found.angle)
    enough = UNSURE * np.max(size, axis=-1, initial=0.0)
    unclear = ~(np.max(found.error, axis=-1, initial=0.0) <= enough)
    again = np.flatnonzero(unclear)
    wrong = size * found.error
    wrong[again] = 0.0
    for number, (one, (stiffness, turn)) in enumerate(zip(shaft.dampers, rings, strict=True)):
        np.multiply(stiffness, found.angle, out=torque[one.element])
        rate = w * lossy[..., one.element] * (np.square(turn.real) + np.square(turn.imag))
        heat[:, number] = 0.5 * np.sum(rate * np.square(size), axis=-1)
        unsure[number] = np.max(np.sum(rate * wrong, axis=-1))
    masked = np.zeros(len(speed), dtype=bool)
    if len(again):
        own = _solved(setup, speed[again])
        torque[:, again], heat[again], masked[again] = own.torque, own.heat, own.masked
    return _State(torque, heat, masked, unsure)


def _solved(setup: Setup, speed: FloatArray) -> _State:
    """Of the whole line."""
    state = solved(setup.model, setup.drive, speed)
    line = setup.model.at(speed[:, None], state.frequency)
    rings = [one.element for one in setup.shaft.dampers]
    twist = state.twist[..., rings]
    factor = state.frequency[..., None] * loss_stiffness(line, state.frequency)[..., rings]
    square = np.square(twist.real) + np.square(twist.imag)
    torque = np.ascontiguousarray(np.moveaxis(state.torque, -1, 0))
    heat = 0.5 * np.sum(factor * square, axis=1)
    return _State(torque, heat, np.any(state.masked, axis=-1), np.zeros(len(rings)))


def _half_ranges(
    orders: FloatArray, drive: Drive, torque: ComplexArray, best: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(s, e) as in `Highest`, with the `best` (e,) below the largest, before and after these."""
    count, speeds, _ = torque.shape
    rows = torque.reshape(count * speeds, -1)
    high = np.sum(np.abs(rows), axis=-1)
    by_section, section = high.reshape(count, speeds), np.repeat(np.arange(count), speeds)
    best = best.copy()

    def narrowed(chosen: np.ndarray) -> None:
        low, high[chosen] = rough_range(orders, rows[chosen])
        np.maximum.at(best, section[chosen], low)

    few = min(speeds, 8)
    seeds = np.argpartition(by_section, speeds - few, axis=1)[:, speeds - few :]
    narrowed((seeds + speeds * np.arange(count)[:, None]).ravel())
    narrowed(np.flatnonzero(high >= RIVAL * best[section]))
    chosen = np.flatnonzero(high >= RIVAL * best[section])
    high[chosen] = synthesis(drive.cycles, rows[chosen]).half_range
    return by_section.T, np.maximum(best, by_section.max(axis=1))


# ----------------------------------------------------------------------------
# The line without its rings, which lines that differ in their rings alone have in common.
# ----------------------------------------------------------------------------


def what_drives(model: Model, drive: Drive, speed: FloatArray) -> tuple[object, ...] | None:
    """All that the orders of a line at speeds (s,) hang on; None where that is not in arrays."""
    if model.modal is not None or model.over_speed is not None or model.couplings is not None:
        return None
    if len(drive.given.column):
        return None
    numbers = (drive.card_speed, drive.gas.value, drive.gas.error, drive.inertia.value)
    others = (drive.inertia.error, drive.freedom, drive.order, drive.orders.fixed)
    return (*model.line, model.speed_stiffness, model.method, *numbers, *others, speed)


def _kept_bare(scene: Scene, setup: Setup, bare: Setup, speed: FloatArray) -> BareLine | None:
    """The line without its rings as runs before this one have solved it; None in the first."""
    dampers, line = setup.shaft.dampers, setup.model.line
    if len({one.carrier for one in dampers}) > 1:
        return None
    rings = [one.ring for one in dampers]
    if np.any(line.absolute_damping[rings]) or np.any(line.ground_stiffness[rings]):
        return None
    numbers = 2 * len(speed) * len(setup.drive.order) * len(line.first)
    if scene.keeper is None or numbers > MOST or setup.torsion.damping_model is not None:
        return None
    freedom = dampers[0].carrier
    inputs = what_drives(bare.model, bare.drive, speed)
    if inputs is None:
        return None

    def make() -> BareLine:
        w = bare.drive.frequency(speed)
        at = bare.model.at(speed[:, None], w)
        return bare_line(at, w, bare.drive.load(speed), bare.drive.freedom, freedom)

    found: BareLine | None = scene.again("line without its rings", (*inputs, freedom), make)
    return found

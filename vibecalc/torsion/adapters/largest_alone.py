"""Largest torques of a shaft line over its speeds, where a study asks for little else."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import (
    EPSILON,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    distinct,
)
from vibecalc.torsion.adapters.motion import HALF, TORQUE, readings_of, solved, speeds_at_once
from vibecalc.torsion.adapters.search import Search, among, some_speeds
from vibecalc.torsion.adapters.setup import Drive, Model, Setup
from vibecalc.torsion.critical_speeds import by_machine, near_the_largest
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, complex_stiffness, loss_stiffness
from vibecalc.torsion.results import FOLLOWED, ROOT

# ----------------------------------------------------------------------------
# A change of rank one: rings on springs and dashpots at one freedom of a line.
#
# With the angle a of the freedom under all torques, and h under a torque of one there, both without
# the rings, rings of the dynamic stiffness D leave it the angle x = a / (1 + D h). They pull at the
# line with D x, so that any torque T in it becomes T - D x H, H being that of a torque of one. What
# the line has without the rings is solved once for any rings.
# ----------------------------------------------------------------------------

#: roundings of the quotient and the products
ROUNDINGS = 16.0


class BareLine(NamedTuple):
    """A line without its rings at frequencies (s, m), under its own torques and under one.

    `torque` and `unit_torque` (e, s, m) of its elements, `angle` and `unit_angle` (s, m) of the
    freedom that the rings hang on, complex; `error` and `unit_error` (s, m) bound all angles,
    `reach` (s, m) is the largest angle under the torque of one. `masked` (s, m): there is none.
    """

    torque: ComplexArray
    unit_torque: ComplexArray
    angle: ComplexArray
    unit_angle: ComplexArray
    error: FloatArray
    unit_error: FloatArray
    reach: FloatArray
    masked: BoolArray

    def cut(self, part: slice) -> "BareLine":
        """Some of the speeds."""
        by_element = {name: getattr(self, name)[:, part] for name in ("torque", "unit_torque")}
        others = {name: getattr(self, name)[part] for name in self._fields[2:]}
        return BareLine(**by_element, **others)


class Hung(NamedTuple):
    """What the rings pull the line with, and the angle of their freedom, (..., s, m) each.

    `error` (..., s, m) bounds all angles.
    """

    pull: ComplexArray
    angle: ComplexArray
    error: FloatArray


def bare_line(
    line: Line, frequency: FloatArray, load: ComplexArray, stations: IntArray, freedom: int
) -> BareLine:
    """Of torques (s, m, k) on some stations of a line without its rings; w (s, m) in rad/s."""
    own = forced_masked(line, frequency, load, stations=stations.tolist())
    one = forced_masked(line, frequency, np.ones((1, 1, 1), complex), stations=[freedom])
    stiffness = np.moveaxis(complex_stiffness(line, frequency), -1, 0)

    def torque(angle: ComplexArray) -> ComplexArray:
        twist = np.moveaxis(angle[..., line.first] - angle[..., line.second], -1, 0)
        return np.ascontiguousarray(stiffness * twist)

    masked = own.masked | one.masked
    return BareLine(
        torque(own.angle),
        torque(one.angle),
        np.ascontiguousarray(own.angle[..., freedom]),
        np.ascontiguousarray(one.angle[..., freedom]),
        np.where(masked, 0.0, own.error),
        np.where(masked, 0.0, one.error),
        np.max(np.abs(one.angle), axis=-1),
        masked,
    )


def ring_stiffness(
    line: Line, element: int, frequency: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Of the ring behind an element at (..., s, m): its dynamic stiffness, and twist per angle."""
    square = -np.square(frequency) * line.inertia[..., line.second[element]]
    stiffness = line.stiffness[..., element]
    lossy = frequency * line.damping[..., element] + stiffness * line.loss_factor[..., element]
    shape = np.broadcast_shapes(square.shape, np.shape(stiffness), lossy.shape)
    spring: ComplexArray = np.empty(shape, dtype=complex)
    spring.real, spring.imag = stiffness, lossy
    twist = square / (spring + square)
    return spring * twist, twist


def hung(bare: BareLine, stiffness: ComplexArray) -> Hung:
    """With rings of a dynamic stiffness (..., s, m) on the freedom, many machines in front.

    Errors are infinite where masked.
    """
    whole = 1.0 / (1.0 + stiffness * bare.unit_angle)
    angle = bare.angle * whole
    pull = stiffness * angle
    # what is wrong in both angles without rings moves the pull, and that all of the line
    size = np.abs(pull)
    wrong = bare.error + size * bare.unit_error
    wrong *= 1.0 + np.abs(stiffness * whole) * bare.reach
    wrong += ROUNDINGS * EPSILON * (np.abs(bare.angle) + size * bare.reach)
    wrong[..., bare.masked] = np.inf
    return Hung(pull, angle, wrong)


def torque_under(bare: BareLine, pull: ComplexArray, out: ComplexArray) -> None:
    """Torques (e, ..., s, m) of the bare line's elements under a pull (..., s, m), into `out`."""
    between = tuple(range(1, pull.ndim - 1))
    np.multiply(np.expand_dims(bare.unit_torque, between), pull, out=out)
    np.subtract(np.expand_dims(bare.torque, between), out, out=out)


# ----------------------------------------------------------------------------
# A study of many lines asks for a few numbers of each: the largest torques over the speeds, what a
# damper takes off them, its heat. Then no curve has to be known where it cannot be the largest, and
# where only the rings of dampers differ from line to line, the line without them is solved once.
# ----------------------------------------------------------------------------

HEAT = f"{ROOT}/speeds/heat"
#: beginnings of results of the stage that want the curves themselves
_CURVES = tuple(
    f"{ROOT}/{name}"
    for name in (
        *("speeds/", "peak/", "limit/", "barred/", "exceeded/", "hammering/", "healthy/"),
        *("coupling/", *(f"largest/{one}" for one in FOLLOWED)),
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


def highest_torques(scene: Scene, setup: Setup, bare: Setup | None, speed: FloatArray) -> Search:
    """A search for the torques of sections over speeds (s,) in rad/s, of one line or of machines.

    Its samples are, where they are not the largest of their section, or near it, something that is
    not below them and less than `RIVAL` of it. `bare` is the line without its rings, where it has
    any, whose heat is emitted.
    """
    known = readings_of(setup)
    names = [name for name in (TORQUE, *HALF, "heat") if name in known]
    readings = {name: known[name] for name in names}
    search = Search([setup], speed, [readings], [TORQUE])
    count, rings = len(setup.model.line.first), [one.element for one in setup.shaft.dampers]
    machines = max(1, setup.model.machines)
    torque = np.empty((machines, len(speed), count))
    heat = np.empty((machines, len(speed), len(rings)))
    wants_torque = not (scene.wanted or set()) <= {HEAT}
    best = np.zeros((count, machines))
    kept = None if bare is None else _kept_bare(scene, setup, bare, speed)
    size = speeds_at_once(setup.model, setup.drive) * (1 if kept is None else 8)
    unsure = np.zeros((machines, len(rings)))
    # of some machines all speeds, or of one machine some speeds
    together = max(1, size // len(speed))
    for first in range(0, machines, together):
        some = slice(first, min(first + together, machines))
        chosen = np.arange(machines)[some]
        for start in range(0, len(speed), size):
            part = slice(start, start + size)
            here = None if kept is None else kept.cut(part)
            state = _state(setup, chosen, speed[part], here, wants_torque)
            place = (some, part)
            if wants_torque:
                torque[place] = _half_ranges(setup, state.torque, best[:, some])
                torque[place][state.masked] = np.inf
            heat[place] = np.where(state.masked[..., None], np.inf, state.heat)
            unsure[some] = np.maximum(unsure[some], state.unsure)
    if wants_torque:
        _put_samples(search, torque / np.abs(setup.shaft.section_ratio))
    if rings and scene.wants(HEAT):
        telling = speed[np.argmax(np.where(np.isfinite(heat), heat, 0.0), axis=1)]
        at = np.concatenate([telling, np.tile(some_speeds(speed), (machines, 1))], axis=1)
        pairs = by_machine(np.arange(machines)[:, None], at).ravel()
        pairs = np.unique(pairs, return_index=True)[0]
        errors = search.errors(pairs, ["heat"])["heat"]
        starts = np.searchsorted(pairs.real, np.arange(machines))
        off = (unsure + np.maximum.reduceat(errors, starts, axis=0))[..., None]
        value = np.swapaxes(heat, 1, 2)
        off = np.where(np.isfinite(value), off, 0.0)
        only: Any = slice(None) if setup.model.machines else 0
        axes = {"speed": speed, "damper": known["heat"].names}
        scene.emit(HEAT, value[only], off[only], axes)
    return search


def _put_samples(search: Search, torque: FloatArray) -> None:
    """Torques (p, s, e) of the sweep, with those about narrow resonances, as samples."""
    count = torque.shape[-1]
    samples = np.zeros((len(search.pairs), search.count))
    swept = among(search.pairs.imag, search.speed)
    samples[swept, :count] = torque.reshape(-1, count)
    machine, section = search.pairs.real.astype(np.int64), np.arange(count)
    best = np.max(torque, axis=1, initial=0.0, where=np.isfinite(torque)).ravel()
    extra = np.flatnonzero(~swept)
    for part, _, motion in search.motions(search.pairs[extra]):
        rows, own = motion.rows("torque", section), extra[part]
        group = machine[own, None] * count + section
        cycles = motion.setup.drive.cycles
        half = near_the_largest(cycles, rows.reshape(group.size, -1), group.ravel(), best)
        samples[own, :count] = np.where(motion.masked[:, None], np.inf, half.reshape(group.shape))
    # the largest ones themselves as any other run has them
    first = np.flatnonzero(np.diff(search.pairs.real, prepend=-1.0))
    most = np.maximum.reduceat(samples[:, :count], first, axis=0)
    place, section = np.nonzero(swept[:, None] & (samples[:, :count] == most[machine]))
    own = np.isfinite(samples[place, section])
    place, section = place[own], section[own]
    numbers = machine[place] * search.count + section
    samples[place, section] = search.value(numbers, search.pairs.imag[place, None])[:, 0]
    search.samples = samples


class _State(NamedTuple):
    """Of p machines at s speeds: torques (e, p, s, m), maybe none, heat (p, s, d), `masked` (p, s).

    `unsure` (p, d) is how much further off the heat may be than that of a line solved as a whole.
    """

    torque: ComplexArray
    heat: FloatArray
    masked: BoolArray
    unsure: FloatArray


def _state(
    setup: Setup,
    machine: IntArray,
    speed: FloatArray,
    bare: BareLine | None,
    with_torque: bool,
) -> _State:
    if bare is None:
        return _solved(setup, machine, speed)
    model, shaft, w = setup.model, setup.shaft, setup.drive.frequency(speed)
    shape = (len(machine), *w.shape)
    # pendulums have springs that follow the speed
    line, first = model.of(machine[:, None]).at(speed[:, None], w), shaft.dampers[0].element
    rings = [ring_stiffness(line, one.element, w) for one in shaft.dampers]
    found = hung(bare, sum((stiffness for stiffness, _ in rings), np.zeros(shape, complex)))
    lossy = loss_stiffness(line, w)
    torque = np.empty((len(line.first) * with_torque, *shape), dtype=complex)
    if with_torque:
        torque_under(bare, found.pull, torque[:first])
    heat, unsure = np.empty((*shape[:2], len(rings))), np.zeros((len(machine), len(rings)))
    size = np.abs(found.angle)
    enough = UNSURE * np.max(size, axis=-1, initial=0.0)
    again = np.nonzero(~(np.max(found.error, axis=-1, initial=0.0) <= enough))
    wrong = size * found.error
    wrong[again] = 0.0
    for number, (one, (stiffness, turn)) in enumerate(zip(shaft.dampers, rings, strict=True)):
        if with_torque:
            np.multiply(stiffness, found.angle, out=torque[one.element])
        rate = w * lossy[..., one.element] * (np.square(turn.real) + np.square(turn.imag))
        heat[..., number] = 0.5 * np.sum(rate * np.square(size), axis=-1)
        unsure[:, number] = np.max(np.sum(rate * wrong, axis=-1), axis=-1)
    masked = np.zeros(shape[:2], dtype=bool)
    if len(again[0]):
        own = _solved_at(setup, machine[again[0]], speed[again[1]])
        heat[again], masked[again] = own.heat, own.masked
        if with_torque:
            torque[:, again[0], again[1]] = own.torque
    return _State(torque, heat, masked, unsure)


def _solved(setup: Setup, machine: IntArray, speed: FloatArray) -> _State:
    """Of the whole lines."""
    at = (np.repeat(machine, len(speed)), np.tile(speed, len(machine)))
    found, shape = _solved_at(setup, *at), (len(machine), len(speed))
    torque = found.torque.reshape(len(found.torque), *shape, -1)
    heat = found.heat.reshape(*shape, -1)
    return _State(torque, heat, found.masked.reshape(shape), np.zeros((shape[0], heat.shape[-1])))


def _solved_at(setup: Setup, machine: IntArray, speed: FloatArray) -> _State:
    """Each machine (s,) at its own speed (s,), as those of one."""
    model = setup.model.of(machine)
    state = solved(model, setup.drive, speed)
    line = model.at(speed[:, None], state.frequency)
    rings = [one.element for one in setup.shaft.dampers]
    twist = state.twist[..., rings]
    factor = state.frequency[..., None] * loss_stiffness(line, state.frequency)[..., rings]
    square = np.square(twist.real) + np.square(twist.imag)
    torque = np.ascontiguousarray(np.moveaxis(state.torque, -1, 0))
    heat = 0.5 * np.sum(factor * square, axis=1)
    return _State(torque, heat, np.any(state.masked, axis=-1), np.zeros((1, len(rings))))


def _half_ranges(setup: Setup, torque: ComplexArray, best: FloatArray) -> FloatArray:
    """(p, s, e) as in `Highest` of torques (e, p, s, m); raises the `best` (e, p) so far."""
    sections, machines, speeds, _ = torque.shape
    group, before = np.repeat(np.arange(best.size), speeds), best.ravel()
    rows = torque.reshape(len(group), -1)
    high = near_the_largest(setup.drive.cycles, rows, group, before, seeds=8)
    best[...] = before.reshape(best.shape)
    return np.moveaxis(high.reshape(sections, machines, speeds), 0, -1)


# ----------------------------------------------------------------------------
# The line without its rings, which lines that differ in their rings alone have in common.
# ----------------------------------------------------------------------------


def what_drives(model: Model, drive: Drive, speed: FloatArray) -> tuple[object, ...] | None:
    """All that the orders of a line at speeds (s,) hang on; None where that is not in arrays."""
    if model.modal is not None or model.over_speed is not None or model.couplings is not None:
        return None
    if drive.given:
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
    if numbers > MOST or setup.torsion.damping_model is not None:
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

"""The one search over a range of speeds: samples of any readings, and where each is largest."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray, IntArray, distinct
from vibecalc.torsion.adapters.bounds import SAME
from vibecalc.torsion.adapters.critical import (
    FREEDOMS,
    STILL,
    UndampedResonances,
    none_undamped,
    undamped_speeds,
)
from vibecalc.torsion.adapters.motion import EVERY, ROWS, Motion, blocks, gear_shares
from vibecalc.torsion.adapters.setup import Model, Setup, line_speeds
from vibecalc.torsion.critical_speeds import Maxima, by_machine, largest, machine_and_speed
from vibecalc.torsion.line import Line, complex_stiffness
from vibecalc.torsion.poles import LinePoles, all_poles, all_poles_by_order, poles_at_orders

# ----------------------------------------------------------------------------
# Speeds between those of a sweep at which a resonance too narrow for its steps may stand.
# ----------------------------------------------------------------------------

#: steps of the sweep that half a resonance is wide when its points show it
SHOWN = 1.5
#: places about a resonance, in half its width
NEARBY = np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
#: relative width below which a resonance has no digits
FINEST = 1e-11
#: parts of a range of speeds, each with the dampings of its middle
PARTS = 12
NONE = np.zeros(0)


def with_narrow(setup: Setup, speed: FloatArray, corners: FloatArray = NONE) -> ComplexArray:
    """Speeds (r,) `by_machine`: those of a sweep (s,), with those of narrow resonances, corners.

    What is a speed of the sweep but for rounding, as the corner of a limit may be, is left out.
    """
    machines = np.arange(max(1, setup.model.machines))
    every = by_machine(np.repeat(machines, len(speed)), np.tile(speed, len(machines)))
    if len(speed) < 2:
        return every
    order = setup.drive.order
    poles = _poles(setup, float(speed[0]), float(speed[-1]))
    at = poles.pole.imag / order[poles.order]
    width = np.maximum(np.abs(poles.pole.real) / order[poles.order], FINEST * at)
    step = np.diff(speed)[np.clip(np.searchsorted(speed, at) - 1, 0, len(speed) - 2)]
    narrow = (width < SHOWN * step) & (poles.pole.real < 0.0)
    narrow &= setup.drive.orders.fixed[poles.order] == 0.0
    extra = at[narrow, None] + width[narrow, None] * NEARBY
    of = np.broadcast_to(poles.machine[narrow, None], extra.shape)
    more = np.concatenate([
        by_machine(of, extra).ravel(),
        by_machine(np.repeat(machines, len(corners)), np.tile(corners, len(machines))),
    ])  # fmt: skip
    more = more[(more.imag > speed[0]) & (more.imag < speed[-1])]
    # without the index numpy imports its masked arrays
    more = np.unique(more, return_index=True)[0]
    place = np.clip(np.searchsorted(speed, more.imag), 1, len(speed) - 1)
    beside = np.abs(speed[np.stack([place - 1, place])] - more.imag)
    more = more[np.all(beside > SAME * more.imag, axis=0)]
    more = more[np.abs(np.diff(more, prepend=-1.0)) > SAME * more.imag]
    return np.unique(np.concatenate([every, more]), return_index=True)[0]


def _poles(setup: Setup, first: float, last: float) -> LinePoles:
    """Poles of the line with positive frequency, each at every order; from `first` to `last`."""
    order, model, line = setup.drive.order, setup.model, setup.model.line
    if model.modal is not None or line.inertia.shape[-1] > FREEDOMS:
        modes = setup.natural()
        some = np.flatnonzero((modes.frequency > 0.0) & ~modes.silent)
        none = np.zeros_like(some)
        return poles_at_orders(LinePoles(modes.pole[some], none, none), len(order))
    if model.couplings is not None:
        return _poles_of_couplings(setup, first, last)
    found = _poles_of(line, model, order)
    if model.over_speed is None:
        return found
    # a width is that of the dampings at the speed where the pole meets the order
    met = found.pole.imag / order[found.order]
    part = np.clip(PARTS * (met - first) / (last - first), 0, PARTS - 1).astype(int)
    for number in sorted(set(part.tolist())):
        middle = first + (number + 0.5) * (last - first) / PARTS
        there = _poles_of(model.over_speed.on(line, middle), model, order)
        rows = np.flatnonzero(part == number)
        apart = np.abs(there.pole.imag - found.pole.imag[rows, None])
        apart[there.order != found.order[rows, None]] = np.inf
        found.pole[rows] = there.pole[np.argmin(apart, axis=1)]
    return found


def _poles_of(line: Line, model: Model, order: FloatArray) -> LinePoles:
    """Those of a line with the dampings of one speed."""
    if not np.any(model.speed_stiffness):
        return poles_at_orders(all_poles(line), len(order))
    # with pendulums the line is another one at every order
    return all_poles_by_order(line, model.speed_stiffness, order)


#: rounds until a pole has the line of its own speed, and its width that is near enough
_TURNS, _ENOUGH = 12, 1e-3


def _poles_of_couplings(setup: Setup, first: float, last: float) -> LinePoles:
    """Poles at each order of the line at the speed of the sweep next to where it meets them."""
    order, model = setup.drive.order, setup.model
    assert setup.torsion.speeds is not None, "asked of a sweep"
    speed = line_speeds(setup.torsion.speeds)
    poles, places = [], []
    for place, one in enumerate(order.tolist()):
        begin = all_poles(model.at(setup.speed, one * setup.speed)).pole
        for pole in begin.tolist():
            if not 0.5 * first <= pole.imag / one <= 2.0 * last:
                continue
            for _ in range(_TURNS):
                at = float(speed[np.argmin(np.abs(speed - pole.imag / one))])
                every = all_poles(model.at(at, pole.imag)).pole
                nearest = complex(every[np.argmin(np.abs(every - pole))])
                moved, pole = abs(nearest - pole), nearest
                if moved <= _ENOUGH * abs(pole.real):
                    break
            poles.append(pole)
            places.append(place)
    met = np.array(places, dtype=np.int64)
    return LinePoles(np.array(poles, dtype=np.complex128), met, np.zeros_like(met))


# ----------------------------------------------------------------------------
# What moves without end where an order meets a mode that nothing damps.
# ----------------------------------------------------------------------------

#: part of a mode's largest torque below which a gear counts as unloaded
UNLOADED = 1e-9


def moved(setup: Setup, undamped: UndampedResonances, signal: str) -> BoolArray:
    """Places (u, r) of a signal that move in the modes of undamped resonances."""
    shaft, line, shape = setup.shaft, setup.model.line, setup.natural().shape[undamped.mode - 1]
    twist = shape[:, line.first] - shape[:, line.second]
    if signal in ("twist", "torque", "stress"):
        return _moves(np.abs(twist))
    if signal not in ("gear", "load"):
        return _moves(np.abs(shape))[:, shaft.freedom]
    frequency = undamped.speed * undamped.order
    torque = complex_stiffness(setup.model.at(undamped.speed, frequency), frequency) * twist
    of_sections, of_stations = gear_shares(shaft)
    inertia, damping, held = shaft.station_values
    w = frequency[:, None]
    need = (held - w**2 * inertia + 1j * w * damping) * shape[:, shaft.freedom]
    carried = np.abs(torque @ of_sections - need @ of_stations)
    both = np.concatenate([np.abs(torque), carried], axis=1)
    loaded = carried > UNLOADED * both.max(axis=1, initial=0.0)[:, None]
    sections = _moves(np.abs(twist))
    return loaded if signal == "gear" else np.concatenate([sections, loaded], axis=1)


def _moves(size: FloatArray) -> BoolArray:
    return np.asarray(size > STILL * np.max(size, axis=1, initial=0.0)[:, None])


def endless(setup: Setup, undamped: UndampedResonances, reading: Any) -> FloatArray:
    """The lowest speeds (r,) at which nothing bounds a reading, NaN for none."""
    found = np.full(len(reading.place), np.nan)
    if len(undamped.speed) and reading.kind != "mean":
        rows = moved(setup, undamped, reading.signal)[:, reading.place]
        rows = rows & (reading.scales(undamped.speed) > 0.0)
        for at, one in zip(undamped.speed[::-1].tolist(), rows[::-1], strict=True):
            found[one] = at
    return found


# ----------------------------------------------------------------------------
# Samples of all readings, and each maximum that may be the highest, refined.
# ----------------------------------------------------------------------------

#: speeds at equal steps, next to those of the largest values, at which errors are taken
SAMPLES = 16


def among(values: FloatArray, known: FloatArray) -> BoolArray:
    """Which values (k,) are among some that rise; numpy's own imports its masked arrays."""
    place = np.minimum(np.searchsorted(known, values), len(known) - 1)
    return np.asarray(known[place] == values)


def some_speeds(speed: FloatArray) -> FloatArray:
    """Speeds at equal steps, at which errors of curves are read."""
    place = np.linspace(0, len(speed) - 1, min(SAMPLES, len(speed))).astype(int)
    return np.asarray(speed[place])


class Top(NamedTuple):
    """The largest of a reading in each of p lines, and the speed in rad/s; (p, r)."""

    value: Bounded
    speed: Bounded

    def of(self, line: int) -> "Top":
        """In one of the lines, (r,)."""
        return Top(self.value[line], self.speed[line])


class Search:
    """Readings of p lines over speeds (s,), each line with the same names of readings.

    `lines` are one, one in several conditions, or one of many machines, whose speeds are then their
    own. `samples` (k, r) at `pairs` (k,) of line and speed are infinite where nothing damps an
    order; `orders` are those that count in each line. What `searched` names is looked for between
    the samples; of curves that have one `group` number (p, r) only what is largest of all is.
    """

    def __init__(
        self,
        lines: Sequence[Setup],
        speed: FloatArray,
        readings: Sequence[Mapping[str, Any]],
        searched: Sequence[str],
        corners: FloatArray = NONE,
        orders: Sequence[Any] = (),
    ) -> None:
        self.lines, self.speed, self.readings = lines, speed, readings
        self.orders, self.searched, first = orders, list(searched), lines[0]
        self.group: IntArray | None = None
        #: speeds at which lines were solved so far
        self.solved = 0
        ends = float(speed[0]), float(speed[-1])
        self.undamped = [none_undamped(one) or undamped_speeds(one, *ends)
                         for one in (lines if not orders else lines[:1])]  # fmt: skip
        own = with_narrow(first, speed, corners)
        for one in self.undamped:
            near = np.any((own.imag[:, None] >= one.low) & (own.imag[:, None] <= one.high), axis=1)
            own = own[~near | among(own.imag, speed)]
        self.pairs = np.concatenate([own + number for number in range(len(lines))])
        sizes = [len(one.place) for one in readings[0].values()]
        ends_of = np.cumsum([0, *sizes]).tolist()
        places = (slice(*pair) for pair in pairwise(ends_of))
        self.columns = dict(zip(readings[0], places, strict=True))
        self.count = ends_of[-1]

    @property
    def machines(self) -> int:
        """How many lines there are."""
        return self.lines[0].model.machines or len(self.lines)

    @property
    def grid(self) -> FloatArray:
        """The speeds of the samples of the first line."""
        return np.asarray(self.pairs.imag[self.pairs.real == 0.0])

    def motions(
        self, pairs: ComplexArray, bounded: bool = False
    ) -> Iterator[tuple[slice, int, Motion]]:
        """The lines in motion at `pairs` (k,), by rising line, block by block."""
        line, speed = machine_and_speed(pairs)
        starts = [0, *(np.flatnonzero(np.diff(line)) + 1).tolist(), len(line)]
        if self.lines[0].model.machines:
            starts = [0, len(line)]
        for start, stop in pairwise(starts):
            number = 0 if self.lines[0].model.machines else int(line[start]) if stop else 0
            setup = self.lines[number]
            parts = blocks(setup, stop - start)
            if bounded:
                parts = [slice(at, at + ROWS) for at in range(0, stop - start, ROWS)]
            for part in parts:
                own = slice(start + part.start, min(start + part.stop, stop))
                orders = self.orders[number] if self.orders else EVERY
                self.solved += own.stop - own.start
                yield own, number, Motion(setup.of(line[own]), speed[own], bounded, orders)

    @cached_property
    def samples(self) -> FloatArray:
        """Values (k, r) of all readings."""
        return self.sampled(self.pairs)

    def sampled(self, pairs: ComplexArray) -> FloatArray:
        """Values (k, r) of all readings at `pairs` (k,) that rise."""
        found = np.empty((len(pairs), self.count))
        for part, number, motion in self.motions(pairs):
            for name, reading in self.readings[number].items():
                found[part, self.columns[name]] = reading.of(motion).value
        return found

    def curves(self, name: str, line: int = 0) -> FloatArray:
        """Samples (s, r) of a reading at the speeds of the sweep."""
        own = self.pairs.real == line
        at = self.samples[own, self.columns[name]]
        return np.asarray(at[among(self.pairs.imag[own], self.speed)])

    def errors(self, pairs: ComplexArray, names: Sequence[str]) -> dict[str, FloatArray]:
        """Errors (k, r) at `pairs` (k,) that rise; 0 where there is no bound."""
        of = {name: np.zeros((len(pairs), self._size(name))) for name in names}
        for part, number, motion in self.motions(pairs, bounded=True):
            for name in names:
                of[name][part] = self.readings[number][name].errors(motion)
        return of

    def _size(self, name: str) -> int:
        columns = self.columns[name]
        return int(columns.stop - columns.start)

    def value(self, rows: IntArray, where: FloatArray) -> FloatArray:
        """Values (n, k) of readings, by their numbers (n,) among those of all lines."""
        line, column = np.divmod(rows, self.count)
        pairs = by_machine(np.broadcast_to(line[:, None], where.shape), where)
        # what is highest at one resonance is examined from the same places
        flat, back = np.unique(pairs, return_inverse=True)
        back, column = back.ravel(), np.repeat(column, where.shape[1])
        found = np.empty(back.size)
        for part, number, motion in self.motions(flat):
            here = np.flatnonzero((back >= part.start) & (back < part.stop))
            of = column[here]
            for name, reading in self.readings[number].items():
                columns = self.columns[name]
                chosen = (of >= columns.start) & (of < columns.stop)
                own = here[chosen]
                if len(own):
                    at = back[own] - part.start
                    found[own] = reading.of(motion, at, column[own] - columns.start).value
        return found.reshape(where.shape)

    @cached_property
    def clear(self) -> BoolArray:
        """Pairs (k,) at which all searched readings have a bound."""
        return np.asarray(np.all(np.isfinite(self.samples[:, self.sought]), axis=1))

    @cached_property
    def sought(self) -> IntArray:
        """Columns of all that is searched."""
        every = np.arange(self.count)
        return np.concatenate([every[:0], *(every[self.columns[one]] for one in self.searched)])

    @cached_property
    def endless(self) -> FloatArray:
        """Speeds (p, r) at which nothing bounds what is searched, NaN for none."""
        if self.orders or self.lines[0].model.machines:
            return np.full((self.machines, len(self.sought)), np.nan)
        return np.array([
            np.concatenate([NONE, *(endless(line, met, own[name]) for name in self.searched)])
            for line, met, own in zip(self.lines, self.undamped, self.readings, strict=True)
        ])  # fmt: skip

    @cached_property
    def undamped_at(self) -> FloatArray:
        """All speeds (u,) at which nothing damps an order."""
        return distinct(np.concatenate([one.speed for one in self.undamped]))

    def number(self, rows: IntArray) -> IntArray:
        """Numbers among all readings of all lines of those (n,) among what is searched."""
        line, own = np.divmod(rows, len(self.sought))
        return np.asarray(line * self.count + self.sought[own])

    @cached_property
    def found(self) -> Maxima:
        """The largest of all that is searched, line by line, (p r,)."""
        curve = self.samples[self.clear][:, self.sought]
        line, speed = machine_and_speed(self.pairs[self.clear])
        # the least of what may be negative is the largest of what a constant leaves
        low = np.concatenate([NONE, *(
            np.full(self._size(name), self.readings[0][name].kind == "least")
            for name in self.searched
        )])  # fmt: skip
        sense = np.where(low, -1.0, 1.0)
        shift = np.where(low, 2.0 * np.max(np.abs(curve), axis=0, initial=0.0), 0.0)

        def value(rows: IntArray, where: FloatArray) -> FloatArray:
            own = rows % len(self.sought)
            return shift[own, None] + sense[own, None] * self.value(self.number(rows), where)

        group = None if self.group is None else self.group[:, self.sought].ravel()
        top = largest(
            value, shift + sense * curve, speed, self.undamped_at, self.endless, line, group
        )
        every = np.tile(sense, self.machines), np.tile(shift, self.machines)
        return top._replace(value=every[0] * (top.value - every[1]))

    def _worst_line(self) -> list[int]:
        """Lines whose errors tell those of curves: all, of conditions the one of the largest."""
        if len(self.lines) < 2:
            return list(range(self.machines))
        value = self.found.value
        return [int(np.argmax(np.where(np.isfinite(value), value, -np.inf)) // len(self.sought))]

    @cached_property
    def _errors(self) -> dict[str, tuple[ComplexArray, dict[str, FloatArray]]]:
        """Pairs at which errors are taken, and errors there of what may be asked for."""
        return {}

    def _told(self, where: str) -> tuple[ComplexArray, dict[str, FloatArray]]:
        """Those at the "tops" of what is searched, or over the "range"."""
        if where not in self._errors:
            top = self.found
            chosen = np.isfinite(top.value)
            if where == "tops":
                line = np.repeat(np.arange(self.machines), len(self.sought))
                if self.group is not None:
                    chosen &= self._highest_of_groups()
                parts = [by_machine(line[chosen], top.speed[chosen])]
            else:
                some = some_speeds(self.speed)
                parts = [by_machine(np.full(len(some), one), some) for one in self._worst_line()]
                # next to what nothing damps errors are largest
                grid = self.pairs[self.clear]
                if len(self.undamped_at) and len(grid):
                    near = np.searchsorted(grid.imag, self.undamped_at)[:, None] + [-1, 0]
                    parts.append(grid[np.clip(near, 0, len(grid) - 1)].ravel())
            at = np.unique(np.concatenate(parts), return_index=True)[0]
            names = [one for one in self.readings[0] if one != "heat" or one in self.searched]
            self._errors[where] = at, self.errors(at, names)
        return self._errors[where]

    def _highest_of_groups(self) -> BoolArray:
        """Which of what is searched (p r,) are the largest of their group."""
        assert self.group is not None
        group, value = self.group[:, self.sought].ravel(), self.found.value
        best = np.full(int(group.max(initial=-1)) + 1, -np.inf)
        np.maximum.at(best, group, value)
        return np.asarray(value >= best[group])

    def uncertainty(self, name: str, line: int = 0) -> FloatArray:
        """Largest errors (r,) of a reading over the range."""
        most = np.zeros(self._size(name))
        for where in ("tops", "range"):
            at, errors = self._told(where)
            own = (at.real == line) | (len(self.lines) > 1)
            most = np.maximum(most, np.max(errors[name][own], axis=0, initial=0.0))
        return most

    def bounded_curves(self, name: str, line: int = 0) -> Bounded:
        """`curves` (s, r) with their errors."""
        values = self.curves(name, line)
        return Bounded(values, np.broadcast_to(self.uncertainty(name, line), values.shape))

    def _at_tops(self, name: str, speed: FloatArray) -> FloatArray:
        """Errors of a reading at speeds (p, r) of largest values; 0 where none were taken."""
        at, errors = self._told("tops")
        if not len(at):
            return np.zeros(speed.shape)
        line = np.broadcast_to(np.arange(len(speed))[:, None], speed.shape)
        pairs = by_machine(line, speed)
        place = np.minimum(np.searchsorted(at, pairs), len(at) - 1)
        found = errors[name][place, np.arange(speed.shape[1])]
        return np.where(at[place] == pairs, found, 0.0)

    def top(self, name: str) -> Top:
        """The largest values of one reading, with the errors at their own speeds."""
        found, columns = self.found, self.columns[name]
        shape = (self.machines, len(self.sought))
        own = (self.sought >= columns.start) & (self.sought < columns.stop)
        speed, speed_error, value, value_error = (
            one.reshape(shape)[:, own] for one in found[1:]
        )  # fmt: skip
        rounding = np.where(np.isfinite(value), self._at_tops(name, speed), 0.0)
        return Top(Bounded(value, value_error + rounding), Bounded(speed, speed_error))

    def beside(self, name: str, top: Top) -> Bounded:
        """A reading at the speeds of another one's largest values (p, r); infinite with those.

        That is flat where it is largest; the reading need not be, and moves by what its speed is
        off.
        """
        speed, off = top.speed
        rows = np.arange(speed.size).reshape(speed.shape)
        line, column = np.divmod(rows, speed.shape[1])
        numbers = (line * self.count + self.columns[name].start + column).ravel()
        off = np.where(speed + off > self.speed[-1], -off, off)
        values = self.value(numbers, np.stack([speed.ravel(), (speed + off).ravel()], axis=1))
        finite = np.isfinite(top.value.value)
        values = np.where(finite.reshape(-1, 1), values, 0.0)
        moves = np.abs(values[:, 1] - values[:, 0])
        error = self._at_tops(name, speed) + moves.reshape(speed.shape)
        value = np.where(finite, values[:, 0].reshape(speed.shape), np.inf)
        return Bounded(value, np.where(finite, error, 0.0))

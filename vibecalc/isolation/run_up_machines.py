"""The highest peaks of the run-ups of many machines at once, from few speeds of each."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.run_up_grid import (
    angle_grid,
    beside_poles,
    coarse_peak,
    exact_peaks,
    sparse_clusters,
    sparse_speeds,
    uncertainty_of,
)
from vibecalc.isolation.run_up_peaks import (
    Ground,
    RunUpPeak,
    Samples,
    Search,
    beyond_speeds,
    highest,
    over_all,
)
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.response.resonances import MaskedSpeeds, outside

# ----------------------------------------------------------------------------
# Speeds of all machines stand in one list, one machine after the other, each with its number, so
# that every step of the search is taken for all of them. What is found of one does not depend on
# the others.
# ----------------------------------------------------------------------------

#: a resonance whose own order stays below this share of a row's maximum gets no cluster there
NEGLIGIBLE = 1e-4

#: unless it stands where the row is high anyway: then down to this share
ROUNDING = 1e-13

#: next to a resonance a row is no higher than there and so many times what the resonance gives
_ADDED = 3.0

#: share of the highest value from which a maximum among few speeds is climbed from
_THRESHOLD = 0.8

#: samples over speed, row, component and angle that are worked on at once
_MOST_AT_ONCE = 2_000_000


class Machines(NamedTuple):
    """Machines of as many rows each, those of one after the other in `ground` and `infinite`.

    `harmonics_at` gives (n, rows, components, orders) of machines (n,) at speeds (n,) in rad/s.
    `frequency`, `damping_ratio` and `exposed` (machines, modes) are of the resonances to look at,
    NaN for none; `masked` are intervals without a bound, where there is but one machine.
    """

    ground: Ground
    harmonics_at: Callable[[np.ndarray, np.ndarray], np.ndarray]
    frequency: np.ndarray
    damping_ratio: np.ndarray
    exposed: np.ndarray
    infinite: np.ndarray
    masked: MaskedSpeeds


def highest_peaks(machines: Machines) -> RunUpPeak:
    """The highest peak (machines * rows,) of each row; those without bound stay zero.

    Examines few speeds between the resonances, at the resonances themselves, and closely only about
    those that can hold the maximum of a row: where all that is there and three times what the
    resonance adds come up to the highest value seen. Polishes both sides of each maximum.
    """
    looked = _Looked(machines)
    looked.add(*looked.first_speeds())
    looked.add(*looked.near(looked.may_win()))
    samples = Samples(looked.machine, looked.speed, looked.value, looked.harmonics)
    search = Search(machines.ground, looked.angle, machines.infinite, machines.harmonics_at)
    peak = highest(search, samples, _THRESHOLD, sparse=True)
    return over_all(peak, lambda rows: _curves(machines, looked, rows))


def _curves(
    machines: Machines, looked: "_Looked", rows: np.ndarray
) -> Iterator[tuple[int, np.ndarray, Bounded]]:
    """Of each of some rows (k,) speeds looked at and resonances of higher orders, and its curve."""
    ground, count = machines.ground, len(machines.frequency)
    more = beyond_speeds(machines.frequency, machines.exposed, ground.highest)
    speed = np.concatenate([looked.speed, more.ravel()])
    of = np.concatenate([looked.machine, np.repeat(np.arange(count), more.shape[1])])
    start, stop = (np.broadcast_to(end, len(machines.infinite))[rows] for end in ground[2:4])
    own = of[:, None] == rows // (len(machines.infinite) // count)
    own &= (speed[:, None] >= start) & (speed[:, None] <= stop)
    if len(machines.masked.low):
        own &= outside(machines.masked, speed)[:, None]
    at, place = np.nonzero(own)
    # speed by speed, since all rows of a machine come at once
    rising = np.lexsort((place, speed[at]))
    at, place = at[rising], place[rising]
    curve = []
    for part in np.array_split(
        np.arange(len(at)), -(-len(at) * len(ground.orders) // _MOST_AT_ONCE)
    ):
        jet = ground.jets_at(speed[at[part]], rows[place[part]], errors=True)
        curve.append(exact_peaks(jet.value, uncertainty_of(jet), ground.orders))
    whole = concatenate(curve)
    for number, row in enumerate(rows.tolist()):
        yield row, speed[at[place == number]], whole[place == number]


class _Looked:
    """Speeds that were looked at: `machine`, `speed` (n,) ascending, and what the rows have there.

    `value` (n, rows) are peaks over the cycle where `known`, else what they cannot exceed: there it
    is too low to matter.
    """

    def __init__(self, machines: Machines) -> None:
        self._given, ground = machines, machines.ground
        self.orders, self.angle = ground.orders, angle_grid(ground.orders)
        count = len(machines.frequency)
        self._rows = len(machines.infinite) // count
        self._start, self._stop = (
            np.broadcast_to(end, len(machines.infinite))[:: self._rows]
            for end in (ground.start, ground.stop)
        )
        centre = machines.frequency[:, None, :] / np.asarray(self.orders, dtype=float)[:, None]
        self._centre = centre
        start, stop = self._start[:, None, None], self._stop[:, None, None]
        self._at = beside_poles(centre, machines.exposed[:, None, :], machines.masked, start, stop)
        self.machine, self.speed = np.zeros(0, int), np.zeros(0)
        self.value, self._known = np.zeros((0, self._rows)), np.zeros((0, self._rows), bool)
        self.harmonics: np.ndarray = np.zeros(0, dtype=complex)
        self._top = np.zeros((count, self._rows))

    def first_speeds(self) -> tuple[np.ndarray, np.ndarray]:
        """Machines and speeds: both ends, steps between them, and all resonances."""
        base = sparse_speeds(self._given.frequency, self.orders, self._start, self._stop)
        table = np.concatenate([base, self._at.reshape(len(base), -1)], axis=1)
        machine = np.repeat(np.arange(len(table)), table.shape[1])
        return machine, table.ravel()

    def add(self, machine: np.ndarray, speed: np.ndarray) -> None:
        """Look at more speeds, of which those outside the range and within masked intervals do not
        count."""
        masked = self._given.masked
        edges = np.concatenate([masked.low, masked.high])
        speed = np.concatenate([speed, edges])
        machine = np.concatenate([machine, np.zeros(len(edges), int)])
        # comparisons with NaN are False
        used = (speed >= self._start[machine]) & (speed <= self._stop[machine])
        if len(edges):
            used &= outside(masked, speed)
        machine, speed = machine[used], speed[used]
        before = len(self.speed)
        every = np.concatenate([self.machine, machine]), np.concatenate([self.speed, speed])
        order = np.lexsort(every[::-1])
        here, there = every[0][order], every[1][order]
        # sorting is stable: of doubles the one that was looked at stands first
        fresh = np.concatenate([[True], (np.diff(here) > 0) | (np.diff(there) > 0.0)])
        order = order[fresh]
        self.machine, self.speed = here[fresh], there[fresh]
        new, place = order >= before, np.cumsum(order >= before) - 1
        harmonics = self._given.harmonics_at(self.machine[new], self.speed[new])
        highest = np.abs(harmonics).sum(axis=-1)
        highest = np.sqrt(np.square(highest).sum(axis=-1))
        if before:
            source = np.where(new, before + place, order)
            harmonics = np.concatenate([self.harmonics, harmonics])[source]
            highest = np.concatenate([self.value, highest])[source]
            known = np.concatenate([self._known, np.zeros((len(place[new]), self._rows), bool)])
            self._known = known[source]
        else:
            self._known = np.zeros(highest.shape, dtype=bool)
        self.harmonics, self.value = harmonics, highest
        first = np.flatnonzero(np.diff(self.machine, prepend=-1))
        if not before:
            # the peak where it may be the highest is one that the highest reaches
            most = np.maximum.reduceat(highest, first)
            reaches = (highest >= most[self.machine]) & (highest > 0.0)
            self.find(reaches)
            np.maximum.at(self._top, self.machine, np.where(self._known, self.value, 0.0))
        self.find(self.value >= _THRESHOLD * self._top[self.machine])
        np.maximum.at(self._top, self.machine, np.where(self._known, self.value, 0.0))

    def find(self, wanted: np.ndarray) -> None:
        """Find peaks over the cycle at some places (n, rows)."""
        at, row = np.nonzero(wanted & ~self._known)
        size = self.harmonics.shape[-2] * len(self.angle)
        for part in np.array_split(np.arange(len(at)), -(-len(at) * size // _MOST_AT_ONCE) or 1):
            if len(part):
                place = at[part], row[part]
                self.value[place] = coarse_peak(self.harmonics[place], self.orders, self.angle)
        self._known[at, row] = True

    def may_win(self) -> np.ndarray:
        """Which resonances (machines, orders, modes) can hold the maximum of a row that has one."""
        at = self._at
        absent = np.isnan(at)
        count = len(at)
        key = np.broadcast_to(np.arange(count)[:, None, None], at.shape)
        at = np.where(absent, self._start[:, None, None], at)
        back = np.searchsorted(self.machine + 1j * self.speed, (key + 1j * at).ravel())
        back = back.reshape(at.shape)
        of_order = self.harmonics[back, ..., np.arange(len(self.orders))[:, None]]
        of_order = np.sqrt(np.sum(np.square(np.abs(of_order)), axis=-1))
        bounded = ~self._given.infinite.reshape(count, 1, 1, self._rows) & ~absent[..., None]
        top = self._top[:, None, None, :]
        driven = (of_order > ROUNDING * top) & bounded

        def may() -> np.ndarray:
            return np.asarray(driven & (self.value[back] + _ADDED * of_order >= top))

        wanted = np.zeros(self._known.shape, dtype=bool)
        some = may()
        row = np.broadcast_to(np.arange(self._rows), some.shape)
        wanted[np.broadcast_to(back[..., None], some.shape)[some], row[some]] = True
        self.find(wanted)
        return np.asarray(np.any(may(), axis=-1))

    def near(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Machines and speeds about chosen resonances (machines, orders, modes)."""
        machine, order, mode = np.nonzero(chosen)
        ratio = self._given.damping_ratio[machine, mode]
        exposed = self._given.exposed[machine, mode]
        speed, which = sparse_clusters(self._centre[machine, order, mode], ratio, exposed)
        return machine[which], speed

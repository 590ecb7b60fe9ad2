"""Running totals of every revolution, from the power series of smooth segments of motion."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.impact.linkage import FREE, GapForces, Train, spring_energy
from vibecalc.impact.roots import bernstein, evaluate, halves, sign_changes, single_root
from vibecalc.impact.setup import DEGREE, MOMENTS, POWERS, WEIGHTS, Setup, harmonics, moments
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Integrals and the highest force of one smooth segment of motion, from its power series.
# ----------------------------------------------------------------------------

#: halvings to tell apart the changes of sign of a force; what is left is 2^-20 of a segment
_DEEPEST = 20
#: points that bracket the extremes of a force
_SAMPLES = 33

_RANK = np.arange(1.0, DEGREE + 2.0)


def at_points(series: FloatArray) -> FloatArray:
    """Values (points, ...) of series (terms, ...) at POINTS."""
    terms = len(series)
    flat = POWERS[:, :terms] @ series.reshape(terms, -1)
    return flat.reshape(len(POWERS), *series.shape[1:])


def mean(values: FloatArray) -> FloatArray:
    """Mean over the segment of values (points, ...) at POINTS."""
    return np.asarray(np.tensordot(WEIGHTS, values, axes=1))


def derivative(series: FloatArray) -> FloatArray:
    """Series (terms - 1, ...) of the derivative by s."""
    rank = _RANK[: len(series) - 1].reshape(-1, *([1] * (series.ndim - 1)))
    return np.asarray(series[1:] * rank)


def primitive(series: FloatArray) -> FloatArray:
    """Series (terms + 1, ...) of the integral from s = 0."""
    rank = _RANK[: len(series)].reshape(-1, *([1] * (series.ndim - 1)))
    return np.concatenate([np.zeros_like(series[:1]), series / rank])


def absolute_mean(force: FloatArray) -> FloatArray:
    """Mean of |F| over pieces (terms, n), with each change of sign found."""
    total = np.zeros(force.shape[1])
    owner, weight = np.arange(force.shape[1]), 1.0
    for _ in range(_DEEPEST):
        changes = sign_changes(bernstein(force) > 0.0)
        area = primitive(force)
        whole = np.sum(area, axis=0)
        plain, once = changes == 0, changes == 1
        np.add.at(total, owner[plain], weight * np.abs(whole[plain]))
        if np.any(once):
            count = int(np.count_nonzero(once))
            root = single_root(force[:, once], np.zeros(count), np.ones(count))
            before = evaluate(area[:, once], root)
            parts = np.abs(before) + np.abs(whole[once] - before)
            np.add.at(total, owner[once], weight * parts)
        crossing = changes > 1
        if not np.any(crossing):
            return total
        first, second = halves(force[:, crossing])
        force = np.concatenate([first, second], axis=1)
        owner, weight = np.concatenate([owner[crossing], owner[crossing]]), 0.5 * weight
    np.add.at(total, owner, weight * np.abs(np.sum(primitive(force), axis=0)))
    return total


def highest(force: FloatArray, floor: FloatArray) -> FloatArray:
    """max(floor, max |F|) over pieces (terms, n); `floor` (n,).

    Only pieces whose Bernstein coefficients, a bound, exceed the floor are searched: between
    points so close that a force has one extreme there, its derivative's root is found.
    """
    result = floor.copy()
    worth = np.flatnonzero(np.max(np.abs(bernstein(force)), axis=0) > floor)
    if not len(worth):
        return result
    part = force[:, worth]
    grid = np.linspace(0.0, 1.0, _SAMPLES)
    size = np.abs((grid[:, None] ** np.arange(len(part))) @ part)
    best = np.argmax(size, axis=0)
    top = size[best, np.arange(len(worth))]
    slope = derivative(part)
    low, high = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, _SAMPLES - 1)]
    turns = evaluate(slope, low) * evaluate(slope, high) < 0.0
    if np.any(turns):
        at = single_root(slope[:, turns], low[turns], high[turns])
        top[turns] = np.maximum(top[turns], np.abs(evaluate(part[:, turns], at)))
    result[worth] = np.maximum(floor[worth], top)
    return result


# ----------------------------------------------------------------------------
# Running totals of every revolution: what the smooth pieces of motion add up to.
# ----------------------------------------------------------------------------

#: first contacts of each gap whose times are kept
FIRST_CONTACTS = 8
#: segments that are entered into the books at once
_SEGMENTS = 4096
#: whose energy an array with a leading axis of two holds
AXIAL, LATERAL = 0, 1


class MotionSegment(NamedTuple):
    """One smooth segment of motion of each run `members` (A,): series in the fraction s of it.

    `velocity` (k, G, A) and `force` (k, G, A) of the gaps, `pin_velocity` (k, A) and `gas`
    (2, A) series, `tangent` (k, A) or None; `spring`, `damper` and `side` (G, A); `duration` (A,)
    in s, zero for runs that stood still; `revolution`, and `panel`, `offset` and `length` its
    place in it in rad.
    """

    members: IntArray
    velocity: FloatArray
    force: FloatArray
    pin_velocity: FloatArray
    gas: FloatArray
    tangent: FloatArray | None
    spring: FloatArray
    damper: FloatArray
    side: IntArray
    duration: FloatArray
    revolution: IntArray
    panel: IntArray
    offset: FloatArray
    length: FloatArray


class Ledger:
    """The books of a batch: totals of G gaps and B runs in R revolutions.

    `forces` with `absolute`, the integrals of |F| (G, B, R) in N s, `loss` (G, B, R) in J;
    `stored` (2, B, R + 1), `work` and `exchanged` (2, B, R), J, of the axial and the lateral
    motion; `first_contacts` (G, B, 8), s, infinite for those that were not made; `gap`, m, and
    `force`, N, (G, B, samples) of the last revolution at equal crank angles from 0.

    Segments wait until there are many of them. `moments` (G, B, 2, p, MOMENTS) are those of the
    running revolution of each run, and of the one before for runs (B,) that are `closing`.
    """

    def __init__(self, setup: Setup, revolutions: int, samples: int):
        gaps, members = setup.train.gaps.clearance.shape
        shape, orders = (gaps, members, revolutions), setup.transform.phase.shape[1]
        self.setup = setup
        self.absolute, self.peak, self.contacts, self.contact_time, self.loss = np.zeros(
            (5, *shape)
        )
        self.work, self.exchanged = np.zeros((2, 2, members, revolutions))
        self.stored = np.zeros((2, members, revolutions + 1))
        self.moments = np.zeros((gaps, members, 2, len(setup.panels.start), MOMENTS))
        self.spectra = np.zeros((*shape, orders), dtype=np.complex128)
        self.first_contacts = np.full((gaps, members, FIRST_CONTACTS), np.inf)
        self.contacts_counted = np.zeros((gaps, members), dtype=np.int64)
        self.waiting: list[MotionSegment] = []
        self.closed: list[tuple[IntArray, IntArray]] = []
        self.closing = np.zeros(members, dtype=np.bool_)
        self.angle = 2.0 * np.pi * np.arange(samples) / max(samples, 1)
        self.gap, self.force = np.zeros((2, gaps, members, samples))
        self.sampled = np.zeros(members, dtype=np.int64)

    @property
    def forces(self) -> GapForces:
        """What the gaps carried, of a finished batch."""
        mean = self.absolute * self.setup.speed / (2.0 * np.pi)
        return GapForces(self.spectra, mean, self.peak, self.contacts, self.contact_time)

    def imbalance(self) -> FloatArray:
        """Error (2, B, R) of the energy over the larger of what is exchanged and stored.

        Of change of stored - work + dissipated, which is zero but for errors, and rounding.
        """
        bore = self.setup.train.bore
        lost = np.zeros_like(self.work)
        lost[AXIAL] = np.sum(self.loss[:bore], axis=0)
        if bore is not None:
            lost[LATERAL] = self.loss[bore]
        off = np.diff(self.stored, axis=-1) - self.work + lost
        stored = np.maximum(self.stored[..., 1:], self.stored[..., :-1])
        scale = np.maximum(self.exchanged, stored)
        error = np.maximum(np.abs(off), 8.0 * EPSILON * scale)
        return np.asarray(error / np.where(scale > 0.0, scale, 1.0))

    def add(self, segment: MotionSegment) -> None:
        """Put a segment to those that wait, and enter them all when they are many."""
        self.waiting.append(segment)
        if sum(len(each.members) for each in self.waiting) >= _SEGMENTS:
            self.settle()

    def settle(self) -> None:
        """Enter the segments that wait, and the spectra of the revolutions that have ended."""
        if self.waiting:
            joined: list[Any] = [
                None if parts[0] is None else np.concatenate(parts, axis=-1)
                for parts in zip(*self.waiting, strict=True)
            ]
            self._enter(MotionSegment(*joined))
        for members, revolution in self.closed:
            for each, sums in enumerate(self.moments):
                values = harmonics(sums[members, revolution % 2], self.setup.transform)
                self.spectra[each, members, revolution] = values
            self.moments[:, members, revolution % 2] = 0.0
        self.closing[:] = False
        self.waiting.clear()
        self.closed.clear()

    def _enter(self, segment: MotionSegment) -> None:
        """Integrals of segments: forces, times, losses and works."""
        members, train, panels = segment.members, self.setup.train, self.setup.panels
        axial = slice(0, train.bore)
        velocity, force = at_points(segment.velocity), at_points(segment.force)
        pin_velocity = at_points(segment.pin_velocity)
        duration, touching = segment.duration, segment.side != FREE
        loss = segment.damper * mean(velocity * velocity) * duration
        pin_work = mean(force[:, train.pin] * pin_velocity) * duration
        piston = pin_velocity - np.sum(velocity[:, axial], axis=1)
        gas_work = mean(at_points(segment.gas) * piston) * duration

        gaps, runs, revolutions = self.peak.shape
        in_run = members * revolutions + segment.revolution
        in_gap = np.arange(gaps)[:, None] * (runs * revolutions) + in_run

        def add(book: FloatArray, place: IntArray, values: FloatArray) -> None:
            np.add.at(book.reshape(-1), place.reshape(-1), values.reshape(-1))

        add(self.loss, in_gap, loss)
        add(self.contact_time, in_gap, np.where(touching, duration, 0.0))
        add(self.work[AXIAL], in_run, pin_work + gas_work)
        exchanged = np.abs(pin_work) + np.abs(gas_work) + np.sum(loss[axial], axis=0)
        add(self.exchanged[AXIAL], in_run, exchanged)
        if train.bore is not None and segment.tangent is not None:
            pull = force[:, 0] * at_points(segment.tangent)
            side_work = mean(pull * velocity[:, train.bore]) * duration
            add(self.work[LATERAL], in_run, side_work)
            add(self.exchanged[LATERAL], in_run, np.abs(side_work) + loss[train.bore])

        pulling = ((segment.spring > 0.0) | (segment.damper > 0.0)) & (duration > 0.0)
        pulls = np.flatnonzero(pulling)
        if not len(pulls):
            return
        gap, run = np.divmod(pulls, len(members))
        place = in_gap.reshape(-1)[pulls]
        series = segment.force.reshape(len(segment.force), -1).take(pulls, axis=1)
        values = force.reshape(len(force), -1).take(pulls, axis=1)
        add(self.absolute, place, absolute_mean(series) * duration[run])
        peak = self.peak.reshape(-1)
        np.maximum.at(peak, place, np.max(np.abs(values), axis=0))
        np.maximum.at(peak, place, highest(series, peak[place]))
        panel = segment.panel[run]
        found = moments(values, segment.offset[run], segment.length[run], panels.width[panel])
        row = ((gap * runs + members[run]) * 2 + segment.revolution[run] % 2) * len(panels.start)
        row = (row + panel) * MOMENTS
        np.add.at(self.moments.reshape(-1), row + np.arange(MOMENTS)[:, None], found)

    def add_contact(
        self, gap: IntArray, members: IntArray, revolution: IntArray, moment: FloatArray
    ) -> None:
        """Count contacts made by `gap` (n,) of runs `members` (n,) at times `moment` (n,)."""
        self.contacts[gap, members, revolution] += 1.0
        counted = self.contacts_counted[gap, members]
        early = counted < FIRST_CONTACTS
        self.first_contacts[gap[early], members[early], counted[early]] = moment[early]
        self.contacts_counted[gap, members] += 1

    def close_revolution(
        self, members: IntArray, revolution: IntArray, gap: FloatArray, velocity: FloatArray
    ) -> None:
        """Enter the energies of runs (n,) at the end of their revolution (n,), and close it."""
        if np.any(self.closing[members]):
            self.settle()
        self.closing[members] = True
        self.closed.append((members, revolution))
        self.enter_energy(members, revolution + 1, gap, velocity)

    def enter_energy(
        self, members: IntArray, revolution: IntArray | int, gap: FloatArray, velocity: FloatArray
    ) -> None:
        """Energy of the masses and springs of runs (n,) at crank angle 0, axial and lateral."""
        self.stored[:, members, revolution] = stored_energy(
            self.setup.train, members, gap, velocity, self.setup.pin_velocity_at_start
        )

    def sample(self, segment: MotionSegment, gap: FloatArray, start: FloatArray) -> None:
        """Fill in the samples that fall into a segment with gap series (k, G, A) from `start` (A,).

        A sample belongs to the segment that it is the start of, not to the one before.
        """
        samples = len(self.angle)
        if not samples:
            return
        last = segment.revolution == self.peak.shape[-1] - 1
        here = np.flatnonzero(last & (segment.length > 0.0))
        while len(here):
            here = here[self.sampled[segment.members[here]] < samples]
            following = self.sampled[segment.members[here]]
            at = (self.angle[following] - start[here]) / segment.length[here]
            inside = at < 1.0
            here, following = here[inside], following[inside]
            members, at = segment.members[here], np.maximum(at[inside], 0.0)
            for each in range(gap.shape[1]):
                self.gap[each, members, following] = evaluate(gap[:, each, here], at)
                self.force[each, members, following] = evaluate(segment.force[:, each, here], at)
            self.sampled[members] += 1


def stored_energy(
    train: Train, members: IntArray, gap: FloatArray, velocity: FloatArray, pin_velocity: float
) -> FloatArray:
    """Kinetic and spring energy (2, n), J, of the axial and of the lateral motion."""
    gaps = train.gaps._replace(**{k: v[:, members] for k, v in train.gaps._asdict().items()})
    spring = spring_energy(gaps, gap)
    axial = slice(0, train.bore)
    mass = train.mass[members]
    piston = pin_velocity - np.sum(velocity[axial], axis=0)
    energy = 0.5 * mass * piston**2 + np.sum(spring[axial], axis=0)
    if train.rod_mass is not None:
        energy = energy + 0.5 * train.rod_mass[members] * (pin_velocity - velocity[1]) ** 2
    lateral = np.zeros_like(energy)
    if train.bore is not None:
        lateral = 0.5 * mass * velocity[train.bore] ** 2 + spring[train.bore]
    return np.stack([energy, lateral])

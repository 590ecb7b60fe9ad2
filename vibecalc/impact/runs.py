"""An ensemble of runs, how fast neighbours part, and the first contacts that all methods share."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.impact.fixed_step import simulate_fixed_steps
from vibecalc.impact.linkage import (
    GapForces,
    Linkage,
    Starts,
    assemble_train,
    central_start,
    clearances,
    contact_force,
    spread_starts,
    velocity_scale,
)
from vibecalc.impact.simulate import end_states, simulate
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray

# ----------------------------------------------------------------------------
# How fast two runs part company that start next to each other.
# ----------------------------------------------------------------------------

#: distance that counts as apart, as a part of the clearance
APART = 0.1
#: distance at which two runs are one to rounding
TOGETHER = 1024.0 * EPSILON


class PartingTime(NamedTuple):
    """Of each pair (...,): `revolutions` until it is apart, infinite if that is not within the
    run; `rate`, the growth of the logarithm of its distance per revolution until then."""

    revolutions: FloatArray
    rate: FloatArray


def distance(
    gap: FloatArray, velocity: FloatArray, clearance: FloatArray, fastest: FloatArray
) -> FloatArray:
    """Distance (...) of pairs from differences (..., G) of their gaps and gap velocities.

    In parts of the clearance, and of the velocity `fastest` with which it is crossed; the
    largest counts.
    """
    apart = np.maximum(np.abs(gap) / clearance, np.abs(velocity) / fastest)
    return np.asarray(np.max(apart, axis=-1))


def parting(distances: FloatArray) -> PartingTime:
    """When pairs part, from distances (..., T + 1) at the start and at the ends of T revolutions.

    Between two ends the distance is taken to grow as an exponential. A pair that has become one
    to rounding has a rate that is only a bound: it shrank at least so fast.
    """
    turns = distances.shape[-1] - 1
    level = np.log(np.maximum(distances, TOGETHER))
    beyond = distances >= APART
    parted = np.any(beyond, axis=-1)
    # the first end beyond, or the last end
    end = np.where(parted, np.argmax(beyond, axis=-1), turns)
    before = np.maximum(end - 1, 0)
    at_end = np.take_along_axis(level, end[..., None], axis=-1)[..., 0]
    at_before = np.take_along_axis(level, before[..., None], axis=-1)[..., 0]
    growth = np.where(at_end > at_before, at_end - at_before, 1.0)
    crossed = before + np.clip((np.log(APART) - at_before) / growth, 0.0, 1.0)
    revolutions = np.where(parted, np.where(end == 0, 0.0, crossed), np.inf)
    rate = (at_end - level[..., 0]) / np.maximum(end, 1)
    return PartingTime(np.asarray(revolutions), np.asarray(rate))


# ----------------------------------------------------------------------------
# An ensemble of runs: all clearances, members and neighbours as one batch.
# ----------------------------------------------------------------------------

#: neighbours whose parting is timed, at most, for each clearance
MOST_NEIGHBOURS = 16
#: bytes of spectra that one study may hold
MOST_MEMORY = 2e9


class Ensemble(NamedTuple):
    """What M members of C clearances do in R revolutions, followed event by event.

    `forces` (G, C, M, R) of the gaps. `dissipated`, `exchanged` (C, M, R), J: energy lost in
    contacts and films, and all that was taken and given. `residual` (C, M, R): the imbalance of
    energy over the energy exchanged. `distances` (C, P, T + 1): how far the first P members are
    from neighbours, at the start and after each of all T revolutions; infinite where they no
    longer run.
    """

    forces: GapForces
    dissipated: FloatArray
    exchanged: FloatArray
    residual: FloatArray
    distances: FloatArray


class Study(NamedTuple):
    """Clearances (C,) of the wrist pin, m; members of each; revolutions; highest order."""

    clearance: FloatArray
    members: int
    discard: int
    revolutions: int
    orders: int

    def batch(self, linkage: Linkage, neighbours: int = 0) -> tuple[FloatArray, Starts]:
        """Clearances (C M,) of all runs and their starts (C M, G).

        Raises UsageError for a study that with so many neighbours does not fit into memory.
        """
        count, members = len(self.clearance), self.members + neighbours
        runs = count * members * len(linkage.joints)
        size = 16.0 * runs * self.revolutions * (self.orders + 1)
        if size > MOST_MEMORY:
            raise UsageError(
                f"the spectra of {count} x {members} runs of {self.revolutions} revolutions with "
                f"{self.orders} orders take {size / 1e9:.3g} GB, more than {MOST_MEMORY / 1e9:g}: "
                f"ask for fewer members, revolutions or orders"
            )
        spread = spread_starts(linkage, self.clearance, self.members)
        start = (one.reshape(-1, len(linkage.joints)) for one in spread)
        return np.repeat(self.clearance, self.members), Starts(*start)

    def forces(self, found: GapForces) -> GapForces:
        """Those (G, C, M, R) of all runs, which come first, in the revolutions that count."""
        runs = len(self.clearance) * self.members
        shape = (-1, len(self.clearance), self.members, self.revolutions)
        kept = (one[:, :runs, -self.revolutions :] for one in found)
        return GapForces._make(one.reshape(*shape, *one.shape[3:]) for one in kept)


def run_ensemble(linkage: Linkage, study: Study, perturbation: float) -> Ensemble:
    """Run a study event by event; its first members have neighbours that start next to them.

    `perturbation`, m, is how much further the joint of a neighbour is open at the start; it runs
    on after the revolutions that are discarded only if it is not apart by then. Raises UsageError
    for a study that does not fit into memory, and what the motion raises.
    """
    count, members = len(study.clearance), study.members
    neighbours, runs = min(members, MOST_NEIGHBOURS), count * members
    each, start = study.batch(linkage, neighbours)
    # all members, and then the neighbours of `paired`
    paired = np.arange(runs).reshape(count, members)[:, :neighbours].reshape(-1)
    nearby = start.gap[paired]
    nearby[:, 0] += perturbation
    each = np.concatenate([each, each[paired]])
    state = Starts(
        np.concatenate([start.gap, nearby]),
        np.concatenate([start.velocity, start.velocity[paired]]),
    )
    width, fastest = (of(linkage, each[runs:])[:, None] for of in (clearances, velocity_scale))
    apart = np.full((len(paired), 1 + study.discard + study.revolutions), np.inf)

    def compare(pairs: IntArray, gap: FloatArray, velocity: FloatArray, first: int) -> None:
        """Enter distances from states (B, n, G) at revolutions `first` to `first` + n - 1."""
        of = paired[pairs]
        apart[pairs, first : first + gap.shape[1]] = distance(
            gap[of] - gap[runs:], velocity[of] - velocity[runs:], width[pairs], fastest[pairs]
        )

    pairs = np.arange(len(paired))
    compare(pairs, state.gap[:, None], state.velocity[:, None], 0)
    if study.discard:
        forgotten = end_states(linkage.with_clearance(each), state, study.discard)
        compare(pairs, *forgotten, 1)
        pairs = np.flatnonzero(np.all(apart[:, : study.discard + 1] < APART, axis=1))
        going = np.concatenate([np.arange(runs), runs + pairs])
        each, state = each[going], Starts(*(one[going, -1] for one in forgotten))
    run = simulate(linkage.with_clearance(each), state, study.revolutions, study.orders)
    compare(pairs, run.end_gap, run.end_velocity, study.discard + 1)
    dissipated, exchanged, residual = (
        one[:runs].reshape(count, members, -1)
        for one in (run.dissipated, run.exchanged, run.imbalance)
    )
    distances = apart.reshape(count, neighbours, -1)
    return Ensemble(study.forces(run.forces), dissipated, exchanged, residual, distances)


def run_fixed_steps(linkage: Linkage, study: Study, method: str, steps: int) -> GapForces:
    """Forces (G, C, M, R) of the same members by a method, `steps` to a revolution.

    Raises UsageError for a study that does not fit into memory, and what the method raises.
    """
    each, start = study.batch(linkage)
    turns = study.discard + study.revolutions
    found, _ = simulate_fixed_steps(
        linkage.with_clearance(each), start, method, steps, turns, study.orders
    )
    return study.forces(found)


# ----------------------------------------------------------------------------
# The first contacts and the force over the first turn, which every good method has to agree on.
#
# Runs that part exponentially have no reproducible late states, but their first contacts are. How
# well is measured: neighbours of the start tell how an error grows up to each contact, and each
# rounding on the way is taken for one at the start.
# ----------------------------------------------------------------------------

#: angles at which the force of the first turn is given, both ends with it
ANGLES = 721
#: distance of the neighbours that measure the growth, in parts of clearance and velocity scale
_NEARBY = 2.0**-30
#: roundings of the state, relative to these, that one at the start stands for
ROUNDINGS = 256.0
#: turns that are run for the contacts, at most
_TURNS = 3
#: a contact whose angle is less certain than this is not listed, but the first few are
UNCERTAIN = 1e-6
FEWEST = 3


class FirstMotion(NamedTuple):
    """From rest in the middle of the play at crank angle 0, for clearances (C,).

    `contacts` (C, k) and `contacts_error`, rad: crank angles, counted on over the turns, at which
    the joint of the wrist pin touches; infinite where it does not within three turns. `force`
    (C, 721) and `force_error`, N: joint force over the first turn at `angle` (721,).
    """

    contacts: FloatArray
    contacts_error: FloatArray
    angle: FloatArray
    force: FloatArray
    force_error: FloatArray


def first_motion(linkage: Linkage, clearance: FloatArray, subdivision: int = 1) -> FirstMotion:
    """The first contacts (as many as are certain for all clearances) and the first turn.

    Nothing but rounding depends on `subdivision`, see `simulate.py`. Raises NumericalFailure where
    the first contacts graze, and what the motion raises.
    """
    count = len(clearance)
    start = _with_neighbours(linkage, clearance)
    members = len(start.gap)
    batch = linkage.with_clearance(np.repeat(clearance, members // count))
    turn = simulate(batch, start, 1, 1, ANGLES - 1, subdivision)
    end = turn.end_gap[:, -1].T, turn.end_velocity[:, -1].T
    last = contact_force(assemble_train(batch, members), *end)[0]
    force = np.concatenate([turn.force[0], last[:, None]], axis=1)
    times = turn.first_contacts[0]
    if not np.all(np.isfinite(times)):
        times = simulate(batch, start, _TURNS, 1, 0, subdivision).first_contacts[0]
    contacts, contacts_error = _with_error(linkage.drive.speed * times, count)
    if not np.all(np.isfinite(contacts_error[:, :FEWEST])):
        raise NumericalFailure(
            "the first contacts of a joint with play graze: whether they are made is a matter of "
            "rounding"
        )
    known = np.where(np.isfinite(contacts), contacts, 0.0)
    contacts_error = np.maximum.accumulate(contacts_error, axis=1) + 8.0 * EPSILON * known
    contact_count = max(FEWEST, int(np.min(np.sum(contacts_error <= UNCERTAIN, axis=1))))
    force, force_error = _with_error(force, count)
    largest = np.maximum.accumulate(np.abs(force), axis=1)
    force_error = np.maximum.accumulate(force_error, axis=1) + ROUNDINGS * EPSILON * largest
    angle = np.linspace(0.0, 2.0 * np.pi, ANGLES)
    return FirstMotion(
        contacts[:, :contact_count], contacts_error[:, :contact_count], angle, force, force_error
    )


def _with_neighbours(linkage: Linkage, clearance: FloatArray) -> Starts:
    """The central start (C * (1 + 2 G), G) and neighbours in every gap and velocity."""
    gaps = len(linkage.joints)
    centre = central_start(linkage, clearance)
    aside = np.zeros((1 + 2 * gaps, 2, gaps))
    for each in range(gaps):
        aside[1 + each, 0, each] = aside[1 + gaps + each, 1, each] = _NEARBY
    gap = centre.gap[:, None] + aside[:, 0] * clearances(linkage, clearance)[:, None]
    fastest = velocity_scale(linkage, clearance)[:, None]
    velocity = centre.velocity[:, None] + aside[:, 1] * fastest
    return Starts(gap.reshape(-1, gaps), velocity.reshape(-1, gaps))


def _with_error(values: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Values (C, n) of the central start, and their errors from those (C * copies, n) of all."""
    copies = values.reshape(count, -1, values.shape[-1])
    centre = copies[:, :1]
    known = np.isfinite(copies) & np.isfinite(centre)
    apart = np.zeros_like(copies)
    np.subtract(copies, centre, out=apart, where=known)
    # a neighbour that makes a contact where the other does not leaves nothing certain
    apart[np.isfinite(copies) != np.isfinite(centre)] = np.inf
    growth = np.sum(np.abs(apart), axis=1) / _NEARBY
    return copies[:, 0], ROUNDINGS * EPSILON * growth

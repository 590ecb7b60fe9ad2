"""An ensemble of runs, how fast neighbours part, and the first contacts that all methods share."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.impact.fixed_step import (
    FixedSteps,
    SampledRecord,
    contact_force,
    simulate_fixed_steps,
)
from vibecalc.impact.linkage import (
    Linkage,
    Starts,
    assemble_train,
    central_start,
    clearances,
    gaps_of,
    spread_starts,
    velocity_scale,
)
from vibecalc.impact.simulate import GapRecord, Revolutions, end_states, simulate
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray

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


class GapRuns(NamedTuple):
    """One gap in every counted revolution; arrays (C, M, R), harmonics (C, M, R, N + 1).

    `harmonics`, mean magnitude `force` and `peak` in N; `contacts` made and `contact_time`, s,
    per revolution.
    """

    harmonics: ComplexArray
    force: FloatArray
    peak: FloatArray
    contacts: FloatArray
    contact_time: FloatArray


class Forces(NamedTuple):
    """The joints of the cylinder; those without play are None."""

    wrist_pin: GapRuns
    crank_pin: GapRuns | None
    bore: GapRuns | None


class Ensemble(NamedTuple):
    """What M members of C clearances do in R revolutions, followed event by event.

    `dissipated`, `exchanged` (C, M, R), J: energy lost in contacts and films, and all that was
    taken and given. `residual` (C, M, R): the imbalance of energy over the energy exchanged.
    `distances` (C, P, T + 1): how far the first P members are from neighbours, at the start and
    after each of all T revolutions; infinite where they no longer run.
    """

    forces: Forces
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


def follow_events(
    linkage: Linkage,
    clearance: FloatArray,
    start: Starts,
    revolutions: int,
    orders: int,
    samples: int = 0,
    subdivision: int = 1,
) -> Revolutions:
    """The event-exact motion of a batch (B,) that differs in clearance and start (B, G)."""
    return simulate(
        gap=start.gap,
        gap_velocity=start.velocity,
        revolutions=revolutions,
        orders_retained=orders,
        samples=samples,
        subdivision=subdivision,
        **_running_gear(linkage, clearance),
    )


def _running_gear(linkage: Linkage, clearance: FloatArray) -> dict[str, Any]:
    """Arguments of every method for the linkage with clearances (B,) of the wrist pin."""
    return {
        "drive": linkage.drive,
        "gas": linkage.gas,
        "mass": linkage.mass,
        "joint": linkage.wrist_pin._replace(clearance=clearance),
        "crank_joint": linkage.crank_pin,
        "rod_mass": linkage.rod_mass,
        "wall": linkage.bore,
    }


def run_ensemble(linkage: Linkage, study: Study, perturbation: float) -> Ensemble:
    """Run a study event by event; its first members have neighbours that start next to them.

    `perturbation`, m, is how much further the joint of a neighbour is open at the start; it runs
    on after the revolutions that are discarded only if it is not apart by then. Raises UsageError
    for a study that does not fit into memory, and what the motion raises.
    """
    count, members = len(study.clearance), study.members
    neighbours, runs = min(members, MOST_NEIGHBOURS), count * members
    _refuse_large(linkage, study, members + neighbours)
    # all members, and then the neighbours of `paired`
    paired = np.arange(runs).reshape(count, members)[:, :neighbours].reshape(-1)
    start = Starts(
        *(one.reshape(runs, -1) for one in spread_starts(linkage, study.clearance, members))
    )
    nearby = start.gap[paired]
    nearby[:, 0] += perturbation
    state = Starts(
        np.concatenate([start.gap, nearby]),
        np.concatenate([start.velocity, start.velocity[paired]]),
    )
    each = np.repeat(study.clearance, members)
    each = np.concatenate([each, each[paired]])
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
        forgotten = end_states(
            gap=state.gap,
            gap_velocity=state.velocity,
            revolutions=study.discard,
            **_running_gear(linkage, each),
        )
        compare(pairs, forgotten.gap, forgotten.velocity, 1)
        pairs = np.flatnonzero(np.all(apart[:, : study.discard + 1] < APART, axis=1))
        going = np.concatenate([np.arange(runs), runs + pairs])
        state, each = Starts(forgotten.gap[going, -1], forgotten.velocity[going, -1]), each[going]
    run = follow_events(linkage, each, state, study.revolutions, study.orders)
    compare(pairs, run.end_gap, run.end_velocity, study.discard + 1)
    exchanged, residual, lost = run.axial.exchanged, run.axial.relative_error, run.axial.dissipated
    if run.lateral is not None:
        exchanged = exchanged + run.lateral.exchanged
        residual = np.maximum(residual, run.lateral.relative_error)
        lost = lost + run.lateral.dissipated
    lost, exchanged, residual = (
        one[:runs].reshape(count, members, -1) for one in (lost, exchanged, residual)
    )
    forces = _forces(run, (count, members))
    return Ensemble(forces, lost, exchanged, residual, apart.reshape(count, neighbours, -1))


def run_fixed_steps(linkage: Linkage, study: Study, method: str, steps: int) -> Forces:
    """The same members by a method of fixed step, `steps` to a revolution.

    Raises UsageError for a study that does not fit into memory, and what the method raises.
    """
    _refuse_large(linkage, study, study.members)
    start = spread_starts(linkage, study.clearance, study.members)
    shape = start.gap.shape
    run = simulate_fixed_steps(
        gap=start.gap.reshape(-1, shape[2]),
        gap_velocity=start.velocity.reshape(-1, shape[2]),
        method=method,
        steps=steps,
        revolutions=study.discard + study.revolutions,
        orders_retained=study.orders,
        **_running_gear(linkage, np.repeat(study.clearance, study.members)),
    )
    return _forces(run, (len(study.clearance), study.members), study.discard)


def _refuse_large(linkage: Linkage, study: Study, members: int) -> None:
    count, turns = len(study.clearance), study.revolutions
    runs = count * members * gaps_of(linkage)
    size = 16.0 * runs * turns * (study.orders + 1)
    if size > MOST_MEMORY:
        raise UsageError(
            f"the spectra of {count} x {members} runs of {turns} revolutions with {study.orders} "
            f"orders take {size / 1e9:.3g} GB, more than {MOST_MEMORY / 1e9:g}: ask for fewer "
            f"members, revolutions or orders"
        )


def _forces(run: Revolutions | FixedSteps, shape: tuple[int, int], discard: int = 0) -> Forces:
    """Of the first C times M runs, for `shape` (C, M), in the revolutions after `discard`."""
    runs = shape[0] * shape[1]

    def gap_runs(gap: GapRecord | SampledRecord) -> GapRuns:
        columns: list[Any] = [
            gap.force_harmonics,
            gap.mean_absolute_force,
            gap.peak_force,
            gap.impact_count.astype(np.float64),
            gap.contact_time,
        ]
        kept = (column[:runs, discard:] for column in columns)
        return GapRuns(*(one.reshape(*shape, *one.shape[1:]) for one in kept))

    return Forces(
        gap_runs(run.wrist_pin),
        None if run.crank_pin is None else gap_runs(run.crank_pin),
        None if run.wall is None else gap_runs(run.wall),
    )


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
    copies = len(start.gap) // count
    each = np.repeat(clearance, copies)
    turn = follow_events(linkage, each, start, 1, 1, ANGLES - 1, subdivision)
    last = _end_force(linkage, each, turn)
    force = np.concatenate([turn.wrist_pin.force, last[:, None]], axis=1)
    times = turn.wrist_pin.first_contacts
    if not np.all(np.isfinite(times)):
        longer = follow_events(linkage, each, start, _TURNS, 1, 0, subdivision)
        times = longer.wrist_pin.first_contacts
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
    gaps = gaps_of(linkage)
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


def _end_force(linkage: Linkage, clearance: FloatArray, turn: Revolutions) -> FloatArray:
    """Force (B,) of the wrist pin at the end of a turn, from the state there."""
    joint = linkage.wrist_pin._replace(clearance=clearance)
    train = assemble_train(len(clearance), np.asarray(linkage.mass), joint, None, None, None)
    gap, velocity = turn.end_gap[:, -1, :1].T, turn.end_velocity[:, -1, :1].T
    return np.asarray(contact_force(train, gap, velocity)[0])

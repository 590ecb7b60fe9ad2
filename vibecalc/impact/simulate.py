"""Motion with play in the joints, from contact to contact, for a batch of runs at once."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.impact.ledger import Ledger, MotionSegment, derivative
from vibecalc.impact.linkage import FREE, GapForces, Law, Linkage, Starts, assemble_train, side_of
from vibecalc.impact.roots import Crossing, first_crossing, in_order, powers
from vibecalc.impact.setup import (
    MOST_STEPS,
    REACH,
    Setup,
    drive_series,
    fastest_rate,
    make_setup,
    motion_series,
)
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray

# ----------------------------------------------------------------------------
# One sweep: every run of a batch takes its own step, to its next event or its panel's end.
# ----------------------------------------------------------------------------

#: changes of side without any progress that count as sticking (each gap may have one)
_MOST_TURNS = 5


@dataclass
class State:
    """Where every run is: gaps (G, B), their sides and faces, and its place on the crank (B,).

    `end_gap` and `end_velocity` (G, B, revolutions) are those at the ends of revolutions.
    """

    gap: FloatArray
    velocity: FloatArray
    side: IntArray
    on_face: IntArray
    panel: IntArray
    offset: FloatArray
    revolution: IntArray
    level: IntArray
    turns: IntArray
    steps: IntArray
    end_gap: FloatArray
    end_velocity: FloatArray


def sweep(setup: Setup, state: State, ledger: Ledger | None, members: IntArray) -> None:
    """Advance the runs `members` by one step each, and keep the books."""
    train, panels = setup.train, setup.panels
    gap, velocity = state.gap[:, members], state.velocity[:, members]
    side, on_face = state.side[:, members], state.on_face[:, members]
    panel, offset, level = state.panel[members], state.offset[members], state.level[members]
    gaps = np.arange(len(gap))[:, None]
    law, mass = Law(*setup.laws[:, side + 1, gaps, members]), train.mass[members]

    width = panels.width[panel]
    remaining = width - offset
    rate = fastest_rate(setup.rate_couple[:, :, members], law)
    with np.errstate(divide="ignore"):
        step = np.minimum(remaining, setup.speed * REACH / rate) * 0.5**level
    whole = step >= remaining * (1.0 - 1e-12)
    step = np.where(whole, remaining, step)
    duration = step / setup.speed

    angle = panels.start[panel] + offset
    pin = drive_series(setup.pin, angle)
    grown = powers(step, len(pin) - 1)
    acceleration = pin[1:] * grown
    push = np.zeros((len(grown), len(gap), len(members)))
    push[:, train.pin] = acceleration
    slope = panels.gas_slope[panel]
    gas = np.stack([panels.gas[panel] + slope * offset, slope * step])
    push[:2, 0] -= gas / mass
    tangent = None if setup.tangent is None else drive_series(setup.tangent, angle) * grown
    motion = motion_series(
        gap, velocity, law, train.couple[:, :, members], push, duration,
        None if tangent is None else tangent / mass,
    )  # fmt: skip
    if not np.all(np.isfinite(np.sum(motion.gap, axis=0))):
        raise NumericalFailure("the motion in a joint with play has left the range of numbers")

    crossing = first_crossing(motion.gap, law, on_face, level)
    taken = crossing.fraction
    part = powers(taken, len(motion.gap))
    gap_series = motion.gap * part[:, None]
    speed_series = derivative(motion.gap) * part[:-1, None]
    speed_series /= duration
    if ledger is not None:
        rank = np.arange(1.0, len(pin))[:, None]
        segment = MotionSegment(
            members, speed_series, motion.force * part[: len(motion.force), None],
            np.concatenate([pin[:1], acceleration * duration / rank * part[1 : len(pin)]]),
            gas * part[:2], None if tangent is None else tangent * part[: len(tangent)],
            law.spring, law.damper, side, duration * taken,
            state.revolution[members], panel, offset, step * taken,
        )  # fmt: skip
        ledger.add(segment)
        ledger.sample(segment, gap_series, angle)

    moved = taken > 0.0
    state.gap[:, members] = in_order(gap_series)
    state.velocity[:, members] = np.where(moved, in_order(speed_series), velocity)
    state.on_face[:, members] = np.where(moved, 0, on_face)
    state.level[members] = np.where(crossing.halve, level + 1, np.maximum(level - moved, 0))
    end = offset + step * taken
    _change_sides(setup, state, ledger, members, law, crossing, end)

    finished = (moved & (crossing.direction == 0) & whole) | (width - end <= 4.0 * EPSILON * width)
    state.panel[members] = panel + finished
    state.offset[members] = np.where(finished, 0.0, end)
    state.steps[members] += 1
    _close(state, ledger, members[state.panel[members] == len(panels.start)])
    if np.max(state.steps[members]) > MOST_STEPS:
        run = members[np.argmax(state.steps[members])]
        raise NumericalFailure(
            f"run {run} needs more than {MOST_STEPS} steps in one revolution: its contacts follow "
            f"each other ever faster, or are too stiff or too strongly damped"
        )


def _change_sides(
    setup: Setup,
    state: State,
    ledger: Ledger | None,
    members: IntArray,
    law: Law,
    crossing: Crossing,
    end: FloatArray,
) -> None:
    """Put gaps that cross a face on it, and on its other side."""
    run = np.flatnonzero(crossing.direction)
    stands = crossing.fraction[run] == 0.0
    state.turns[members] = np.where(crossing.fraction > 0.0, 0, state.turns[members])
    if not len(run):
        return
    gap, direction, member = crossing.gap[run], crossing.direction[run], members[run]
    face = np.where(direction < 0, law.lower[gap, run], law.upper[gap, run])
    state.gap[gap, member] = face
    state.side[gap, member] += direction
    state.on_face[gap, member] = -direction
    state.turns[member] += stands
    if np.any(state.turns[member] > _MOST_TURNS):
        raise NumericalFailure(
            f"run {member[np.argmax(state.turns[member])]} sticks at the face of a gap: the forces "
            f"on both of its sides hold it there, and the law of the contact, which jumps at the "
            f"face, does not say how; take the continuous law"
        )
    if ledger is None:
        return
    made = state.side[gap, member] != FREE
    gap, member, end = gap[made], member[made], end[run[made]]
    revolution = state.revolution[member]
    angle = 2.0 * np.pi * revolution + setup.panels.start[state.panel[member]] + end
    ledger.add_contact(gap, member, revolution, angle / setup.speed)


def _close(state: State, ledger: Ledger | None, members: IntArray) -> None:
    """Turn over to the next revolution."""
    if not len(members):
        return
    gap, velocity, revolution = state.gap[:, members], state.velocity[:, members], state.revolution
    state.end_gap[:, members, revolution[members]] = gap
    state.end_velocity[:, members, revolution[members]] = velocity
    if ledger is not None:
        ledger.close_revolution(members, revolution[members], gap, velocity)
    state.revolution[members] += 1
    state.panel[members] = 0
    state.steps[members] = 0


# ----------------------------------------------------------------------------
# Motion with play in the joints, from contact to contact, for a batch of runs at once.
# ----------------------------------------------------------------------------


class Revolutions(NamedTuple):
    """Runs of a batch (B,), gaps in the order wrist pin, crank pin, bore.

    `forces` (G, B, R). `dissipated` (B, R), J, in contacts and films; `exchanged` (B, R), J, the
    sum of the sizes of what each piece of motion took and gave; `imbalance` (B, R), the error of
    the energy over the larger of that and the stored one, the larger of the axial and the lateral
    motion. `end_gap`, `end_velocity` (B, R, G) at the end of each revolution, m and m/s.
    `first_contacts` (G, B, 8), s: when the first contacts of the run were made, infinite for those
    that were not. `force` and `gap` (G, B, samples), N and m: the last revolution at equal crank
    angles from 0.
    """

    forces: GapForces
    dissipated: FloatArray
    exchanged: FloatArray
    imbalance: FloatArray
    end_gap: FloatArray
    end_velocity: FloatArray
    first_contacts: FloatArray
    force: FloatArray
    gap: FloatArray


def simulate(
    linkage: Linkage,
    start: Starts,
    revolutions: int,
    orders: int,
    samples: int = 0,
    subdivision: int = 1,
) -> Revolutions:
    """Run B machines that differ in anything but their drive and gas force, from crank angle 0.

    Parameters
    ----------
    linkage : numbers of its joints and masses may be (B,).
    start : (B, G)
    revolutions, orders : int
        How far to run, and the highest order of the force spectra.
    samples : int
        Equal crank angles at which the last revolution is sampled.
    subdivision : int
        Parts that every panel of crank angle is cut into; the results do not depend on it.

    Returns
    -------
    Revolutions
        Events are exact to rounding. The error estimates are those of one revolution from its
        own start: runs part exponentially, so that no method can give the state of a single run
        after many revolutions, and only statistics of many runs are results.

    Raises
    ------
    NumericalFailure
        Contacts too short or too strongly damped to be followed, a run that sticks at the jump
        of a full-deflection law, a state that is not finite.
    """
    setup, state = _prepare(linkage, start, revolutions, orders, subdivision)
    ledger = Ledger(setup, revolutions, samples)
    ledger.enter_energy(np.arange(state.gap.shape[1]), 0, state.gap, state.velocity)
    end = _march(setup, state, ledger, revolutions)
    ledger.settle()
    return Revolutions(
        ledger.forces,
        np.sum(ledger.loss, axis=0),
        np.sum(ledger.exchanged, axis=0),
        np.max(ledger.imbalance(), axis=0),
        *end,
        ledger.first_contacts,
        ledger.force,
        ledger.gap,
    )


def end_states(linkage: Linkage, start: Starts, revolutions: int) -> Starts:
    """States (B, R, G) at the ends of revolutions: the motion of `simulate`, nothing else kept.

    It is that of `simulate` with `orders` = 1, to the last bit. Errors are those of `simulate`.
    """
    setup, state = _prepare(linkage, start, revolutions, 1, 1)
    return _march(setup, state, None, revolutions)


def _march(setup: Setup, state: State, ledger: Ledger | None, revolutions: int) -> Starts:
    """Every run to the end of its last revolution; states at the ends of all."""
    everyone = np.arange(state.gap.shape[1])
    running = everyone
    while len(running):
        sweep(setup, state, ledger, running)
        running = everyone[state.revolution < revolutions]
    return Starts(np.moveaxis(state.end_gap, 0, -1), np.moveaxis(state.end_velocity, 0, -1))


def _prepare(
    linkage: Linkage, start: Starts, revolutions: int, orders: int, subdivision: int
) -> tuple[Setup, State]:
    gap, velocity = (np.array(one.T, dtype=np.float64, order="C") for one in start)
    members = gap.shape[1]
    train = assemble_train(linkage, members)
    on_lower, on_upper = gap == 0.0, gap == train.gaps.clearance
    state = State(
        gap=gap,
        velocity=velocity,
        side=side_of(train.gaps, gap),
        on_face=on_upper.astype(np.int64) - on_lower.astype(np.int64),
        panel=np.zeros(members, dtype=np.int64),
        offset=np.zeros(members),
        revolution=np.zeros(members, dtype=np.int64),
        level=np.zeros(members, dtype=np.int64),
        turns=np.zeros(members, dtype=np.int64),
        steps=np.zeros(members, dtype=np.int64),
        end_gap=np.zeros((*gap.shape, revolutions)),
        end_velocity=np.zeros((*gap.shape, revolutions)),
    )
    return make_setup(train, linkage.drive, linkage.gas, orders, subdivision), state

"""Motion with play in the joints, from contact to contact, for a batch of runs at once."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.impact.ledger import (
    Ledger,
    MotionSegment,
    Trace,
    add_contact,
    add_segment,
    close_revolution,
    derivative,
    enter_energy,
    open_ledger,
    open_trace,
    record,
    settle,
)
from vibecalc.impact.linkage import (
    FREE,
    Drive,
    GasForce,
    Joint,
    Law,
    Train,
    assemble_train,
    side_of,
    starts,
)
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
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray

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


class Books(NamedTuple):
    """What is kept of the motion besides the ends of its revolutions."""

    ledger: Ledger
    trace: Trace


def sweep(setup: Setup, state: State, books: Books | None, members: IntArray) -> None:
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
    if books is not None:
        rank = np.arange(1.0, len(pin))[:, None]
        segment = MotionSegment(
            members, speed_series, motion.force * part[: len(motion.force), None],
            np.concatenate([pin[:1], acceleration * duration / rank * part[1 : len(pin)]]),
            gas * part[:2], None if tangent is None else tangent * part[: len(tangent)],
            law.spring, law.damper, side, duration * taken,
            state.revolution[members], panel, offset, step * taken,
        )  # fmt: skip
        add_segment(books.ledger, setup, segment)
        record(books.trace, segment, gap_series, angle)

    moved = taken > 0.0
    state.gap[:, members] = in_order(gap_series)
    state.velocity[:, members] = np.where(moved, in_order(speed_series), velocity)
    state.on_face[:, members] = np.where(moved, 0, on_face)
    state.level[members] = np.where(crossing.halve, level + 1, np.maximum(level - moved, 0))
    end = offset + step * taken
    _change_sides(setup, state, books, members, law, crossing, end)

    finished = (moved & (crossing.direction == 0) & whole) | (width - end <= 4.0 * EPSILON * width)
    state.panel[members] = panel + finished
    state.offset[members] = np.where(finished, 0.0, end)
    state.steps[members] += 1
    _close(setup, state, books, members[state.panel[members] == len(panels.start)])
    if np.max(state.steps[members]) > MOST_STEPS:
        run = members[np.argmax(state.steps[members])]
        raise NumericalFailure(
            f"run {run} needs more than {MOST_STEPS} steps in one revolution: its contacts follow "
            f"each other ever faster, or are too stiff or too strongly damped"
        )


def _change_sides(
    setup: Setup,
    state: State,
    books: Books | None,
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
    if books is None:
        return
    made = state.side[gap, member] != FREE
    gap, member, end = gap[made], member[made], end[run[made]]
    revolution = state.revolution[member]
    angle = 2.0 * np.pi * revolution + setup.panels.start[state.panel[member]] + end
    add_contact(books.ledger, gap, member, revolution, angle / setup.speed)


def _close(setup: Setup, state: State, books: Books | None, members: IntArray) -> None:
    """Turn over to the next revolution."""
    if not len(members):
        return
    gap, velocity, revolution = state.gap[:, members], state.velocity[:, members], state.revolution
    state.end_gap[:, members, revolution[members]] = gap
    state.end_velocity[:, members, revolution[members]] = velocity
    if books is not None:
        close_revolution(books.ledger, setup, members, revolution[members], gap, velocity)
    state.revolution[members] += 1
    state.panel[members] = 0
    state.steps[members] = 0


# ----------------------------------------------------------------------------
# What the runs of a batch give, revolution by revolution.
# ----------------------------------------------------------------------------


class GapRecord(NamedTuple):
    """One gap of every run; arrays (B, revolutions) but for what is said otherwise.

    force_harmonics : complex (B, revolutions, N + 1), N
        One-sided 0-to-peak amplitudes over each revolution, F = Re sum F_n exp(i n theta);
        order 0 is the mean.
    mean_absolute_force, peak_force : N
        Mean and true maximum over time of |F|, film included.
    force_error : N
        Absolute error of each harmonic and of the mean, for the motion from the revolution's
        start: its energy residual and the rounding of the integrals.
    impact_count : contacts made. contact_time : s. impulse : N s, integral of |F| in contact.
    contact_dissipation, film_dissipation : J
    first_contacts : (B, 8), s
        When the first contacts of the run were made, infinity for those that were not.
    force, gap : (B, samples), N and m
        The last revolution at equal crank angles from 0.
    """

    force_harmonics: ComplexArray
    mean_absolute_force: FloatArray
    peak_force: FloatArray
    force_error: FloatArray
    impact_count: IntArray
    contact_time: FloatArray
    impulse: FloatArray
    contact_dissipation: FloatArray
    film_dissipation: FloatArray
    first_contacts: FloatArray
    force: FloatArray
    gap: FloatArray


class EnergyBalance(NamedTuple):
    """Energy of the axial or the lateral motion, J, arrays (B, revolutions).

    `stored` (B, revolutions + 1): kinetic and spring energy at the start and at each
    revolution's end. `work` of all forces from outside, `dissipated` in contacts and films,
    `residual` = change of stored - work + dissipated, zero but for errors; `exchanged` the sum of
    the sizes of what each piece of motion took and gave. `relative_error`: the larger of the
    residual and the rounding of the stored energy, over the larger of exchanged and stored.
    """

    stored: FloatArray
    work: FloatArray
    dissipated: FloatArray
    residual: FloatArray
    exchanged: FloatArray
    relative_error: FloatArray


class Revolutions(NamedTuple):
    """Runs of a batch; `crank_pin`, `wall` and `lateral` are None where there is no such gap.

    `end_gap`, `end_velocity` (B, revolutions, G) at the end of each revolution, m and m/s, gaps
    in the order wrist pin, crank pin, bore. `pin_work`, `gas_work` (B, revolutions) in J are done
    on the masses. `angle` (samples,) rad of the samples.
    """

    wrist_pin: GapRecord
    crank_pin: GapRecord | None
    wall: GapRecord | None
    axial: EnergyBalance
    lateral: EnergyBalance | None
    pin_work: FloatArray
    gas_work: FloatArray
    end_gap: FloatArray
    end_velocity: FloatArray
    angle: FloatArray


def collect(setup: Setup, state: State, books: Books) -> Revolutions:
    """The books of a finished batch as results."""
    ledger, trace = books
    settle(ledger, setup)
    book, train = ledger.book, setup.train
    loss = book["contact_loss"] + book["film_loss"]
    work = book["pin_work"] + book["gas_work"]
    stored, exchanged = book["axial_energy"], book["axial_exchanged"]
    axial_loss = np.sum(loss[: train.bore], axis=0)
    axial = _balance(stored, work, axial_loss, exchanged)
    error, lateral, wall = axial.relative_error, None, None
    if train.bore is not None:
        bore_loss, exchanged = loss[train.bore], book["lateral_exchanged"]
        lateral = _balance(book["lateral_energy"], book["side_work"], bore_loss, exchanged)
        total_error = error + lateral.relative_error
        wall = _gap_record(setup, ledger, trace, train.bore, total_error)
    return Revolutions(
        _gap_record(setup, ledger, trace, 0, error),
        _gap_record(setup, ledger, trace, 1, error) if train.pin == 1 else None,
        wall,
        axial,
        lateral,
        book["pin_work"],
        book["gas_work"],
        np.moveaxis(state.end_gap, 0, -1),
        np.moveaxis(state.end_velocity, 0, -1),
        trace.angle,
    )


def _balance(
    stored: FloatArray, work: FloatArray, dissipated: FloatArray, exchanged: FloatArray
) -> EnergyBalance:
    residual = np.diff(stored, axis=-1) - work + dissipated
    largest = np.maximum(stored[:, 1:], stored[:, :-1])
    scale = np.maximum(exchanged, largest)
    uncertainty = np.maximum(np.abs(residual), 8.0 * EPSILON * scale)
    relative = uncertainty / np.where(scale > 0.0, scale, 1.0)
    return EnergyBalance(stored, work, dissipated, residual, exchanged, relative)


def _gap_record(
    setup: Setup, ledger: Ledger, trace: Trace, gap: int, relative: FloatArray
) -> GapRecord:
    book = {name: values[gap] for name, values in ledger.book.items() if values.ndim == 3}
    absolute = book["absolute"] * setup.speed / (2.0 * np.pi)
    return GapRecord(
        ledger.spectra[gap],
        absolute,
        book["peak"],
        # twice: a harmonic is twice a mean
        2.0 * absolute * (relative + 32.0 * EPSILON),
        book["count"].astype(np.int64),
        book["contact_time"],
        book["contact_absolute"],
        book["contact_loss"],
        book["film_loss"],
        ledger.first_contacts[gap],
        trace.force[gap],
        trace.gap[gap],
    )


# ----------------------------------------------------------------------------
# Motion with play in the joints, from contact to contact, for a batch of runs at once.
# ----------------------------------------------------------------------------


def simulate(
    drive: Drive,
    gas: GasForce,
    mass: ArrayLike,
    joint: Joint,
    gap: ArrayLike,
    gap_velocity: ArrayLike,
    *,
    revolutions: int,
    orders_retained: int,
    crank_joint: Joint | None = None,
    rod_mass: ArrayLike | None = None,
    wall: Joint | None = None,
    samples: int = 0,
    subdivision: int = 1,
) -> Revolutions:
    """Run B machines that differ in anything but their drive and gas force, from crank angle 0.

    Parameters
    ----------
    drive, gas, joint, crank_joint, wall
        See `model.py`, which has the equations and the signs. The clearance of `wall` is the
        whole lateral play of the piston in the bore.
    mass, rod_mass : (B,) or a number, kg
        Of the piston with what moves with it, and of the rod's reciprocating point mass, which
        belongs to a crank joint with play.
    gap, gap_velocity : (B, G), or (B,) with one gap; m and m/s
        Start of the gaps, in the order wrist pin, crank pin, bore.
    revolutions, orders_retained : int
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
    parts = (drive, gas, mass, joint, crank_joint, rod_mass, wall)
    setup, state = _prepare(parts, gap, gap_velocity, revolutions, orders_retained, subdivision)
    gaps, members = state.gap.shape
    books = Books(open_ledger(setup, revolutions), open_trace(gaps, members, samples, revolutions))
    everyone = np.arange(members)
    enter_energy(books.ledger, setup, everyone, 0 * everyone, state.gap, state.velocity)
    _march(setup, state, books, revolutions)
    return collect(setup, state, books)


class EndStates(NamedTuple):
    """`gap` m and `velocity` m/s (B, revolutions, G) of the gaps at the ends of revolutions."""

    gap: FloatArray
    velocity: FloatArray


def end_states(
    drive: Drive,
    gas: GasForce,
    mass: ArrayLike,
    joint: Joint,
    gap: ArrayLike,
    gap_velocity: ArrayLike,
    *,
    revolutions: int,
    crank_joint: Joint | None = None,
    rod_mass: ArrayLike | None = None,
    wall: Joint | None = None,
) -> EndStates:
    """Where runs are after each revolution: the motion of `simulate`, of which nothing is kept.

    It is that of `simulate` with `orders_retained` = 1, to the last bit. Parameters and errors
    are those of `simulate`.
    """
    parts = (drive, gas, mass, joint, crank_joint, rod_mass, wall)
    setup, state = _prepare(parts, gap, gap_velocity, revolutions, 1, 1)
    _march(setup, state, None, revolutions)
    return EndStates(np.moveaxis(state.end_gap, 0, -1), np.moveaxis(state.end_velocity, 0, -1))


#: drive, gas, mass, wrist pin, crank pin, rod mass, bore
_Parts = tuple[
    Drive, GasForce, ArrayLike, Joint, Joint | None, ArrayLike | None, Joint | None
]  # fmt: skip


def _prepare(
    parts: _Parts,
    gap: ArrayLike,
    velocity: ArrayLike,
    revolutions: int,
    orders: int,
    subdivision: int,
) -> tuple[Setup, State]:
    drive, gas, mass, joint, crank_joint, rod_mass, wall = parts
    start, speed = starts(gap), starts(velocity)
    rod = None if rod_mass is None else np.asarray(rod_mass, dtype=np.float64)
    piston = np.asarray(mass, dtype=np.float64)
    train = assemble_train(start.shape[1], piston, joint, crank_joint, rod, wall)
    setup = make_setup(train, drive, gas, orders, subdivision)
    return setup, _first_state(train, start, speed, revolutions)


def _march(setup: Setup, state: State, books: Books | None, revolutions: int) -> None:
    """Every run to the end of its last revolution."""
    everyone = np.arange(state.gap.shape[1])
    running = everyone
    while len(running):
        sweep(setup, state, books, running)
        running = everyone[state.revolution < revolutions]


def _first_state(train: Train, gap: FloatArray, velocity: FloatArray, revolutions: int) -> State:
    members = gap.shape[1]

    def zeros() -> np.ndarray:
        return np.zeros(members, dtype=np.int64)

    on_lower, on_upper = gap == 0.0, gap == train.gaps.clearance
    return State(
        gap.copy(),
        velocity.copy(),
        side_of(train.gaps, gap),
        on_upper.astype(np.int64) - on_lower.astype(np.int64),
        zeros(),
        np.zeros(members),
        zeros(),
        zeros(),
        zeros(),
        zeros(),
        np.zeros((*gap.shape, revolutions)),
        np.zeros((*gap.shape, revolutions)),
    )

"""One sweep: every run of a batch takes its own step, to its next event or its panel's end."""

from dataclasses import dataclass

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.impact.contact import FREE, Law, law_of
from vibecalc.response.impact.events import Crossing, first_crossing
from vibecalc.response.impact.ledger import (
    Ledger,
    Piece,
    add_contact,
    add_piece,
    close_revolution,
)
from vibecalc.response.impact.piece import derivative
from vibecalc.response.impact.roots import in_order
from vibecalc.response.impact.series import REACH, drive_series, fastest_rate, motion_series
from vibecalc.response.impact.setup import MOST_STEPS, Setup
from vibecalc.response.impact.trace import Trace, record

#: changes of side without any progress that count as sticking (each gap may have one)
_MOST_TURNS = 5


@dataclass
class State:
    """Where every run is: gaps (G, B), their sides and faces, and its place on the crank (B,)."""

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


def sweep(setup: Setup, state: State, ledger: Ledger, trace: Trace, members: IntArray) -> None:
    """Advance the runs `members` by one step each, and keep the books."""
    train, panels = setup.train, setup.panels
    gaps = train.gaps._replace(**{k: v[:, members] for k, v in train.gaps._asdict().items()})
    gap, velocity = state.gap[:, members], state.velocity[:, members]
    side, on_face = state.side[:, members], state.on_face[:, members]
    panel, offset, level = state.panel[members], state.offset[members], state.level[members]
    law, mass = law_of(gaps, side), train.mass[members]

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
    rise = np.ones((len(pin) - 1, len(members)))
    rise[1:] = step
    np.cumprod(rise, axis=0, out=rise)
    push = np.zeros((len(rise), len(gap), len(members)))
    push[:, train.pin] = pin[1:] * rise
    slope = panels.gas_slope[panel]
    gas = np.stack([panels.gas[panel] + slope * offset, slope * step])
    push[:2, 0] -= gas / mass
    tangent = None if setup.tangent is None else drive_series(setup.tangent, angle) * rise
    motion = motion_series(
        gap, velocity, law, train.couple[:, :, members], push, duration,
        None if tangent is None else tangent / mass,
    )  # fmt: skip
    if not np.all(np.isfinite(np.sum(motion.gap, axis=0))):
        raise NumericalFailure("the motion in a joint with play has left the range of numbers")

    crossing = first_crossing(motion.gap, law, on_face, level)
    taken = crossing.fraction
    part = np.ones((len(motion.gap), len(members)))
    part[1:] = taken
    np.cumprod(part, axis=0, out=part)
    gap_series = motion.gap * part[:, None]
    speed_series = derivative(motion.gap) * part[:-1, None] / duration
    force_series = motion.force * part[: len(motion.force), None]
    acceleration = pin[1:] * rise * duration / np.arange(1.0, len(pin))[:, None]
    pin_velocity = np.concatenate([pin[:1], acceleration * part[1 : len(pin)]])
    piece = Piece(
        members, speed_series, force_series, pin_velocity, gas * part[:2],
        None if tangent is None else tangent * part[: len(tangent)],
        side, duration * taken, panel, offset, step * taken,
    )  # fmt: skip
    add_piece(ledger, setup, piece, law)
    record(trace, piece, gap_series, angle, state.revolution[members])

    moved = taken > 0.0
    state.gap[:, members] = in_order(gap_series)
    state.velocity[:, members] = np.where(moved, in_order(speed_series), velocity)
    state.on_face[:, members] = np.where(moved, 0, on_face)
    state.level[members] = np.where(crossing.halve, level + 1, np.maximum(level - moved, 0))
    end = offset + step * taken
    _change_sides(setup, state, ledger, members, law, crossing, end)

    finished = (moved & (crossing.way == 0) & whole) | (width - end <= 4.0 * EPSILON * width)
    state.panel[members] = panel + finished
    state.offset[members] = np.where(finished, 0.0, end)
    state.steps[members] += 1
    _close(setup, state, ledger, members[state.panel[members] == len(panels.start)])
    if np.max(state.steps[members]) > MOST_STEPS:
        run = members[np.argmax(state.steps[members])]
        raise NumericalFailure(
            f"run {run} needs more than {MOST_STEPS} steps in one revolution: its contacts follow "
            f"each other ever faster, or are too stiff or too strongly damped"
        )


def _change_sides(
    setup: Setup,
    state: State,
    ledger: Ledger,
    members: IntArray,
    law: Law,
    crossing: Crossing,
    end: FloatArray,
) -> None:
    """Put gaps that cross a face on it, and on its other side."""
    run = np.flatnonzero(crossing.way)
    stands = crossing.fraction[run] == 0.0
    state.turns[members] = np.where(crossing.fraction > 0.0, 0, state.turns[members])
    if not len(run):
        return
    gap, way, member = crossing.gap[run], crossing.way[run], members[run]
    face = np.where(way < 0, law.lower[gap, run], law.upper[gap, run])
    state.gap[gap, member] = face
    state.side[gap, member] += way
    state.on_face[gap, member] = -way
    state.turns[member] += stands
    if np.any(state.turns[member] > _MOST_TURNS):
        raise NumericalFailure(
            f"run {member[np.argmax(state.turns[member])]} sticks at the face of a gap: the forces "
            f"on both of its sides hold it there, and the law of the contact, which jumps at the "
            f"face, does not say how; take the continuous law"
        )
    made = state.side[gap, member] != FREE
    turns = 2.0 * np.pi * state.revolution[member]
    angle = turns + setup.panels.start[state.panel[member]] + end[run]
    add_contact(ledger, gap[made], member[made], angle[made] / setup.speed)


def _close(setup: Setup, state: State, ledger: Ledger, members: IntArray) -> None:
    """Turn over to the next revolution."""
    if not len(members):
        return
    gap, velocity = state.gap[:, members], state.velocity[:, members]
    close_revolution(ledger, setup, members, state.revolution[members], gap, velocity)
    state.revolution[members] += 1
    state.panel[members] = 0
    state.steps[members] = 0

"""The first contacts and the force over the first turn, which every good method has to agree on.

Runs that part exponentially have no reproducible late states, but their first contacts are. How
well is measured: neighbours of the start tell how an error grows up to each contact, and each
rounding on the way is taken for one at the start.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.impact.fixed_step import contact_force
from vibecalc.response.impact.linkage import (
    Linkage,
    Starts,
    central_start,
    clearances,
    gaps_of,
    velocity_scale,
)
from vibecalc.response.impact.model import assemble_train
from vibecalc.response.impact.results import Revolutions
from vibecalc.response.impact.runs import follow_events

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
    kept = max(FEWEST, int(np.min(np.sum(contacts_error <= UNCERTAIN, axis=1))))
    force, force_error = _with_error(force, count)
    largest = np.maximum.accumulate(np.abs(force), axis=1)
    force_error = np.maximum.accumulate(force_error, axis=1) + ROUNDINGS * EPSILON * largest
    angle = np.linspace(0.0, 2.0 * np.pi, ANGLES)
    return FirstMotion(contacts[:, :kept], contacts_error[:, :kept], angle, force, force_error)


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

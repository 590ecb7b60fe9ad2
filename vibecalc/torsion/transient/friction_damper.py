"""A ring that dry friction drags along through a run: it holds, slips, and holds again."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.line import Line
from vibecalc.torsion.transient.clutch import (
    ROUNDED,
    Clutch,
    clutch_system,
    marched_until,
    slip_heat,
    slip_view,
)
from vibecalc.torsion.transient.march import (
    TransientRun,
    TransientSystem,
    balance_matrix,
    steady_start,
    transient,
)
from vibecalc.torsion.transient.motion import Stretch, speed_after, split, turned_after

# ----------------------------------------------------------------------------
# The ring is the driven part of a clutch that is always engaged: the linings are an element in line
# with plates without mass, which slip where the torque of the element would exceed the friction.
# The prescribed motion is that of the whole line, ring included, whether it slips or not.
# ----------------------------------------------------------------------------

#: more changes between slipping and holding than this are refused
_MOST_CHANGES = 4000
#: rad of the vibration of the ring on its linings after which slips are looked for
_LOOK = 0.2


class Dragged(NamedTuple):
    """A run with the ring slipping, `slip` = 1 or -1 (station faster or slower), or holding, 0.

    `slip` belongs to the stretches of the run; `slip_time` in s and `heat` in J are of all its
    slipping, `heat_error` in J; `locks` says how often it begins to hold.
    """

    run: TransientRun
    slip: tuple[int, ...]
    slip_time: float
    heat: float
    heat_error: float
    locks: int


def drag(
    line: Line,
    order: FloatArray,
    clutch: Clutch,
    stretches: Sequence[Stretch],
    speed: float,
    start: str,
    reaction: FloatArray | None,
    rtol: float = 1e-7,
) -> Dragged:
    """March a line, as `transient` does, whose ring a `clutch` of constant friction drags along.

    It begins with the ring holding, in the steady vibration or at rest.

    Raises NumericalFailure if it changes between slipping and holding without end, or as
    `transient` does.
    """
    balance, full = balance_matrix(line, reaction), clutch.friction_torque

    @cache
    def system_of(slip: int) -> TransientSystem:
        found = clutch_system(line, clutch, slip, 0.0)
        return replace(found, balance=balance, tools={})

    own_ends = line.inertia[[line.first[clutch.element], line.second[clutch.element]]]
    longest = _LOOK / np.sqrt(line.stiffness[clutch.element] * np.sum(1.0 / own_ends))
    state = np.zeros(len(system_of(0).state_matrix))
    if start == "steady":
        state = steady_start(system_of(0), order, stretches[0], speed)
    state[-2:] = full / np.sqrt(line.stiffness[clutch.element])
    begin, total = state, sum(one.duration for one in stretches)
    fastest = speed + sum(abs(one.acceleration) * one.duration for one in stretches)
    crank, angle, slip, locks, changes = speed, 0.0, 0, 0, 0
    waiting = list(reversed(stretches))
    parts, systems, slips = list[Stretch](), list[TransientSystem](), list[int]()
    while waiting:
        part, system = waiting.pop(), system_of(slip)
        own = system.torque[clutch.element]
        if slip:
            watched = slip * slip_view(system, line, clutch)[None]
            allowed = ROUNDED * fastest
        else:
            reserve = np.zeros(state.size)
            reserve[-2] = np.sqrt(line.stiffness[clutch.element])
            watched, allowed = np.stack([reserve - own, reserve + own]), ROUNDED * full
        passed, state, changed = marched_until(
            system, order, part, crank, angle, state, watched, allowed, longest
        )
        first = part
        if changed:
            first, rest = split(part, crank, passed)
            waiting.append(rest if passed > ROUNDED * total else part)
            if rest.duration <= ROUNDED * total:
                waiting.pop()
        if passed > ROUNDED * total:
            parts.append(first)
            systems.append(system)
            slips.append(slip)
            angle += float(turned_after(part, crank, passed))
            crank = float(speed_after(part, crank, np.asarray(passed)))
        if not changed:
            continue
        changes += 1
        if slip:
            slip, locks = 0, locks + 1
        else:
            slip = 1 if own @ state > 0.0 else -1
            if not parts:
                # it slips from the start on, where the friction takes less than holding it would
                begin = state = _let_go(state, line, clutch, slip)
        if changes > _MOST_CHANGES:
            raise NumericalFailure(
                f"the ring of a friction damper changes between slipping and holding more than "
                f"{_MOST_CHANGES} times: a shorter transient, or another friction_torque"
            )
    run = transient(line, order, parts, speed, start=begin, rtol=rtol, systems=systems)
    slipped = [one.duration for one, way in zip(parts, slips, strict=True) if way]
    heat, heat_error = slip_heat(run, line, clutch, slips)
    return Dragged(run, tuple(slips), float(sum(slipped)), heat, heat_error, locks)


def _let_go(state: FloatArray, line: Line, clutch: Clutch, slip: int) -> FloatArray:
    """With linings that carry the friction torque and no more; a dashpot in them winds up."""
    found = state.copy()
    if line.damping[clutch.element] == 0.0:
        found[clutch.element] = slip * state[-2]
    return found

"""What larger changes of the machine do to the shell: each one solved for, no slope."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.response.roll.demand import surely_fastest
from vibecalc.response.roll.machine import RollDrive, RollMachine, member
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.running import running_state
from vibecalc.response.roll.sensitivity import Parameter, altered, parameters
from vibecalc.response.roll.steady import Steady, multipliers, steady_state
from vibecalc.response.roll.turn import harmonics, level

#: the rounding of a sum over a turn, over the largest harmonic
_ROUNDING = 1e3 * EPSILON
#: dB for a relative change, when it is small
_DECIBELS = 20.0 / np.log(10.0)


class Change(NamedTuple):
    """Changes of level, dB, for one factor on each parameter (parameters, orders).

    `lost` are parameters with which no running state was found, each with the reason in words;
    they are not among `parameters`.
    """

    parameters: tuple[str, ...]
    value: FloatArray
    error: FloatArray
    lost: tuple[tuple[str, str], ...]


def changes(
    machine: RollMachine,
    drive: RollDrive,
    orders: Sequence[int],
    cylinders: Sequence[str],
    factors: Sequence[float],
    *,
    points: int,
    started_at: float | None = None,
) -> list[Change]:
    """Levels of the shell's acceleration with each parameter times each factor, less those as is.

    For one machine (B = 1), which runs. All altered machines are one batch; one that it does not
    surely solve is solved alone, by all that `running_state` knows. The error is twice what two
    more points on each panel change, and the rounding.
    """
    rows = parameters(machine, cylinders)
    asked = [(row, factor) for factor in factors for row in rows]
    batch = altered(machine, [(None, 1.0), *asked])
    fits = _turns(batch)
    # a stand-in for what cannot turn at all; it is not looked at
    usable = altered(machine, [(None, 1.0), *((r, f if ok else 1.0) for (r, f), ok in
                                              zip(asked, fits[1:], strict=True))])  # fmt: skip
    first = steady_state(usable, drive, points, started_at=started_at)
    finer = steady_state(usable, drive, points + 2, started_at=started_at, start=first)
    own, other = (_levels(usable, drive, found, orders) for found in (first, finer))
    sure = first.found & finer.found & surely_fastest(usable, drive, first.turn)
    sure &= _stable(first) & _within(first, drive)
    reasons: dict[int, str] = {}
    for place in np.flatnonzero(~sure | ~fits):
        if not fits[place]:
            reasons[int(place)] = "the rod is too short for the crank"
            continue
        try:
            alone = _alone(member(batch, int(place)), drive, orders, points, started_at)
        except NumericalFailure as failure:
            reasons[int(place)] = str(failure).removeprefix("roll: ")
        else:
            own[place], other[place] = alone
    return [
        _change(rows, 1 + step * len(rows), own, other, reasons) for step in range(len(factors))
    ]


def _change(
    rows: Sequence[Parameter],
    start: int,
    own: FloatArray,
    other: FloatArray,
    reasons: dict[int, str],
) -> Change:
    places = np.arange(start, start + len(rows))
    if 0 in reasons or not np.isfinite(own[0]).all():
        raise NumericalFailure(
            "roll: the running state is lost when it is solved for once more, so that nothing can "
            "be said of changes; leave sensitivity away"
        )
    lost = {int(place): reasons[int(place)] for place in places if int(place) in reasons}
    for place in places:
        if int(place) not in lost and not np.isfinite(own[place]).all():
            lost[int(place)] = "a harmonic vanishes, which has no level"
    kept = np.array([place for place in places if int(place) not in lost], dtype=int)
    value = own[kept] - own[0]
    doubt = np.abs(value - (other[kept] - other[0]))
    error = 2.0 * doubt + _rounding(own[kept]) + _rounding(own[:1])
    names = tuple(rows[place - start].name for place in kept)
    return Change(
        names, value, error, tuple((rows[p - start].name, words) for p, words in lost.items())
    )


def _rounding(levels: FloatArray) -> FloatArray:
    """dB; the rounding of a harmonic is that of the largest one."""
    below = np.max(levels, axis=-1, keepdims=True, initial=-np.inf) - levels
    return np.asarray(_DECIBELS * _ROUNDING * 10.0 ** (below / 20.0))


def _alone(
    machine: RollMachine,
    drive: RollDrive,
    orders: Sequence[int],
    points: int,
    started_at: float | None,
) -> tuple[FloatArray, FloatArray]:
    found = running_state(
        machine, drive, rtol=1.0, orders=max(orders), started_at=started_at, points=points
    )
    own, other = (_levels(machine, drive, one, orders)[0] for one in (found.state, found.check))
    return own, other


def _levels(
    machine: RollMachine, drive: RollDrive, found: Steady, orders: Sequence[int]
) -> FloatArray:
    read = readings(machine, drive, found.turn, pistons=False)
    return level(harmonics(found.turn, read.shell_acceleration, np.asarray(orders, dtype=float)))


def _turns(batch: RollMachine) -> BoolArray:
    """Whether the rod reaches over the crank, in all positions of all cylinders."""
    offset = np.abs(batch.wrist_pin_offset)
    return np.asarray(batch.rod_length > batch.crank_radius + offset)


def _stable(found: Steady) -> BoolArray:
    value, error = multipliers(found)
    return np.asarray(np.all(np.abs(value) <= 1.0 + error, axis=-1))


def _within(found: Steady, drive: RollDrive) -> BoolArray:
    """Whether the slip stays in the table of the motor."""
    if drive.circuit is not None or drive.holds:
        return np.ones(len(found.found), dtype=bool)
    slip = drive.synchronous_speed[..., None] - found.turn.crank_speed
    return np.asarray(np.max(np.abs(slip), axis=-1) <= drive.motor.largest)

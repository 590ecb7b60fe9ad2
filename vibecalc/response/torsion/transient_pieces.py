"""Pieces of equal steps: a stretch is cut where the speed halves, each piece has its step."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.transient_motion import (
    Course,
    Stretch,
    speed_after,
    time_of_speed,
    turned_after,
)
from vibecalc.response.torsion.transient_step import Propagator
from vibecalc.response.torsion.transient_torque import CYCLE, TorqueLaw, torque_at

#: radians of the highest order in one step, and of the highest mode that is followed in detail
ORDER_STEP, MODE_STEP = 2.0, 12.0

#: modes faster than this many times the fastest torque are not resolved by the step
FOLLOWED = 10.0

#: more steps than this are refused
MOST_STEPS = 4_000_000

#: least number of steps in a stretch
FEWEST = 16


class Piece(NamedTuple):
    """`steps` steps of `step` s in stretch number `stretch`, from `offset` s after its start."""

    stretch: int
    offset: float
    step: float
    steps: int


def cut(
    stretches: Sequence[Stretch], borders: Course, highest: float, fastest: float, finer: float
) -> list[Piece]:
    """Pieces with an even number of steps; `highest` order, `fastest` mode in rad/s.

    `finer` divides every step. Raises NumericalFailure beyond MOST_STEPS.
    """
    excited = highest * float(borders.speed.max())
    followed = min(fastest, FOLLOWED * excited) if excited > 0.0 else fastest
    # the slowest piece is that of 2^-12 of the highest speed, whatever the modes
    floor = max(followed * ORDER_STEP / MODE_STEP, excited * 2.0**-12)
    parts: list[Piece] = []
    for number, part in enumerate(stretches):
        start, end = borders.speed[number], borders.speed[number + 1]
        level, cuts = max(start, end), [0.0, part.duration]
        # going down in halves from the higher speed, as far as the orders set the step
        while start != end and highest * level > max(floor, highest * min(start, end)):
            level /= 2.0
            if level > min(start, end):
                cuts.append(time_of_speed(part, float(start), float(level)))
        ordered = sorted(cuts)
        for left, right in pairwise(ordered):
            speeds = speed_after(part, float(start), np.array([left, right]))
            rate = max(floor, highest * float(speeds.max()), 1e-300)
            length = min(ORDER_STEP / rate, part.duration / FEWEST) / finer
            count = 2 * max(1, int(np.ceil((right - left) / length / 2.0)))
            parts.append(Piece(number, left, (right - left) / count, count))
    if sum(piece.steps for piece in parts) > MOST_STEPS:
        raise NumericalFailure(
            f"the transient needs more than {MOST_STEPS} steps: shorten it or drop high orders"
        )
    return parts


def piece_gain(
    piece: Piece, law: TorqueLaw, part: Stretch, borders: Course, weight: FloatArray,
    place: FloatArray, steps: IntArray,
) -> FloatArray:  # fmt: skip
    """What the torque adds to the state in the given steps (counted from 0) of a piece, (steps, s).

    `weight` (s, p, n) of a propagator, `place` (p,) its Gauss points as shares of the step. The
    angle at the start of each step is formed in the widest float and reduced to one cycle.
    """
    begin = piece.offset + steps * np.longdouble(piece.step)
    origin, speed = borders.angle[piece.stretch], float(borders.speed[piece.stretch])
    turned = origin + turned_after(part, speed, begin)
    reduced = np.asarray(turned % CYCLE, dtype=float)[:, None]
    since = np.asarray(begin, dtype=float)[:, None]
    ahead = place * piece.step
    rate = speed_after(part, speed, since)
    growth = part.acceleration + part.acceleration_rate * since
    bend = part.acceleration_rate * ahead
    angle = reduced + (rate + (growth + bend / 3.0) * ahead / 2.0) * ahead
    torque = torque_at(
        law, part, angle, rate + (growth + bend / 2.0) * ahead, (since + ahead) / part.duration
    )
    size, points, n = weight.shape
    gain: FloatArray = np.einsum(
        "ij,kj->ik",
        torque.transpose(1, 2, 0).reshape(-1, points * n),
        weight.reshape(size, -1),
        optimize=True,
    )
    return gain


def inside(
    piece: Piece, law: TorqueLaw, part: Stretch, borders: Course, tool: Propagator,
    states: FloatArray, steps: IntArray,
) -> FloatArray:  # fmt: skip
    """States (steps, parts, s) at the parts of the given steps, whose starts are `states`."""
    parts, size, points, n = tool.weight.shape
    merged = tool.weight.reshape(parts * size, points, n)
    gain = piece_gain(piece, law, part, borders, merged, tool.place, steps)
    inner = np.einsum("ks,jts->kjt", states, tool.transition, optimize=True)
    reached: FloatArray = gain.reshape(-1, parts, size) + inner
    return reached

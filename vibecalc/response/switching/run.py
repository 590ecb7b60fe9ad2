"""A run: a stretch of time in which the crank accelerates evenly, its load and its panels."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.response.switching.free_motion import fastest_rate
from vibecalc.response.switching.orders import order_waves, real_rows
from vibecalc.response.switching.system import ModalLoads, ModalSystem, Piece

#: phase in rad that the fastest part of the motion may turn within a panel
PANEL_PHASE = 2.0
#: more panels than this are refused
MOST_PANELS = 1_000_000
_BLOCK = 1 << 21


class Run(NamedTuple):
    """`start` and `duration` in s, crank `angle` and `speed` at its start, even `acceleration`."""

    start: float
    duration: float
    angle: float
    speed: float
    acceleration: float
    operation: int
    piece: int

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        """Crank angle at times after the run's start."""
        return self.angle + time * (self.speed + 0.5 * self.acceleration * time)

    def speed_at(self, time: np.ndarray) -> np.ndarray:
        """Crank speed at times after the run's start."""
        return self.speed + self.acceleration * time

    @property
    def end_speed(self) -> float:
        """Crank speed at its end."""
        return self.speed + self.acceleration * self.duration


def runs_of(pieces: Sequence[Piece], angle: float) -> list[Run]:
    """The pieces one after the other; one that passes a standstill gives two runs.

    Raises ValueError where a piece does not begin at the speed at which the one before it ends.
    """
    runs: list[Run] = []
    start, speed = 0.0, pieces[0].start_speed
    for number, piece in enumerate(pieces):
        if piece.start_speed != speed:
            raise ValueError(f"piece {number} begins at {piece.start_speed}, not at {speed}")
        acceleration = (piece.end_speed - speed) / piece.duration
        ends = [piece.duration]
        # next to nothing before or after the standstill is no run of its own
        rest = -speed / acceleration if acceleration else 0.0
        if speed * piece.end_speed < 0.0 and 0.0 < rest < piece.duration:
            ends = [rest, piece.duration]
        begin = 0.0
        for end in ends:
            at = 0.0 if begin > 0.0 else speed
            run = Run(start + begin, end - begin, angle, at, acceleration, piece.operation, number)
            runs.append(run)
            angle = float(np.mod(run.angle_at(np.array(end - begin)), 2.0 * np.pi))
            begin = end
        start, speed = start + piece.duration, piece.end_speed
    return runs


def panel_grid(
    system: ModalSystem, loads: ModalLoads, run: Run, longest: float, phase: float = PANEL_PHASE
) -> np.ndarray:
    """Times (panels + 1,) from 0 to the run's duration, closer where the crank is faster.

    Over a panel the highest order, the fastest pole and the change of speed together turn by
    `phase` at most, and it is not longer than `longest`. Raises NumericalFailure if that takes
    more than a million panels.
    """
    driven = ModalSystem(
        system.shape[:, loads.driven],
        system.frequency[loads.driven],
        system.damping_ratio[loads.driven],
    )
    highest = float(np.max(loads.orders, initial=0))
    sense = 1.0 if run.speed + run.end_speed >= 0.0 else -1.0
    chirp = sense * highest * run.acceleration
    base = fastest_rate(driven) + np.sqrt(abs(chirp)) + phase / longest
    first = base + highest * abs(run.speed)
    total = run.duration * (first + 0.5 * chirp * run.duration)
    count = np.ceil(total / phase)
    require_panels(count, run.start, run.start + run.duration)
    share = np.linspace(0.0, total, int(count) + 1)
    root = np.sqrt(np.maximum(first**2 + 2.0 * chirp * share, 0.0))
    grid: np.ndarray = 2.0 * share / (first + root)
    grid[-1] = run.duration
    return grid


def require_panels(count: float, start: float, end: float) -> None:
    """Raise NumericalFailure where a span of time needs more than a million panels."""
    if not count <= MOST_PANELS:
        raise NumericalFailure(
            f"the transient between {start:.6g} and {end:.6g} s would take {count:.3g} steps, more "
            f"than can be followed ({MOST_PANELS}): the fastest order or mode turns too often; "
            f"shorten it, keep fewer orders, or see whether a mode is meant to be so stiff or so "
            f"strongly damped"
        )


def load_at(
    loads: ModalLoads, run: Run, time: np.ndarray, with_rate: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Modal load (times, modes) and its rate of change at times after the run's start.

    With S_k = sum p_n (i n)^k exp(i n theta) the load is Re(w^2 S_0 + w' S_-1) and, w' being
    constant, its rate is Re(w^3 S_1 + 3 w w' S_0). Without the rate, the load stands twice.
    """
    amplitude, factor = loads.amplitude[run.operation], 1j * loads.orders[:, None]
    parts = [amplitude, amplitude / factor]
    if with_rate:
        parts.append(amplitude * factor)
    rows = real_rows(np.concatenate(parts, axis=1))
    modes = amplitude.shape[1]
    speed = run.speed_at(time)[:, None]
    push = loads.push[run.operation] * run.acceleration
    value, rate = np.empty((2, len(time), modes))
    step = max(1, _BLOCK // (int(np.max(loads.orders, initial=0)) + 1))
    for start in range(0, len(time), step):
        part = slice(start, start + step)
        sums = order_waves(run.angle_at(time[part]), loads.orders) @ rows
        plain, w = sums[:, :modes], speed[part]
        value[part] = w**2 * plain + run.acceleration * sums[:, modes : 2 * modes] + push
        if with_rate:
            rate[part] = w**3 * sums[:, 2 * modes :] + 3.0 * run.acceleration * w * plain
    return value, rate if with_rate else value

"""Speed against error of every way to the running state of the compressor of Herold (1977).

Each way goes from the parameters of the machine to ten levels of the shell's acceleration. The
yardstick is the published method: Euler's rule at half a millisecond, three turns, in float64, one
machine at a time, with the published analyser that integrates twenty products step by step; beside
it the same march with one analysis at its end, which is kinder to it. Least CPU time of some
repeats; ratios count. Truth by collocation with 14 points and by an independent integration.
"""

import os
import sys
import time
from collections.abc import Callable
from math import cos, pi, sin
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from exact_roll import exact_levels, exact_turn
from roll_machines import FIRST_MASS, SECOND_MASS, SYNCHRONOUS, source_drive, source_machine

from vibecalc.response.roll.fourier_state import fourier_state
from vibecalc.response.roll.machine import RollMachine, as_batch
from vibecalc.response.roll.march import march_to_repeat
from vibecalc.response.roll.march_scalar import running
from vibecalc.response.roll.quick import quick_spectrum, quick_turn
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.running import running_state
from vibecalc.response.roll.shooting_state import shooting_state
from vibecalc.response.roll.steady import started_momentum, steady_state
from vibecalc.response.roll.turn import Turn, harmonics, level

ORDERS = np.arange(1, 11)
SINGLE, DRIVE = source_machine(), source_drive()
MACHINE = as_batch(SINGLE)
STEP = 0.5e-3
RODS = np.linspace(0.2, 0.6, 1000)
BLOCK = 128


class Way(NamedTuple):
    """A method with its dial, what does it, and how often it is repeated."""

    name: str
    levels: Callable[[], np.ndarray]
    repeats: int = 40


def seen(turn: Turn, machine: RollMachine = MACHINE) -> np.ndarray:
    """Levels (..., 10) from a turn."""
    read = readings(machine, DRIVE, turn, pistons=False)
    return level(harmonics(turn, read.shell_acceleration, ORDERS))


def collocated(points: int, tolerance: float, machine: RollMachine = MACHINE) -> np.ndarray:
    """Panels split at every kink."""
    found = steady_state(machine, DRIVE, points, started_at=SYNCHRONOUS, tolerance=tolerance)
    return seen(found.turn, machine)


def unsplit(points: int) -> np.ndarray:
    """The same without panels split at kinks of the motor's curve."""
    from vibecalc.numerics.periodic_collocation import solve_periodic
    from vibecalc.numerics.periodic_panels import running_integral
    from vibecalc.response.roll.problem import roll_problem
    from vibecalc.response.roll.rates import shell_speed

    momentum = started_momentum(MACHINE, SYNCHRONOUS)
    problem, rates = roll_problem(MACHINE, DRIVE, momentum)
    whole = problem._replace(switch=None, thresholds=None)
    found = solve_periodic(whole, points, [0.99 * SYNCHRONOUS], tolerance=1e-6)
    speed, nodes = found.stages[..., 0], found.nodes
    time_, ends = running_integral(found.edges, 1.0 / speed)
    flat = speed.reshape(1, -1)
    shell = shell_speed(rates.place(nodes), momentum, flat)
    turn = Turn(
        nodes.reshape(1, -1), found.weights.reshape(1, -1), time_.reshape(1, -1), flat, shell,
        np.zeros_like(flat), ends[:, -1],
    )  # fmt: skip
    return seen(turn)[0]


def marched(method: str, step: float = STEP, turns: int | None = 3, repeats: float = 1e-5):
    """A march in time, analysed once over its last turn."""
    found = march_to_repeat(
        SINGLE, DRIVE, method, started_at=SYNCHRONOUS, step=step, turns=turns, repeats=repeats
    )
    turn = Turn(*(None if part is None else np.asarray(part)[None] for part in found.turn))
    return level(harmonics(turn, found.shell_acceleration[None], ORDERS))[0]


def published() -> np.ndarray:
    """Three turns of Euler's rule with twenty integrals, window and phase as published."""
    rates = running(SINGLE, DRIVE)
    b, w, theta, s, clock = 0.0, SYNCHRONOUS, 0.0, 0.0, 0.0
    begun, period, turns = 0.0, 1.0, 0
    cosines, sines = [0.0] * 10, [0.0] * 10
    while True:
        if b >= 2.0 * pi * (turns + 1):
            turns += 1
            last, period, begun = period, clock - begun, clock
            if turns == 3:
                break
            cosines, sines = [0.0] * 10, [0.0] * 10
        crank, shell = rates(b, w, theta, s)
        phase = 2.0 * pi * (clock - begun) / period
        for n in range(10):
            cosines[n] += STEP * shell * cos((n + 1) * phase)
            sines[n] += STEP * shell * sin((n + 1) * phase)
        b += STEP * w
        theta += STEP * s
        w += STEP * crank
        s += STEP * shell
        clock += STEP
    assert last > 0.0
    return level(np.hypot(cosines, sines) * (2.0 / period))


def quick(points: int) -> np.ndarray:
    """The coarse march over the crank angle."""
    turn = quick_turn(MACHINE, DRIVE, SYNCHRONOUS, points=points)
    assert turn is not None
    return level(quick_spectrum(turn, 10))


def ways() -> list[Way]:
    """All that are compared; the first two are the yardsticks."""
    momentum = started_momentum(MACHINE, SYNCHRONOUS)
    found = [
        Way("euler 0.5 ms, as published", published, 12),
        Way("euler 0.5 ms, analysed once", lambda: marched("euler"), 12),
        Way("euler 50 us, 3 turns", lambda: marched("euler", 5e-5), 2),
        Way("rk4 0.5 ms, 3 turns", lambda: marched("rk4"), 8),
        Way("rk4 50 us, 3 turns", lambda: marched("rk4", 5e-5), 2),
        Way("dop853 1e-8, 3 turns", lambda: marched("dop853"), 2),
        Way("dop853 1e-8, until it repeats", lambda: marched("dop853", turns=None), 2),
        Way("shooting, 4 steps on 10 degrees",
            lambda: seen(shooting_state(MACHINE, DRIVE, 4, momentum).turn)[0], 2),
        Way("shooting, 16 steps on 10 degrees",
            lambda: seen(shooting_state(MACHINE, DRIVE, 16, momentum).turn)[0], 1),
    ]  # fmt: skip
    for points in (91, 361, 1441):
        found.append(
            Way(
                f"fourier, {points} points",
                lambda n=points: seen(fourier_state(MACHINE, DRIVE, n, momentum).turn)[0],
                8 if points < 1000 else 1,
            )
        )
    found += [Way(f"quick march, {n} angles", lambda n=n: quick(n), 200) for n in (72, 144, 288)]
    found += [Way(f"collocation, {n} points, unsplit", lambda n=n: unsplit(n)) for n in (1, 2, 4)]
    for points, tolerance in (
        (1, 1e-3), (2, 1e-5), (3, 1e-7), (4, 1e-9), (5, 1e-11), (6, 1e-11), (8, 1e-13)
    ):  # fmt: skip
        found.append(
            Way(
                f"collocation, {points} points, split",
                lambda n=points, tol=tolerance: collocated(n, tol)[0],
            )
        )
    found.append(Way("collocation to 1e-10, with estimates and multipliers", to_tolerance, 20))
    return found


def to_tolerance() -> np.ndarray:
    """What a run does: two numbers of points, multipliers, stability."""
    found = running_state(MACHINE, DRIVE, rtol=1e-10, orders=10, started_at=SYNCHRONOUS)
    return seen(found.state.turn)[0]


def timed(every: list[Way]) -> dict[str, float]:
    """Least CPU seconds of each; the ways take turns, so that a busy moment hits them all."""
    best: dict[str, float] = {}
    for _ in range(3):
        for way in every:
            for _ in range(way.repeats):
                started = time.process_time()
                way.levels()
                spent = time.process_time() - started
                best[way.name] = min(best.get(way.name, spent), spent)
    return best


def batch(rods: np.ndarray) -> np.ndarray:
    """Levels of machines with these rods, in blocks."""
    parts = [rods[k : k + BLOCK] for k in range(0, len(rods), BLOCK)]
    return np.concatenate([collocated(6, 1e-11, with_rods(part)) for part in parts])


def with_rods(rods: np.ndarray) -> RollMachine:
    """One machine for each rod length."""
    masses = np.tile([FIRST_MASS, SECOND_MASS], (len(rods), 1))
    return source_machine(rod_length=rods, reciprocating_mass=masses)


def rates() -> tuple[float, float, float]:
    """Machines per second: in one batch, one after another; largest difference in dB."""
    together = alone = np.inf
    some = RODS[::10]
    for _ in range(3):
        started = time.process_time()
        whole = batch(RODS)
        together = min(together, (time.process_time() - started) / len(RODS))
        started = time.process_time()
        single = [collocated(6, 1e-11, with_rods(some[k : k + 1]))[0] for k in range(len(some))]
        alone = min(alone, (time.process_time() - started) / len(some))
    return 1.0 / together, 1.0 / alone, float(np.max(np.abs(whole[::10] - np.array(single))))


def sweep_rates() -> tuple[float, float]:
    """Points per second of `vibecalc sweep` over rods: by arrays, and by runs one after another."""
    from sweep import Sweep, make_design, plain

    from vibecalc.study.load import load_checked
    from vibecalc.study.sweep.arrays import ArrayEvaluator

    (loaded,) = load_checked([Path(__file__).resolve().parents[1] / "cases" / "roll.toml"])
    axis = {"key": "machine.crank_train.rod_length", "from": 0.2, "to": 0.6, "points": 1000}
    design = make_design(Sweep.model_validate({"axes": [axis]}), loaded.resolved)
    keep = ("response/roll/level/shell_acceleration", "response/roll/speed")
    some = np.arange(0, 1000, 40)
    best = [np.inf, np.inf]
    for _ in range(2):
        for place, (count, work) in enumerate(
            (
                (1000, lambda: ArrayEvaluator(loaded, design, keep)(np.arange(1000))),
                (len(some), lambda: plain(loaded, design, keep, some)),
            )
        ):
            started = time.process_time()
            work()
            best[place] = min(best[place], (time.process_time() - started) / count)
    return 1.0 / best[0], 1.0 / best[1]


def main() -> None:
    """Print the table, how two independent ways agree, and the rates of batches."""
    truth = collocated(14, 1e-13)[0]
    other = exact_levels(exact_turn(SINGLE, DRIVE, started_at=SYNCHRONOUS), ORDERS)
    print(f"two independent ways agree to {np.max(np.abs(truth - other)):.0e} dB")
    every = ways()
    seconds = timed(every)
    lean = seconds[every[1].name]
    first = seconds[every[0].name]
    print(f"{'method':<52} {'ms':>9} {'worst dB':>9} {'/ published':>12} {'/ analysed once':>16}")
    for way in every:
        spent, error = seconds[way.name], float(np.max(np.abs(way.levels() - truth)))
        print(
            f"{way.name:<52} {1e3 * spent:9.3f} {error:9.1e} {spent / first:12.3f} "
            f"{spent / lean:16.3f}"
        )
    together, alone, apart = rates()
    print(f"1000 rods, six points: {together:.0f} a second in batches, {alone:.0f} one by one "
          f"(ratio {together / alone:.1f}, apart {apart:.0e} dB)")  # fmt: skip
    arrays, plain_ = sweep_rates()
    print(f"vibecalc sweep of them: {arrays:.0f} points a second by arrays, {plain_:.0f} by runs "
          f"(ratio {arrays / plain_:.1f})")  # fmt: skip


if __name__ == "__main__":
    main()

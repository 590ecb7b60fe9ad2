"""Speed against error of every way to the running state of the compressor of Herold (1977).

Each way goes from the parameters of the machine to ten levels of the shell's acceleration. The
yardstick is the published method: Euler's rule at half a millisecond, three turns, in float64, one
machine at a time, with the published analyser that integrates twenty products step by step; next to
it the same march with one analysis at its end, which is kinder to it. Least CPU time of some
repeats; ratios count. Truth by collocation with 14 points and by an independent integration.
"""

import os
import sys
from collections.abc import Callable
from math import cos, pi, sin
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from exact_roll import exact_levels, exact_turn
from roll_machines import (
    FIRST_MASS,
    SECOND_MASS,
    SYNCHRONOUS,
    quick_spectrum,
    source_drive,
    source_machine,
)
from rows import Report, Row, Table, digits, reported, seconds
from timing import in_turns

from vibecalc.roll.between_kinks import running
from vibecalc.roll.march import march_to_repeat
from vibecalc.roll.mechanism import AngleTerms, RollMachine, as_batch
from vibecalc.roll.methods import fourier_state, shooting_state
from vibecalc.roll.running import running_state
from vibecalc.roll.steady import quick_turn, started_momentum, steady_state
from vibecalc.roll.turn import Turn, harmonics, level, readings

ORDERS = np.arange(1, 11)
SINGLE, DRIVE = source_machine(), source_drive()
MACHINE = as_batch(SINGLE)
STEP = 0.5e-3
RODS = np.linspace(0.2, 0.6, 1000)
BLOCK = 128


class Way(NamedTuple):
    """A method with its setting, what does it, and how often it is repeated."""

    name: str
    levels: Callable[[], np.ndarray]
    repeats: int = 20


PUBLISHED, LEAN = "Euler 0.5 ms, as published", "Euler 0.5 ms, analysed once"
SCIPY, QUICK = "DOP853 rtol 1e-8, until it repeats", "quick march, 72 angles"
FOUR, SIX = "collocation, 4 points, split", "collocation, 6 points, split"
WHOLE = "to 1e-10, with estimates and multipliers"


def seen(turn: Turn, machine: RollMachine = MACHINE, place: AngleTerms | None = None) -> np.ndarray:
    """Levels (..., 10) from a turn; `place` are its terms of the angle, if the method has them."""
    read = readings(machine, DRIVE, turn, pistons=False, place=place)
    return level(harmonics(turn, read.shell_acceleration, ORDERS))


def collocated(points: int, tolerance: float, machine: RollMachine = MACHINE) -> np.ndarray:
    """Panels split at every kink."""
    found = steady_state(machine, DRIVE, points, started_at=SYNCHRONOUS, tolerance=tolerance)
    return seen(found.turn, machine, found.place)


def unsplit(points: int) -> np.ndarray:
    """The same without panels split at kinks of the motor's curve."""
    from vibecalc.numerics.periodic.collocation import solve_periodic
    from vibecalc.numerics.periodic.panels import running_integral
    from vibecalc.roll.rates import roll_problem, shell_speed

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
        Way(PUBLISHED, published),
        Way(LEAN, lambda: marched("euler")),
        Way("Euler 50 us, 3 turns", lambda: marched("euler", 5e-5), 4),
        Way("RK4 0.5 ms, 3 turns", lambda: marched("rk4"), 10),
        Way("RK4 50 us, 3 turns", lambda: marched("rk4", 5e-5), 3),
        Way(SCIPY, lambda: marched("dop853", turns=None), 3),
        Way("shooting, 4 steps on 10 degrees",
            lambda: seen(shooting_state(MACHINE, DRIVE, 4, momentum).turn)[0], 4),
        Way("shooting, 16 steps on 10 degrees",
            lambda: seen(shooting_state(MACHINE, DRIVE, 16, momentum).turn)[0], 2),
    ]  # fmt: skip
    for points, repeats in ((91, 20), (361, 8), (1441, 2)):
        found.append(
            Way(
                f"Fourier, {points} points",
                lambda n=points: seen(fourier_state(MACHINE, DRIVE, n, momentum).turn)[0],
                repeats,
            )
        )
    found += [Way(f"quick march, {n} angles", lambda n=n: quick(n), 60) for n in (72, 144, 288)]
    found += [
        Way(f"collocation, {n} point{'s' * (n > 1)}, unsplit", lambda n=n: unsplit(n))
        for n in (1, 2, 4)
    ]
    for points, tolerance in (
        (1, 1e-3), (2, 1e-5), (3, 1e-7), (4, 1e-9), (5, 1e-11), (6, 1e-11), (8, 1e-13)
    ):  # fmt: skip
        found.append(
            Way(
                f"collocation, {points} point{'s' * (points > 1)}, split",
                lambda n=points, tol=tolerance: collocated(n, tol)[0],
            )
        )
    found.append(Way(WHOLE, to_tolerance))
    return found


def to_tolerance() -> np.ndarray:
    """What a run does: two numbers of points, multipliers, stability."""
    found = running_state(MACHINE, DRIVE, rtol=1e-10, orders=10, started_at=SYNCHRONOUS)
    return seen(found.state.turn)[0]


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
    some = RODS[::10]
    whole: list[np.ndarray] = []
    single: list[list[np.ndarray]] = []

    def one_by_one() -> None:
        alone = [some[k : k + 1] for k in range(len(some))]
        single.append([collocated(6, 1e-11, with_rods(one))[0] for one in alone])

    ways = {"together": lambda: whole.append(batch(RODS)), "alone": one_by_one}
    took = in_turns(ways, 2)
    apart = float(np.max(np.abs(whole[0][::10] - np.array(single[0]))))
    return len(RODS) / took["together"], len(some) / took["alone"], apart


def sweep_rates() -> tuple[float, float]:
    """Points per second of `vibecalc sweep` over rods: by arrays, and by runs one after another."""
    from sweep import Sweep, make_design, plain

    from vibecalc.core.study.execute import load_checked
    from vibecalc.core.study.sweep.evaluate import ArrayEvaluator

    (loaded,) = load_checked([Path(__file__).resolve().parents[1] / "cases" / "roll.toml"])
    axis = {"key": "machine.crank_train.rod_length", "from": 0.2, "to": 0.6, "points": 1000}
    design = make_design(Sweep.model_validate({"axes": [axis]}), loaded.resolved)
    keep = ("response/roll/level/shell_acceleration", "response/roll/speed")
    some = np.arange(0, 1000, 40)
    took = in_turns(
        {
            "arrays": lambda: ArrayEvaluator(loaded, design, keep)(np.arange(1000)),
            "plain": lambda: plain(loaded, design, keep, some),
        },
        2,
    )
    return 1000 / took["arrays"], len(some) / took["plain"]


def measure() -> Report:
    """Every way, how two independent ways agree, and the rates of batches."""
    truth = collocated(14, 1e-13)[0]
    other = exact_levels(exact_turn(SINGLE, DRIVE, started_at=SYNCHRONOUS), ORDERS)
    agreed = float(np.max(np.abs(truth - other)))
    every = ways()
    took = in_turns({w.name: w.levels for w in every}, {w.name: w.repeats for w in every})
    errors = {way.name: float(np.max(np.abs(way.levels() - truth))) for way in every}
    lines = [
        [name, seconds(took[name]), f"{errors[name]:.1e}",
         digits(took[name] / took[PUBLISHED]), digits(took[name] / took[LEAN])]
        for name in took
    ]  # fmt: skip

    def row(way: str, yardstick: str, words: str, aim: float, cost: bool = False) -> Row:
        ratio = took[way] / took[yardstick] if cost else took[yardstick] / took[way]
        error = f"{errors[way]:.1e} dB ({errors[yardstick]:.1e} dB)"
        note = f"{seconds(took[way])} against {seconds(took[yardstick])}"
        return Row("ten levels of one machine", way, words, ratio, aim, error, note, cost)

    euler = "the source's Euler 0.5 ms with its analyser"
    together, alone, apart = rates()
    arrays, runs = sweep_rates()
    rods = [
        Row("levels for 1000 rods", "collocation, 6 points, in blocks of 128",
            "the same one after another", together / alone, 10.0, f"{apart:.0e} dB apart",
            f"{together:.0f} machines a second against {alone:.0f}"),
        Row("levels for 1000 rods", "vibecalc sweep by arrays", "runs one after another",
            arrays / runs, 10.0, "within the tolerance",
            f"{arrays:.0f} machines a second against {runs:.0f}"),
        Row("levels for 1000 rods", "collocation, 6 points, in blocks of 128",
            "scipy DOP853 rtol 1e-8, one machine", took[SCIPY] * together, 50.0,
            f"{errors[SIX]:.1e} dB ({errors[SCIPY]:.1e} dB)", "a machine of the batch"),
    ]  # fmt: skip
    rows = [
        row(SIX, PUBLISHED, euler, 3.0, cost=True),
        row(QUICK, PUBLISHED, euler, 8.0),
        row(FOUR, SCIPY, "scipy DOP853 rtol 1e-8", 60.0),
        *rods,
    ]
    columns = ["method", "time", "worst dB", "time / as published", "time / analysed once"]
    return Report(
        "Roll of a compressor",
        "Running state of the machine of Herold (1977), from its parameters to ten levels of the "
        f"shell; two independent ways to the truth agree to {agreed:.0e} dB. In brackets the "
        "error of the yardstick.",
        rows,
        [Table("Every way", columns, lines)],
        ["One machine alone stays within 50 times of scipy: what is left are many numpy calls on "
         "small arrays, hardly fewer with fewer points; docs/accuracy.md has the shares."]
        if rows[2].missed else [],
    )  # fmt: skip


if __name__ == "__main__":
    reported(measure)

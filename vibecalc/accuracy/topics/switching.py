"""Topics of switching: the motion after a change at once, and during a run-down to rest."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.change_exactly import DIGITS, exact_change
from vibecalc.accuracy.yardsticks.change_marches import (
    integrator_ladders,
    marcher,
    superposed,
)
from vibecalc.accuracy.yardsticks.changes import Change, change_of
from vibecalc.pipeline.scene import Scene
from vibecalc.response.switching.free_motion import propagator
from vibecalc.response.switching.march import driven_part
from vibecalc.response.switching.run import PANEL_PHASE, panel_grid, runs_of
from vibecalc.response.switching.steady import steady_motion, steady_state
from vibecalc.response.switching.system import Piece

#: turns after a change at once, times in each
TURNS, PER_TURN = 2, 16
#: a run-down is watched for a part of it, so long that it passes some modes
PASSAGE = 0.1
PASSAGE_TIMES = 20
TIGHT = 3e-14
#: points of the quadrature on a panel, and those that check it
GAUSS = 7.0 + 6.0


def topics(scene: Scene) -> list[Topic]:
    """The change from the first to the second operation, and the beginning of the real one."""
    change = change_of(scene)
    response = scene.case.response
    if change is None or response is None or response.switching is None:
        return []
    found = [_at_once(change)]
    if response.switching.run_down > 0.0:
        found.append(_run_down(change, float(response.switching.run_down)))
    return found


def _at_once(change: Change) -> Topic:
    count = TURNS * PER_TURN
    times = 2.0 * np.pi / (PER_TURN * change.speed) * np.arange(1, count + 1)
    march = marcher(change, 1, 0.0, times)

    def closed(_: float) -> Answer:
        old, new = (steady_motion(change.system, change.modal, k, change.speed) for k in (0, 1))
        here = np.asarray(change.angle)
        first, second = (
            steady_state(motion, change.modal.orders, change.speed, here) for motion in (old, new)
        )
        angle = change.angle + change.speed * times
        forced = steady_state(new, change.modal.orders, change.speed, angle)
        free = propagator(change.system, times)(first - second)
        moved = (forced + free)[..., 0] @ change.system.shape.T
        return Answer(moved[:, :3], count)

    def reference() -> Reference:
        values = exact_change(change, times)
        agreement = _apart(values, march("DOP853", TIGHT).values)
        return Reference(
            values,
            agreement,
            f"modal closed form in {DIGITS} digits (mpmath); DOP853 at rtol {TIGHT:g} on the "
            f"equations of motion agrees to {agreement:.1e}",
        )

    steps = tuple(float(count * 2**k) for k in range(7))
    return Topic(
        stage="switching",
        name="change at once",
        words=f"translations of the body at {count} times of the first {TURNS} turns after the "
        f"change of operation",
        quantity="response/switching/instant/translation_high, translation_low",
        unit="m",
        work="evaluations of the right-hand side",
        reference=reference,
        ladders=(
            Ladder(
                "closed form of modes",
                "steady motion under the second operation and the free motion of each mode",
                "",
                NOTHING_TO_SET,
                closed,
                default=1.0,
                citation="docs/theory.md; cf. Goloskokow and Filippow (1971)",
            ),
            *integrator_ladders(march, steps),
        ),
    )


def _apart(values: np.ndarray, other: np.ndarray) -> float:
    return float(np.max(np.abs(other - values)) / np.max(np.abs(values)))


def _run_down(change: Change, duration: float) -> Topic:
    span = PASSAGE * duration
    acceleration = -change.speed / duration
    times = span / PASSAGE_TIMES * np.arange(1, PASSAGE_TIMES + 1)
    march = marcher(change, 0, acceleration, times)
    turns = span * (change.speed + 0.5 * acceleration * span) / (2.0 * np.pi)
    pieces = [Piece(span, change.speed, change.speed + acceleration * span, 0)]

    def quadrature(phase: float) -> Answer:
        run = runs_of(pieces, change.angle)[0]
        grid = panel_grid(change.system, change.modal, run, span, phase)
        grid = np.union1d(grid, times[times < span])
        first = steady_motion(change.system, change.modal, 0, change.speed)
        state = steady_state(first, change.modal.orders, change.speed, np.asarray(change.angle))
        step = np.diff(grid)
        gained = driven_part(change.system, change.modal, run, grid[:-1], step)
        moved = propagator(change.system, step)
        shown = []
        for k in range(len(step)):
            own = type(moved)(*(part[k] for part in moved))
            state = own(state) + gained[k]
            if np.any(np.abs(times - grid[k + 1]) <= 1e-12 * span):
                shown.append(change.system.shape @ state[:, 0])
        return Answer(np.array(shown)[:, :3], GAUSS * len(step))

    coarse = PASSAGE_TIMES * int(np.ceil(8.0 * turns / PASSAGE_TIMES))
    steps = tuple(float(coarse * 2**k) for k in range(6))

    def reference() -> Reference:
        values = quadrature(0.5 * PANEL_PHASE).values
        agreement = _apart(values, superposed(change, 0, acceleration, times))
        return Reference(
            values,
            agreement,
            "quadrature of the exact propagator on panels of half the length; Duhamel's integral "
            "with matrix exponentials of the equations of motion, without modes, agrees to "
            f"{agreement:.1e}",
        )

    return Topic(
        stage="switching",
        name="run-down",
        words=f"translations of the body at {PASSAGE_TIMES} times of the first {span:.3g} s of "
        f"the run-down, {turns:.3g} turns",
        quantity="response/switching/reversal/translation_high, translation_low",
        unit="m",
        work="evaluations of the load",
        reference=reference,
        ladders=(
            Ladder(
                "quadrature of the propagator",
                "free motion in closed form, loads by Gauss's rule on panels",
                "phase of a panel [rad]",
                (32.0, 16.0, 8.0, 4.0, PANEL_PHASE, 0.5 * PANEL_PHASE),
                quadrature,
                default=PANEL_PHASE,
                theory="geometric",
                citation="docs/theory.md; cf. Goloskokow and Filippow (1971)",
            ),
            *integrator_ladders(march, steps),
        ),
        default_extra=2.0,
        default_why="panels are safe for a load all at the fastest rate, of which twice as long "
        "ones would miss 4e-11, and short enough to bound the peaks between them",
    )

"""Topics of the roll: the spectrum of the shell's acceleration, the largest slip and its place."""

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks import roll_collocations as ways
from vibecalc.accuracy.yardsticks import roll_marches as marches
from vibecalc.accuracy.yardsticks.roll_retrace import departure, retrace
from vibecalc.accuracy.yardsticks.roll_setup import RollSetup, roll_setup, spectrum
from vibecalc.accuracy.yardsticks.roll_slip import slip_topic
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.scene import Scene
from vibecalc.response.roll.steady import steady_state

#: Gauss points of the reference, and of what it is held against beside the march
_POINTS, _FEWER = 14, 11
#: evaluations of a march that a rung may take
_MOST = 90_000
#: work of a run over that of the cheapest number of points: 1.4 to 2.0 in the shipped cases
_EXTRA = 2.5
#: turns that an adaptive march of scipy may take
_FEW_TURNS = 8
_HEROLD = "Herold (1977), appendix A"
_ASCHER = "Ascher, Mattheij and Russell (1995), chapter 5"


def topics(scene: Scene) -> list[Topic]:
    """What [response.roll] asks; none without it."""
    response = scene.case.response
    if response is None or response.roll is None:
        return []
    setup = roll_setup(scene)
    return [_spectrum_topic(setup), slip_topic(setup)]


def _spectrum_topic(setup: RollSetup) -> Topic:
    return Topic(
        stage="roll",
        name="spectrum",
        words=f"harmonics 1 to {len(setup.orders)} of the shell's angular acceleration",
        quantity="response/roll/shell_acceleration",
        unit="rad/s^2",
        work="evaluations of the right-hand side at one crank angle",
        reference=lambda: _reference(setup),
        ladders=(*_collocations(setup), *_others(setup), *_marches(setup)),
        default_extra=_EXTRA,
        default_why="other numbers of points prove the error, and the multipliers the stability",
    )


def _reference(setup: RollSetup) -> Reference:
    found, fewer = (
        steady_state(
            setup.machine, setup.drive, points,
            started_at=setup.started_at, start=setup.running.state,
        )
        for points in (_POINTS, _FEWER)
    )  # fmt: skip
    if not (found.found[0] and fewer.found[0]):
        raise NumericalFailure(f"collocation with {_POINTS} points loses the running state")
    values = spectrum(setup, found.turn)
    largest = float(np.max(np.abs(values)))
    apart = float(np.max(np.abs(values - spectrum(setup, fewer.turn)))) / largest
    if setup.drive.fluxes:
        other = departure(setup, found)
        words = "an eighth-order Runge-Kutta march of every panel"
    else:
        again = retrace(setup, found)
        other = float(np.max(np.abs(values - again.values))) / largest + again.gap
        words = "an eighth-order Runge-Kutta march of the turn, equations of its own, in time"
    agreement = max(other, apart if setup.drive.fluxes else 0.0, 16.0 * EPSILON)
    return Reference(
        values, agreement, f"collocation with {_POINTS} points a panel, against {words}"
    )


def _collocations(setup: RollSetup) -> list[Ladder]:
    own = 1e-9 if setup.points else setup.rtol
    as_run = ways.AsRun(setup)
    found = [
        Ladder(
            "collocation to a tolerance",
            "points are added until two numbers of them agree; multipliers; as a run does",
            "relative tolerance",
            tuple(sorted({1e-3, 1e-5, 1e-7, 1e-9, 1e-11, own}, reverse=True)),
            as_run,
            default=None if setup.points else own,
            citation=_ASCHER,
        )
    ]
    counts = {1, 2, 3, 4, 5, 6, 8, 10} | ({setup.points} if setup.points else set())
    solve = ways.lifted if setup.drive.fluxes else ways.split
    found.append(
        Ladder(
            "collocation, split",
            "one number of Gauss points on each panel, panels split at every kink",
            "points a panel",
            tuple(float(count) for count in sorted(counts)),
            lambda points: solve(setup, points),
            default=float(setup.points) if setup.points else None,
            theory="geometric",
            citation=_ASCHER,
        )
    )
    return found


def _others(setup: RollSetup) -> list[Ladder]:
    if setup.drive.circuit is not None:
        return [
            Ladder(
                "steady curve of the motor",
                "the same without the transients of the fluxes",
                "points a panel",
                (2.0, 4.0, 6.0, 8.0),
                lambda points: ways.steady_curve(setup, points),
            )
        ]
    found = [
        Ladder(
            "Fourier collocation",
            "evenly spaced crank angles, a dense system; kinks leave order 2 in the end",
            "points a turn",
            (45.0, 91.0, 181.0, 361.0) + (() if setup.mounted else (721.0,)),
            lambda points: ways.fourier(setup, points),
        ),
        Ladder(
            "shooting",
            "Runge-Kutta over the angle, Newton's method on the start; kinks leave order 2",
            "steps a panel",
            (1.0, 2.0, 4.0) + (() if setup.mounted else (8.0,)),
            lambda steps: ways.shooting(setup, steps),
        ),
    ]
    if len(setup.drive.motor.threshold):
        found.append(
            Ladder(
                "collocation, not split",
                "panels between the nodes of the gas tables, blind to the motor's kinks",
                "points a panel",
                (1.0, 2.0, 3.0, 4.0, 6.0, 8.0),
                lambda points: ways.unsplit(setup, points),
            )
        )
    if not setup.mounted:
        found.append(
            Ladder(
                "quick march of the energy",
                "Adams and Bashforth over even angles; the start of the others",
                "angles a turn",
                (36.0, 72.0, 144.0, 288.0, 576.0),
                lambda points: ways.quick(setup, points),
                theory="order 2",
            )
        )
    return found


def _marches(setup: RollSetup) -> list[Ladder]:
    if setup.drive.circuit is not None:
        return []
    seconds = setup.turns * 2.0 * np.pi / setup.speed
    found = [
        Ladder(
            "Euler, as published",
            "three turns, the integrals of the analyser summed step by step",
            "time step [s]",
            (2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4),
            lambda step: marches.as_published(setup, step),
            citation=_HEROLD,
        )
    ]
    for name, method, stages, theory in (
        ("Euler", "euler", 1, "order 1"),
        ("Runge-Kutta", "rk4", 4, ""),
    ):
        steps = tuple(
            step
            for step in (2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5)
            if stages * seconds / step <= _MOST
        )
        if len(steps) < 2:
            continue

        def solve(step: float, method: str = method) -> Answer:
            return marches.fixed_steps(setup, method, step)

        found.append(
            Ladder(
                f"{name}, fixed steps",
                f"{setup.turns} turns in time, the last one analysed; order 2 at best across kinks",
                "time step [s]",
                steps,
                solve,
                theory=theory,
            )
        )
    if setup.turns <= _FEW_TURNS:
        for method, tolerances in (
            ("RK45", (1e-3, 1e-5, 1e-7)),
            ("DOP853", (1e-3, 1e-5, 1e-7, 1e-9)),
        ):

            def adapt(rtol: float, method: str = method) -> Answer:
                return marches.adaptive(setup, method, rtol)

            found.append(
                Ladder(
                    f"scipy {method}",
                    f"{setup.turns} turns over the crank angle, the last one read at Gauss points",
                    "relative tolerance",
                    tolerances,
                    adapt,
                )
            )
    return found

"""Accuracy of the running state: the spectrum of the shell's acceleration and the largest slip."""

import numpy as np

from vibecalc.core.accuracy.other_searches import cyclic_parabola_maximum
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.roll.accuracy import by_other_means as marches
from vibecalc.roll.accuracy import by_other_means as ways
from vibecalc.roll.accuracy.by_other_means import (
    RollSetup,
    departure,
    retrace,
    roll_setup,
    spectrum,
)
from vibecalc.roll.running import speed_of_state
from vibecalc.roll.steady import steady_state
from vibecalc.roll.turn import peak

# ----------------------------------------------------------------------------
# Topics of the roll: the spectrum of the shell's acceleration, the largest slip and its place.
# ----------------------------------------------------------------------------

#: Gauss points of the reference, and of what it is held against next to the march
_POINTS, _FEWER = 14, 11
#: evaluations of a march that a level may take
_MOST = 90_000
#: work of a run over that of the cheapest number of points: 1.4 to 2.0 in the shipped cases
_EXTRA = 2.5
#: turns that an adaptive march of scipy may take
_FEW_TURNS = 8
_HEROLD = "Herold (1977), appendix A"
_ASCHER = "Ascher, Mattheij and Russell (1995), chapter 5"


def roll_topics(scene: Scene) -> list[Topic]:
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
        reference=lambda: _spectrum_reference(setup),
        solvers=(*_collocations(setup), *_others(setup), *_marches(setup)),
        default_extra=_EXTRA,
        default_why="other numbers of points prove the error, and the multipliers the stability",
    )


def _spectrum_reference(setup: RollSetup) -> Reference:
    found, fewer = (
        steady_state(
            setup.machine, setup.drive, points,
            started_at=setup.started_at, start=setup.running.state,
        )
        for points in (_POINTS, _FEWER)
    )  # fmt: skip
    if not (found.solved[0] and fewer.solved[0]):
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


def _collocations(setup: RollSetup) -> list[Solver]:
    own = 1e-9 if setup.points else setup.rtol
    as_run = ways.AsRun(setup)
    found = [
        Solver(
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
        Solver(
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


def _others(setup: RollSetup) -> list[Solver]:
    if setup.drive.circuit is not None:
        return [
            Solver(
                "steady curve of the motor",
                "the same without the transients of the fluxes",
                "points a panel",
                (2.0, 4.0, 6.0, 8.0),
                lambda points: ways.steady_curve(setup, points),
            )
        ]
    found = [
        Solver(
            "Fourier collocation",
            "evenly spaced crank angles, a dense system; kinks leave order 2 in the end",
            "points a turn",
            (45.0, 91.0, 181.0, 361.0) + (() if setup.mounted else (721.0,)),
            lambda points: ways.fourier(setup, points),
        ),
        Solver(
            "shooting",
            "Runge-Kutta over the angle, Newton's method on the start; kinks leave order 2",
            "steps a panel",
            (1.0, 2.0, 4.0) + (() if setup.mounted else (8.0,)),
            lambda steps: ways.shooting(setup, steps),
        ),
    ]
    if len(setup.drive.motor.threshold):
        found.append(
            Solver(
                "collocation, not split",
                "panels between the nodes of the gas tables, blind to the motor's kinks",
                "points a panel",
                (1.0, 2.0, 3.0, 4.0, 6.0, 8.0),
                lambda points: ways.unsplit(setup, points),
            )
        )
    if not setup.mounted:
        found.append(
            Solver(
                "quick march of the energy",
                "Adams and Bashforth over even angles; the start of the others",
                "angles a turn",
                (36.0, 72.0, 144.0, 288.0, 576.0),
                lambda points: ways.quick(setup, points),
                theory="order 2",
            )
        )
    return found


def _marches(setup: RollSetup) -> list[Solver]:
    if setup.drive.circuit is not None:
        return []
    seconds = setup.turns * 2.0 * np.pi / setup.speed
    found = [
        Solver(
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
            Solver(
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
                Solver(
                    f"scipy {method}",
                    f"{setup.turns} turns over the crank angle, the last one read at Gauss points",
                    "relative tolerance",
                    tolerances,
                    adapt,
                )
            )
    return found


# ----------------------------------------------------------------------------
# The largest slip within a turn and the crank angle at which it is, looked for in several ways.
# ----------------------------------------------------------------------------

_TURN = 2.0 * np.pi
#: looks of a coarse grid before a closer search, and how close that of the reference goes, rad
_COARSE, _CLOSE = 72, 1e-10
#: peaks so far apart, rad, and so much alike are taken for equal; angles examined for that
_AWAY, _ALIKE, _CLOSELY = 0.2, 1e-4, 720
_GRIDS = (36.0, 72.0, 144.0, 360.0, 1440.0, 5760.0)


def slip_topic(setup: RollSetup) -> Topic:
    """Largest slip of the running state of the case, whose own error does not count here."""
    # of two peaks of one height nobody can say which is the largest
    alone = _stands_alone(setup)
    return Topic(
        stage="roll",
        name="largest slip",
        words="largest slip within a turn of the running state that the run found, and where",
        quantity="response/roll/largest_slip",
        unit="rad/s",
        work="examines the slip at one crank angle",
        reference=lambda: _slip_reference(setup, alone),
        solvers=(
            Solver(
                "closer and closer looks",
                "about the highest points of the state, by parabolas; as a run does",
                "",
                NOTHING_TO_SET,
                lambda _: _closer(setup),
                default=NOTHING_TO_SET[0],
            ),
            Solver(
                "grid", "the best of even angles", "angles a turn", _GRIDS,
                lambda points: _grid(setup, int(points)),
            ),
            Solver(
                "grid and parabola", "a parabola through the best and its neighbours",
                "angles a turn", _GRIDS, lambda points: _parabola(setup, int(points)),
            ),
            Solver(
                "scipy from the points",
                "Brent's method bounded by the neighbours of the state's highest point",
                "tolerance of the angle [rad]", (1e-2, 1e-4, 1e-6, 1e-8),
                lambda tolerance: _from_points(setup, tolerance),
            ),
            Solver(
                "scipy minimize_scalar",
                f"{_COARSE} angles, then Brent's method bounded by the neighbours of the best",
                "tolerance of the angle [rad]", (1e-2, 1e-3, 1e-4, 1e-6, 1e-8),
                lambda tolerance: _brent(setup, tolerance),
                citation="Brent (1973), Algorithms for minimization without derivatives, chapter 5",
            ),
        ),
        position="crank angle [rad]" if alone else "",
        default_extra=_EXTRA,
        default_why="up to four peaks are followed, so that of two alike the higher is not "
        "overlooked, to the last digit, and each look has one to either side as a proof",
    )  # fmt: skip


def _slip(setup: RollSetup, angles: FloatArray) -> FloatArray:
    synchronous = float(np.max(setup.drive.synchronous_speed))
    values = evaluate(setup.running.state.solution, np.mod(angles, _TURN))
    return np.asarray(synchronous - values[0, :, 0])


def _stands_alone(setup: RollSetup) -> bool:
    """Whether no slip away from the largest comes near to it."""
    angles = np.linspace(0.0, _TURN, _CLOSELY, endpoint=False)
    values = _slip(setup, angles)
    best = int(np.argmax(values))
    away = np.abs(np.mod(angles - angles[best] + np.pi, _TURN) - np.pi) > _AWAY
    return float(np.max(values[away])) < float(values[best]) * (1.0 - _ALIKE)


def _closer(setup: RollSetup) -> Answer:
    speed = speed_of_state(setup.running.state)
    synchronous = float(np.max(setup.drive.synchronous_speed))
    looks, best, place = 0, -np.inf, 0.0

    def slower(angles: FloatArray) -> FloatArray:
        nonlocal looks, best, place
        values: FloatArray = -speed(angles)
        looks += len(angles)
        at = int(np.argmax(values))
        if values[at] > best:
            best, place = float(values[at]), float(angles[at])
        return values

    turn = setup.running.state.turn
    top, _ = peak(slower, (turn.crank_angle[0], -turn.crank_speed[0]))
    return Answer(np.array([synchronous + top]), float(looks), place % _TURN)


def _grid(setup: RollSetup, points: int) -> Answer:
    angles = np.linspace(0.0, _TURN, points, endpoint=False, dtype=np.float64)
    values = _slip(setup, angles)
    best = int(np.argmax(values))
    return Answer(values[best : best + 1], float(points), float(angles[best]))


def _parabola(setup: RollSetup, points: int) -> Answer:
    found = cyclic_parabola_maximum(lambda at: _slip(setup, at), _TURN, points)
    return Answer(np.array([found.value]), float(found.evaluations), found.position % _TURN)


def _brent(setup: RollSetup, tolerance: float) -> Answer:
    first = _grid(setup, _COARSE)
    place, reach = float(first.position or 0.0), _TURN / _COARSE
    return _between(setup, place - reach, place + reach, tolerance, _COARSE)


def _from_points(setup: RollSetup, tolerance: float) -> Answer:
    turn = setup.running.state.turn
    angles, slowest = turn.crank_angle[0], int(np.argmin(turn.crank_speed[0]))
    step = np.max(np.diff(angles))
    low = angles[slowest - 1] if slowest else angles[0] - step
    high = angles[slowest + 1] if slowest + 1 < len(angles) else angles[-1] + step
    return _between(setup, float(low), float(high), tolerance, 0)


def _between(setup: RollSetup, low: float, high: float, tolerance: float, looks: int) -> Answer:
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda at: -float(_slip(setup, np.array([at]))[0]),
        bounds=(low, high), method="bounded", options={"xatol": tolerance},
    )  # fmt: skip
    return Answer(np.array([-float(found.fun)]), float(looks + found.nfev), float(found.x) % _TURN)


def _slip_reference(setup: RollSetup, alone: bool) -> Reference:
    """A root of dw/db on each panel's polynomial, held against Brent's method."""
    state = setup.running.state
    solution = state.solution
    edges, speeds = solution.edges[0], solution.stages[0, :, :, 0]
    best: tuple[float, float] | None = None
    nodes = gauss_rule(solution.points).dense_nodes
    for panel in np.argsort(np.min(speeds, axis=1))[:3].tolist():
        width = float(edges[panel + 1] - edges[panel])
        if width <= 0.0:
            continue
        values = np.concatenate([solution.left[0, panel, :1], speeds[panel]])
        curve = np.polynomial.Legendre.fit(nodes, values, solution.points, domain=[0.0, 1.0])
        turns = curve.deriv().roots()
        inside = turns.real[(np.abs(turns.imag) < 1e-9) & (turns.real >= 0) & (turns.real <= 1)]
        for place in [0.0, 1.0, *inside.tolist()]:
            found = float(curve(place)), float(edges[panel]) + width * place
            if best is None or found[0] < best[0]:
                best = found
    assert best is not None
    slip = float(np.max(setup.drive.synchronous_speed)) - best[0]
    other = _brent(setup, _CLOSE)
    agreement = abs(slip - float(other.values[0])) / slip
    return Reference(
        np.array([slip]),
        max(agreement, 16.0 * EPSILON),
        "roots of the derivative of the polynomials of the slowest panels, against Brent's method",
        best[1] % _TURN if alone else None,
    )

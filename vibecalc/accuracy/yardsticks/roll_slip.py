"""The largest slip within a turn and the crank angle at which it is, looked for in several ways."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.grids import cyclic_parabola_maximum
from vibecalc.accuracy.yardsticks.roll_setup import RollSetup
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.course import speed_of_state
from vibecalc.response.roll.summit import summit

_TURN = 2.0 * np.pi
#: looks of a coarse grid before a closer search, and how close that of the reference goes, rad
_COARSE, _CLOSE = 72, 1e-10
#: summits so far apart, rad, and so much alike are taken for equal; angles looked at for that
_AWAY, _ALIKE, _CLOSELY = 0.2, 1e-4, 720
#: looks over those of Brent's method from the highest point: 1.0 to 2.2 in the shipped cases
_EXTRA = 2.5
_GRIDS = (36.0, 72.0, 144.0, 360.0, 1440.0, 5760.0)


def slip_topic(setup: RollSetup) -> Topic:
    """Largest slip of the running state of the case, whose own error does not count here."""
    # of two summits of one height nobody can say which is the largest
    alone = _stands_alone(setup)
    return Topic(
        stage="roll",
        name="largest slip",
        words="largest slip within a turn of the running state that the run found, and where",
        quantity="response/roll/largest_slip",
        unit="rad/s",
        work="looks at the slip at one crank angle",
        reference=lambda: _reference(setup, alone),
        ladders=(
            Ladder(
                "closer and closer looks",
                "about the highest points of the state, by parabolas; as a run does",
                "",
                NOTHING_TO_SET,
                lambda _: _closer(setup),
                default=NOTHING_TO_SET[0],
            ),
            Ladder(
                "grid", "the best of even angles", "angles a turn", _GRIDS,
                lambda points: _grid(setup, int(points)),
            ),
            Ladder(
                "grid and parabola", "a parabola through the best and its neighbours",
                "angles a turn", _GRIDS, lambda points: _parabola(setup, int(points)),
            ),
            Ladder(
                "scipy from the points",
                "Brent's method bounded by the neighbours of the state's highest point",
                "tolerance of the angle [rad]", (1e-2, 1e-4, 1e-6, 1e-8),
                lambda tolerance: _from_points(setup, tolerance),
            ),
            Ladder(
                "scipy minimize_scalar",
                f"{_COARSE} angles, then Brent's method bounded by the neighbours of the best",
                "tolerance of the angle [rad]", (1e-2, 1e-3, 1e-4, 1e-6, 1e-8),
                lambda tolerance: _brent(setup, tolerance),
                citation="Brent (1973), Algorithms for minimization without derivatives, chapter 5",
            ),
        ),
        position="crank angle [rad]" if alone else "",
        default_extra=_EXTRA,
        default_why="up to four summits are followed, so that of two alike the higher is not "
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
    top, _ = summit(slower, (turn.crank_angle[0], -turn.crank_speed[0]))
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


def _reference(setup: RollSetup, alone: bool) -> Reference:
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

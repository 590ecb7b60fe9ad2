"""The damper of a shaft line for its strongest order: maps, simplex, evolution, the own search."""

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.grids import Function, parabola_maximum
from vibecalc.accuracy.yardsticks.searches import evolution, nelder_mead
from vibecalc.accuracy.yardsticks.shaft_lines import dense_angles
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.chart import chart_of, valleys
from vibecalc.optimisation.damper.design import design_from
from vibecalc.optimisation.damper.follow import LEVEL, Summits
from vibecalc.optimisation.damper.problem import Damper, Limits, Problem
from vibecalc.optimisation.damper.speed_torque import torque_at
from vibecalc.optimisation.damper.survey import Survey, survey
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.damper_design_problem import build_problem
from vibecalc.pipeline.stages.torsion.curves import stiffness_of
from vibecalc.pipeline.stages.torsion.setup import build_setup
from vibecalc.response.torsion.line import Line

#: values of each variable on the map of the search, of which `design` takes 15
MAPS, TAKEN = (5.0, 9.0, 15.0), 15
GRIDS = (7.0, 11.0, 15.0, 21.0)
SIMPLEX = (1e-1, 1e-2, 1e-4, 1e-6)
GENERATIONS = (1.0, 3.0, 8.0)
#: speeds that guide the search, that a user would take, of the trusted answer
GUIDES, SPEEDS, FINEST = 41, 121, 481
#: shares by which the trusted search starts beside the optimum
BESIDE = 0.2


class _Counted(Survey):
    """A survey that counts the dampers whose summits are looked for; `counts` has one entry."""

    counts: list[int]

    def summits(self, damper: Damper, share: float, tolerance: float = LEVEL) -> Summits:
        self.counts[0] += 1
        return super().summits(damper, share, tolerance)


def topics(scene: Scene) -> list[Topic]:
    """Least largest torque of the order that loads the line most, without limits of the ring."""
    options = scene.case.damper_design
    if options is None:
        return []
    asked = build_problem(build_setup(scene.case), options)
    limits = asked.limits
    if limits.inertia[0] != limits.inertia[1] or limits.stiffness[0] == limits.stiffness[1]:
        return []
    middle = Damper(limits.inertia[0], *(float(np.sqrt(a * b)) for a, b in limits.bounds[1:]))
    place = _strongest(asked.problem, middle)
    problem = asked.problem._replace(
        order=asked.problem.order[[place]],
        torque=asked.problem.torque._replace(
            coefficient=asked.problem.torque.coefficient[:, :, [place]]
        ),
    )
    return [_topic(problem, Limits(limits.inertia, limits.stiffness, limits.damping))]


def _topic(problem: Problem, limits: Limits) -> Topic:
    inertia = limits.inertia[0]
    logarithms = np.log(limits.bounds[1:])

    def searched(points: float) -> Answer:
        prepared = _Counted(*survey(problem, limits, GUIDES))
        prepared.counts = [0]
        seen = chart_of(prepared, int(points))
        found = design_from(prepared, valleys(prepared, seen, 1))
        work = seen.worst.size + prepared.counts[0]
        return Answer(np.array([found.worst]), float(work), found.damper.stiffness)

    def mapped(points: float) -> Answer:
        seen = chart_of(survey(problem, limits, SPEEDS), int(points))
        k, c = np.unravel_index(int(np.argmin(seen.worst[0])), seen.worst[0].shape)
        damper = Damper(inertia, float(seen.stiffness[k]), float(seen.damping[c]))
        # what the map calls best is worth what it truly does
        value = worst_of(problem, damper, FINEST)
        return Answer(np.array([value]), float(seen.worst.size), damper.stiffness)

    def objective(variables: FloatArray, speeds: int) -> float:
        inside = np.clip(variables, logarithms[:, 0], logarithms[:, 1])
        away = float(np.sum(np.abs(variables - inside)))
        damper = Damper(inertia, *(float(np.exp(one)) for one in inside))
        return worst_of(problem, damper, speeds) * (1.0 + away)

    def told(place: FloatArray, work: int) -> Answer:
        damper = Damper(inertia, *(float(np.exp(one)) for one in place))
        return Answer(np.array([worst_of(problem, damper, FINEST)]), float(work), damper.stiffness)

    def simplex(tolerance: float) -> Answer:
        found = nelder_mead(lambda one: objective(one, SPEEDS), logarithms.mean(axis=1), tolerance)
        return told(found.place, found.evaluations)

    def evolved(generations: float) -> Answer:
        bounds = [(float(low), float(high)) for low, high in logarithms]
        found = evolution(lambda one: objective(one, SPEEDS), bounds, int(generations))
        return told(found.place, found.evaluations)

    def reference() -> Reference:
        prepared = survey(problem, limits, GUIDES)
        tuned = design_from(prepared, valleys(prepared, chart_of(prepared, TAKEN), 1))
        start = np.log(np.array(tuned.damper)[1:]) + BESIDE * np.array([1.0, -1.0])
        for tolerance in (1e-4, 1e-9):
            start = nelder_mead(lambda one: objective(one, FINEST), start, tolerance).place
        away = abs(objective(start, FINEST) / tuned.worst - 1.0)
        return Reference(
            np.array([tuned.worst]), away,
            "minimax conditions by Newton's method, held against a simplex from beside it on full "
            f"matrices at {FINEST} speeds with parabolas",
            tuned.damper.stiffness,
        )  # fmt: skip

    ladders = (
        Ladder(
            "map and minimax", "linear programs downhill from the valley of a map, then Newton's "
            "method on the conditions of the optimum", "points of a variable", MAPS, searched,
            default=float(TAKEN), citation="Madsen 1975",
        ),
        Ladder(
            "map alone", f"the best of even ratios, {SPEEDS} speeds", "points of a variable", GRIDS,
            mapped,
        ),
        Ladder(
            "simplex", f"Nelder and Mead from the middle, {SPEEDS} speeds with a parabola",
            "tolerance", SIMPLEX, simplex,
        ),
        Ladder(
            "differential evolution", f"of scipy, {SPEEDS} speeds with a parabola", "generations",
            GENERATIONS, evolved,
        ),
    )  # fmt: skip
    unit = "rad" if problem.quantity == "twist" else "N*m"
    return Topic(
        "damper design", "least largest torque",
        f"least of the largest half range over sections and speeds, of order "
        f"{problem.order[0]:g} alone and without limits of the ring, spring and dashpot chosen",
        "damper_design/worst_torque", unit, "dampers looked at over all speeds", reference, ladders,
        position="referred stiffness [N*m/rad]",
        default_extra=7.5,
        default_why="a map of 15 by 15, fine enough that no valley is lost, where a coarser one "
        "happens to show the right one; and conditions that prove the optimum",
    )  # fmt: skip


def with_damper(problem: Problem, damper: Damper) -> Line:
    """The line with a ring as its last freedom."""
    line, n = problem.line, len(problem.line.inertia)

    def added(values: FloatArray, one: float) -> FloatArray:
        return np.append(values, one)

    return Line(
        added(line.inertia, damper.inertia),
        added(line.absolute_damping, 0.0),
        added(line.ground_stiffness, 0.0),
        np.append(line.first, problem.station),
        np.append(line.second, n),
        added(line.stiffness, damper.stiffness),
        added(line.damping, damper.damping),
        added(line.loss_factor, 0.0),
    )


def worst_of(problem: Problem, damper: Damper, speeds: int) -> float:
    """Largest weighted amplitude of the one order over sections and speeds, by full matrices.

    Each section's highest speed with a parabola through its neighbours.
    """
    line = with_damper(problem, damper)
    sections = len(problem.weight)

    def curves(at: FloatArray) -> FloatArray:
        torque = torque_at(problem.torque, at)[0][:, 0]
        load = np.concatenate([torque, np.zeros((len(at), 1))], axis=1)
        w = at * problem.order[0]
        angle = dense_angles(line, w, load)
        seen = angle[:, line.first] - angle[:, line.second]
        if problem.quantity == "torque":
            seen = stiffness_of(line, w) * seen
        return np.asarray(np.abs(seen[:, :sections]) * problem.weight)

    whole = curves(np.linspace(*problem.speed, speeds))
    top = whole.max()
    highest = np.flatnonzero(whole.max(axis=0) >= 0.98 * top)

    def of_section(section: int) -> Function:
        return lambda _: whole[:, section]

    return max(
        parabola_maximum(of_section(int(one)), *problem.speed, speeds).value for one in highest
    )


def _strongest(problem: Problem, damper: Damper) -> int:
    """The order that loads the line most with a damper in the middle of the bounds."""
    size = []
    for place in range(len(problem.order)):
        alone = problem._replace(
            order=problem.order[[place]],
            torque=problem.torque._replace(coefficient=problem.torque.coefficient[:, :, [place]]),
        )
        size.append(worst_of(alone, damper, SPEEDS))
    if not np.all(np.isfinite(size)):
        raise NumericalFailure("a mode of the line is excited without damping")
    return int(np.argmax(size))

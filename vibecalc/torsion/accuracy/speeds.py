"""Accuracy of the largest torque at any speed, and of the damper that makes it least."""

from collections.abc import Callable

import numpy as np

from vibecalc.core.accuracy.other_integrators import samples_of_harmonics, transform_work
from vibecalc.core.accuracy.other_searches import (
    Function,
    evolution,
    golden_maximum,
    grid_maximum,
    nelder_mead,
    parabola_maximum,
)
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.torsion.accuracy.by_other_means import (
    dense_angles,
    exact_angles,
    exact_highest,
    modal_angles,
    on_freedoms,
)
from vibecalc.torsion.accuracy.steady import apart, by_modes_refused
from vibecalc.torsion.adapters.critical import undamped_speeds
from vibecalc.torsion.adapters.curves import solved, sweep
from vibecalc.torsion.adapters.damper_design import build_problem
from vibecalc.torsion.adapters.maxima import torque_value, with_narrow_resonances
from vibecalc.torsion.adapters.setup import Setup, build_setup
from vibecalc.torsion.adapters.speeds import chosen
from vibecalc.torsion.critical_speeds import Value, largest
from vibecalc.torsion.damper_design.descend import chart_of, valleys
from vibecalc.torsion.damper_design.design import design_from
from vibecalc.torsion.damper_design.peaks import LEVEL, DamperPeaks, Survey, survey
from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, Limits, torque_at
from vibecalc.torsion.line import Line, complex_stiffness
from vibecalc.torsion.synthesis import synthesis

# ----------------------------------------------------------------------------
# Curves of a shaft line against speed and the largest torque at any speed, with its place.
# ----------------------------------------------------------------------------

#: speeds of a curve that are held against long arithmetic
SHOWN = 9
SWEPT = (31.0, 61.0, 121.0, 241.0, 481.0, 961.0)
GRID = (51.0, 101.0, 201.0, 401.0, 1001.0, 2001.0, 4001.0)
ANGLES = (64.0, 256.0, 1024.0, 4096.0, 16384.0)
#: speeds of the first look of the trusted answer, and its highest maxima that are refined
LOOKED, RIVALS = 3001, 4
#: distance, relative to the speed, over which the curvature at a maximum is examined
NEAR = 1e-4


def torsion_speeds_topics(scene: Scene) -> list[Topic]:
    """The curve of the most loaded section; its largest value where it has one."""
    setup = build_setup(scene.case)
    if setup.torsion.speeds is None or by_modes_refused(setup):
        return []
    speed = chosen(setup.torsion.speeds)
    seen = sweep(setup.model, setup.drive, speed[:: max(1, len(speed) // 200)], None, angles=False)
    clear = ~seen.masked
    size = np.max(seen.torque[clear], axis=0) / np.abs(setup.shaft.section_ratio)
    section = int(np.argmax(size))
    found = [_curve(setup, speed, section)]
    endless = undamped_speeds(setup, speed[0], speed[-1]).endless
    if len(speed) > 2 and np.isnan(endless[section]):
        found.append(_largest(setup, speed, section))
    return found


def _curve(setup: Setup, speed: FloatArray, section: int) -> Topic:
    inner = speed[np.linspace(0, len(speed) - 1, SHOWN + 2).astype(int)[1:-1]]
    inner = inner[~np.any(solved(setup.model, setup.drive, inner).masked, axis=1)]
    drive, n = setup.drive, len(setup.model.line.inertia)
    order, place = drive.order, _places(setup)
    torque = on_freedoms(setup, drive.torque(inner))
    every = len(inner) * len(order)

    def rows(way: Callable[..., ComplexArray]) -> ComplexArray:
        """Torque (s, m) of the section at each speed by a way to the angles."""
        found = np.empty((len(inner), len(order)), dtype=np.complex128)
        for k, one in enumerate(inner.tolist()):
            line, w = setup.model.at(one), one * order
            angle = way(line, w, torque[k])
            twist = angle[:, line.first[section]] - angle[:, line.second[section]]
            found[k] = complex_stiffness(line, w)[:, section] * twist
        return found

    def kernel(_: float) -> Answer:
        found = sweep(setup.model, drive, inner, None, angles=False).torque[:, section]
        # one section of a sweep that gives them all
        each = transform_work(8 * int(place[-1])) + 32.0 * len(order)
        solve = 6.0 * n if setup.model.modal is None else 2.0 * n**2
        return Answer(found, every * solve + len(inner) * each)

    def sampled(number: float) -> Answer:
        values = samples_of_harmonics(rows(dense_angles), place, int(number))
        half = 0.5 * (values.max(axis=1) - values.min(axis=1))
        work = every * (n**3 / 3.0 + n**2) + len(inner) * transform_work(int(number))
        return Answer(half, work)

    def summed(count: float) -> Answer:
        found = rows(lambda line, w, load: modal_angles(line, setup.modes, int(count), w, load))
        half = synthesis(order, found).half_range
        each = transform_work(8 * int(place[-1])) + 32.0 * len(order)
        return Answer(half, every * count * (2.0 * n + 1.0) + len(inner) * each)

    def reference() -> Reference:
        found = rows(exact_angles)
        half = 0.5 * (exact_highest(found, place)[0] + exact_highest(-found, place)[0])
        return Reference(
            half, 2.0**-53, "the equations of motion in 40 digits, highest and lowest of the "
            "cycle by Newton's method in 30",
        )  # fmt: skip

    count = len(setup.modes.frequency)
    kept = np.unique(np.linspace(min(2, count), count, min(count, 6)).astype(int))
    solvers = (
        Solver(
            "sweep", "elimination (or all modes where the case says so) and cells", "",
            NOTHING_TO_SET, kernel, default=1.0,
        ),
        Solver(
            "full matrices, samples", "numpy.linalg.solve at each order, even angles of the cycle",
            "angles", ANGLES, sampled, theory="order 2",
        ),
        Solver(
            "sum over modes", "undamped modes, what damping couples them by left out", "modes",
            tuple(float(one) for one in kept), summed,
        ),
    )  # fmt: skip
    return Topic(
        "torsion_speeds", "curve against speed",
        f"half range of the torque of section {section + 1} at {len(inner)} speeds of the range",
        "response/torsion/speeds/torque_half_range", "N*m", "complex multiplications",
        reference, solvers,
        default_extra=1.0 if setup.model.modal is None else 4.0,
        default_why="" if setup.model.modal is None else "the case asks for a sum over modes",
    )  # fmt: skip


def _largest(setup: Setup, speed: FloatArray, section: int) -> Topic:
    first, last, points = float(speed[0]), float(speed[-1]), float(len(speed))
    own = torque_value(setup.model, setup.drive, np.array([section]))

    def value(at: FloatArray) -> FloatArray:
        return np.asarray(own(at[None])[0])

    def kernel(number: float) -> Answer:
        count = [0.0]

        def make(_: IntArray) -> Value:
            def counted(at: FloatArray) -> FloatArray:
                count[0] += np.unique(at).size
                return np.array([value(row) for row in at])

            return counted

        at = speed if number == points else np.linspace(first, last, int(number))
        curve = sweep(setup.model, setup.drive, at, None, angles=False).torque
        undamped = undamped_speeds(setup, first, last)
        dense = with_narrow_resonances(setup, at, curve, undamped)
        top = largest(
            make, dense.torque[:, [section]], dense.speed, undamped.speed,
            undamped.endless[[section]],
        )  # fmt: skip
        work = len(dense.speed) + count[0]
        return Answer(top.value, work, float(top.speed[0]))

    def gridded(number: float) -> Answer:
        seen = grid_maximum(value, first, last, int(number))
        return Answer(np.array([seen.value]), number, seen.position)

    def curved(number: float) -> Answer:
        seen = parabola_maximum(value, first, last, int(number))
        return Answer(np.array([seen.value]), number, seen.position)

    def golden(number: float) -> Answer:
        seen = grid_maximum(value, first, last, int(number))
        step = (last - first) / (number - 1.0)
        low, high = max(first, seen.position - step), min(last, seen.position + step)
        found = golden_maximum(value, low, high, 40)
        return Answer(np.array([found.value]), number + found.evaluations, found.position)

    def criticals(_: float) -> Answer:
        natural = setup.modes.frequency[setup.modes.frequency > 0.0]
        at = np.unique(natural[:, None] / setup.drive.order)
        at = at[(at >= first) & (at <= last)]
        if not len(at):
            at = np.array([first, last])
        seen = value(at)
        best = int(np.argmax(seen))
        return Answer(seen[[best]], float(len(at)), float(at[best]))

    def reference() -> Reference:
        places = np.linspace(first, last, LOOKED)
        seen = value(places)
        padded = np.pad(seen, 1, constant_values=-np.inf)
        tops = np.flatnonzero((seen >= padded[:-2]) & (seen >= padded[2:]))
        tops = tops[np.argsort(-seen[tops])][:RIVALS]
        found = [
            golden_maximum(value, places[max(k - 1, 0)], places[min(k + 1, LOOKED - 1)], 45)
            for k in tops.tolist()
        ]
        best = max(found, key=lambda one: one.value)
        other = _by_matrices(setup, section, best.position)
        return Reference(
            np.array([best.value]), apart(np.array([best.value]), np.array([other])),
            f"golden section about the highest of {LOOKED} speeds; the value there held against "
            "full matrices and long arithmetic over the cycle, the place by a polynomial",
            _peak(value, best.position, first, last),
        )  # fmt: skip

    solvers = (
        Solver(
            "sweep and peaks", "poles looked up, the slope of the highest brought to zero",
            "speeds", tuple(sorted({*(one for one in SWEPT if one < points), points})), kernel,
            default=points,
        ),
        Solver("grid", "the best of even speeds", "speeds", GRID, gridded, theory="order 2"),
        Solver(
            "grid with parabola", "through the best speed and its neighbours", "speeds", GRID,
            curved, theory="order 3",
        ),
        Solver(
            "grid and golden section", "about the best speed", "speeds", GRID[:4], golden,
        ),
        Solver(
            "critical speeds", "the best of those at which an order meets a mode", "",
            NOTHING_TO_SET, criticals,
        ),
    )  # fmt: skip
    return Topic(
        "torsion_speeds", "largest torque",
        f"largest half range of the torque of section {section + 1} at any speed of the range",
        "response/torsion/largest/torque_half_range", "N*m",
        "speeds at which all orders are solved", reference, solvers,
        position="crank speed [rad/s]",
        default_extra=2.0 + points / 100.0,
        default_why=f"the case asks for the curves at {int(points)} speeds; the largest value "
        "alone is found from fewer",
    )  # fmt: skip


def _peak(value: Function, at: float, low: float, high: float) -> float:
    """Where the slope of a polynomial through values close about a maximum is zero.

    The highest value alone tells the place to half the digits.
    """
    step = NEAR * at
    if not low + step < at < high - step:
        return at
    before, top, after = value(at + step * np.array([-1.0, 0.0, 1.0]))
    bend = (2.0 * top - before - after) / step**2
    if not bend > 0.0:
        return at
    reach = min(0.03 * float(np.sqrt(top / bend)), at - low, high - at)
    share = np.cos(np.pi * np.arange(11) / 10)
    fit = np.polynomial.Polynomial.fit(share, value(at + reach * share), 7, domain=[-1.0, 1.0])
    slope, curve = fit.deriv(), fit.deriv(2)
    place = 0.0
    for _ in range(6):
        place -= float(slope(place) / curve(place))
    return at + reach * place if abs(place) < 1.0 else at


def _places(setup: Setup) -> IntArray:
    """Orders as harmonics of the cycle."""
    return np.rint(setup.drive.order * setup.drive.firing.cycle / (2.0 * np.pi)).astype(int)


def _by_matrices(setup: Setup, section: int, speed: float) -> float:
    line, drive = setup.model.at(speed), setup.drive
    w = speed * drive.order
    angle = dense_angles(line, w, on_freedoms(setup, drive.torque(np.array([speed]))[0]))
    twist = angle[:, line.first[section]] - angle[:, line.second[section]]
    row = (complex_stiffness(line, w)[:, section] * twist)[None]
    place = _places(setup)
    high, low = (exact_highest(sign * row, place)[0][0] for sign in (1.0, -1.0))
    return float(0.5 * (high + low))


# ----------------------------------------------------------------------------
# The damper of a shaft line for its strongest order: maps, simplex, evolution, the own search.
# ----------------------------------------------------------------------------

#: values of each variable on the map of the search, of which `design` takes 15
MAPS, TAKEN = (5.0, 9.0, 15.0), 15
GRIDS = (7.0, 11.0, 15.0, 21.0)
SIMPLEX = (1e-1, 1e-2, 1e-4, 1e-6)
GENERATIONS = (1.0, 3.0, 8.0)
#: speeds that guide the search, that a user would take, of the trusted answer
GUIDES, SPEEDS, FINEST = 41, 121, 481
#: shares by which the trusted search starts next to the optimum
NEARBY = 0.2


class _Counted(Survey):
    """A survey that counts the dampers whose peaks are looked for; `counts` has one entry."""

    counts: list[int]

    def peaks(self, damper: Damper, share: float, tolerance: float = LEVEL) -> DamperPeaks:
        self.counts[0] += 1
        return super().peaks(damper, share, tolerance)


def damper_design_topics(scene: Scene) -> list[Topic]:
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


def _topic(problem: DamperProblem, limits: Limits) -> Topic:
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

    def reported(place: FloatArray, work: int) -> Answer:
        damper = Damper(inertia, *(float(np.exp(one)) for one in place))
        return Answer(np.array([worst_of(problem, damper, FINEST)]), float(work), damper.stiffness)

    def simplex(tolerance: float) -> Answer:
        found = nelder_mead(lambda one: objective(one, SPEEDS), logarithms.mean(axis=1), tolerance)
        return reported(found.place, found.evaluations)

    def evolved(generations: float) -> Answer:
        bounds = [(float(low), float(high)) for low, high in logarithms]
        found = evolution(lambda one: objective(one, SPEEDS), bounds, int(generations))
        return reported(found.place, found.evaluations)

    def reference() -> Reference:
        prepared = survey(problem, limits, GUIDES)
        tuned = design_from(prepared, valleys(prepared, chart_of(prepared, TAKEN), 1))
        start = np.log(np.array(tuned.damper)[1:]) + NEARBY * np.array([1.0, -1.0])
        for tolerance in (1e-4, 1e-9):
            start = nelder_mead(lambda one: objective(one, FINEST), start, tolerance).place
        away = abs(objective(start, FINEST) / tuned.worst - 1.0)
        return Reference(
            np.array([tuned.worst]), away,
            "minimax conditions by Newton's method, held against a simplex from next to it on full "
            f"matrices at {FINEST} speeds with parabolas",
            tuned.damper.stiffness,
        )  # fmt: skip

    solvers = (
        Solver(
            "map and minimax", "linear programs downhill from the valley of a map, then Newton's "
            "method on the conditions of the optimum", "points of a variable", MAPS, searched,
            default=float(TAKEN), citation="Madsen 1975",
        ),
        Solver(
            "map alone", f"the best of even ratios, {SPEEDS} speeds", "points of a variable", GRIDS,
            mapped,
        ),
        Solver(
            "simplex", f"Nelder and Mead from the middle, {SPEEDS} speeds with a parabola",
            "tolerance", SIMPLEX, simplex,
        ),
        Solver(
            "differential evolution", f"of scipy, {SPEEDS} speeds with a parabola", "generations",
            GENERATIONS, evolved,
        ),
    )  # fmt: skip
    unit = "rad" if problem.quantity == "twist" else "N*m"
    return Topic(
        "damper design", "least largest torque",
        f"least of the largest half range over sections and speeds, of order "
        f"{problem.order[0]:g} alone and without limits of the ring, spring and dashpot chosen",
        "damper_design/worst_torque", unit, "dampers examined over all speeds", reference,
        solvers,
        position="referred stiffness [N*m/rad]",
        default_extra=7.5,
        default_why="a map of 15 by 15, fine enough that no valley is lost, where a coarser one "
        "happens to show the right one; and conditions that prove the optimum",
    )  # fmt: skip


def with_damper(problem: DamperProblem, damper: Damper) -> Line:
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


def worst_of(problem: DamperProblem, damper: Damper, speeds: int) -> float:
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
            seen = complex_stiffness(line, w) * seen
        return np.asarray(np.abs(seen[:, :sections]) * problem.weight)

    whole = curves(np.linspace(*problem.speed, speeds))
    top = whole.max()
    highest = np.flatnonzero(whole.max(axis=0) >= 0.98 * top)

    def of_section(section: int) -> Function:
        return lambda _: whole[:, section]

    return max(
        parabola_maximum(of_section(int(one)), *problem.speed, speeds).value for one in highest
    )


def _strongest(problem: DamperProblem, damper: Damper) -> int:
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

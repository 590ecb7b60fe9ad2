"""Questions of shaft lines: modes, torques by order, over a cycle, a range and in time, dampers."""

from functools import partial

import numpy as np

from vibecalc.core.accuracy.kinds import (
    TURN,
    Optimal,
    forced,
    harmonics,
    harmonics_of_samples,
    modes,
    optimum,
    peak_over_range,
    periodic,
    time_history,
    top_of_samples,
)
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import gas_harmonics, gas_torque_at
from vibecalc.numerics.cycle_peak import DEGREE
from vibecalc.numerics.rounding import ComplexArray, FloatArray, distinct
from vibecalc.numerics.synthesis import cycle_of, synthesis
from vibecalc.torsion.adapters.damper_design import build_problem
from vibecalc.torsion.adapters.motion import readings_of
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import Setup, build_setup, line_speeds, placed
from vibecalc.torsion.adapters.transient_motion import journey, running
from vibecalc.torsion.adapters.variable_inertia import gas_torque, half_ranges, system_of
from vibecalc.torsion.asked import has_friction_damper
from vibecalc.torsion.damper_design.design import design_from
from vibecalc.torsion.damper_design.peaks import LEVEL, DamperPeaks, Survey, survey
from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, Limits, torque_at
from vibecalc.torsion.damper_design.settle import chart_of, valleys
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import (
    Line,
    complex_stiffness,
    connected_parts,
    damping_matrix,
    dynamic_stiffness,
    stiffness_matrix,
)
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.transient.march import (
    POINTS,
    StepBlock,
    driven,
    steady_start,
    transient_system,
)
from vibecalc.torsion.transient.motion import course_of, repeats, speed_after, turned_after
from vibecalc.torsion.variable_inertia.motion import steady_response

#: longer lines take more than their share of time in long arithmetic, or their first orders only
MOST_FREEDOMS, LONG, ORDERS_OF_LONG = 24, 10, 12
SWEPT = (31, 61, 121, 241, 481, 961)
#: points of a map of dampers, speeds that guide the search, speeds that a user would take
MAPS, TAKEN, GUIDES, SPEEDS = (5, 9, 15), 15, 41, 241
#: moments of a change; parts of the steps taken; samples of a cycle
MOMENTS, SHARES, SAMPLES = 8, (0.125, 0.25, 0.5, 1.0, 2.0), 1024


def _matrices(line: Line) -> tuple[np.ndarray, ...]:
    """Inertia, stiffness, damping and loss matrices, in numbers as those of the line."""
    loss = line.stiffness * line.loss_factor
    lossy = line._replace(stiffness=loss, ground_stiffness=0 * line.ground_stiffness)
    parts = np.diag(line.inertia), stiffness_matrix(line), damping_matrix(line)
    return *parts, stiffness_matrix(lossy)


def _exact(line: Line) -> tuple[np.ndarray, ...]:
    """The same summed in long arithmetic."""
    import mpmath

    return _matrices(line._replace(**{
        name: np.array([mpmath.mpf(one) for one in part.tolist()], object)
        for name, part in line._asdict().items() if part.dtype.kind == "f"
    }))  # fmt: skip


def _sections(line: Line, w: FloatArray, angle: np.ndarray) -> ComplexArray:
    """Torques (m, e) of the elements from angles (m, n)."""
    return np.asarray(complex_stiffness(line, w) * (angle[:, line.first] - angle[:, line.second]))


def _by_modes(setup: Setup) -> bool:
    """Whether damping is given by mode, for which no matrix is at hand."""
    damping = setup.torsion.damping_model
    return damping is not None and damping.kind == "modal"


def torsion_topics(scene: Scene) -> list[Topic]:
    """Natural frequencies, torques by order, gas torque of a cylinder, peak over the cycle."""
    setup = build_setup(scene.case)
    line, drive, speed = setup.model.at(setup.speed), setup.drive, setup.speed
    gas = [_cylinder(setup)] if drive.cards and np.any(drive.healthy(speed).gas.value) else []
    if any(one.varies for one in setup.shaft.couplings):  # at every frequency another line
        return gas
    parts, n, found = connected_parts(line), len(line.inertia), []
    if n <= MOST_FREEDOMS and line.inertia.all() and len(parts) == 1 and parts[0].is_tree:
        row = all(len(others) <= 2 for others in parts[0].spring.values())
        work = (4.0 / 3.0 if row else 8.0) * n**3 + 12.0 * n**2
        ask = Ask("natural frequencies", f"{n} undamped, in rad/s",
                  "response/torsion/modes/natural_frequency", 8.0,
                  "shapes too, each mode to its own last digits")  # fmt: skip
        solver = Solver("factor and mode counts",
                        lambda _: Answer(natural_modes(line).frequency, work))  # fmt: skip
        mass, stiffness, *_ = _matrices(line)
        found.append(modes(ask, [solver], mass, stiffness, exact=partial(_exact, line)))
    w = speed * drive.order
    load = drive.torque(np.array([speed])).value[0] @ placed(drive.freedom, n)
    if not _by_modes(setup):
        found.append(_by_order(setup, line, w, load))
    found += gas
    if len(distinct(drive.cycles.group)) > 1:  # of cycles that never meet no cycle is sampled
        return found
    rows = _sections(line, w, forced_masked(line, w, load).angle).T
    return [*found, _over_cycle(setup, rows)]


def _by_order(setup: Setup, line: Line, w: FloatArray, load: ComplexArray) -> Topic:
    n = len(line.inertia)
    taken = setup.model.method if setup.model.modal is None else "modal"
    count = ORDERS_OF_LONG if n > LONG else len(w)
    w, load = w[:count], load[:count]

    def kernel(dense: bool, _: float) -> Answer:
        angle = forced_masked(line, w, load, dense=dense).angle
        # an elimination along the line next to full matrices with pivoting
        work = len(w) * (4.0 if dense else min(1.0, 30.0 / n**2))
        return Answer(_sections(line, w, angle), work)

    ask = Ask("torques by order", f"{len(w)} orders at {setup.speed:.6g} rad/s",
              "response/torsion/torque", 4.0, "an error bound at each order")  # fmt: skip
    solvers = [
        Solver(name, partial(kernel, name == "dense"), default=1.0 if name == taken else None)
        for name in ("elimination", "dense")
    ]
    read = partial(_sections, line, w)
    return forced(ask, solvers, _matrices(line), w, load, read, partial(_exact, line))


def _cylinder(setup: Setup) -> Topic:
    drive, cycle = setup.drive, setup.drive.firing.cycle
    share = drive.weights(np.asarray(setup.speed))
    first = min(float(card.node[0]) for card in drive.cards)
    nodes = np.concatenate([np.mod(card.node - first, cycle) for card in drive.cards])
    edges = first + np.append(np.unique(np.round(nodes, 13)), cycle)
    edges = edges[np.append(np.diff(edges) > 1e-12, True)]

    def panels(_: float) -> Answer:
        each = [gas_harmonics(card, drive.geometry, drive.order)[0].value for card in drive.cards]
        return Answer(share @ np.array(each), 25.0 * sum(len(card.node) for card in drive.cards))

    def torque(angle: FloatArray) -> FloatArray:
        each = [gas_torque_at(card, drive.geometry, angle) for card in drive.cards]
        return np.asarray(np.tensordot(share, np.array(each), 1))

    ask = Ask("gas torque of a cylinder", f"{len(drive.order)} orders",
              "response/torsion/excitation/gas")  # fmt: skip
    solver = Solver("bounded panels", panels)
    return harmonics(ask, [solver], torque, np.rint(drive.order * cycle / TURN), edges)


def _over_cycle(setup: Setup, rows: ComplexArray) -> Topic:
    order, cycle = setup.drive.order, setup.drive.firing.cycle
    whole = synthesis(order, rows)
    worst = int(np.argmax(whole.highest))
    row, known, count = rows[worst], float(whole.highest_angle[worst]), len(order)
    places = tuple(np.rint(order * cycle / TURN).astype(int).tolist())

    def curve(angle: FloatArray) -> FloatArray:
        return np.asarray((np.exp(1j * np.multiply.outer(angle, order)) @ row).real)

    def kernel(_: float) -> Answer:
        seen = synthesis(order, row[None])
        samples = cycle_of(places).samples
        work = (0.5 * samples * np.log2(samples) + 4.0 * count * (DEGREE + 3)) / count
        place = known + (float(seen.highest_angle[0]) - known + 0.5 * cycle) % cycle - 0.5 * cycle
        return Answer(seen.highest, float(work), place)

    ask = Ask("highest torque over the cycle", f"section {worst + 1}, {count} orders",
              "response/torsion/torque_half_range", 12.0,
              "samples so dense that no maximum is missed, for all sections")  # fmt: skip
    ends = known - 0.5 * cycle, known + 0.5 * cycle
    return peak_over_range(ask, Solver("cells", kernel), curve, ends, known, "crank angle [rad]",
                           around=True)  # fmt: skip


def torsion_speeds_topics(scene: Scene) -> list[Topic]:
    """The largest torque of the most loaded section at any speed; none where it has no bound."""
    setup = build_setup(scene.case)
    if setup.torsion.speeds is None or _by_modes(setup):
        return []
    speed = line_speeds(setup.torsion.speeds)
    torque = readings_of(setup)["torque_half_range"]

    def search(at: FloatArray, section: slice = slice(None)) -> Search:
        of = torque._replace(place=torque.place[section], names=torque.names[section])
        return Search([setup], at, [{"torque": of}], ["torque"])

    seen = search(speed[:: max(1, len(speed) // 200)]).samples
    size = np.max(seen[np.all(np.isfinite(seen), axis=1)], axis=0)
    section, ends = int(np.argmax(size)), (float(speed[0]), float(speed[-1]))
    own, points = slice(section, section + 1), float(len(speed))
    one = search(speed, own)
    if len(speed) < 3 or not np.all(np.isnan(one.endless)):
        return []

    def curve(at: FloatArray) -> FloatArray:
        return np.asarray(one.value(np.zeros(1, dtype=np.int64), at[None])[0])

    def kernel(number: float) -> Answer:
        at = speed if number == points else np.linspace(*ends, int(number))
        of = search(at, own)
        top = of.found
        return Answer(top.value, float(of.solved), float(top.speed[0]))

    own_way = kernel(points)
    ask = Ask("largest torque", f"section {section + 1} at any speed",
              "response/torsion/largest/torque_half_range", 12.0 + own_way.work / 20.0,
              f"the case asks for curves at {int(points)} speeds, narrow resonances for samples "
              "between them")  # fmt: skip
    settings = [one for one in SWEPT if one < points]
    solver = Solver("sweep and peaks", kernel, "speeds", settings, points)
    known = float(own_way.position or 0.0)
    return [peak_over_range(ask, solver, curve, ends, known, "crank speed [rad/s]", "speeds")]


class _Counted(Survey):
    """A survey with a list, into which each damper goes whose peaks are sought."""

    sought: list[Damper]

    def peaks(self, damper: Damper, share: float, tolerance: float = LEVEL) -> DamperPeaks:
        self.sought.append(damper)
        return super().peaks(damper, share, tolerance)


def damper_design_topics(scene: Scene) -> list[Topic]:
    """Least largest torque of the order that loads the line most, without limits of the ring."""
    options = scene.case.damper_design
    if options is None:
        return []
    asked = build_problem(build_setup(scene.case), options)
    bounds, whole = asked.limits, asked.problem
    if bounds.inertia[0] != bounds.inertia[1] or bounds.stiffness[0] == bounds.stiffness[1]:
        return []
    limits = Limits(bounds.inertia, bounds.stiffness, bounds.damping)
    logarithms, inertia = np.log(limits.bounds[1:]), limits.inertia[0]

    def alone(place: int) -> DamperProblem:
        torque = whole.torque._replace(coefficient=whole.torque.coefficient[:, :, [place]])
        return whole._replace(order=whole.order[[place]], torque=torque)

    def worst(problem: DamperProblem, place: FloatArray) -> float:
        return worst_of(problem, Damper(inertia, *np.exp(place).tolist()), SPEEDS)

    middle = logarithms.mean(axis=1)
    size = [worst(alone(place), middle) for place in range(len(whole.order))]
    if not np.all(np.isfinite(size)):
        raise NumericalFailure("a mode of the line is excited without damping")
    problem = alone(int(np.argmax(size)))

    def search(points: float) -> Optimal:
        prepared = _Counted(*survey(problem, limits, GUIDES))
        prepared.sought = []
        seen = chart_of(prepared, int(points))
        found = design_from(prepared, valleys(prepared, seen, 1))
        place = np.log(found.damper.value[1:])
        asked = float(seen.worst.size + len(prepared.sought))
        return Optimal(place, float(found.worst.value), 0.0, asked)

    ask = Ask("least largest torque", f"order {problem.order[0]:g} alone",
              "damper_design/worst_torque", 7.5,
              "a map on which no valley is lost, a proof of the optimum")  # fmt: skip
    ours = Solver("map and minimax", search, "points of a variable", MAPS, TAKEN)
    return [optimum(
        ask, ours, lambda: lambda place: (worst(problem, place), np.zeros(0)), logarithms,
        middle, (20, 40, 80, 160), ("Nelder-Mead", "differential evolution"),
        "dampers examined over all speeds", confirm=300,
    )]  # fmt: skip


def worst_of(problem: DamperProblem, damper: Damper, speeds: int) -> float:
    """Largest weighted amplitude of the one order over sections and speeds, by full matrices."""
    line, n = problem.line, len(problem.line.inertia)
    added = zip(line, (damper.inertia, 0.0, 0.0, problem.station, n, *damper[1:], 0.0), strict=True)
    line = Line(*(np.append(part, one) for part, one in added))
    speed = np.linspace(*problem.speed, speeds)
    torque = torque_at(problem.torque, speed)[0][:, 0]
    w = speed * problem.order[0]
    load = np.concatenate([torque, np.zeros((speeds, 1))], axis=1)[..., None]
    angle = np.linalg.solve(dynamic_stiffness(line, w), load)[..., 0]
    twist = angle[:, line.first] - angle[:, line.second]
    seen = _sections(line, w, angle) if problem.quantity == "torque" else twist
    curve = np.abs(seen[:, : len(problem.weight)]) * problem.weight
    return float(np.max(top_of_samples(curve)))


def torsion_transient_topics(scene: Scene) -> list[Topic]:
    """Torques of the sections over the first cycle of a change in time; none without one."""
    setup = build_setup(running(scene.case))
    options = setup.torsion.transient
    if options is None or options.kind == "clutch_in" or has_friction_damper(scene.case):
        return []
    path = journey(setup, scene.case.machine, options)
    whole, steady, first = course_of(path.stretches, path.speed), path.start == "steady", 0
    # what lasts at constant speed before the change is no transient
    if steady and len(path.stretches) > 1:
        one = path.stretches[0]
        first = int(one.acceleration == 0.0 and one.acceleration_rate == 0.0)
    part, system = path.stretches[first], transient_system(path.line, path.reaction)
    speed, angle = float(whole.speed[first]), float(whole.angle[first])
    drive = driven(path.order, course_of([part], speed, angle), [system])
    law, begin = drive.laws[0], np.zeros(len(system.state_matrix))
    if steady:
        before = path.stretches[max(first - 1, 0)]
        begin = steady_start(system, path.order, before, speed, angle)
    # as much of it as a cycle takes, or all
    seen = np.linspace(0.0, part.duration, 2001)
    cycle = setup.drive.firing.cycle
    duration = float(np.interp(cycle, turned_after(part, speed, seen), seen))
    planned = drive.cut(1.0)
    steps = sum(min(one.steps, max(0.0, duration - one.offset) / one.step) for one in planned)
    taken = MOMENTS * max(1, round(steps / MOMENTS))
    m, turned = len(law.power), float(drive.course.angle[0])
    if repeats(law.power):
        turned %= 8.0 * np.pi
    gas, growth, inertia = (one[:, :m] - 1j * one[:, m:] for one in law.harmonic)

    def rates(time: float, state: FloatArray) -> FloatArray:
        share, at = time / part.duration, turned + float(turned_after(part, speed, np.array(time)))
        now = float(speed_after(part, speed, np.array(time)))
        scale = part.scale_start + share * (part.scale_end - part.scale_start)
        wave = np.exp(0.5j * law.power * at)
        torque = scale * ((gas + (now - speed) * growth + now**2 * inertia) @ wave).real
        torque = torque + law.pull[0] + share * (law.pull[1] - law.pull[0])
        torque = torque + now**part.exponent @ law.load
        if part.in_time is not None:
            torque = torque + part.in_time.share * part.in_time.at(np.array(time))
        return np.asarray(system.state_matrix @ state + system.input_matrix @ torque)

    def shown(states: FloatArray) -> FloatArray:
        return np.asarray(states @ system.torque.T)

    def propagated(steps: float) -> Answer:
        count = int(steps)
        piece = StepBlock(0, 0.0, duration / count, count)
        (states,) = drive.march([piece], begin)
        return Answer(shown(states[:: count // MOMENTS][1:]), 1.5 * POINTS * steps)

    ask = Ask("torques in time", f"first {duration:.4g} s of the change",
              "response/torsion/transient/peak")  # fmt: skip
    settings = [MOMENTS * max(1, round(one * taken / MOMENTS)) for one in SHARES]
    solver = Solver("exact propagation", propagated, "steps", settings, taken, "order 10 at least")
    size = float(np.max(np.abs(begin), initial=1e-3))
    times = np.linspace(0.0, duration, MOMENTS + 1)
    return [time_history(ask, solver, rates, begin, times, shown, size,
                         lambda: propagated(4 * taken).values, system.state_matrix)]  # fmt: skip


def torsion_variable_topics(scene: Scene) -> list[Topic]:
    """Half ranges where inertias turn with the shaft; none with loss factors, unknown in time."""
    setup = build_setup(scene.case)
    options, speed = setup.torsion.variable_inertia, setup.speed
    if options is None or not setup.model.line.inertia.all():
        return []
    system, torque = system_of(setup, speed), gas_torque(setup, speed)
    line, n = system.line, len(system.line.inertia)
    if np.any(line.loss_factor) or np.any(line.ground_stiffness):
        return []
    taken = float(scene.record["response/torsion/variable_inertia/highest_order"].values)
    order, load = np.arange(1, system.variation.shape[1] + 1), system.load / system.load.sum()
    shafts = np.concatenate([stiffness_matrix(line), damping_matrix(line)])
    mean = line.inertia / line.inertia.sum()

    def balanced(highest: float) -> Answer:
        found = steady_response(system, speed, torque, highest, exact=True)
        # Newton's steps on the factors of all orders, next to the products of one evaluation
        work = 4.0 * (2.0 * highest * system.turns + 1.0) ** 3 * n / 12.0
        return Answer(half_ranges(system, speed, found).value, work)

    def rates(time: float, state: FloatArray) -> FloatArray:
        """Angles, rates, the steady load and the sum of the mean angle, in rows."""
        angle, rate, held = state[:, :n], state[:, n : 2 * n], state[:, -2:-1] * load
        gas = (np.exp(1j * speed * time / system.turns * np.arange(len(torque))) @ torque).real
        wave = np.exp(1j * (speed * time + angle)[..., None] * order) * system.variation
        bend = 0.5 * (wave.imag @ order) * (speed + rate) ** 2 + gas + held
        bend = (bend - state[:, : 2 * n] @ shafts) / (line.inertia + wave.real.sum(axis=-1))
        rest = np.zeros((len(state), 1)), speed * (angle @ mean)[:, None]
        return np.concatenate([rate, bend, *rest], axis=1)

    def read(_: FloatArray, states: FloatArray) -> FloatArray:
        angle, rate = states[:, :n], states[:, n : 2 * n]
        twist, spin = (part[:, line.first] - part[:, line.second] for part in (angle, rate))
        torque = (line.stiffness * twist + line.damping * spin).T
        parts = harmonics_of_samples(np.roll(torque, 1, axis=1), SAMPLES // 2 - 1)
        return synthesis(np.arange(SAMPLES // 2), parts).half_range

    ask = Ask("half ranges", f"all sections at {speed:.6g} rad/s",
              "response/torsion/variable_inertia/torque_half_range", 6.0,
              "loss factors and undamped lines too, an error estimate of every order")  # fmt: skip
    settings = [one for one in (12, 14, 16, 18, 20, 23) if one < taken]
    solver = Solver("harmonic balance", balanced, "highest order", settings, taken, "geometric")
    times = TURN * system.turns / speed * np.arange(SAMPLES + 1) / SAMPLES
    size = np.repeat([1e-2, speed, speed**2 * line.inertia.sum(), 1.0], [n, n, 1, 1])
    return [periodic(
        ask, [solver], rates, np.zeros(2 * n + 2), range(2 * n + 1), [*range(2 * n), 2 * n + 1],
        times, read, size, lambda: balanced(np.ceil(1.5 * taken)).values, rtols=(1e-4, 1e-6),
    )]  # fmt: skip

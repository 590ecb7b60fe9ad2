"""Questions of shaft lines: modes, torques by order, over a cycle, a range and in time, dampers."""

from functools import cache, partial
from typing import Any

import numpy as np

from vibecalc.core.accuracy.kinds import (
    TURN,
    Ask,
    Matrices,
    forced,
    harmonics,
    harmonics_of_samples,
    modes,
    optimum,
    ours,
    peak_over_range,
    periodic,
    time_history,
)
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import gas_harmonics, gas_torque_at
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray, distinct
from vibecalc.numerics.synthesis import DEGREE, cycle_of, synthesis
from vibecalc.torsion.adapters.critical import undamped_speeds
from vibecalc.torsion.adapters.curves import sweep
from vibecalc.torsion.adapters.damper_design import build_problem
from vibecalc.torsion.adapters.maxima import torque_value, with_narrow_resonances
from vibecalc.torsion.adapters.setup import Setup, build_setup, line_speeds
from vibecalc.torsion.adapters.transient_motion import journey, running
from vibecalc.torsion.adapters.variable_inertia import gas_torque, half_ranges, system_of
from vibecalc.torsion.critical_speeds import Value, largest
from vibecalc.torsion.damper_design.descend import chart_of, valleys
from vibecalc.torsion.damper_design.design import design_from
from vibecalc.torsion.damper_design.peaks import LEVEL, DamperPeaks, Survey, survey
from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, Limits, torque_at
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
    cut,
    march,
    rest_state,
    steady_start,
    transient_system,
)
from vibecalc.torsion.transient.motion import (
    Stretch,
    repeats,
    speed_after,
    speed_profile,
    torque_law,
    turned_after,
)
from vibecalc.torsion.variable_inertia.steady import steady_response

#: longer lines take more than their share of time in long arithmetic, or their first orders only
MOST_FREEDOMS, LONG, ORDERS_OF_LONG = 24, 10, 12
SWEPT = (31, 61, 121, 241, 481, 961)
#: points of a map of dampers, speeds that guide the search, speeds that a user would take
MAPS, TAKEN, GUIDES, SPEEDS = (5, 9, 15), 15, 41, 241
#: moments of a change; parts of the steps taken; samples of a cycle
MOMENTS, SHARES, SAMPLES = 8, (0.125, 0.25, 0.5, 1.0, 2.0), 1024


def exact_matrices(line: Line) -> Matrices:
    """Inertia, stiffness, damping and loss matrices summed in the numbers of mpmath."""
    import mpmath

    n = len(line.inertia)

    def summed(own: FloatArray, links: list[Any]) -> np.ndarray:
        found = np.array([[mpmath.mpf(0)] * n for _ in range(n)], dtype=object)
        for i, value in enumerate(own.tolist()):
            found[i, i] += mpmath.mpf(value)
        for a, b, value in zip(line.first.tolist(), line.second.tolist(), links, strict=True):
            for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                found[i, j] += sign * value
        return found

    nothing = np.zeros(n)
    stiff, damp, loss = (
        [mpmath.mpf(one) for one in part.tolist()]
        for part in (line.stiffness, line.damping, line.loss_factor)
    )
    lossy = [k * eta for k, eta in zip(stiff, loss, strict=True)]
    return Matrices(
        summed(line.inertia, [mpmath.mpf(0)] * len(stiff)), summed(line.ground_stiffness, stiff),
        summed(line.absolute_damping, damp), summed(nothing, lossy),
    )  # fmt: skip


def _matrices(line: Line) -> Matrices:
    lossy = line._replace(
        stiffness=line.stiffness * line.loss_factor, ground_stiffness=0.0 * line.inertia
    )
    return Matrices(
        np.diag(line.inertia), stiffness_matrix(line), damping_matrix(line), stiffness_matrix(lossy)
    )


def _on_freedoms(setup: Setup, torque: ComplexArray) -> ComplexArray:
    """Torques (..., k) at the driven stations as those (..., n) on all freedoms of the line."""
    places = np.arange(len(setup.model.line.inertia))
    return np.asarray(torque @ (setup.drive.freedom[:, None] == places))


def _sections(line: Line, w: FloatArray, angle: ComplexArray) -> ComplexArray:
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
    if any(one.varies for one in setup.shaft.couplings):  # at every frequency another line
        return [_cylinder(setup)] if drive.cards and np.any(drive.healthy(speed).gas.value) else []
    parts, n, found = connected_parts(line), len(line.inertia), []
    if n <= MOST_FREEDOMS and line.inertia.all() and len(parts) == 1 and parts[0].is_tree:
        row = all(len(others) <= 2 for others in parts[0].spring.values())
        work = (4.0 / 3.0 if row else 8.0) * n**3 + 12.0 * n**2
        ask = Ask("torsion", "natural frequencies", f"{n} undamped, in rad/s",
                  "response/torsion/modes/natural_frequency", "rad/s", 8.0,
                  "shapes too, each mode to its own last digits")  # fmt: skip
        solver = ours("factor and mode counts", "bidiagonal factor; of trees halved brackets",
                      lambda _: Answer(natural_modes(line).frequency, work),
                      citation="Fernando and Parlett 1994")  # fmt: skip
        whole = _matrices(line)
        found.append(modes(ask, [solver], whole.mass, whole.stiffness,
                           exact=lambda: exact_matrices(line).stiffness))  # fmt: skip
    if not _by_modes(setup):
        found.append(_by_order(setup, line))
    if drive.cards and np.any(drive.healthy(speed).gas.value):
        found.append(_cylinder(setup))
    if len(distinct(drive.cycles.group)) > 1:  # of cycles that never meet no cycle is sampled
        return found
    w = speed * drive.order
    load = _on_freedoms(setup, drive.torque(np.array([speed])).value[0])
    rows = _sections(line, w, forced_masked(line, w, load).angle).T
    return [*found, _over_cycle(setup, rows)]


def _by_order(setup: Setup, line: Line) -> Topic:
    n, drive = len(line.inertia), setup.drive
    taken = setup.model.method if setup.model.modal is None else "modal"
    count = ORDERS_OF_LONG if n > LONG else len(drive.order)
    w = setup.speed * drive.order[:count]
    load = _on_freedoms(setup, drive.torque(np.array([setup.speed])).value[0][:count])

    def kernel(dense: bool) -> Answer:
        angle = forced_masked(line, w, load, dense=dense).angle
        # an elimination along the line next to full matrices with pivoting
        work = len(w) * (4.0 if dense else min(1.0, 30.0 / n**2))
        return Answer(_sections(line, w, angle), work)

    ask = Ask("torsion", "torques by order", f"{len(w)} orders at {setup.speed:.6g} rad/s",
              "response/torsion/torque", "N*m", 4.0, "an error bound at each order")  # fmt: skip
    solvers = [
        ours(name, words, lambda _, dense=dense: kernel(dense),  # type: ignore[misc]
             default=1.0 if name == taken else None)
        for name, words, dense in (
            ("elimination", "along the line, with its error bound", False),
            ("dense", "full matrix with pivoting, refined, error bound", True),
        )
    ]  # fmt: skip
    read = partial(_sections, line, w)
    return forced(ask, solvers, _matrices(line), w, load, read, partial(exact_matrices, line))


def _cylinder(setup: Setup) -> Topic:
    drive, cycle = setup.drive, setup.drive.firing.cycle
    share = drive.weights(np.asarray(setup.speed))
    first = min(float(card.node[0]) for card in drive.cards)
    nodes = np.concatenate([first + np.mod(card.node - first, cycle) for card in drive.cards])
    edges = np.append(np.unique(np.round(nodes, 13)), first + cycle)
    edges = edges[np.append(np.diff(edges) > 1e-12, True)]

    def panels(_: float) -> Answer:
        each = [gas_harmonics(card, drive.geometry, drive.order)[0].value for card in drive.cards]
        return Answer(share @ np.array(each), 25.0 * sum(len(card.node) for card in drive.cards))

    def torque(angle: FloatArray) -> FloatArray:
        each = [gas_torque_at(card, drive.geometry, angle) for card in drive.cards]
        return np.asarray(np.tensordot(share, np.array(each), 1))

    ask = Ask("torsion", "gas torque of a cylinder", f"{len(drive.order)} orders",
              "response/torsion/excitation/gas", "N*m")  # fmt: skip
    solver = ours("bounded panels", "Gauss points enough for a proof", panels,
                  citation="Trefethen 2013, theorem 19.3")  # fmt: skip
    places = np.rint(drive.order * cycle / TURN).astype(int)
    return harmonics(ask, [solver], torque, places, cycle, edges)


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

    ask = Ask("torsion", "highest torque over the cycle", f"section {worst + 1}, {count} orders",
              "response/torsion/torque_half_range", "N*m", 12.0,
              "samples so dense that no maximum is missed, for all sections")  # fmt: skip
    solver = ours("cells", "samples, then Taylor polynomials where the maximum may be", kernel)
    ends = known - 0.5 * cycle, known + 0.5 * cycle
    return peak_over_range(ask, [solver], curve, *ends, "crank angle [rad]", known,
                           kind="peak over a cycle", ends=False)  # fmt: skip


def torsion_speeds_topics(scene: Scene) -> list[Topic]:
    """The largest torque of the most loaded section at any speed; none where it has no bound."""
    setup = build_setup(scene.case)
    if setup.torsion.speeds is None or _by_modes(setup):
        return []
    speed = line_speeds(setup.torsion.speeds)
    seen = sweep(setup.model, setup.drive, speed[:: max(1, len(speed) // 200)], None, angles=False)
    size = np.max(seen.torque[~seen.masked], axis=0) / np.abs(setup.shaft.section_ratio)
    section, ends = int(np.argmax(size)), (float(speed[0]), float(speed[-1]))
    undamped = undamped_speeds(setup, *ends)
    if len(speed) < 3 or not np.isnan(undamped.endless[section]):
        return []
    own, points = torque_value(setup.model, setup.drive, np.array([section])), float(len(speed))

    def curve(at: FloatArray) -> FloatArray:
        return np.asarray(own(at[None])[0])

    def kernel(number: float) -> Answer:
        count = [0.0]

        def make(_: IntArray) -> Value:
            def counted(at: FloatArray) -> FloatArray:
                count[0] += np.unique(at).size
                return np.array([curve(row) for row in at])

            return counted

        at = speed if number == points else np.linspace(*ends, int(number))
        torque = sweep(setup.model, setup.drive, at, None, angles=False).torque
        dense = with_narrow_resonances(setup, at, torque, undamped)
        top = largest(make, dense.torque[:, [section]], dense.speed, undamped.speed,
                      undamped.endless[[section]])  # fmt: skip
        return Answer(top.value, len(dense.speed) + count[0], float(top.speed[0]))

    ask = Ask("torsion_speeds", "largest torque", f"section {section + 1} at any speed",
              "response/torsion/largest/torque_half_range", "N*m", 12.0 + points / 20.0,
              f"the case asks for curves at {int(points)} speeds")  # fmt: skip
    solver = ours("sweep and peaks", "poles first, polynomials about the highest",
                  kernel, "speeds", [one for one in SWEPT if one < points], points)  # fmt: skip
    known = float(kernel(points).position or 0.0)
    return [
        peak_over_range(ask, [solver], curve, *ends, "crank speed [rad/s]", known, work="speeds")
    ]


class _Counted(Survey):
    """A survey that counts the dampers whose peaks are sought; `counts` has one entry."""

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

    @cache
    def searched(points: int) -> tuple[FloatArray, float, FloatArray]:
        prepared = _Counted(*survey(problem, limits, GUIDES))
        prepared.counts = [0]
        seen = chart_of(prepared, points)
        found = design_from(prepared, valleys(prepared, seen, 1))
        place = np.log([found.damper.stiffness, found.damper.damping])
        return np.array([found.worst]), float(seen.worst.size + prepared.counts[0]), place

    ask = Ask("damper design", "least largest torque", f"order {problem.order[0]:g} alone",
              "damper_design/worst_torque", "rad" if problem.quantity == "twist" else "N*m", 7.5,
              "a map on which no valley is lost, a proof of the optimum")  # fmt: skip
    solver = ours("map and minimax", "downhill from the valley of a map, Newton's method",
                  lambda points: Answer(*searched(int(points))[:2]),
                  "points of a variable", MAPS, TAKEN, citation="Madsen 1975")  # fmt: skip
    return [optimum(
        ask, [solver], lambda: lambda place: (worst(problem, place), np.zeros(0)),
        [(float(low), float(high)) for low, high in logarithms], middle, float,
        lambda: (searched(TAKEN)[2], float(searched(TAKEN)[0][0]), 0.0), (20, 40, 80, 160),
        ("Nelder-Mead", "differential evolution"), "dampers examined over all speeds", 300,
    )]  # fmt: skip


def worst_of(problem: DamperProblem, damper: Damper, speeds: int) -> float:
    """Largest weighted amplitude of the one order over sections and speeds, by full matrices.

    Each section's highest speed with a parabola through its neighbours.
    """
    line, n = problem.line, len(problem.line.inertia)
    added = zip(line, (damper.inertia, 0.0, 0.0, problem.station, n, *damper[1:], 0.0), strict=True)
    line = Line(*(np.append(part, one) for part, one in added))
    speed = np.linspace(*problem.speed, speeds)
    torque = torque_at(problem.torque, speed)[0][:, 0]
    w = speed * problem.order[0]
    load = np.concatenate([torque, np.zeros((speeds, 1))], axis=1)[..., None]
    angle = np.linalg.solve(dynamic_stiffness(line, w), load)[..., 0]
    seen = angle[:, line.first] - angle[:, line.second]
    if problem.quantity == "torque":
        seen = complex_stiffness(line, w) * seen
    curve = np.abs(seen[:, : len(problem.weight)]) * problem.weight
    best, column = np.clip(curve.argmax(axis=0), 1, speeds - 2), np.arange(curve.shape[1])
    low, top, high = (curve[best + k, column] for k in (-1, 0, 1))
    bend = 2.0 * top - low - high
    rise = np.where(bend > 0.0, (high - low) ** 2 / (8.0 * np.where(bend > 0.0, bend, 1.0)), 0.0)
    return float(np.max(np.maximum(top + rise, curve.max(axis=0))))


def torsion_transient_topics(scene: Scene) -> list[Topic]:
    """Torques of the sections over the first cycle of a change in time; none without one."""
    setup = build_setup(running(scene.case))
    options = setup.torsion.transient
    if options is None or options.kind == "clutch_in":
        return []
    path = journey(setup, scene.case.machine, options)
    whole, steady, first = speed_profile(path.stretches, path.speed), path.start == "steady", 0
    # what lasts at constant speed before the change is no transient
    if steady and len(path.stretches) > 1:
        one = path.stretches[0]
        first = int(one.acceleration == 0.0 and one.acceleration_rate == 0.0)
    system = transient_system(path.line, path.reaction)
    speed, angle = float(whole.speed[first]), float(whole.angle[first])
    part = _shortened(path.stretches[first], speed, setup.drive.firing.cycle)
    borders = speed_profile([part], speed, angle)
    law = torque_law(path.order, part, system.balance, system.inertia, borders.speed)
    begin = rest_state(system)
    if steady:
        before = path.stretches[max(first - 1, 0)]
        begin = steady_start(system, path.order, before, speed, angle)
    duration = part.duration
    planned = cut([part], borders, float(law.power.max(initial=0.0)) / 2.0, system.fastest, 1.0)
    taken = MOMENTS * max(1, round(sum(one.steps for one in planned) / MOMENTS))
    m, turned = len(law.power), float(borders.angle[0])
    if repeats(law.power):
        turned %= 8.0 * np.pi
    gas, growth, inertia = (one[:, :m] - 1j * one[:, m:] for one in law.harmonic)

    def rates(time: float, state: FloatArray) -> FloatArray:
        share, at = time / duration, turned + float(turned_after(part, speed, np.array(time)))
        now = float(speed_after(part, speed, np.array(time)))
        scale = part.scale_start + share * (part.scale_end - part.scale_start)
        wave = np.exp(0.5j * law.power * at)
        torque = scale * ((gas + (now - speed) * growth + now**2 * inertia) @ wave).real
        torque = torque + law.pull[0] + share * (law.pull[1] - law.pull[0])
        torque = torque + now**law.exponent @ law.load
        if part.in_time is not None:
            torque = torque + part.in_time.share * part.in_time.at(np.array(time))
        return np.asarray(system.state_matrix @ state + system.input_matrix @ torque)

    def shown(states: FloatArray) -> FloatArray:
        return np.asarray(states @ system.torque.T)

    def propagated(steps: float) -> FloatArray:
        count = int(steps)
        piece = StepBlock(0, 0.0, duration / count, count)
        (states,) = march([system], [part], borders, [law], [piece], begin)
        return shown(states[:: count // MOMENTS][1:])

    ask = Ask("transient", "torques in time", f"first {duration:.4g} s of the change",
              "response/torsion/transient/peak", "N*m")  # fmt: skip
    solver = ours("exact propagation",
                  "matrix exponential, torque a polynomial; whole and half steps",
                  lambda steps: Answer(propagated(steps), 1.5 * POINTS * steps), "steps",
                  {MOMENTS * max(1, round(one * taken / MOMENTS)) for one in SHARES}, taken,
                  "order 10 at least")  # fmt: skip
    return [time_history(
        ask, [solver], rates, begin, np.linspace(0.0, duration, MOMENTS + 1), shown,
        float(np.max(np.abs(begin), initial=1e-3)), lambda: propagated(4 * taken),
        system.state_matrix,
    )]  # fmt: skip


def _shortened(part: Stretch, speed: float, cycle: float) -> Stretch:
    """As much of a stretch as a cycle takes, or all of it."""
    times = np.linspace(0.0, part.duration, 2001)
    duration = float(np.interp(cycle, turned_after(part, speed, times), times))
    share = duration / part.duration
    ends = speed_after(part, speed, np.array([duration, part.duration]))
    passed = (ends[0] - speed) / (ends[1] - speed) if ends[1] != speed else 0.0
    return part._replace(
        duration=duration,
        scale_end=part.scale_start + share * (part.scale_end - part.scale_start),
        gas_end=part.gas + passed * (part.gas_end - part.gas),
    )


def torsion_variable_topics(scene: Scene) -> list[Topic]:
    """Half ranges where inertias turn with the shaft; none with loss factors, unknown in time."""
    setup = build_setup(scene.case)
    options = setup.torsion.variable_inertia
    if options is None or not setup.model.line.inertia.all():
        return []
    speed = setup.speed
    system, torque = system_of(setup, speed), gas_torque(setup, speed)
    line, n = system.line, len(system.line.inertia)
    if np.any(line.loss_factor) or np.any(line.ground_stiffness):
        return []
    path = "response/torsion/variable_inertia/highest_order"
    taken = np.ceil(max(setup.drive.order[-1], system.variation.shape[1])) + 1.0
    if options.orders is not None:
        taken = float(options.orders)
    elif path in scene.record.quantities:
        taken = float(scene.record.quantities[path].values)
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

    ask = Ask("variable inertia", "half ranges", f"all sections at {speed:.6g} rad/s",
              "response/torsion/variable_inertia/torque_half_range", "N*m", 6.0,
              "loss factors and undamped lines too, an error estimate of every order")  # fmt: skip
    solver = ours("harmonic balance", "the whole Lagrangian system by Newton's method", balanced,
                  "highest order", [one for one in (12, 14, 16, 18, 20, 23) if one < taken], taken,
                  "geometric", "Pasricha and Carnegie 1976")  # fmt: skip
    times = TURN * system.turns / speed * np.arange(SAMPLES + 1) / SAMPLES
    size = np.concatenate(
        [np.full(n, 1e-2), np.full(n, speed), [speed**2 * line.inertia.sum(), 1.0]]
    )
    return [periodic(
        ask, [solver], rates, np.zeros(2 * n + 2), range(2 * n + 1), times, read, size,
        lambda: balanced(np.ceil(1.5 * taken)).values, rtols=(1e-4, 1e-6),
        back=[*range(2 * n), 2 * n + 1], in_rows=True,
    )]  # fmt: skip

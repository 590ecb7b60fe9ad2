"""Questions of the response of a body: modes, forced motion, energies, changes in time."""

from functools import partial

import numpy as np

from vibecalc.core.accuracy.kinds import (
    TURN,
    Ask,
    Matrices,
    forced,
    modes,
    ours,
    peak_over_range,
    time_history,
)
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.numerics.bounded import Bounded, stack
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.linear import dynamics, response
from vibecalc.numerics.rounding import FloatArray
from vibecalc.response import modes as natural
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import LinearSystem, forcing_of, linear_system, ratios_of
from vibecalc.response.energies import energy_by_order, energy_signal, mass_of, velocity
from vibecalc.response.forced import modal_response
from vibecalc.response.operations import Rows, search_phases, superpose
from vibecalc.response.switching.motion import PANEL_PHASE, driven_part, panel_grid, runs_of
from vibecalc.response.switching.system import (
    Loads,
    ModalSystem,
    SpeedSegment,
    SteadyMotion,
    modal_loads,
    propagator,
    steady_motion,
    steady_state,
)

#: multiplications over n^3 of the refined modes: factors, vectors, quotients; and of each step
FULL, STEP = 9.7, 5.0
#: solutions that an inverse with a step of refinement takes, six eigenpairs, a sum of modes
INVERSE, EIGENPAIRS, SUM = 4.0, 25.0, 2.0
#: speeds at which energies are compared
SPEEDS = 10


def response_topics(scene: Scene) -> list[Topic]:
    """Natural frequencies where all modes are held; translations of the orders that are driven."""
    system, options = linear_system(scene), scene.case.response
    if system.own:
        return []  # the questions are of matrices that no frequency changes
    shapes, found = system.shapes, []
    if np.all(shapes.eigenvalue > shapes.eigenvalue_error):
        size, matrices = shapes.natural_frequency, system.matrices
        work = (FULL + STEP * natural.refined_shapes(matrices)[1]) * len(size) ** 3

        def refined(_: float) -> Answer:
            return Answer(natural.modes(matrices).natural_frequency / size, work)

        ask = Ask("response", "natural frequencies", f"{len(size)} undamped, each over its value",
                  "response/modes/natural_frequency", "", 15.0,
                  "shapes, digits of low modes next to stiff ones, and errors")  # fmt: skip
        solver = ours("Cholesky, eigh, refined", "steps of refinement on the pencil", refined,
                      citation="Ogita and Aishima (2018), algorithm 1")  # fmt: skip
        found.append(modes(ask, [solver], matrices.mass, matrices.stiffness, size))
    orders, load, error = _driven(scene)
    if options is None or not len(orders):
        return found
    speed, count = scene.case.machine.speed, len(orders)
    w, load, error = orders * speed, load * speed**2, error * speed**2

    def direct(_: float) -> Answer:
        value = response(dynamics(system.matrices, w), load, error).value
        return Answer(value[:, :3], INVERSE * count)

    def modal(_: float) -> Answer:
        value = modal_response(system.matrices, shapes.shape, w, load, error).value
        return Answer(value[:, :3], EIGENPAIRS + SUM * count)

    solvers = [
        ours(name, words, solve, default=1.0 if options.method == name else None, citation=source)
        for name, words, solve, source in (
            ("direct", "all orders inverted together, a step of refinement", direct,
             "Harris and Piersol (2002), ch. 3"),
            ("modal", "sum of all modes, a step of refinement", modal,
             "Thomson and Dahleh (1998), ch. 6"),
        )
    ]  # fmt: skip
    extra = INVERSE if options.method == "direct" else float(np.ceil(EIGENPAIRS / count + SUM))
    ask = Ask("response", "translations by order", f"{count} driven orders at {speed:.6g} rad/s",
              "response/translation_harmonics", "m", extra,
              "an error for every entry; modes are results themselves")  # fmt: skip
    parts = Matrices(*system.matrices[:4])
    return [*found, forced(ask, solvers, parts, w, load, lambda found: found[:, :3])]


def _driven(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Orders (m,) kept that shake the body; their loads (m, 6) per speed squared, with errors."""
    forcing = forcing_of(scene)
    load = forcing.per_speed_squared
    value, error = load.value[: forcing.retained], load.error[: forcing.retained]
    value = np.where(np.abs(value) > 4.0 * error, value, 0.0)
    driven = np.any(value != 0.0, axis=-1)
    return forcing.order[: forcing.retained][driven], value[driven], error[driven]


def speeds_topics(scene: Scene) -> list[Topic]:
    """Mean kinetic energy at speeds of the range, golden steps apart; none at rest."""
    options = scene.case.response
    orders, load, error = _driven(scene)
    if options is None or options.run_up is None or not len(orders):
        return []
    system, (start, stop) = linear_system(scene), (options.run_up.start, options.run_up.stop)
    share = np.sort(np.modf(0.6180339887498949 * np.arange(1, SPEEDS + 1))[0])
    speed = start + (stop - start) * share
    w, mass, square = (
        np.outer(speed, orders),
        mass_of(system.matrices),
        np.square(speed)[:, None, None],
    )

    def direct(_: float) -> Answer:
        motion = response(dynamics(system.matrices, w), square * load, square * error)
        energy = energy_by_order(mass, velocity(motion, w)).mean.sum(-1)
        return Answer(energy, INVERSE * w.size)

    def energies(amplitudes: np.ndarray) -> np.ndarray:
        rate = w.reshape(-1, 1) * amplitudes
        each = np.einsum("mi,ij,mj->m", rate.conj(), system.matrices.mass, rate).real
        return np.asarray(0.25 * each.reshape(w.shape).sum(-1))

    ask = Ask("speeds", "mean kinetic energy over speed", f"{SPEEDS} speeds, {len(orders)} orders",
              "response/run_up/kinetic_energy", "J", INVERSE, "an error for each")  # fmt: skip
    solver = ours("direct", "orders and speeds inverted together, refined", direct)
    parts = Matrices(*system.matrices[:4])
    return [forced(ask, [solver], parts, w.ravel(), (square * load).reshape(-1, 6), energies)]


def operations_topics(scene: Scene) -> list[Topic]:
    """The highest peak energy over all angles of the balance weight that matters most."""
    options = scene.case.response
    if options is None or not options.operations:
        return []
    forcing, system = forcing_of(scene), linear_system(scene)
    loads = operation_loads(scene, options.operations, options.balances)
    speed, kept = scene.case.machine.speed, forcing.retained
    orders, weight = forcing.order[:kept], mass_of(system.matrices)

    shaking = [at_speed(load, speed) for load in loads.shaking]
    residual = [[at_speed(load, speed) for load in row] for row in loads.residual]
    parts = superpose(
        system.matrices, orders, speed,
        stack([x[:kept] for x in shaking], axis=0),
        stack([stack([x[0] for x in row], axis=0) for row in residual], axis=0),
    )  # fmt: skip
    first, rate = parts.first, 1j * orders * speed
    push = parts.shaking.value[:, None, first].conj() * (parts.residual.value @ weight.value)
    swing = np.abs(np.sum(push, axis=-1))
    if not np.any(swing > 0.0):
        return []
    at = np.unravel_index(int(np.argmax(swing)), swing.shape)

    def moved(part: Bounded, factor: np.ndarray) -> Bounded:
        return Bounded(part.value * factor, part.error * np.abs(factor))

    one = Bounded(parts.shaking.value[at[0]][None], parts.shaking.error[at[0]][None])
    other = Bounded(*(part[at][None, None] for part in parts.residual))
    still = energy_signal(weight, moved(one, rate[:, None]))
    turning = energy_signal(weight, moved(other, rate[first]))
    used = still.used.copy()
    used[first] = True
    rows = Rows(still.harmonics[..., used], orders[used], turning.harmonics[..., 0])
    place = int(np.flatnonzero(rows.orders == 1)[0])
    rtol = scene.case.accuracy.rtol

    def curve(phase: FloatArray) -> FloatArray:
        signal = np.repeat(rows.harmonics, len(phase), axis=0)
        signal[..., place] += np.exp(1j * phase)[:, None] * rows.turned
        return np.asarray(0.5 * np.square(vector_cycle_peak(signal, rows.orders).value))

    def bounded(tolerance: float) -> Answer:
        found = search_phases(rows, tolerance)
        return Answer(np.array([found.high[0]]), float(found.peaks[0]))

    known = float(search_phases(rows, rtol).high_phase[0])
    ask = Ask("operations", "highest peak energy",
              f"{loads.operations[at[0]]!r} with {loads.balances[at[1]]!r} at any angle",
              "response/operations/kinetic_energy/peak_low, peak_high", "J", 12.0,
              "no angle is left out, and both ends are proven to within rtol")  # fmt: skip
    solver = ours("branch and bound", "intervals that can hold no end are dropped", bounded, "rtol",
                  (1e-1, 1e-2, 1e-3, 1e-4, 1e-6), rtol, falling=True)  # fmt: skip
    ends = known - 0.5 * TURN, known + 0.5 * TURN
    return [
        peak_over_range(
            ask, [solver], curve, *ends, "", known, ends=False, work="peaks over the cycle"
        )
    ]


def switching_topics(scene: Scene) -> list[Topic]:
    """Translations in the turns after a change at once, and at the beginning of a run-down."""
    options = scene.case.response.switching if scene.case.response else None
    if options is None or scene.case.response is None:
        return []
    known = {operation.name: operation for operation in scene.case.response.operations}
    found = operation_loads(scene, [known[name] for name in options.between])
    kept, linear = forcing_of(scene).retained, linear_system(scene)
    rows = [
        shaking + residual[0]
        for shaking, residual in zip(found.shaking, found.residual, strict=True)
    ]
    load = np.stack([
        np.where(np.abs(one.value) > 4.0 * one.error, one.value, 0.0)[:kept] for one in rows
    ])  # fmt: skip
    matrices, shapes = linear[:2]
    ratio = ratios_of(scene, LinearSystem(matrices, shapes)).value
    system = ModalSystem(shapes.shape, shapes.natural_frequency, ratio)
    orders, speed, angle = np.arange(1, kept + 1), scene.case.machine.speed, options.crank_angle
    modal = modal_loads(system, Loads(orders, load, np.zeros((2, 6))))
    momentum = matrices.mass @ shapes.shape
    stiffness, damping = (
        (momentum * own) @ momentum.T
        for own in (shapes.natural_frequency**2, 2.0 * ratio * shapes.natural_frequency)
    )
    inverse = shapes.shape @ shapes.shape.T
    matrix = np.block([[np.zeros((6, 6)), np.eye(6)], [-inverse @ stiffness, -inverse @ damping]])
    old, new = (steady_motion(system, modal, k, speed) for k in (0, 1))

    def steady(motion: SteadyMotion, at: np.ndarray) -> np.ndarray:
        return np.asarray(steady_state(motion, modal.orders, speed, at))

    begin = steady(old, np.asarray(angle))
    start = np.concatenate([shapes.shape @ begin[:, 0], shapes.shape @ begin[:, 1]])
    length = np.maximum(np.abs(start[:6]), 1e-3 * np.max(np.abs(start[:3])))
    scale = np.concatenate([length, length * speed])

    def rates(operation: int, acceleration: float, time: float, state: FloatArray) -> FloatArray:
        now = speed + acceleration * time
        theta = angle + time * (speed + 0.5 * acceleration * time)
        wave = (now * now - 1j * acceleration / orders) * np.exp(1j * orders * theta)
        result = matrix @ state
        result[6:] += inverse @ (wave @ load[operation]).real
        return np.asarray(result)

    times = TURN / (16.0 * speed) * np.arange(33)

    def closed(_: float) -> Answer:
        forced_part = steady(new, angle + speed * times[1:])
        free = propagator(system, times[1:])(begin - steady(new, np.asarray(angle)))
        moved = (forced_part + free)[..., 0] @ shapes.shape.T
        return Answer(moved[:, :3], 32.0)

    path = "response/switching/{}/translation_high, translation_low"
    ask = Ask("switching", "change at once", "translations in the two turns after the change",
              path.format("instant"), "m")  # fmt: skip
    solver = ours("closed form of modes", "steady and free motion of each mode", closed,
                  citation="cf. Goloskokow and Filippow (1971)")  # fmt: skip
    topics = [time_history(
        ask, [solver], partial(rates, 1, 0.0), start, times, lambda states: states[:, :3], scale,
        lambda: closed(1.0).values, matrix,
    )]  # fmt: skip
    if not options.run_down > 0.0:
        return topics
    span, acceleration = 0.1 * float(options.run_down), -speed / float(options.run_down)
    moments = span / 20.0 * np.arange(21)
    run = runs_of([SpeedSegment(span, speed, speed + acceleration * span, 0)], angle)[0]

    def quadrature(phase: float) -> Answer:
        grid = np.union1d(panel_grid(system, modal, run, span, phase), moments)
        state, step, shown = begin, np.diff(grid), []
        gained, moved = driven_part(system, modal, run, grid[:-1], step), propagator(system, step)
        for k in range(len(step)):
            state = type(moved)(*(part[k] for part in moved))(state) + gained[k]
            if np.any(np.abs(moments - grid[k + 1]) <= 1e-12 * span):
                shown.append(shapes.shape @ state[:, 0])
        return Answer(np.array(shown)[:, :3], 13.0 * len(step))

    ask = Ask("switching", "run-down", f"translations in its first {span:.3g} s",
              path.format("reversal"), "m", 3.5, "short panels bound peaks between")  # fmt: skip
    solver = ours("quadrature of the propagator", "Gauss's rule on panels", quadrature,
                  "phase of a panel [rad]", (32.0, 16.0, 8.0, 4.0), PANEL_PHASE, "geometric",
                  "cf. Goloskokow and Filippow (1971)", falling=True)  # fmt: skip
    return [*topics, time_history(
        ask, [solver], partial(rates, 0, acceleration), start, moments,
        lambda states: states[:, :3], scale, lambda: quadrature(0.5 * PANEL_PHASE).values, matrix,
    )]  # fmt: skip

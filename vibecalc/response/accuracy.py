"""Questions of the response of a body: modes, forced motion, energies, changes in time."""

from dataclasses import replace
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
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.linear import Linear, dynamics, response
from vibecalc.numerics.rounding import FloatArray
from vibecalc.response import modes as natural
from vibecalc.response.adapters.loads import BodyLoads, LoadsOverSpeed, body_loads, loads_over_speed
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import forcing_of, mounted_body
from vibecalc.response.adapters.switching import modes_and_loads
from vibecalc.response.energies import energy_signal, mass_of, mean_over_cycle, velocity
from vibecalc.response.operations import Parts, search_phases, superpose
from vibecalc.response.stage import names_of
from vibecalc.response.switching.motion import PANEL_PHASE, Panels, course_of, march, panels_of
from vibecalc.response.switching.system import (
    SpeedSegment,
    SteadyMotion,
    free_motion,
    steady_motion,
    steady_state,
)
from vibecalc.response.system import in_modes

#: multiplications over n^3 of the refined modes: factors, vectors, quotients, two steps
REFINED = 19.7
#: solutions that an inverse with a step of refinement takes, six eigenpairs
INVERSE, EIGENPAIRS = 4.0, 25.0
#: speeds at which energies are compared
SPEEDS = 10


def response_topics(scene: Scene) -> list[Topic]:
    """Natural frequencies where all modes are held; translations of the orders that are driven."""
    system, options = mounted_body(scene), scene.case.response
    if options is None or system.spectral is not None:
        return []  # the questions are of matrices that no frequency changes
    matrices, found = system.matrices, []
    parts, size = Matrices(*matrices[:4]), system.shapes.natural_frequency
    if np.all(system.shapes.held):

        def refined(_: float) -> Answer:
            return Answer(
                natural.modes(matrices).natural_frequency / size, REFINED * len(size) ** 3
            )

        ask = Ask("response", "natural frequencies", f"{len(size)} undamped, each over its value",
                  "response/modes/natural_frequency", "", 15.0,
                  "shapes, digits of low modes next to stiff ones, and errors")  # fmt: skip
        solver = ours("Cholesky, eigh, refined", "steps of refinement on the pencil", refined,
                      citation="Ogita and Aishima (2018), algorithm 1")  # fmt: skip
        found.append(modes(ask, [solver], parts.mass, parts.stiffness, size))
    loads, speed = body_loads(scene, "response"), scene.case.machine.speed
    orders, load = _driven(loads, loads.load)
    if not len(orders):
        return found
    w, count, shape = orders * speed, len(orders), system.shapes.shape

    def translations(form: Linear, basis: np.ndarray) -> np.ndarray:
        value = response(dynamics(form, w), *(load @ basis)).value @ basis.T
        return np.asarray(value[:, :3])

    def direct(_: float) -> Answer:
        return Answer(translations(matrices, np.eye(6)), INVERSE * count)

    def modal(_: float) -> Answer:
        return Answer(translations(in_modes(matrices, shape), shape), EIGENPAIRS + INVERSE * count)

    solvers = [
        ours(name, words, solve, default=1.0 if options.method == name else None, citation=source)
        for name, words, solve, source in (
            ("direct", "all orders inverted together, a step of refinement", direct,
             "Harris and Piersol (2002), ch. 3"),
            ("modal", "sum of all modes", modal, "Thomson and Dahleh (1998), ch. 6"),
        )
    ]  # fmt: skip
    extra = INVERSE if options.method == "direct" else float(np.ceil(EIGENPAIRS / count + INVERSE))
    ask = Ask("response", "translations by order", f"{count} driven orders at {speed:.6g} rad/s",
              "response/translation_harmonics", "m", extra,
              "an error for every entry; modes are results themselves")  # fmt: skip
    return [*found, forced(ask, solvers, parts, w, load.value, lambda found: found[:, :3])]


def _driven(loads: BodyLoads | LoadsOverSpeed, load: Bounded) -> tuple[np.ndarray, Bounded]:
    """Orders (m,) kept that move the body under loads (..., every order, 6), and these."""
    load = load[..., : loads.retained, :]
    moves = np.any(np.abs(load.value) > 4.0 * load.error, axis=(-1, *range(load.value.ndim - 2)))
    return loads.order[: loads.retained][moves], load[..., moves, :]


def speeds_topics(scene: Scene) -> list[Topic]:
    """Mean kinetic energy at speeds of the range, golden steps apart; none at rest."""
    options = scene.case.response
    if options is None or options.run_up is None:
        return []
    matrices, start, stop = mounted_body(scene).matrices, options.run_up.start, options.run_up.stop
    share = np.sort(np.modf(0.6180339887498949 * np.arange(1, SPEEDS + 1))[0])
    speed, loads = start + (stop - start) * share, loads_over_speed(scene, "response", start, stop)
    orders, load = _driven(loads, loads.at(speed))
    if not len(orders):
        return []
    w = np.outer(speed, orders)

    def direct(_: float) -> Answer:
        motion = response(dynamics(matrices, w), load.value, load.error)
        return Answer(
            mean_over_cycle(mass_of(matrices), velocity(motion, w)).value, INVERSE * w.size
        )

    def energies(amplitudes: np.ndarray) -> np.ndarray:
        rate = w.reshape(-1, 1) * amplitudes
        each = np.einsum("mi,ij,mj->m", rate.conj(), matrices.mass, rate).real
        return np.asarray(0.25 * each.reshape(w.shape).sum(-1))

    ask = Ask("speeds", "mean kinetic energy over speed", f"{SPEEDS} speeds, {len(orders)} orders",
              "response/run_up/kinetic_energy", "J", INVERSE, "an error for each")  # fmt: skip
    solver = ours("direct", "orders and speeds inverted together, refined", direct)
    parts, rows = Matrices(*matrices[:4]), load.value.reshape(-1, 6)
    return [forced(ask, [solver], parts, w.ravel(), rows, energies)]


def operations_topics(scene: Scene) -> list[Topic]:
    """The highest peak energy over all angles of the balance weight that matters most."""
    options = scene.case.response
    if options is None or not options.operations:
        return []
    forcing, system = forcing_of(scene), mounted_body(scene)
    loads = operation_loads(scene, options.operations, options.balances)
    speed, kept = scene.case.machine.speed, forcing.retained
    orders, weight = forcing.order[:kept], mass_of(system.matrices)

    acting = Parts(loads.shaking[:, :kept], loads.residual).times(np.full(kept, speed**2))
    parts = superpose(dynamics(system.matrices, orders * speed), acting)
    push = parts.shaking.value[:, None, 0].conj() * (parts.residual.value @ weight.value)
    swing = np.abs(np.sum(push, axis=-1))
    if not np.any(swing > 0.0):
        return []
    at = np.unravel_index(int(np.argmax(swing)), swing.shape)
    moving = parts.times(1j * orders * speed)
    harmonics, *_ = energy_signal(weight, moving.shaking[at[0]][None])
    turned = energy_signal(weight, moving.residual[at][None, None])[0][..., 0]
    rtol = scene.case.accuracy.rtol

    def curve(phase: FloatArray) -> FloatArray:
        signal = np.repeat(harmonics, len(phase), axis=0)
        signal[..., 0] += np.exp(1j * phase)[:, None] * turned
        return np.asarray(0.5 * np.square(vector_cycle_peak(signal, orders).value))

    def bounded(tolerance: float) -> Answer:
        found, peaks = search_phases(harmonics, orders, turned, tolerance)
        return Answer(found.high.value, float(peaks[0]))

    known = float(search_phases(harmonics, orders, turned, rtol)[0].high_phase[0])
    names = names_of(scene.case)
    ask = Ask("operations", "highest peak energy",
              f"{names['operation'][at[0]]!r} with {names['balance'][at[1]]!r} at any angle",
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
    system, every = modes_and_loads(scene)
    modal, shape = every.some(slice(every.retained)), system.shape
    orders, load = modal.orders, modal.amplitude.value
    speed, angle = scene.case.machine.speed, options.crank_angle
    frequency, none = system.frequency, np.zeros((6, 6))
    loss = np.diag(2.0 * system.damping_ratio * frequency)
    matrix = np.block([[none, np.eye(6)], [-np.diag(np.square(frequency)), -loss]])
    old, new = (steady_motion(system, modal, k, speed) for k in (0, 1))

    def steady(motion: SteadyMotion, at: np.ndarray) -> np.ndarray:
        return steady_state(motion.amplitude, orders, speed, at)

    def translations(displacement: np.ndarray) -> np.ndarray:
        return np.asarray(displacement[:, :6] @ shape[:3].T)

    begin = steady(old, np.asarray(angle))
    start = begin.T.ravel()
    length = np.maximum(np.abs(start[:6]), 1e-3 * np.max(np.abs(start[:6])))
    scale = np.concatenate([length, length * speed])

    def rates(operation: int, acceleration: float, time: float, state: FloatArray) -> FloatArray:
        now = speed + acceleration * time
        theta = angle + time * (speed + 0.5 * acceleration * time)
        wave = (now * now - 1j * acceleration / orders) * np.exp(1j * orders * theta)
        result = matrix @ state
        result[6:] += (wave @ load[operation]).real
        return np.asarray(result)

    times = TURN / (16.0 * speed) * np.arange(33)

    def closed(_: float) -> Answer:
        forced_part = steady(new, angle + speed * times[1:])
        free = free_motion(system, times[1:], begin - steady(new, np.asarray(angle)))
        return Answer(translations((forced_part + free)[..., 0]), 32.0)

    path = "response/switching/{}/translation_high, translation_low"
    ask = Ask("switching", "change at once", "translations in the two turns after the change",
              path.format("instant"), "m")  # fmt: skip
    solver = ours("closed form of modes", "steady and free motion of each mode", closed,
                  citation="cf. Goloskokow and Filippow (1971)")  # fmt: skip
    topics = [time_history(
        ask, [solver], partial(rates, 1, 0.0), start, times, translations, scale,
        lambda: closed(1.0).values, matrix,
    )]  # fmt: skip
    if not options.run_down > 0.0:
        return topics
    span, acceleration = 0.1 * float(options.run_down), -speed / float(options.run_down)
    moments = span / 20.0 * np.arange(21)
    ramp = [SpeedSegment(span, speed, speed + acceleration * span, 0)]
    bounded_course = course_of(system, modal, ramp, angle, 0)
    course = replace(bounded_course, amplitude=modal.amplitude.value)

    def quadrature(phase: float) -> Answer:
        found = panels_of(bounded_course, span, phase)
        node = np.union1d(found.node, moments)
        panels = Panels(node, np.zeros(len(node) - 1, dtype=int))
        moved = march(course, panels)[np.searchsorted(node, moments[1:])]
        return Answer(translations(moved[..., 0]), 13.0 * len(panels.run))

    ask = Ask("switching", "run-down", f"translations in its first {span:.3g} s",
              path.format("reversal"), "m", 3.5, "short panels bound peaks between")  # fmt: skip
    solver = ours("quadrature of the propagator", "Gauss's rule on panels", quadrature,
                  "phase of a panel [rad]", (32.0, 16.0, 8.0, 4.0), PANEL_PHASE, "geometric",
                  "cf. Goloskokow and Filippow (1971)", falling=True)  # fmt: skip
    return [*topics, time_history(
        ask, [solver], partial(rates, 0, acceleration), start, moments, translations, scale,
        lambda: quadrature(0.5 * PANEL_PHASE).values, matrix,
    )]  # fmt: skip

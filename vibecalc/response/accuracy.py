"""Questions of the response of a body: modes, forced motion, energies, changes in time."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from vibecalc.core.accuracy.kinds import TURN, forced, modes, peak_over_range, time_history
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import in_rpm
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.linear import Linear, dynamics, response
from vibecalc.numerics.rounding import FloatArray
from vibecalc.response import modes as natural
from vibecalc.response.adapters.loads import body_loads
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import forcing_of, mounted_body
from vibecalc.response.adapters.switching import modes_and_loads
from vibecalc.response.energies import energy_signal, mass_of
from vibecalc.response.operations import Parts, search_phases, superpose
from vibecalc.response.stage import names_of
from vibecalc.response.switching.motion import PANEL_PHASE, course_of, march, panels_of
from vibecalc.response.switching.system import (
    SpeedSegment,
    free_motion,
    steady_motion,
    steady_state,
)
from vibecalc.response.system import in_modes

#: multiplications over n^3 of the refined modes: factors, vectors, quotients, two steps
REFINED = 19.7
#: solutions that an inverse with a step of refinement takes, six eigenpairs
INVERSE, EIGENPAIRS = 4.0, 25.0


def response_topics(scene: Scene) -> list[Topic]:
    """Natural frequencies where all modes are held; translations of the orders that are driven."""
    system, options = mounted_body(scene), scene.case.response
    if options is None or system.spectral is not None:
        return []  # the questions are of matrices that no frequency changes
    matrices, found = system.matrices, []
    size = system.shapes.natural_frequency
    if np.all(system.shapes.held):

        def refined(_: float) -> Answer:
            frequency = natural.modes(matrices).natural_frequency
            return Answer(frequency / size, REFINED * len(size) ** 3)

        ask = Ask("natural frequencies", f"{len(size)} undamped, each over its value",
                  "response/modes/natural_frequency", 15.0,
                  "shapes, digits of low modes next to stiff ones, and errors")  # fmt: skip
        solver = Solver("Cholesky, eigh, refined", refined)
        found.append(modes(ask, [solver], matrices.mass, matrices.stiffness, size))
    loads, speed = body_loads(scene, "response"), scene.case.machine.speed
    load = loads.load[: loads.retained]
    moves = np.any(np.abs(load.value) > 4.0 * load.error, axis=-1)
    orders, load = loads.order[: loads.retained][moves], load[moves]
    if not len(orders):
        return found
    w, count, shape = orders * speed, len(orders), system.shapes.shape

    def translations(form: Linear, basis: np.ndarray, work: float, _: float) -> Answer:
        value = response(dynamics(form, w), *(load @ basis)).value @ basis.T
        return Answer(value[:, :3], work)

    ways = {
        "direct": (matrices, np.eye(6), INVERSE * count),
        "modal": (in_modes(matrices, shape), shape, EIGENPAIRS + INVERSE * count),
    }
    solvers = [
        Solver(name, partial(translations, *given), default=1.0 if options.method == name else None)
        for name, given in ways.items()
    ]
    extra = INVERSE if options.method == "direct" else float(np.ceil(EIGENPAIRS / count + INVERSE))
    ask = Ask("translations by order", f"{count} driven orders at {in_rpm(speed)}",
              "response/translation_harmonics", extra,
              "an error for every entry; modes are results themselves")  # fmt: skip
    return [*found, forced(ask, solvers, matrices, w, load.value, lambda found: found[:, :3])]


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
    ask = Ask("highest peak energy",
              f"{names['operation'][at[0]]!r} with {names['balance'][at[1]]!r} at any angle",
              "response/operations/kinetic_energy/peak_low, peak_high", 12.0,
              "no angle is left out, and both ends are proven to within rtol")  # fmt: skip
    solver = Solver("branch and bound", bounded, "rtol", (1e-1, 1e-2, 1e-3, 1e-4, 1e-6), rtol)
    ends = known - 0.5 * TURN, known + 0.5 * TURN
    return [peak_over_range(ask, solver, curve, ends, known, work="peaks over the cycle",
                            around=True)]  # fmt: skip


def switching_topics(scene: Scene) -> list[Topic]:
    """Translations in the turns after a change at once, and at the beginning of a run-down."""
    options = scene.case.response.switching if scene.case.response else None
    if options is None:
        return []
    system, every = modes_and_loads(scene)
    modal, shape = every.some(slice(every.retained)), system.shape
    orders, load = modal.orders, modal.amplitude.value
    speed, angle = scene.case.machine.speed, options.crank_angle
    frequency, none = system.frequency, np.zeros((6, 6))
    loss = np.diag(2.0 * system.damping_ratio * frequency)
    matrix = np.block([[none, np.eye(6)], [-np.diag(np.square(frequency)), -loss]])

    def steady(operation: int, at: np.ndarray | float) -> np.ndarray:
        motion = steady_motion(system, modal, operation, speed)
        return steady_state(motion.amplitude, orders, speed, np.asarray(at))

    def translations(displacement: np.ndarray) -> np.ndarray:
        return np.asarray(displacement[:, :6] @ shape[:3].T)

    begin = steady(0, angle)
    length = np.maximum(np.abs(begin[:, 0]), 1e-3 * np.max(np.abs(begin[:, 0])))
    start, scale = begin.T.ravel(), np.concatenate([length, length * speed])

    def rates(operation: int, acceleration: float, time: float, state: FloatArray) -> FloatArray:
        now = speed + acceleration * time
        theta = angle + time * (speed + 0.5 * acceleration * time)
        wave = (now * now - 1j * acceleration / orders) * np.exp(1j * orders * theta)
        result = matrix @ state
        result[6:] += (wave @ load[operation]).real
        return np.asarray(result)

    times = TURN / (16.0 * speed) * np.arange(33)

    def closed(_: float) -> Answer:
        free = free_motion(system, times[1:], begin - steady(1, angle))
        moved = steady(1, angle + speed * times[1:]) + free
        return Answer(translations(moved[..., 0]), 32.0)

    path = "response/switching/{}/translation_high, translation_low"
    ask = Ask("change at once", "translations in the two turns after the change",
              path.format("instant"))  # fmt: skip
    solver = Solver("closed form of modes", closed)
    topics = [time_history(ask, solver, partial(rates, 1, 0.0), start, times, translations, scale,
                           lambda: closed(1.0).values, matrix)]  # fmt: skip
    if not options.run_down > 0.0:
        return topics
    span, acceleration = 0.1 * float(options.run_down), -speed / float(options.run_down)
    moments = span / 20.0 * np.arange(21)
    paces = speed + acceleration * moments
    ramp = [SpeedSegment(span / 20.0, *pair, 0) for pair in pairwise(paces.tolist())]
    course = course_of(system, modal, ramp, angle, 0)

    def quadrature(phase: float) -> Answer:
        panels = panels_of(course, span, phase)
        ends = np.cumsum(np.bincount(panels.run))
        moved = march(replace(course, amplitude=load), panels)[ends]
        return Answer(translations(moved[..., 0]), 13.0 * len(panels.run))

    ask = Ask("run-down", f"translations in its first {span:.3g} s", path.format("reversal"), 3.5,
              "short panels bound peaks between")  # fmt: skip
    solver = Solver("quadrature of the propagator", quadrature, "phase of a panel [rad]",
                    (32.0, 16.0, 8.0, 4.0), PANEL_PHASE, "geometric")  # fmt: skip
    return [*topics, time_history(
        ask, solver, partial(rates, 0, acceleration), start, moments, translations, scale,
        lambda: quadrature(0.5 * PANEL_PHASE).values, matrix,
    )]  # fmt: skip

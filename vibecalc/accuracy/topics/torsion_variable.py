"""A shaft line whose inertias turn with it: orders of the balance, mean inertias, steps in time."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.topics.torsion_cycle import apart
from vibecalc.accuracy.yardsticks.shaft_cycles import half_ranges_of_samples
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import build_setup
from vibecalc.pipeline.stages.torsion.variable import gas_torque, half_ranges, system_of
from vibecalc.response.torsion.line import damping_matrix, stiffness_matrix
from vibecalc.response.torsion.variable_inertia import VariableLine
from vibecalc.response.torsion.variable_inertia_steady import constant_response, steady_response

KEPT = (12.0, 14.0, 16.0, 18.0, 20.0, 23.0)
STEPS = (90.0, 180.0, 360.0, 720.0)
#: orders of the trusted answer over those taken, and steps of its second way
MORE, FINEST = 1.5, 1080
#: steps of Newton's method that a balance takes, and those of shooting
PASSES, SHOTS = 4.0, 3
#: size of the changes that tell a derivative, and of what may be left over; over the twist
NUDGE, LEFT = 1e-6, 1e-8


def topics(scene: Scene) -> list[Topic]:
    """Half ranges of the torques at the operating speed; none where inertias are constant."""
    setup = build_setup(scene.case)
    options = setup.torsion.variable_inertia
    if options is None or not setup.model.line.inertia.all():
        return []
    speed = setup.speed
    system, torque = system_of(setup, speed), gas_torque(setup, speed)
    path = "response/torsion/variable_inertia/highest_order"
    if options.orders is not None:
        taken = float(options.orders)
    elif path in scene.record.quantities:
        taken = float(scene.record.quantities[path].values)
    else:
        taken = float(np.ceil(max(setup.drive.order[-1], system.variation.shape[1]))) + 1.0
    n = len(system.line.inertia)

    def balanced(highest: float) -> Answer:
        found = steady_response(system, speed, torque, highest, exact=True)
        return Answer(half_ranges(system, speed, found)[0], PASSES * _work(system, highest))

    def linear(highest: float) -> Answer:
        found = steady_response(system, speed, torque, highest)
        return Answer(half_ranges(system, speed, found)[0], _work(system, highest))

    def constant(_: float) -> Answer:
        found = constant_response(system, speed, torque, taken)
        return Answer(half_ranges(system, speed, found)[0], taken * system.turns * n**3 / 3.0)

    def shot(steps: float) -> Answer:
        found = _by_shooting(system, speed, torque, int(steps))
        each = 4.0 * (2.0 * n * system.variation.shape[1] + 2.0 * n**2) / 2.0
        return Answer(found, (SHOTS * (2.0 * n + 2.0) + 1.0) * steps * each)

    def reference() -> Reference:
        many = steady_response(system, speed, torque, np.ceil(MORE * taken), exact=True)
        value = half_ranges(system, speed, many)[0]
        other = _by_shooting(system, speed, torque, FINEST)
        return Reference(
            value, apart(value, other),
            f"harmonic balance to order {np.ceil(MORE * taken):g}, held against {FINEST} steps of "
            "RK4 and the state that comes back",
        )  # fmt: skip

    settings = tuple(sorted({*(one for one in KEPT if one < taken), taken, np.ceil(1.2 * taken)}))
    ladders = (
        Ladder(
            "harmonic balance", "the whole Lagrangian system by Newton's method", "highest order",
            settings, balanced, default=taken, theory="geometric",
            citation="Pasricha and Carnegie 1976",
        ),
        Ladder(
            "linear balance", "its first step: linear in the twist", "highest order", settings,
            linear,
        ),
        Ladder(
            "mean inertias", "with the inertia torque as a load, as is usual", "", NOTHING_TO_SET,
            constant,
        ),
        Ladder(
            "steps in time", "RK4 over a cycle, Newton's method on the state that comes back",
            "steps", STEPS, shot, theory="order 3: a parabola through the highest steps",
        ),
    )  # fmt: skip
    return [
        Topic(
            "variable inertia", "half ranges",
            f"half range of the torque of all sections at {speed:.6g} rad/s",
            "response/torsion/variable_inertia/torque_half_range", "N*m", "complex multiplications",
            reference, ladders,
            default_extra=3.0,
            default_why="loss factors and undamped lines too, and an error estimate of every order",
        )
    ]  # fmt: skip


def _work(system: VariableLine, highest: float) -> float:
    """Factors of the orders kept and of those just beyond, which tell the truncation."""
    n, reach = len(system.line.inertia), system.turns * system.variation.shape[1]
    inner = (2.0 * highest * system.turns + 1.0) * n
    return float((inner**3 + (2.0 * reach * n) ** 3) / 3.0)


def _by_shooting(
    system: VariableLine, speed: float, torque: ComplexArray, steps: int
) -> FloatArray:
    """Half ranges (e,) of the section torques over the cycle that comes back to its start.

    Unknown are angles and rates at the start and the steady torque of the load; the mean angle,
    weighted with the inertias, is zero. Raises NumericalFailure for loss factors and where Newton's
    method does not settle.
    """
    line = system.line
    if np.any(line.loss_factor):
        raise NumericalFailure("a loss factor has no form in time: it is of steady vibration only")
    n, free = len(line.inertia), int(not np.any(line.ground_stiffness))
    size = np.concatenate([np.ones(n), np.full(n, speed), np.full(free, speed**2)])
    size[2 * n :] *= line.inertia.sum()
    unknown, nudge = np.zeros(2 * n + free), NUDGE * size
    march = _marcher(system, speed, torque, steps)
    for _ in range(SHOTS):
        gap = march(np.concatenate([unknown[None], unknown + np.diag(nudge)]))[0] / size
        slope = ((gap[1:] - gap[0]) / nudge[:, None]).T
        unknown = unknown + np.linalg.lstsq(slope * size, -gap[0], rcond=1e-13)[0] * size
    gap, course = march(unknown[None])
    angle, rate = course[:-1, 0, :n], course[:-1, 0, n:]
    twist = angle[:, line.first] - angle[:, line.second]
    if not np.max(np.abs(gap[0] / size)) <= LEFT:
        raise NumericalFailure(f"{steps} steps: the state that comes back was not found")
    spin = rate[:, line.first] - rate[:, line.second]
    return half_ranges_of_samples((line.stiffness * twist + line.damping * spin).T)


def _marcher(
    system: VariableLine, speed: float, torque: ComplexArray, steps: int
) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]]:
    """From starts (k, 2 n + 1) to what does not come back (the same shape) and the courses."""
    line, n = system.line, len(system.line.inertia)
    free = not np.any(line.ground_stiffness)
    weight, load = line.inertia / line.inertia.sum(), system.load / system.load.sum()
    shafts = np.concatenate([stiffness_matrix(line), damping_matrix(line)])
    h = 2.0 * np.pi * system.turns / speed / steps
    times = 0.5 * h * np.arange(2 * steps + 1)
    gas = (
        np.exp(1j * speed * times[:, None] / system.turns * np.arange(len(torque))) @ torque
    ).real
    order = np.arange(1, system.variation.shape[1] + 1)

    def march(starts: FloatArray) -> tuple[FloatArray, FloatArray]:
        held = starts[:, 2 * n :] * load if free else np.zeros(n)
        state = starts[:, : 2 * n]
        mean, courses = np.zeros(len(starts)), [state]

        def rates(place: int, now: FloatArray) -> FloatArray:
            phase = (speed * times[place] + now[:, :n])[..., None] * order
            turned = np.exp(1j * phase) * system.variation
            inertia = line.inertia + turned.real.sum(axis=-1)
            bend = 0.5 * turned.imag @ order * (speed + now[:, n:]) ** 2
            bend = (bend + gas[place] + held - now @ shafts) / inertia
            return np.concatenate([now[:, n:], bend], axis=1)

        for k in range(steps):
            one = rates(2 * k, state)
            two = rates(2 * k + 1, state + 0.5 * h * one)
            three = rates(2 * k + 1, state + 0.5 * h * two)
            four = rates(2 * k + 2, state + h * three)
            mean = mean + state[:, :n] @ weight / steps
            state = state + h / 6.0 * (one + 2.0 * (two + three) + four)
            courses.append(state)
        gap = [state - starts[:, : 2 * n]]
        if free:
            # a gap as of an acceleration, for its size to be that of the unknown
            gap.append(mean[:, None] * speed**2 * line.inertia.sum())
        return np.concatenate(gap, axis=1), np.array(courses)

    return march

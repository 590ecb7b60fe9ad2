"""Accuracy of studies next to the steady vibration: change in time, variable inertia."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import Rates, march_fixed, march_scipy
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import ComplexArray, FloatArray
from vibecalc.torsion.accuracy.by_other_means import half_ranges_of_samples
from vibecalc.torsion.accuracy.steady import apart
from vibecalc.torsion.adapters.setup import build_setup
from vibecalc.torsion.adapters.transient_motion import journey
from vibecalc.torsion.adapters.variable_inertia import gas_torque, half_ranges, system_of
from vibecalc.torsion.line import damping_matrix, stiffness_matrix
from vibecalc.torsion.transient.march import (
    POINTS,
    StepBlock,
    TransientSystem,
    cut,
    march,
    rest_state,
    steady_start,
    transient_system,
)
from vibecalc.torsion.transient.motion import (
    SpeedProfile,
    Stretch,
    TorqueLaw,
    speed_after,
    speed_profile,
    torque_law,
    turned_after,
)
from vibecalc.torsion.variable_inertia.motion import VariableLine
from vibecalc.torsion.variable_inertia.steady import constant_response, steady_response

# ----------------------------------------------------------------------------
# The first cycle of a change in time of a shaft line: exact propagation, Runge-Kutta, scipy's.
# ----------------------------------------------------------------------------

#: moments at which the torques are compared, evenly over the time
MOMENTS = 8
#: with the steps of the kernel as one
SHARES = (0.125, 0.25, 0.5, 1.0, 2.0)
STEPS = (64.0, 128.0, 256.0, 512.0, 1024.0)
#: the trusted march takes so many times the steps of the kernel
FINER = 4
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)


#: logarithm of the growth of free vibration from which on a march is unstable
GROWN = 5.0


class Short(NamedTuple):
    """The beginning of a change: one stretch, from a state, with what it takes to follow it."""

    system: TransientSystem
    part: Stretch
    borders: SpeedProfile
    law: TorqueLaw
    begin: FloatArray
    order: FloatArray


def torsion_transient_topics(scene: Scene) -> list[Topic]:
    """Torques of the sections over the first cycle of the change; none without a change."""
    setup = build_setup(scene.case)
    options = setup.torsion.transient
    if options is None:
        return []
    path = journey(setup, scene.case.machine, options)
    whole = speed_profile(path.stretches, path.speed)
    steady = path.start == "steady"
    # what lasts before the change is no transient
    first = 0
    while first + 1 < len(path.stretches) and steady and _lasts(path.stretches[first], first):
        first += 1
    system = transient_system(path.line, path.reaction)
    speed, angle = float(whole.speed[first]), float(whole.angle[first])
    part = _shortened(path.stretches[first], speed, setup.drive.firing.cycle)
    borders = speed_profile([part], speed, angle)
    law = torque_law(path.order, part, system.balance, system.inertia, borders.speed)
    begin = rest_state(system)
    if steady:
        before = path.stretches[max(first - 1, 0)]
        begin = steady_start(system, path.order, before, speed, angle)
    return [_topic(Short(system, part, borders, law, begin, path.order))]


def _lasts(part: Stretch, place: int) -> bool:
    """Whether a stretch is one of constant speed before a change."""
    return place == 0 and part.acceleration == 0.0 and part.acceleration_rate == 0.0


def _shortened(part: Stretch, speed: float, cycle: float) -> Stretch:
    """As much of a stretch as a cycle takes, or all of it."""
    times = np.linspace(0.0, part.duration, 2001)
    turned = turned_after(part, speed, times)
    duration = float(np.interp(cycle, turned, times))
    share = duration / part.duration
    ends = speed_after(part, speed, np.array([duration, part.duration]))
    passed = (ends[0] - speed) / (ends[1] - speed) if ends[1] != speed else 0.0
    return part._replace(
        duration=duration,
        scale_end=part.scale_start + share * (part.scale_end - part.scale_start),
        gas_end=part.gas + passed * (part.gas_end - part.gas),
    )


def _topic(short: Short) -> Topic:
    system, duration = short.system, short.part.duration
    highest = float(short.law.power.max(initial=0.0)) / 2.0
    parts = cut([short.part], short.borders, highest, system.fastest, 1.0)
    taken = MOMENTS * max(1, round(sum(one.steps for one in parts) / MOMENTS))
    times = np.linspace(0.0, duration, MOMENTS + 1)
    rates = _rates(short)

    def shown(states: FloatArray) -> FloatArray:
        return np.asarray(states @ system.torque.T)

    def propagated(steps: float) -> FloatArray:
        count = int(steps)
        block = StepBlock(0, 0.0, duration / count, count)
        (states,) = march(system, [short.part], short.borders, [short.law], [block], short.begin)
        return shown(states[:: count // MOMENTS][1:])

    def kernel(steps: float) -> Answer:
        found = propagated(steps)
        propagated_twice = 1.5  # whole steps next to the halves tell the error
        return Answer(found, propagated_twice * POINTS * steps)

    def fixed(method: str, steps: float) -> Answer:
        _refuse_growth(system, duration / steps, int(steps), method)
        found = march_fixed(rates, short.begin, 0.0, duration, int(steps), method)
        return Answer(shown(found.states[:: int(steps) // MOMENTS][1:]), found.evaluations)

    def scipys(method: str, tolerance: float) -> Answer:
        size = tolerance * float(np.max(np.abs(short.begin), initial=1e-3))
        found = march_scipy(
            rates, short.begin, times, tolerance, size, method,
            system.state_matrix if method in ("Radau", "BDF") else None,
        )  # fmt: skip
        return Answer(shown(found.states[1:]), found.evaluations)

    def reference() -> Reference:
        fine = propagated(FINER * taken)
        size = 1e-13 * float(np.max(np.abs(short.begin), initial=1e-3))
        other = shown(march_scipy(rates, short.begin, times, 1e-13, size).states[1:])
        return Reference(
            fine, apart(fine, other),
            f"{FINER * taken} steps of exact propagation, held against DOP853 at 1e-13",
        )  # fmt: skip

    multiples = sorted({MOMENTS * max(1, round(one * taken / MOMENTS)) for one in SHARES})
    solvers = (
        Solver(
            "exact propagation", "matrix exponential, torque a polynomial over ten points; twice, "
            "with whole and half steps", "steps", tuple(map(float, multiples)), kernel,
            default=float(taken), theory="order 10 at least",
        ),
        Solver(
            "Runge-Kutta", "classical, equal steps", "steps", STEPS,
            lambda steps: fixed("rk4", steps), theory="order 4",
        ),
        Solver(
            "Euler", "explicit, equal steps", "steps", STEPS[1:],
            lambda steps: fixed("euler", steps), theory="order 1",
        ),
        *(
            Solver(name, "scipy.integrate.solve_ivp", "rtol", levels, partial(scipys, name))
            for name, levels in (
                ("RK45", TOLERANCES[:3]), ("DOP853", TOLERANCES), ("Radau", TOLERANCES[:3]),
            )
        ),
    )  # fmt: skip
    return Topic(
        "transient", "torques in time",
        f"torques of all sections at {MOMENTS} moments of the first {duration:.4g} s of the change",
        "response/torsion/transient/peak", "N*m",
        "evaluations of the torques on all stations", reference, solvers,
    )  # fmt: skip


def _refuse_growth(system: TransientSystem, step: float, steps: int, method: str) -> None:
    """Raise NumericalFailure where steps make free vibration grow that in truth dies out."""
    z = step * np.linalg.eigvals(system.state_matrix)
    factor = (
        1.0 + z
        if method == "euler"
        else 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))
    )
    growth = steps * float(np.log(np.max(np.abs(factor))))
    if growth > GROWN:
        raise NumericalFailure(
            f"{steps} steps are unstable: free vibration grows "
            f"{np.exp(min(growth, 700.0)):.1g} times"
        )


def _rates(short: Short) -> Rates:
    """Right-hand side: state (s,) at times in s from the begin of the stretch."""
    system, part, law = short.system, short.part, short.law
    matrix, inputs = system.state_matrix, system.input_matrix
    m = len(law.power)
    gas, growth, inertia = (one[:, :m] - 1j * one[:, m:] for one in law.harmonic)
    start, half = float(short.borders.speed[0]), 0.5j * law.power
    begin = float(short.borders.angle[0] % (8.0 * np.pi))

    def rates(time: float, state: FloatArray) -> FloatArray:
        share = time / part.duration
        at = begin + float(turned_after(part, start, np.array(time)))
        speed = float(speed_after(part, start, np.array(time)))
        scale = part.scale_start + share * (part.scale_end - part.scale_start)
        wave = np.exp(half * at)
        torque = scale * ((gas + (speed - start) * growth + speed**2 * inertia) @ wave).real
        torque = torque + law.pull[0] + share * (law.pull[1] - law.pull[0])
        torque = torque + speed**law.exponent @ law.load
        return np.asarray(matrix @ state + inputs @ torque)

    return rates


# ----------------------------------------------------------------------------
# A shaft line whose inertias turn with it: orders of the balance, mean inertias, steps in time.
# ----------------------------------------------------------------------------

KEPT = (12.0, 14.0, 16.0, 18.0, 20.0, 23.0)
SHOT_STEPS = (90.0, 180.0, 360.0, 720.0)
#: orders of the trusted answer over those taken, and steps of its second way
MORE, FINEST = 1.5, 1080
#: steps of Newton's method that a balance takes, and those of shooting
PASSES, SHOTS = 4.0, 3
#: size of the changes that tell a derivative, and of what may be left over; over the twist
NUDGE, LEFT = 1e-6, 1e-8


def torsion_variable_topics(scene: Scene) -> list[Topic]:
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
    solvers = (
        Solver(
            "harmonic balance", "the whole Lagrangian system by Newton's method", "highest order",
            settings, balanced, default=taken, theory="geometric",
            citation="Pasricha and Carnegie 1976",
        ),
        Solver(
            "linear balance", "its first step: linear in the twist", "highest order", settings,
            linear,
        ),
        Solver(
            "mean inertias", "with the inertia torque as a load, as is usual", "", NOTHING_TO_SET,
            constant,
        ),
        Solver(
            "steps in time", "RK4 over a cycle, Newton's method on the state that comes back",
            "steps", SHOT_STEPS, shot, theory="order 3: a parabola through the highest steps",
        ),
    )  # fmt: skip
    return [
        Topic(
            "variable inertia", "half ranges",
            f"half range of the torque of all sections at {speed:.6g} rad/s",
            "response/torsion/variable_inertia/torque_half_range", "N*m", "complex multiplications",
            reference, solvers,
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

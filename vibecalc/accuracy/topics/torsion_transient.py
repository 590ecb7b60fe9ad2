"""The first cycle of a change in time of a shaft line: exact propagation, Runge-Kutta, scipy's."""

from functools import partial
from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.topics.torsion_cycle import apart
from vibecalc.accuracy.yardsticks.integrators import Rates, march_fixed, march_scipy
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import build_setup
from vibecalc.pipeline.stages.torsion.transient_course import journey
from vibecalc.response.torsion.transient_march import march
from vibecalc.response.torsion.transient_motion import (
    Course,
    Stretch,
    course,
    speed_after,
    turned_after,
)
from vibecalc.response.torsion.transient_pieces import Piece, cut
from vibecalc.response.torsion.transient_start import rest, steady_start
from vibecalc.response.torsion.transient_step import POINTS
from vibecalc.response.torsion.transient_system import TransientSystem, transient_system
from vibecalc.response.torsion.transient_torque import TorqueLaw, torque_law

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
    borders: Course
    law: TorqueLaw
    begin: FloatArray
    order: FloatArray


def topics(scene: Scene) -> list[Topic]:
    """Torques of the sections over the first cycle of the change; none without a change."""
    setup = build_setup(scene.case)
    options = setup.torsion.transient
    if options is None:
        return []
    path = journey(setup, scene.case.machine, options)
    whole = course(path.stretches, path.speed)
    steady = path.start == "steady"
    # what lasts before the change is no transient
    first = 0
    while first + 1 < len(path.stretches) and steady and _lasts(path.stretches[first], first):
        first += 1
    system = transient_system(path.line, path.reaction)
    speed, angle = float(whole.speed[first]), float(whole.angle[first])
    part = _shortened(path.stretches[first], speed, setup.drive.firing.cycle)
    borders = course([part], speed, angle)
    law = torque_law(path.order, part, system.balance, system.inertia, borders.speed)
    begin = rest(system)
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
        piece = Piece(0, 0.0, duration / count, count)
        (states,) = march(system, [short.part], short.borders, [short.law], [piece], short.begin)
        return shown(states[:: count // MOMENTS][1:])

    def kernel(steps: float) -> Answer:
        found = propagated(steps)
        propagated_twice = 1.5  # whole steps beside the halves tell the error
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
    ladders = (
        Ladder(
            "exact propagation", "matrix exponential, torque a polynomial over ten points; twice, "
            "with whole and half steps", "steps", tuple(map(float, multiples)), kernel,
            default=float(taken), theory="order 10 at least",
        ),
        Ladder(
            "Runge-Kutta", "classical, equal steps", "steps", STEPS,
            lambda steps: fixed("rk4", steps), theory="order 4",
        ),
        Ladder(
            "Euler", "explicit, equal steps", "steps", STEPS[1:],
            lambda steps: fixed("euler", steps), theory="order 1",
        ),
        *(
            Ladder(name, "scipy.integrate.solve_ivp", "rtol", levels, partial(scipys, name))
            for name, levels in (
                ("RK45", TOLERANCES[:3]), ("DOP853", TOLERANCES), ("Radau", TOLERANCES[:3]),
            )
        ),
    )  # fmt: skip
    return Topic(
        "transient", "torques in time",
        f"torques of all sections at {MOMENTS} moments of the first {duration:.4g} s of the change",
        "response/torsion/transient/peak", "N*m",
        "evaluations of the torques on all stations", reference, ladders,
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

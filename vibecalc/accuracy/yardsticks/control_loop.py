"""The closed loop under control and its harmonics, found in many ways.

The controller is that of the case with the speed feedback that the run found, the load that of the
run: none of their errors counts here.
"""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.integrators import march_fixed, march_scipy
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.stages.control_setup import Setup
from vibecalc.response.roll_control.evaluate import Load, evaluate, evaluate_at_speed
from vibecalc.response.roll_control.model import Controller, Loop, loop_of

#: digits of the references
_DIGITS = 40
#: what is left of a disturbance when a march counts as settled, turns it may take, samples a turn
_FADED, _MOST_TURNS, _SAMPLES = 1e-13, 40, 64


class LoopSetup(NamedTuple):
    """Controller with its speed feedback, load, mean speed (rad/s) and coefficients of the loop."""

    given: Setup
    controller: Controller
    load: Load
    speed: float
    loop: Loop


def loop_setup(given: Setup) -> LoopSetup:
    """The loop of the case as its stage closes it."""
    own, load = given.controller(), given.load(given.target)
    if given.options.speed_feedback is None:
        found = evaluate_at_speed(given.model, own, load, given.target)
    else:
        found = evaluate(given.model, own, load)
        load = given.load(float(found.speed.value))
    controller = own._replace(speed_feedback=float(found.speed_feedback.value))
    loop = loop_of(given.model, controller)
    return LoopSetup(given, controller, load, float(found.speed.value), loop)


def harmonics_topic(setup: LoopSetup) -> Topic:
    """Steady shaking of the shell in the closed loop of the reduced model."""
    orders = len(setup.given.orders)
    ladders = [
        Ladder(
            "closed form", "the transfer function at each order, with its error; as a run does",
            "", NOTHING_TO_SET, lambda _: _closed(setup, orders), default=NOTHING_TO_SET[0],
            citation="Herold (1977), equations 112 and 113",
        ),
        Ladder(
            "linear equations", "numpy.linalg.solve of rotor and actuator at each order",
            "", NOTHING_TO_SET, lambda _: _solved(setup, orders),
        ),
    ]  # fmt: skip
    if float(setup.loop.delay) == 0.0 and float(setup.loop.p2) > 0.0 and _turns(setup) is not None:
        ladders += [
            Ladder(
                "Runge-Kutta in time", "even steps until all has faded, then the Fourier transform",
                "steps a turn", (256.0, 512.0, 768.0, 1024.0),
                lambda steps: _stepped(setup, orders, int(steps)),
            ),
            Ladder(
                "scipy Radau in time", "until all has faded, then the Fourier transform",
                "relative tolerance", (1e-3, 1e-4, 1e-5),
                lambda rtol: _adapted(setup, orders, rtol),
            ),
        ]  # fmt: skip
    return Topic(
        stage="control",
        name="closed loop",
        words=f"harmonics 1 to {orders} of the shell's acceleration under control, reduced model",
        quantity="response/control/shell_acceleration",
        unit="rad/s^2",
        work="evaluations of the equations at one order or one time",
        reference=lambda: _closed_in_digits(setup, orders),
        ladders=tuple(ladders),
    )


def _torques(setup: LoopSetup, orders: int) -> ComplexArray:
    return np.asarray(setup.load.harmonics, dtype=complex)[:orders]


def _closed(setup: LoopSetup, orders: int) -> Answer:
    found = evaluate(
        setup.given.model, setup.controller, setup.load._replace(harmonics=_torques(setup, orders),
        harmonics_error=0.0),
    )  # fmt: skip
    if not bool(found.margins.stable):
        raise NumericalFailure("the loop is not stable: its amplitudes have no bound")
    return Answer(found.harmonics.shell_acceleration.value, float(orders))


class _Matrix(NamedTuple):
    """x' = matrix x + column d(t) for x = (rotor speed, actuator), and the shell's share."""

    matrix: FloatArray
    column: FloatArray
    ratio: float


def _matrix(setup: LoopSetup) -> _Matrix:
    model, own = setup.given.model, setup.controller
    inertia, ratio, motor, viscous = (float(np.asarray(part)) for part in model)
    gain, feedback, back, lag = (float(np.asarray(part)) for part in own[:4])
    rotor = np.array([-(motor + viscous), motor]) / inertia
    pushed = np.array([1.0 / inertia, 0.0])
    if lag > 0.0:
        told = -gain * (np.array([feedback, 0.0]) - back * ratio * rotor)
        pushed[1] = gain * back * ratio / inertia / lag
        return _Matrix(np.stack([rotor, (told - np.array([0.0, 1.0])) / lag]), pushed, ratio)
    return _Matrix(np.stack([rotor, np.zeros(2)]), pushed, ratio)


def _solved(setup: LoopSetup, orders: int) -> Answer:
    model, own = setup.given.model, setup.controller
    inertia, ratio, motor, viscous = (float(np.asarray(part)) for part in model)
    gain, feedback, back, lag, delay = (float(np.asarray(part)) for part in own)
    found = []
    for place, torque in enumerate(_torques(setup, orders)):
        s = 1j * (place + 1) * setup.speed
        late = np.exp(-s * delay)
        matrix = np.array([
            [inertia * s + motor + viscous, -motor],
            [gain * (feedback - back * ratio * s) * late, 1.0 + lag * s],
        ])  # fmt: skip
        rotor = np.linalg.solve(matrix, np.array([torque, 0.0]))[0]
        found.append(-ratio * s * rotor)
    return Answer(np.array(found), float(orders))


def _turns(setup: LoopSetup) -> int | None:
    """Turns until a disturbance has faded; None where that takes too long, or it grows."""
    slowest = float(np.max(np.linalg.eigvals(_matrix(setup).matrix).real))
    if slowest >= 0.0:
        return None
    turns = int(np.ceil(np.log(_FADED) / slowest * setup.speed / (2.0 * np.pi))) + 1
    return turns if turns <= _MOST_TURNS else None


def _rates(setup: LoopSetup, orders: int) -> tuple[Any, _Matrix]:
    own, torques = _matrix(setup), _torques(setup, orders)
    number = np.arange(1, orders + 1)

    def rates(time: float, state: FloatArray) -> FloatArray:
        push = float(np.real(torques @ np.exp(1j * number * (setup.speed * time))))
        return np.asarray(own.matrix @ state + own.column * push)

    return rates, own


def _analysed(setup: LoopSetup, orders: int, states: FloatArray, work: int) -> Answer:
    """Harmonics from one turn of states at even times; the acceleration from the speed's."""
    number = np.arange(1, orders + 1)
    speeds = np.fft.rfft(states[:, 0])[1 : orders + 1] * (2.0 / len(states))
    ratio = float(np.asarray(setup.given.model.ratio))
    return Answer(-ratio * 1j * number * setup.speed * speeds, float(work))


def _stepped(setup: LoopSetup, orders: int, steps: int) -> Answer:
    rates, _ = _rates(setup, orders)
    turns = _turns(setup) or 1
    end = turns * 2.0 * np.pi / setup.speed
    found = march_fixed(rates, np.zeros(2), 0.0, end, turns * steps, "rk4")
    # the march ends a whole number of turns after time zero: the last turn begins in phase
    return _analysed(setup, orders, found.states[-steps - 1 : -1], found.evaluations)


def _adapted(setup: LoopSetup, orders: int, rtol: float) -> Answer:
    rates, own = _rates(setup, orders)
    turns = _turns(setup) or 1
    period = 2.0 * np.pi / setup.speed
    times = period * (turns - 1 + np.arange(_SAMPLES) / _SAMPLES)
    times = np.concatenate([[0.0], times]) if turns > 1 else times
    size = float(np.max(np.abs(_torques(setup, orders)))) / float(own.matrix[0, 1] + 1.0)
    found = march_scipy(rates, np.zeros(2), times, rtol, rtol * size, "Radau", own.matrix)
    return _analysed(setup, orders, found.states[-_SAMPLES:], found.evaluations)


def _closed_in_digits(setup: LoopSetup, orders: int) -> Reference:
    import mpmath as mp

    with mp.workdps(_DIGITS):
        inertia, ratio, motor, viscous = (mp.mpf(float(np.asarray(p))) for p in setup.given.model)
        gain, feedback, back, lag, delay = (
            mp.mpf(float(np.asarray(part))) for part in setup.controller
        )
        found = []
        speed = _mean_speed(mp, setup)
        for place, torque in enumerate(_torques(setup, orders)):
            s = mp.mpc(0, (place + 1) * speed)
            loop = gain * motor * mp.exp(-s * delay) * (feedback - back * ratio * s) / (1 + lag * s)
            found.append(-ratio * s * mp.mpc(torque) / (inertia * s + motor + viscous + loop))
        values = np.array([complex(part) for part in found])
    return Reference(
        values, 16.0 * EPSILON, f"the transfer function of the loop in {_DIGITS} digits"
    )


def _mean_speed(mp: Any, setup: LoopSetup) -> Any:
    """The speed at which motor and load balance, in as many digits as all the rest."""
    model, own, load = setup.given.model, setup.controller, setup.load
    motor, viscous = (mp.mpf(float(np.asarray(p))) for p in (model.motor_gain, model.viscous))
    push = mp.mpf(float(np.asarray(own.gain))) * motor
    reference, mean = (mp.mpf(float(np.asarray(p))) for p in (load.reference, load.mean))
    return (push * reference + mean) / (
        motor + viscous + push * mp.mpf(float(np.asarray(own.speed_feedback)))
    )

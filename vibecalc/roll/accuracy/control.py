"""Accuracy of the control: the closed loop, its harmonics, its poles and its delay margin."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import march_fixed, march_scipy
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.roll.accuracy.control_load import load_topic
from vibecalc.roll.adapters.control import Setup, setup
from vibecalc.roll.control.gains import LoopLoad, evaluate, evaluate_at_speed
from vibecalc.roll.control.loop import Controller, Loop, loop_of
from vibecalc.roll.control.margins import margins, open_loop
from vibecalc.roll.control.poles import poles

# ----------------------------------------------------------------------------
# Topics of the control: the load on the rotor, the closed loop, its poles and its delay margin.
# ----------------------------------------------------------------------------


def control_topics(scene: Scene) -> list[Topic]:
    """What [response.control] asks; none without it. A loop that is not stable has its load only.

    With a delay the poles are left out: there are infinitely many.
    """
    response = scene.case.response
    if response is None or response.control is None:
        return []
    given = setup(scene.case)
    found = [load_topic(given)]
    closed = loop_setup(given)
    if bool(margins(closed.loop).stable):
        found.append(harmonics_topic(closed))
        margin = margin_topic(closed)
        found += [] if margin is None else [margin]
    if not float(closed.loop.delay) > 0.0:
        found.append(poles_topic(closed))
    return found


# ----------------------------------------------------------------------------
# The closed loop under control and its harmonics, found in many ways.
#
# The controller is that of the case with the speed feedback that the run found, the load that of
# the run: none of their errors counts here.
# ----------------------------------------------------------------------------

#: digits of the references
_DIGITS = 40
#: what is left of a disturbance when a march counts as settled, turns it may take, samples a turn
_FADED, _MOST_TURNS, _SAMPLES = 1e-13, 40, 64


class LoopSetup(NamedTuple):
    """Controller with its speed feedback, load, mean speed (rad/s) and coefficients of the loop."""

    given: Setup
    controller: Controller
    load: LoopLoad
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
    solvers = [
        Solver(
            "closed form", "the transfer function at each order, with its error; as a run does",
            "", NOTHING_TO_SET, lambda _: _closed(setup, orders), default=NOTHING_TO_SET[0],
            citation="Herold (1977), equations 112 and 113",
        ),
        Solver(
            "linear equations", "numpy.linalg.solve of rotor and actuator at each order",
            "", NOTHING_TO_SET, lambda _: _solved(setup, orders),
        ),
    ]  # fmt: skip
    if float(setup.loop.delay) == 0.0 and float(setup.loop.p2) > 0.0 and _turns(setup) is not None:
        solvers += [
            Solver(
                "Runge-Kutta in time", "even steps until all has faded, then the Fourier transform",
                "steps a turn", (256.0, 512.0, 768.0, 1024.0),
                lambda steps: _stepped(setup, orders, int(steps)),
            ),
            Solver(
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
        solvers=tuple(solvers),
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
        reported = -gain * (np.array([feedback, 0.0]) - back * ratio * rotor)
        pushed[1] = gain * back * ratio / inertia / lag
        return _Matrix(np.stack([rotor, (reported - np.array([0.0, 1.0])) / lag]), pushed, ratio)
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


# ----------------------------------------------------------------------------
# Poles of a loop without a delay, by formulas that lose digits and one that does not.
# ----------------------------------------------------------------------------


def poles_topic(setup: LoopSetup) -> Topic:
    """Poles of a loop without a delay, which are two or one."""
    return Topic(
        stage="control",
        name="poles",
        words="poles of the closed loop, rightmost first",
        quantity="response/control/pole",
        unit="1/s",
        work="solved polynomials",
        reference=lambda: _poles_in_digits(setup),
        solvers=(
            Solver(
                "stable closed form", "no difference of like numbers; as a run does",
                "", NOTHING_TO_SET, lambda _: Answer(poles(setup.loop).value, 1.0),
                default=NOTHING_TO_SET[0],
            ),
            Solver(
                "textbook formula", "(-b + sqrt(b^2 - 4 a c)) / 2 a",
                "", NOTHING_TO_SET, lambda _: Answer(_textbook(setup.loop), 1.0),
            ),
            Solver(
                "numpy.roots", "eigenvalues of the companion matrix",
                "", NOTHING_TO_SET, lambda _: Answer(_roots(setup.loop), 1.0),
            ),
        ),
    )  # fmt: skip


def _quadratic(loop: Loop) -> tuple[float, float, float]:
    return float(loop.p2), float(loop.p1 + loop.q1), float(loop.p0 + loop.q0)


def _in_order(values: ComplexArray) -> ComplexArray:
    rank = np.lexsort((-values.imag, -values.real))
    ordered: ComplexArray = values[rank]
    return ordered


def _textbook(loop: Loop) -> ComplexArray:
    a, b, c = _quadratic(loop)
    if a == 0.0:
        return np.array([-c / b + 0j])
    root = np.sqrt(complex(b * b - 4.0 * a * c))
    return _in_order(np.array([(-b + root) / (2.0 * a), (-b - root) / (2.0 * a)]))


def _roots(loop: Loop) -> ComplexArray:
    return _in_order(np.roots(np.trim_zeros(_quadratic(loop), "f")).astype(complex))


def _poles_in_digits(setup: LoopSetup) -> Reference:
    import mpmath as mp

    with mp.workdps(_DIGITS):
        loop = setup.loop
        a, b, c = mp.mpf(float(loop.p2)), mp.mpf(float(loop.p1)), mp.mpf(float(loop.p0))
        b, c = b + mp.mpf(float(loop.q1)), c + mp.mpf(float(loop.q0))
        if a == 0:
            found = [-c / b]
        else:
            root = mp.sqrt(b * b - 4 * a * c)
            found = [(-b + root) / (2 * a), (-b - root) / (2 * a)]
        values = _in_order(np.array([complex(part) for part in found]))
    return Reference(values, 16.0 * EPSILON, f"the quadratic formula in {_DIGITS} digits")


# ----------------------------------------------------------------------------
# The delay margin of a loop with the frequency at which it is met: closed form and Bode plots.
# ----------------------------------------------------------------------------

#: decades below and above the crossing that a plot spans
_DECADES = 2.0
_TURN = 2.0 * np.pi


def margin_topic(setup: LoopSetup) -> Topic | None:
    """The delay margin; None for an unstable loop or one that bears any delay."""
    found = margins(setup.loop)
    value, place = float(found.delay.value), float(found.delay_frequency)
    if not (bool(found.stable) and np.isfinite(value) and np.isfinite(place) and value > 0.0):
        return None
    span = place * 10.0**-_DECADES, place * 10.0**_DECADES
    counts = (30.0, 100.0, 300.0, 1000.0, 10000.0, 100000.0)
    return Topic(
        stage="control",
        name="delay margin",
        words="further delay that brings the loop to its limit, and the frequency there",
        quantity="response/control/delay_margin",
        unit="s",
        work="evaluations of the open loop at one frequency",
        reference=lambda: _reference(setup, place),
        solvers=(
            Solver(
                "closed form", "both frequencies of gain one from a quadratic; as a run does",
                "", NOTHING_TO_SET, lambda _: _margin_closed(setup), default=NOTHING_TO_SET[0],
                citation="Walton and Marshall (1987), IEE Proc. D 134, 101-107",
            ),
            Solver(
                "Bode plot", f"logarithms over {2 * _DECADES:g} decades, straight lines between",
                "frequencies", counts, lambda count: _plotted(setup, span, int(count)),
                theory="order 2",
            ),
            Solver(
                "Bode plot, nearest point", "of two at the crossing that with a gain nearer to one",
                "frequencies", counts, lambda count: _nearest(setup, span, int(count)),
            ),
            Solver(
                "scipy brentq", "30 frequencies, then a root of the gain between two of them",
                "tolerance of the frequency", (1e-2, 1e-4, 1e-6, 1e-8, 1e-12),
                lambda tolerance: _root(setup, span, tolerance),
            ),
        ),
        position="frequency [rad/s]",
    )  # fmt: skip


def _margin_closed(setup: LoopSetup) -> Answer:
    found = margins(setup.loop)
    # two frequencies come out of the quadratic, whose phases tell which one is met first
    return Answer(np.array([float(found.delay.value)]), 2.0, float(found.delay_frequency))


def _slack(phase: float) -> float:
    """Lag that is left until the phase is that of -1, in (0, 2 pi]."""
    return float(np.mod(np.pi + phase, _TURN))


def _crossed(gain: np.ndarray) -> int:
    crossings = np.flatnonzero((gain[:-1] - 1.0) * (gain[1:] - 1.0) <= 0.0)
    if not len(crossings):
        raise NumericalFailure("the gain does not pass one between two of the frequencies")
    return int(crossings[-1])


def _points(setup: LoopSetup, span: tuple[float, float], count: int) -> tuple[np.ndarray, ...]:
    frequency = np.geomspace(*span, count)
    return frequency, open_loop(setup.loop, frequency)


def _plotted(setup: LoopSetup, span: tuple[float, float], count: int) -> Answer:
    frequency, value = _points(setup, span, count)
    size = np.log(np.abs(value))
    at = _crossed(np.abs(value))
    share = size[at] / (size[at] - size[at + 1])
    place = float(frequency[at] * (frequency[at + 1] / frequency[at]) ** share)
    turned = np.unwrap(np.angle(value[at : at + 2]))
    phase = float(turned[0] + share * (turned[1] - turned[0]))
    return Answer(np.array([_slack(phase) / place]), float(count), place)


def _nearest(setup: LoopSetup, span: tuple[float, float], count: int) -> Answer:
    frequency, value = _points(setup, span, count)
    at = _crossed(np.abs(value))
    at += int(np.argmin(np.abs(np.log(np.abs(value[at : at + 2])))))
    place = float(frequency[at])
    return Answer(np.array([_slack(float(np.angle(value[at]))) / place]), float(count), place)


def _root(setup: LoopSetup, span: tuple[float, float], tolerance: float) -> Answer:
    from scipy.optimize import brentq

    frequency, value = _points(setup, span, 30)
    at = _crossed(np.abs(value))
    place, reported = brentq(
        lambda w: float(np.log(np.abs(open_loop(setup.loop, np.array([w]))[0]))),
        frequency[at], frequency[at + 1], xtol=tolerance * frequency[at], rtol=4.0 * EPSILON,
        full_output=True,
    )  # fmt: skip
    phase = float(np.angle(open_loop(setup.loop, np.array([place]))[0]))
    work = float(len(frequency) + reported.function_calls + 1)
    return Answer(np.array([_slack(phase) / place]), work, float(place))


def _reference(setup: LoopSetup, near: float) -> Reference:
    import mpmath as mp

    with mp.workdps(_DIGITS):
        p2, p1, p0, q1, q0, delay = (mp.mpf(float(part)) for part in setup.loop)
        a, b, c = p2 * p2, p1 * p1 - 2 * p0 * p2 - q1 * q1, p0 * p0 - q0 * q0
        squares = [-c / b]
        if a != 0:
            root = mp.sqrt(b * b - 4 * a * c)
            squares = [(-b + root) / (2 * a), (-b - root) / (2 * a)]
        found = []
        for square in squares:
            if mp.im(square) == 0 and mp.re(square) > 0:
                w = mp.sqrt(mp.re(square))
                s = mp.mpc(0, w)
                value = (q1 * s + q0) * mp.exp(-s * delay) / ((p2 * s + p1) * s + p0)
                found.append((mp.fmod(mp.pi + mp.arg(value) + 2 * mp.pi, 2 * mp.pi) / w, w))
        least, place = min(found)
        values, frequency = np.array([float(least)]), float(place)
    if abs(frequency - near) > 1e-6 * near:
        raise NumericalFailure("delay margin: the reference meets another crossing than the run")
    return Reference(
        values, 16.0 * EPSILON, f"the quadratic of the crossings in {_DIGITS} digits", frequency
    )

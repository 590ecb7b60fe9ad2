"""The delay margin of a loop with the frequency at which it is met: closed form and Bode plots."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.control_loop import LoopSetup
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.roll_control.crossings import open_loop
from vibecalc.response.roll_control.margins import margins

_DIGITS = 40
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
        ladders=(
            Ladder(
                "closed form", "both frequencies of gain one from a quadratic; as a run does",
                "", NOTHING_TO_SET, lambda _: _closed(setup), default=NOTHING_TO_SET[0],
                citation="Walton and Marshall (1987), IEE Proc. D 134, 101-107",
            ),
            Ladder(
                "Bode plot", f"logarithms over {2 * _DECADES:g} decades, straight lines between",
                "frequencies", counts, lambda count: _plotted(setup, span, int(count)),
                theory="order 2",
            ),
            Ladder(
                "Bode plot, nearest point", "of two at the crossing that with a gain nearer to one",
                "frequencies", counts, lambda count: _nearest(setup, span, int(count)),
            ),
            Ladder(
                "scipy brentq", "30 frequencies, then a root of the gain between two of them",
                "tolerance of the frequency", (1e-2, 1e-4, 1e-6, 1e-8, 1e-12),
                lambda tolerance: _root(setup, span, tolerance),
            ),
        ),
        position="frequency [rad/s]",
    )  # fmt: skip


def _closed(setup: LoopSetup) -> Answer:
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
    place, told = brentq(
        lambda w: float(np.log(np.abs(open_loop(setup.loop, np.array([w]))[0]))),
        frequency[at], frequency[at + 1], xtol=tolerance * frequency[at], rtol=4.0 * EPSILON,
        full_output=True,
    )  # fmt: skip
    phase = float(np.angle(open_loop(setup.loop, np.array([place]))[0]))
    work = float(len(frequency) + told.function_calls + 1)
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

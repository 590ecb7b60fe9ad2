"""Poles of a loop without a delay, by formulas that lose digits and one that does not."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.control_loop import LoopSetup
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray
from vibecalc.response.roll_control.model import Loop
from vibecalc.response.roll_control.poles import poles

_DIGITS = 40


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
        ladders=(
            Ladder(
                "stable closed form", "no difference of like numbers; as a run does",
                "", NOTHING_TO_SET, lambda _: Answer(poles(setup.loop).value, 1.0),
                default=NOTHING_TO_SET[0],
            ),
            Ladder(
                "textbook formula", "(-b + sqrt(b^2 - 4 a c)) / 2 a",
                "", NOTHING_TO_SET, lambda _: Answer(_textbook(setup.loop), 1.0),
            ),
            Ladder(
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

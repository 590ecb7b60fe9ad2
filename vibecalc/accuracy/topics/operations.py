"""Topics of the operations: range of the kinetic energy over all angles of a balance weight."""

from typing import Any

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.topics.operations_peak import peak_range
from vibecalc.accuracy.yardsticks.grids import golden_maximum
from vibecalc.accuracy.yardsticks.weight_angles import (
    TURN,
    Curve,
    both_ends,
    whole_turn,
    with_parabola,
    words_of,
)
from vibecalc.numerics.rounding import WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.response.accuracy.combinations import Combination, strongest
from vibecalc.response.balance_phase import mean_energy_range
from vibecalc.response.energies import energy_by_order

#: of a step, how far beside a point of a grid the highest mean lies, as on average it does
MISSED = 0.25
GRIDS = tuple(float(4 * 4**k) for k in range(6))
#: what the closed form evaluates: both energies and what they have in common
PARTS = 3.0


def topics(scene: Scene) -> list[Topic]:
    """The operation and balance that the weight's angle matters most to; none without a weight."""
    one = strongest(scene)
    if one is None:
        return []
    return [_mean(one), peak_range(one, scene.case.accuracy.rtol)]


def _mean(one: Combination) -> Topic:
    still = float(np.sum(energy_by_order(one.weight, one.state.shaking).mean))
    shaking = one.state.shaking.value[0, one.state.first]
    rest = still - 0.25 * float((shaking.conj() @ one.weight.value @ shaking).real)

    def at(phase: np.ndarray) -> np.ndarray:
        turned = shaking + np.exp(1j * phase)[:, None] * one.state.residual.value[0, 0]
        each = energy_by_order(one.weight, WithError(turned, 0.0 * np.abs(turned)))
        return np.asarray(rest + each.mean)

    highest = float(mean_energy_range(one.weight, one.state).high_phase[0, 0])

    def beside(points: float) -> Curve:
        return lambda phase: at(highest + MISSED * TURN / points + phase)

    def closed(_: float) -> Answer:
        found = mean_energy_range(one.weight, one.state)
        return Answer(np.array([found.low[0, 0], found.high[0, 0]]), PARTS)

    return Topic(
        stage="operations",
        name="range of the mean energy",
        words=words_of(one, "mean"),
        quantity="response/operations/kinetic_energy/mean_low, mean_high",
        unit="J",
        work="energies",
        reference=lambda: _mean_reference(one, at),
        ladders=(
            Ladder(
                "closed form",
                "the weight turns one phasor: a + b cos of its angle",
                "",
                NOTHING_TO_SET,
                closed,
                default=1.0,
                citation="docs/theory.md",
            ),
            Ladder(
                "grid",
                "lowest and highest of N angles, a quarter of a step beside the known highest",
                "angles",
                GRIDS,
                lambda points: both_ends(beside(points), points, whole_turn),
                theory="order 2",
            ),
            Ladder(
                "grid with parabola",
                "parabolas through the best of N angles and their neighbours",
                "angles",
                GRIDS,
                lambda points: both_ends(beside(points), points, with_parabola),
                theory="order 4",
            ),
        ),
    )


def _mean_reference(one: Combination, curve: Curve) -> Reference:
    """The closed form in 40 digits, against golden section on energies in doubles."""
    import mpmath

    with mpmath.workdps(40):

        def row(values: np.ndarray) -> list[Any]:
            return [mpmath.mpc(complex(x)) for x in values]

        weight = [[mpmath.mpf(float(x)) for x in line] for line in one.weight.value]

        def product(left: list[Any], right: list[Any]) -> Any:
            return mpmath.fsum(
                mpmath.conj(a) * w * b
                for a, line in zip(left, weight, strict=True)
                for w, b in zip(line, right, strict=True)
            )

        states = [row(values) for values in one.state.shaking.value[0]]
        turned = row(one.state.residual.value[0, 0])
        middle = mpmath.fsum(mpmath.re(product(x, x)) for x in [*states, turned]) / 4
        swing = abs(product(states[one.state.first], turned)) / 2
        ends = np.array([float(middle - swing), float(middle + swing)])
    place = whole_turn(curve, 256).position
    half = TURN / 256.0
    high = golden_maximum(curve, place - half, place + half).value
    agreement = abs(high / ends[1] - 1.0)
    return Reference(
        ends,
        agreement,
        f"closed form in 40 digits (mpmath); golden section over the angle agrees to "
        f"{agreement:.1e}",
    )

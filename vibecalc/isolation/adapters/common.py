"""What adapters of the isolation share: their table, and extremes over the cycle."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Orders, left_out
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.synthesis import synthesis

if TYPE_CHECKING:
    from vibecalc.isolation.tables import Isolation


def isolation_of(scene: Scene) -> "Isolation":
    """The `[isolation]` table, which the plan has seen."""
    if scene.case.isolation is None:
        raise ValueError("the case has no [isolation]")
    return scene.case.isolation


class Extremes(NamedTuple):
    """Highest and lowest value (...) over the cycle of something constant and what alternates."""

    highest: Bounded
    lowest: Bounded


def extremes(constant: Bounded, harmonics: Bounded, of: Orders) -> Extremes:
    """Of a constant (...) and harmonics (..., orders), what is left out in their errors."""
    used = of.retained
    total = synthesis(of.order[:used], harmonics.value[..., :used])
    error = total.error + np.add(*left_out(harmonics, of))
    return Extremes(
        constant + Bounded(total.highest, error), constant + Bounded(total.lowest, error)
    )

"""What a plan says of one stage."""

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.parts.firing import shakes_with_torque
from vibecalc.pipeline.catalogue import CATALOGUE

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


class StagePlan(NamedTuple):
    """One stage of a run: its adapter, why it is there, what it reads and what it will make.

    `adapter` names the function that runs it as `package.module:function`; `is_last` marks a stage
    that no later one reads from.
    """

    stage: str
    adapter: str
    why: str
    parts: tuple[str, ...]
    orders: str
    cost: str
    quantities: tuple[str, ...]
    is_last: bool = False

    def as_texts(self) -> dict[str, str]:
        """The plan of this stage as short texts, for reports."""
        return {
            "stage": self.stage,
            "why": self.why,
            "parts": ", ".join(self.parts),
            "orders": self.orders,
            "cost": self.cost,
            "quantities": ", ".join(self.quantities),
        }


@lru_cache(maxsize=64)
def below(prefix: str, without: tuple[str, ...] = ()) -> tuple[str, ...]:
    return tuple(
        path
        for path in CATALOGUE
        if path.startswith(prefix) and not any(word in path for word in without)
    )


def orders_words(case: "Case") -> str:
    if case.excitation and case.excitation.orders:
        return f"1 to {case.excitation.orders}, as the case asks"
    if case.kinematics and case.kinematics.series == "truncated":
        last = (4 if shakes_with_torque(case) else 2) * (case.kinematics.terms or 1)
        return f"1 to {last}, all of the truncated series"
    return f"until the rest is below rtol = {case.accuracy.rtol:g}"

"""The stage of an engine or a pump on its mounts under the torque of its cylinders."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import StagePlan, below
from vibecalc.parts.firing import is_separate, torque_reaches_mounts

if TYPE_CHECKING:
    from vibecalc.schema import Case

ORDERS = "half ones of four strokes, else whole ones, and as many again for the error"


def plan_torque_reaction(case: "Case") -> Iterator[StagePlan]:
    """Planned where the torque of the cylinders reaches the mounts."""
    if not torque_reaches_mounts(case):
        return
    separate = is_separate(case)
    line = case.machine.shaft_line is not None and not separate
    where = "elsewhere" if separate else "on the body" + ", with a shaft line" * line
    yield StagePlan(
        stage="torque reaction",
        adapter="vibecalc.isolation.adapters.torque_reaction:run_torque_reaction",
        why=f"[isolation] is in the case, torque in the cylinders of the {case.machine.kind}, "
        f"its driven machine {where}",
        parts=("crank_train", "body", "mounts") + (("shaft_line",) if line else ()),
        orders=ORDERS,
        cost=f"one solve per order at {case.machine.speed:.6g} rad/s",
        quantities=below("isolation/torque_reaction/"),
        is_last=True,
    )

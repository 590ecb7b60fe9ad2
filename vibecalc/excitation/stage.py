"""The stage of the cylinders of a pump."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import StagePlan, below

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_pump(case: "Case") -> Iterator[StagePlan]:
    """Planned for every machine of kind "pump": its pressures stand in the case."""
    if case.machine.kind != "pump":
        return
    own = None if case.excitation is None else case.excitation.orders
    yield StagePlan(
        stage="pump",
        adapter="vibecalc.excitation.pump_adapter:run_pump",
        why="[machine.crank_train.pump_cycle] is in the case",
        parts=("crank_train",),
        orders=f"1 to {own}, as the case asks" if own else "the usual ones of a torque",
        cost="one fit of the pressure, one quadrature per order",
        quantities=below("excitation/pump/"),
        is_last=True,
    )

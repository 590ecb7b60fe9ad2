"""Sweeps over the shipped generator, for tests of axes and designs."""

from functools import cache
from typing import Any

from shipped_cases import CASES

from vibecalc.core.case.load import LoadedCase, load_case
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.study.sweep.design import Design, make_design

STIFFNESS = "machine.mounts.each.stiffness"
DAMPING = "machine.mounts.each.damping"
SPEED = "machine.speed"
PHASE = "machine.crank_train.cylinders[0].crank_phase"
MODEL = "isolation.model"
ORDERS = "excitation.orders"


@cache
def generator() -> LoadedCase:
    return load_case(CASES["generator"])


def axis(key: str, *values: Any, **more: Any) -> dict[str, Any]:
    """A table of `sweep.axes` with listed values."""
    return {"key": key, "values": list(values), **more}


def spread(
    key: str, start: Any, stop: Any, points: int | None = None, **more: Any
) -> dict[str, Any]:
    """A table of `sweep.axes` between two ends."""
    counted = {} if points is None else {"points": points}
    return {"key": key, "from": start, "to": stop, **counted, **more}


def scattered(key: str, kind: str, **parameters: Any) -> dict[str, Any]:
    """A table of `sweep.axes` with a distribution."""
    return {"key": key, "distribution": {"kind": kind, **parameters}}


def design_of(*axes: dict[str, Any], **more: Any) -> Design:
    """Design over the generator; CaseError if the tables do not make one."""
    sweep = Sweep.model_validate({"axes": list(axes), **more})
    return make_design(sweep, generator().resolved)


#: an axis of every kind, for samplings
ALL_KINDS = (
    spread(STIFFNESS, "5 N/mm", "50 N/mm", spacing="log"),
    scattered(DAMPING, "lognormal", mean=50, deviation=10),
    axis(MODEL, "pitch", "rigid_body"),
    axis(ORDERS, 4, 6, 8),
)

"""What bearing loads cannot be computed of."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import Problem
from vibecalc.parts import tables as parts
from vibecalc.parts.body import DIRECTIONS, build_frame
from vibecalc.schema import Case

if TYPE_CHECKING:
    from vibecalc.bearings.tables import BearingLoads


def bearing_problems(case: Case) -> Iterator[Problem]:
    """Problems of [bearing_loads]: forces and weights along the shaft."""
    table, train = case.bearing_loads, case.machine.crank_train
    if table is not None and train.axis != train.stroke_axis:
        yield from _shaft_loads(table, train)
        yield from _weights(case, table)


def _shaft_loads(table: "BearingLoads", train: parts.CrankTrain) -> Iterator[Problem]:
    axis = build_frame(train.axis, train.stroke_axis).axis
    for place, load in enumerate(table.shaft_loads):
        along = 0.0 if load.force is None else float(np.asarray(load.force) @ axis)
        if along != 0.0:
            yield Problem(
                path=("bearing_loads", "shaft_loads", place, "force"),
                message="main bearings cannot carry a force along the shaft",
                found=f"{along:.6g} N along {train.axis}",
                allowed=f"none along {train.axis}, the axis of the crankshaft",
            )


def _weights(case: Case, table: "BearingLoads") -> Iterator[Problem]:
    """Weights act as those of the body on its mounts do, and not along the shaft."""
    isolation, axis = case.isolation, case.machine.crank_train.axis
    if isolation is not None and table.up is not None and table.up != isolation.up:
        yield Problem(
            path=("bearing_loads", "up"),
            message="up differs from up in [isolation]",
            found=f"up = {table.up!r}, and up = {isolation.up!r} in [isolation]",
            allowed=f"{isolation.up!r}, or no such key",
            also=("isolation", "up") if "up" in isolation.model_fields_set else ("isolation",),
        )
        return
    weights = any(load.mass is not None for load in table.shaft_loads)
    up = isolation.up if isolation is not None and weights else table.up
    if up is not None and up.strip("-") == axis:
        others = ", ".join(repr(name) for name in DIRECTIONS if name != axis)
        yield Problem(
            path=("isolation" if table.up is None else "bearing_loads", "up"),
            message="main bearings cannot carry weight along the shaft",
            found=f"up = {up!r}",
            allowed=others + (", or one of these with a minus" if isolation is None else ""),
            also=("bearing_loads", "shaft_loads") if table.up is None else None,
        )


def bearing_cautions(case: Case) -> list[str]:
    """What other tables of the case have and bearing loads leave out."""
    if case.bearing_loads is None:
        return []
    response = case.response
    texts = {
        "[bearing_loads] follow joints without play: the impacts of [machine.joints] are not in "
        "them": case.machine.joints is not None,
        "[bearing_loads] hold for the cylinders that work in [excitation] at a steady speed: other "
        "operations and the changes between them are not in them": (
            response is not None and bool(response.operations)
        ),
    }
    return [text for text, holds in texts.items() if holds]

"""Harmonics of tangential pressure as makers of engines print them, over the load."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from vibecalc.core.case.fields import AngularSpeed, Pressure, Table, key
from vibecalc.core.case.rules import Row, ascending, one_of, same_length
from vibecalc.errors import Problem

Order = Annotated[float, Field(gt=0, le=400)]
#: rows of a table
_MOST = 20_000


def _half_orders(row: Row) -> Iterator[Problem]:
    for place, order in enumerate(row.listed("order")):
        if isinstance(order, float) and order > 0.0 and 2.0 * order != round(2.0 * order):
            yield row.problem(
                (*row.path, "order", place),
                "the gas of a cylinder has half and whole orders only",
                found=f"{order:g}",
                allowed="0.5, 1, 1.5, ...",
            )
            return


def _each_once(row: Row) -> Iterator[Problem]:
    """Each order once at each load, and the same orders at all of them."""
    loads, orders = row.listed("mean_indicated_pressure"), row.listed("order")
    if len(loads) != len(orders) or None in loads or None in orders:
        return
    by_load: dict[float, list[float]] = {}
    for load, order in zip(loads, orders, strict=True):
        by_load.setdefault(load, []).append(order)
    for load, listed in by_load.items():
        if len(set(listed)) < len(listed):
            yield row.problem(
                "order",
                f"an order is given twice at the mean indicated pressure {1e-5 * load:.6g} bar",
                allowed="each order once at each mean indicated pressure",
            )
            return
    every = {*orders}
    for load, listed in by_load.items():
        lacking = sorted(every - {*listed})
        if lacking:
            yield row.problem(
                "order",
                "the mean indicated pressures do not have the same orders",
                found=f"no order {lacking[0]:g} at {1e-5 * load:.6g} bar",
                allowed="the same orders at each of them",
            )
            return


class EffortHarmonics(Table):
    """Tangential gas pressure on the piston area, without inertia forces.

    A row is a cos(n t) + b sin(n t) of the crank angle t from the firing dead centre on; piston
    area times crank radius makes a torque of it, positive in the sense of rotation.
    """

    mean_indicated_pressure: tuple[Pressure, ...] = key(
        "of the row", min_length=1, max_length=_MOST
    )
    order: tuple[Order, ...] = key("n", min_length=1, max_length=_MOST)
    cosine: tuple[Pressure, ...] = key("a, 0-to-peak", min_length=1, max_length=_MOST)
    sine: tuple[Pressure, ...] = key("b, 0-to-peak", min_length=1, max_length=_MOST)
    RULES = (
        same_length("mean_indicated_pressure", "order", "cosine", "sine"),
        _half_orders,
        _each_once,
    )


class LoadOverSpeed(Table):
    """Mean indicated pressure over speed, straight lines between the entries."""

    speed: tuple[AngularSpeed, ...] = key(
        "ascending, of the crankshaft", min_length=2, max_length=2000
    )
    mean_indicated_pressure: tuple[Pressure, ...] = key(
        "one per speed", min_length=2, max_length=2000
    )
    RULES = (same_length("speed", "mean_indicated_pressure"), ascending("speed"))


class TangentialEffort(Table):
    """Gas torque of an engine by harmonics, instead of pressure over the angle."""

    harmonics: EffortHarmonics = key("rows over load and order, a table or a CSV")
    mean_indicated_pressure: Pressure | None = key("constant over speed", None, gt=0)
    over_speed: LoadOverSpeed | None = key("instead, over speed: a table or a CSV", None)
    RULES = (one_of("mean_indicated_pressure", "over_speed"),)

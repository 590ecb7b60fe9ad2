"""Does a table of tangential effort have the orders, loads and speeds that a case asks for?"""

from collections.abc import Iterator, Sequence

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.firing import TURN, cycle_angle, with_torque
from vibecalc.parts.tangential_effort import TangentialEffort
from vibecalc.schema import Case
from vibecalc.torsion.asked import asked_orders

EFFORT: KeyPath = ("machine", "crank_train", "tangential_effort")
TORSION: KeyPath = ("response", "torsion")
#: names that are listed of what is missing
_LISTED = 6


def effort_problems(case: Case, speeds: Sequence[tuple[KeyPath, float]]) -> Iterator[Problem]:
    """Problems of [machine.crank_train.tangential_effort] with the crank speeds that are asked."""
    given = case.machine.crank_train.tangential_effort
    assert given is not None
    yield from _loads(given)
    yield from _speeds(given, speeds)
    if case.machine.shaft_line is not None:
        yield from _orders(case, given)
        yield from _motored(case)
    for table in with_torque(case):
        yield Problem(
            path=EFFORT,
            message="the torque on the mounts takes its error from as many orders again, which a "
            "table of tangential effort does not have",
            allowed="gas_pressure, gas_cards or gas_cycle, or driven_machine = 'cancels_torque' in "
            "[excitation]",
            hint='loads = ["shaking"] leaves the torque out',
            also=(table,),
        )


def _loads(given: TangentialEffort) -> Iterator[Problem]:
    """Between loads of the table harmonics are interpolated, beyond them nobody knows them."""
    rows = given.harmonics.mean_indicated_pressure
    low, high = min(rows), max(rows)
    over = given.over_speed
    asked: list[tuple[KeyPath, float]] = []
    key = "mean_indicated_pressure"
    if given.mean_indicated_pressure is not None:
        asked = [((*EFFORT, key), given.mean_indicated_pressure)]
    elif over is not None:
        listed = enumerate(over.mean_indicated_pressure)
        asked = [((*EFFORT, "over_speed", key, place), load) for place, load in listed]
    for path, load in asked:
        if not low <= load <= high:
            allowed = f"{1e-5 * low:.6g} to {1e-5 * high:.6g} bar"
            yield Problem(
                path=path,
                message="the harmonics have no row for this mean indicated pressure",
                found=f"{1e-5 * load:.6g} bar",
                allowed=allowed if low < high else f"{1e-5 * low:.6g} bar, the only load there is",
                hint="rows of harmonics at loads below and above it",
                also=(*EFFORT, "harmonics"),
            )
            return


def _speeds(given: TangentialEffort, speeds: Sequence[tuple[KeyPath, float]]) -> Iterator[Problem]:
    if given.over_speed is None:
        return
    low, high = given.over_speed.speed[0], given.over_speed.speed[-1]
    for path, speed in speeds:
        if not low * (1 - 1e-12) <= speed <= high * (1 + 1e-12):
            yield Problem(
                path=path,
                message="no mean indicated pressure is given for this speed",
                found=f"{speed:.6g} rad/s",
                allowed=f"{low:.6g} to {high:.6g} rad/s",
                hint="a row of over_speed at this speed, or a range that its rows cover",
                also=(*EFFORT, "over_speed"),
            )


def _orders(case: Case, given: TangentialEffort) -> Iterator[Problem]:
    """Orders that the gas of such an engine has, and all of those that are asked."""
    rows = given.harmonics.order
    base = TURN / cycle_angle(case.machine)
    for place, order in enumerate(rows if base == 1.0 else ()):
        if order != round(order):
            yield Problem(
                path=(*EFFORT, "harmonics", "order", place),
                message="a two-stroke engine repeats itself every turn and has no half orders",
                found=f"{order:g}",
                allowed="1, 2, 3, ..., or cycle = 'four_stroke'",
                also=("machine", "cycle"),
            )
            return
    highest, step = asked_orders(case)
    asked = np.arange(1, round(highest / step) + 1) * step
    missing = [f"{order:g}" for order in asked.tolist() if order not in {*rows}]
    if missing:
        more = f" and {len(missing) - _LISTED} more" if len(missing) > _LISTED else ""
        torsion = None if case.response is None else case.response.torsion
        said = torsion is not None and torsion.orders is not None
        yield Problem(
            path=(*TORSION, "orders") if said else (*EFFORT, "harmonics", "order"),
            message="the table of tangential effort does not have all orders that are asked for",
            found=f"no order {', '.join(missing[:_LISTED])}{more}",
            allowed=f"orders that it has, up to {max(rows):g}",
            hint=_rather(rows, base),
            also=(*EFFORT, "harmonics", "order") if said else None,
        )


def _rather(orders: Sequence[float], base: float) -> str:
    """Orders of [response.torsion] that a table has all of, as a case says them."""
    there = {*orders}
    for step in (base, 1.0):
        count = 0
        while (count + 1) * step in there:
            count += 1
        if count:
            chosen = f"highest = {count * step:g}" + f", step = {step:g}" * (step != base)
            return f"orders = {{ {chosen} }} in [response.torsion]"
    return "the harmonics from the first order on"


def _motored(case: Case) -> Iterator[Problem]:
    torsion = None if case.response is None else case.response.torsion
    if torsion is None:
        return
    asked: dict[KeyPath, str] = {(*TORSION, "misfire_kind"): torsion.misfire_kind}
    if torsion.conditions is not None:
        asked[(*TORSION, "conditions", "misfire_kind")] = torsion.conditions.misfire_kind
    for path, kind in asked.items():
        if kind == "motored":
            yield Problem(
                path=path,
                message="harmonics of a cylinder that works do not say what one without fuel does",
                found="'motored'",
                allowed="'no_gas', or gas_pressure, gas_cards or gas_cycle",
                also=EFFORT,
            )

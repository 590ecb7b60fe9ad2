"""Torques given at stations, in words: where, at which orders, how they follow the speed."""

import math
from collections.abc import Mapping
from typing import Any

from vibecalc.core.report.sections import table_of
from vibecalc.core.results.record import Result


def given_rows(result: Result, unit: tuple[float, str]) -> list[tuple[str, str]]:
    """A row for each of the excitations; `unit`: factor from N m, and what torques are read in."""
    given: Any = table_of(result.case, "machine", "shaft_line").get("excitations") or ()
    return [
        (f"torque on {one.get('on')!r}", f"{_orders(one)}: {_sizes(one, *unit)}{_law(one)}")
        for one in given
    ]


def _orders(one: Mapping[str, Any]) -> str:
    if one.get("record"):
        return f"record over its angle, {one.get('harmonics') or 24} orders"
    if one.get("frequencies"):
        return f"{_list(w / (2.0 * math.pi) for w in one['frequencies'])} Hz"
    for wheel in ("blades", "teeth"):
        if one.get(wheel):
            count = len(one.get("torques") or one.get("shares") or ())
            return f"{one[wheel]} {wheel}, order " + _list(
                one[wheel] * (k + 1) for k in range(count)
            )
    whose = "of the crankshaft" if one.get("of") == "crankshaft" else "of its shaft"
    return f"order {_list(one.get('orders') or ())} {whose}"


def _sizes(one: Mapping[str, Any], factor: float, unit: str) -> str:
    if one.get("record"):
        torque = one["record"]["torque"]
        return f"{factor * min(torque):.4g} to {factor * max(torque):.4g} {unit}"
    if one.get("shares"):
        return f"{_list(100.0 * share for share in one['shares'])} % of its mean torque"
    return f"{_list(factor * torque for torque in one.get('torques') or ())} {unit}"


def _law(one: Mapping[str, Any]) -> str:
    if one.get("over_speed"):
        return ", over speed by its table"
    power = one.get("exponent") or 0.0
    return f" at the operating speed, with speed to the power {power:g}" if power else ""


def _list(numbers: Any) -> str:
    return ", ".join(f"{float(number):.4g}" for number in numbers)

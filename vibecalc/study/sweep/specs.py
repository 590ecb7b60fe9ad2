"""Axes and samplings written on the command line, turned into the tables of `[sweep]`.

machine.speed=2000 rpm:4000 rpm:21        21 values in equal steps
machine.mounts.each.stiffness=5 N/mm:50 N/mm:21log   in equal ratios
machine.mounts.each.stiffness=5 N/mm:50 N/mm         a range to draw from
response.method=modal,direct              these values
"""

import difflib
import re
from collections.abc import Sequence
from typing import Any, get_args

from vibecalc.case.overrides import key_text, parse_key
from vibecalc.case.sweep_tables import Sweep
from vibecalc.errors import UnitError, UsageError
from vibecalc.units import split_number

_POINTS = re.compile(r"\s*(\d{1,18})?\s*(log|linear)?\s*\Z")
_LONGEST = 2000
_EXAMPLES = "key=5 N/mm:50 N/mm:21, key=5 N/mm:50 N/mm:21log or key=2 kg,3 kg,5 kg"


def axis_table(text: str, option: str = "--grid") -> dict[str, Any]:
    """Read `key=SPEC` as one table of `sweep.axes`; UsageError if it is not of that form."""
    key, sign, spec = text.partition("=")
    if not sign or not spec.strip() or len(text) > _LONGEST or not text.isprintable():
        raise UsageError(f"{option} needs {_EXAMPLES}; found {text[:80]!r}")
    table: dict[str, Any] = {"key": key_text(parse_key(key.strip()))}
    said = f"{option} {text[:80]}"
    if ":" not in spec:
        values = [value.strip() for value in spec.split(",")]
        _refuse_gaps(values, said)
        _refuse_mixed_units(values, said)
        return {**table, "values": values}
    ends = [part.strip() for part in spec.split(":")]
    match = _POINTS.match(ends[2]) if len(ends) == 3 else None
    if len(ends) not in (2, 3) or (len(ends) == 3 and (match is None or not ends[2])):
        raise UsageError(f"{said}: expected start:stop:points, as in {_EXAMPLES}")
    _refuse_gaps(ends[:2], said)
    _refuse_mixed_units(ends[:2], said)
    table |= {"from": ends[0], "to": ends[1]}
    if match is not None and match[1]:
        table["points"] = int(match[1])
    if match is not None and match[2]:
        table["spacing"] = match[2]
    return table


def axis_tables(grid: Sequence[str], zipped: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Tables of `sweep.axes`: one for each text of `grid`, then one with all of `zipped`."""
    tables = [axis_table(text) for text in grid]
    if zipped:
        first, *others = (axis_table(text, "--zip") for text in zipped)
        tables.append({**first, "with": others} if others else first)
    return tables


def sampling_table(text: str) -> dict[str, Any]:
    """Read `METHOD:N` or `METHOD:N:SEED` as keys of `[sweep]`; UsageError if it is not that."""
    method, *numbers = (part.strip() for part in text.split(":"))
    known = [name for name in get_args(Sweep.model_fields["sampling"].annotation) if name != "grid"]
    if method not in known:
        near = difflib.get_close_matches(method, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise UsageError(f"--sample {text[:80]}: no sampling {method[:40]!r}{hint} "
                         f"(there are {', '.join(known)})")  # fmt: skip
    if len(numbers) not in (1, 2) or not all(re.fullmatch(r"[0-9]{1,18}", n) for n in numbers):
        raise UsageError(f"--sample {text[:80]}: expected METHOD:POINTS or METHOD:POINTS:SEED")
    table: dict[str, Any] = {"sampling": method, "points": int(numbers[0])}
    if len(numbers) == 2:
        table["seed"] = int(numbers[1])
    return table


def _refuse_gaps(values: Sequence[str], said: str) -> None:
    if not all(values):
        raise UsageError(f"{said}: a value is missing, expected {_EXAMPLES}")


def _refuse_mixed_units(values: Sequence[str], said: str) -> None:
    """A bare number is in SI; beside one with a unit it was hardly meant so."""
    units = set()
    for value in values:
        try:
            number, unit = split_number(value)
        except UnitError:
            return
        if unit or re.search("[1-9]", number):
            units.add(bool(unit))
    if len(units) > 1:
        example = next(value for value in values if split_number(value)[1])
        raise UsageError(f"{said}: give every value its unit, as in {example!r}")

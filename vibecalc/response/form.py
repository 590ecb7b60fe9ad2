"""Checks of form of what is asked of the body's motion, and of tables of references."""

from collections.abc import Iterator
from typing import Any

from vibecalc.core.case.raw import Data, listed, nearest, read_number, table_at, tables_at
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.kinds import OF_THE_BODY, WITHOUT_A_BODY
from vibecalc.roll.form import check_roll
from vibecalc.units import split_number

IMPACT: KeyPath = ("response", "impact")
SWITCHING: KeyPath = ("response", "switching")
TRAIN: KeyPath = ("machine", "crank_train")


def check_asked(data: Data) -> Iterator[Problem]:
    """Yield the problems of [isolation], [response] and [[reference_table]]."""
    if isinstance(data.get("isolation"), dict):
        yield from _isolation(data)
        yield from _run_up(data, "isolation")
    if isinstance(data.get("response"), dict):
        yield from _response(data)
        yield from _run_up(data, "response")
    for position, row in tables_at(data, "reference_table"):
        yield from _reference_table(("reference_table", position), row)


def _isolation(data: Data) -> Iterator[Problem]:
    machine = table_at(data, "machine")
    for part in ("body", "mounts"):
        if machine and part not in machine:
            yield Problem(
                path=("isolation",),
                message=f"[isolation] needs [machine.{part}]",
                hint="leave [isolation] out for forces and balance only",
            )
    for part, matrix, instead in (
        ("body", "mass_matrix", "a body with mass and inertia"),
        ("mounts", "stiffness_matrix", "mounts with places"),
    ):
        if matrix in table_at(machine, part):
            yield Problem(
                path=("isolation",),
                message=f"[isolation] needs {instead}, not a {matrix}",
                hint="[response] takes matrices",
                also=("machine", part, matrix),
            )


def _run_up(data: Data, table: str) -> Iterator[Problem]:
    run_up = table_at(data, table, "run_up")
    start, stop = (
        read_number(run_up.get("from", 0), "rad/s"),
        read_number(run_up.get("to"), "rad/s"),
    )
    if start is not None and stop is not None and not start < stop:
        yield Problem(
            path=(table, "run_up", "from"),
            message="a run-up goes from a lower speed to a higher one",
            found=f"from {run_up.get('from', 0)} to {run_up.get('to')}",
            allowed="from < to",
        )


def _response(data: Data) -> Iterator[Problem]:
    machine, response = table_at(data, "machine"), table_at(data, "response")
    alone_there = any(key in response for key in WITHOUT_A_BODY)
    if not alone_there or any(response.get(key) for key in OF_THE_BODY):
        alone = f"impacts alone need none: leave {', '.join(OF_THE_BODY)} out"
        for part in ("body", "mounts"):
            if machine and part not in machine:
                yield Problem(
                    path=("response",),
                    message=f"[response] needs [machine.{part}]",
                    hint=alone if "impact" in response else "leave [response] out for forces only",
                )
    if "balances" in response and "operations" not in response:
        yield Problem(
            path=("response", "balances"),
            message="balances are combined with operations, and there are none",
            allowed='operations = [{ name = "all", working = ["1", "2"] }], for example',
        )
    if isinstance(response.get("switching"), dict):
        yield from _switching(data)
    if "impact" in response and machine:
        yield from _impact(machine)
    yield from check_roll(data)


def _switching(data: Data) -> Iterator[Problem]:
    entries = tables_at(data, "response", "operations")
    names = [entry["name"] for _, entry in entries if isinstance(entry.get("name"), str)]
    if not names:
        yield Problem(
            path=SWITCHING,
            message="[response.switching] goes between two operations, and there are none",
            allowed="operations in [response], two of which `between` names",
        )
        return
    between = table_at(data, *SWITCHING).get("between")
    if not isinstance(between, list) or len(between) != 2:
        return
    for position, name in enumerate(between):
        if isinstance(name, str) and name and name not in names:
            yield Problem(
                path=(*SWITCHING, "between", position),
                message=f"no operation is named {name[:60]!r}",
                allowed=listed(names),
                hint=nearest(name, names),
            )
    if between[0] == between[1]:
        yield Problem(
            path=(*SWITCHING, "between"),
            message="a change goes from one operation to another one",
            found=repr(between)[:60],
            allowed="two different names",
        )


def _impact(machine: Data) -> Iterator[Problem]:
    if "joints" not in machine:
        yield Problem(
            path=IMPACT,
            message="[response.impact] needs [machine.joints]",
            allowed="joints with clearance and stiffness, of the wrist pin at least",
        )
    train = table_at(machine, "crank_train")
    for one, other in (("bore", "gas_pressure"), ("gas_pressure", "bore")):
        if one in train and other not in train:
            yield Problem(
                path=(*TRAIN, one),
                message=f"[response.impact] cannot use {one} without {other}: the gas force "
                "is pressure times area",
                allowed=f"{other} beside it, or neither for impacts by inertia alone",
            )


def _reference_table(path: KeyPath, row: Data) -> Iterator[Problem]:
    if row.get("file"):  # it could not be read, which is told elsewhere
        return
    if "column" in row:
        yield Problem(
            path=(*path, "column"),
            message="column is one of a file, and there is none",
            allowed="file and column, or entry and value",
        )
        return
    entry, value = row.get("entry"), row.get("value")
    if "entry" not in row or "value" not in row:
        given = [key for key in ("entry", "value") if key in row]
        missing = "value" if "entry" in row else "entry"
        yield Problem(
            path=(*path, *given),
            message=f"{given[0]} without {missing}" if given else "a table without numbers",
            allowed="a file, or entry and value",
        )
    elif isinstance(entry, list) and isinstance(value, list):
        if len(entry) != len(value) or not entry:
            yield Problem(
                path=(*path, "value"),
                message="each entry has one value",
                found=f"{len(entry)} of entry and {len(value)} of value",
                allowed="as many of the one as of the other, at least one",
                also=(*path, "entry"),
            )
        yield from _unit_twice(path, row, value)


def _unit_twice(path: KeyPath, row: Data, values: list[Any]) -> Iterator[Problem]:
    unit = row.get("unit")
    for position, value in enumerate(values):
        if unit and isinstance(unit, str) and isinstance(value, str) and _has_unit(value):
            yield Problem(
                path=(*path, "unit"),
                message="the unit stands twice",
                found=f"{value[:40]!r} and unit = {unit[:40]!r}",
                also=(*path, "value", position),
            )
            return


def _has_unit(value: str) -> bool:
    try:
        return bool(split_number(value)[1])
    except UnitError:
        return False

"""Rules between the records of a case and its orders and positions."""

import re
from collections.abc import Iterator
from typing import Any

from vibecalc.core.case.raw import Data, read_number, table_at, tables_at, unknown
from vibecalc.core.case.rules import Row
from vibecalc.errors import KeyPath, Problem
from vibecalc.measurement.record_tables import RecordFile


def check_records(row: Row) -> Iterator[Problem]:
    """Yield records whose orders are not those of the case, and shafts that share no angle."""
    records = row.each("record")
    positions = [str(one.data.get("name")) for one in row.each("positions")]
    for one in records:
        for place, channel in enumerate(one.each("channels")):
            name = channel.data.get("at")
            if isinstance(name, str) and name not in positions:
                yield unknown((*one.path, "channels", place, "at"), "position", name, positions)
        found = one.data.get("found")
        if isinstance(found, dict) and not _fits(found, len(one.entries("channels"))):
            yield one.problem(
                "found",
                "these are no orders of so many channels and blocks",
                hint=_LEAVE_OUT,
            )
            continue
        yield from _of_other_orders(one, row)
        yield from _made_otherwise(one)
    for one in row.each("spectrum"):
        yield from _of_other_orders(one, row)
        yield from _read_otherwise(one)
    yield from _changed_by_studies(row)
    yield from _without_one_angle(row, records)


_LEAVE_OUT = "leave found out: it is put there when the file is read"


def _of_other_orders(one: Row, row: Row) -> Iterator[Problem]:
    orders = table_at(one.data, "found").get("orders")
    if isinstance(orders, list) and orders != row.entries("orders"):
        yield one.problem(
            "found",
            "these are orders of other harmonics than the case asks for",
            found=", ".join(map(str, orders))[:60],
            hint=_LEAVE_OUT,
        )


# ----------------------------------------------------------------------------
# Numbers that stand for a file were made with keys, which may no longer change.
# ----------------------------------------------------------------------------


def _made_otherwise(record: Row) -> Iterator[Problem]:
    """Keys of a record that are not those that its orders were made with."""
    found = record.below("found")
    made = found.below("made_with") if found is not None else None
    if made is None:
        return
    for key in RecordFile.model_fields:
        if key != "channels" and not _same(record, made, key):
            yield _no_longer(record, key, made[key])
    now, then = record.each("channels"), made.each("channels")
    for one, other in zip(now, then, strict=False):
        for key in ("column", "scale"):
            if not _same(one, other, key):
                yield _no_longer(one, key, other[key])


def _same(one: Row, other: Row, key: str) -> bool:
    return bool(one[key] == other[key] or one.number(key) == other.number(key) is not None)


def _no_longer(row: Row, key: str, made_with: Any) -> Problem:
    return row.problem(
        key,
        "the orders here were made of the file with another value of this key, and it would "
        "change nothing",
        found=str(row[key])[:60],
        allowed=str(made_with)[:60],
        hint="change it in a case that names the file and has no `found`",
    )


def _read_otherwise(spectrum: Row) -> Iterator[Problem]:
    """A spectrum whose lines are of another file, or of another frequency of order 1."""
    found = spectrum.below("found")
    if found is None:
        return
    if not _same(spectrum, found, "file"):
        yield _no_longer(spectrum, "file", found["file"])
    base = found.number("base_frequency")
    if base is not None and base != base_frequency_of(spectrum.case):
        yield spectrum.problem(
            "found",
            "these lines were picked from the file with another frequency of order 1",
            found=f"{base:.6g} rad/s",
            hint=f"{_LEAVE_OUT}; a column order in the file needs no frequency",
        )


def base_frequency_of(case: Data) -> float | None:
    """The frequency of order 1 that a case as written says, rad/s."""
    base = read_number(table_at(case, "measurement").get("base_frequency"), "rad/s")
    return base or read_number(table_at(case, "machine").get("speed"), "rad/s")


def _changed_by_studies(row: Row) -> Iterator[Problem]:
    """Keys that a sweep or search changes, and that numbers of a file were made with."""
    by_frequency = any(
        "base_frequency" in table_at(one, "found") for _, one in tables_at(row.data, "spectrum")
    )
    for study in ("sweep", "optimisation", "find", "fit"):
        for path, key in _texts(row.case.get(study), (study,)):
            of_record = _OF_RECORD.match(key) and not _OF_CHANNEL.search(key)
            if of_record or (by_frequency and key in _BASES):
                yield Problem(
                    path=path,
                    message=f"{key} stands behind numbers that were read from a file, and would "
                    "change nothing",
                    found=key[:80],
                    hint="one case for each value"
                    if of_record
                    else "a column order in the file of the spectrum needs no frequency",
                )


_OF_RECORD = re.compile(r"measurement\.(record|spectrum)\b")
#: what of a channel or spectrum is not read from the file
_OF_CHANNEL = re.compile(r"\.(use|at)\Z")
_BASES = ("machine.speed", "measurement.base_frequency")


def _texts(place: Any, path: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    """All texts below a table, with their places."""
    if isinstance(place, str):
        yield path, place
    elif isinstance(place, dict | list):
        entries = place.items() if isinstance(place, dict) else enumerate(place)
        for key, value in entries:
            yield from _texts(value, (*path, key))


# ----------------------------------------------------------------------------
# Phases of several files count from one place of the shaft.
# ----------------------------------------------------------------------------


def _without_one_angle(row: Row, records: list[Row]) -> Iterator[Problem]:
    """Records that are not alone and whose angle does not begin at the one mark of the shaft."""
    if len(records) + len(row.each("spectrum")) < 2 and not _phases_read(row):
        return
    for one in records:
        several = one["pulses_per_turn"]
        if not one.data.get("pulses"):
            yield one.problem(
                "",
                "phases of several records or readings need one angle of the shaft",
                found="a record whose angle begins where it begins",
                allowed="pulses in each record, or all channels in one",
            )
        elif isinstance(several, int) and several > 1:
            yield one.problem(
                "pulses_per_turn",
                "phases of several records or readings need one angle of the shaft, and any of "
                "these pulses may be the first of a record",
                found=f"{several} pulses per turn",
                allowed="one pulse per turn in each record, or all channels in one",
                hint="a record of its own case may have more: its phases are against its first "
                "pulse",
            )


def _phases_read(row: Row) -> bool:
    """Whether phases are given next to records."""
    scan = row.data.get("scan")
    return any("phase" in one for _, one in tables_at(row.data, "readings")) or (
        isinstance(scan, dict) and "phase" in scan
    )


def _fits(found: dict[str, Any], channels: int) -> bool:
    """Whether what was found has the numbers of so many channels; the schema says what else."""
    sizes = {key: len(one) for key, one in found.items() if isinstance(one, list)}
    if len(sizes) < len(_LISTS):
        return True
    each = channels * sizes["orders"]
    blocks = each * sizes["speeds"]
    return (
        sizes["speeds"] > 1
        and (sizes["real"], sizes["imaginary"]) == (blocks, blocks)
        and (sizes["error"], sizes["by_angle"]) == (each, each)
        and sizes["lines"] > 0
        and sizes["lines"] % max(channels, 1) == 0
    )


_LISTS = ("orders", "speeds", "real", "imaginary", "error", "by_angle", "lines")

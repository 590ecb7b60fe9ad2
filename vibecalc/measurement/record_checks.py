"""Rules between the records of a case and its orders and positions."""

import re
from collections.abc import Iterator, Sequence
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
        for channel in one.each("channels"):
            name = channel.data.get("at")
            if isinstance(name, str) and name not in positions:
                yield unknown((*channel.path, "at"), "position", name, positions)
        found = one.below("found")
        if found is not None and not _fits(found.data, len(one.entries("channels"))):
            words = "these are no orders of so many channels and blocks"
            yield one.problem("found", words, hint=_LEAVE_OUT)
        elif found is not None:
            yield from _of_other_orders(one, found, row)
            made = found.below("made_with")
            keys = [key for key in RecordFile.model_fields if key != "channels"]
            yield from _changed(one, made, keys)
            others = [] if made is None else made.each("channels")
            for channel, other in zip(one.each("channels"), others, strict=False):
                yield from _changed(channel, other, ("column", "scale"))
    for one in row.each("spectrum"):
        found = one.below("found")
        if found is not None:
            yield from _of_other_orders(one, found, row)
            yield from _changed(one, found, ("file",))
            base = found.number("base_frequency")
            if base is not None and base != base_frequency_of(row.case):
                yield one.problem(
                    "found",
                    "these lines were picked from the file with another frequency of order 1",
                    found=f"{base:.6g} rad/s",
                    hint=f"{_LEAVE_OUT}; a column order in the file needs no frequency",
                )
    yield from _changed_by_studies(row)
    yield from _without_one_angle(row, records)


# ----------------------------------------------------------------------------
# Numbers that stand for a file were made with keys, which may no longer change.
# ----------------------------------------------------------------------------

_LEAVE_OUT = "leave found out: it is put there when the file is read"


def _of_other_orders(one: Row, found: Row, row: Row) -> Iterator[Problem]:
    orders = found.data.get("orders")
    if isinstance(orders, list) and orders != row.entries("orders"):
        yield one.problem(
            "found",
            "these are orders of other harmonics than the case asks for",
            found=", ".join(map(str, orders))[:60],
            hint=_LEAVE_OUT,
        )


def _changed(row: Row, made: Row | None, keys: Sequence[str]) -> Iterator[Problem]:
    """Keys of a table that are not those that its numbers were made with."""
    for key in keys if made is not None else ():
        assert made is not None
        if row[key] != made[key] and not row.number(key) == made.number(key) is not None:
            yield row.problem(
                key,
                "the orders here were made of the file with another value of this key, and it "
                "would change nothing",
                found=str(row[key])[:60],
                allowed=str(made[key])[:60],
                hint="change it in a case that names the file and has no `found`",
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

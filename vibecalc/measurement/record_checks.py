"""Rules between the records of a case and its orders and positions."""

from collections.abc import Iterator
from typing import Any

from vibecalc.core.case.raw import unknown
from vibecalc.core.case.rules import Row
from vibecalc.errors import Problem


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
                hint="leave found out: it is put there when the file is read",
            )
            continue
        orders = found.get("orders") if isinstance(found, dict) else None
        if orders is not None and list(orders) != row.entries("orders"):
            yield one.problem(
                "found",
                "these are orders of other harmonics than the case asks for",
                found=", ".join(map(str, orders))[:60],
                hint="leave found out: it is put there when the file is read",
            )
    blind = [one for one in records if not one.data.get("pulses")]
    if len(records) > 1 and blind:
        yield blind[0].problem(
            "",
            "phases of several records need one angle of the shaft",
            found="a record whose angle begins where it begins",
            allowed="pulses in each record, or all channels in one",
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
        and (sizes["real"], sizes["imaginary"], sizes["error"]) == (blocks, blocks, each)
        and sizes["lines"] > 0
        and sizes["lines"] % max(channels, 1) == 0
    )


_LISTS = ("orders", "speeds", "real", "imaginary", "error", "lines")

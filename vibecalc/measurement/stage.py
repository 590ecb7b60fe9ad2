"""The stage that [measurement] asks for."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Entries, Harmonics, Stage, Subject, Unit, below

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_measurement(case: "Case") -> Iterator[Stage]:
    """The motion of a plate from its readings; it stands alone, or next to a machine."""
    table = case.measurement
    if table is None:
        return
    from vibecalc.measurement.model import build_harmonics  # loads what solves the motion

    harmonics = build_harmonics(table)
    reads = [read for one in harmonics for read in one.reads]
    by_levels = not all(one.is_complex for one in harmonics)
    phases = any(read.phase is not None for read in reads)
    parts = {
        "frequency": table.base_frequency is not None or case.machine.speed is not None,
        "candidate/": by_levels,
        "further/": by_levels and bool(table.positions),
        "signal/": phases,
        "reading/": any(read.amplitude > 0.0 for read in reads),
        "record/": bool(table.record),
        "map/": table.plate is not None,
        "quiet/": table.plate is not None,
        **dict.fromkeys(_OF_POSITIONS, bool(table.positions)),
    }
    left_out = (f"measurement/{part}" for part, there in parts.items() if not there)
    method = "levels: all motions that they allow" if by_levels else "least squares"
    orders = table.orders
    counted = Harmonics(len(orders), min(orders), max(orders), "[measurement] orders")
    yield Stage(
        name="measurement",
        adapter="vibecalc.measurement.adapter:run_measurement",
        why="[measurement] is in the case",
        parts=(),
        orders=", ".join(map(str, orders)),
        cost=f"{len(reads)} readings, {len(orders)} harmonics one by one; {method}",
        quantities=below("measurement/", without=tuple(left_out)),
        is_last=True,
        harmonics=lambda _: counted,
        work=lambda _, number: ((number, "least_squares" if phases else "level_motions"),),
    )


_OF_POSITIONS = ("acceleration", "level/", "candidate/level", "uncertainty/level")


def names_of(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
    """Entries of the axes that the case names."""
    if case.measurement is None:
        return {}
    table = case.measurement
    named = {"position": tuple(position.name for position in table.positions)}
    channels = table.channel_names
    return named | ({"channel": channels} if channels else {})


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    if axis != "order" or case.measurement is None:
        return None
    return Entries(tuple(map(float, case.measurement.orders)), "[measurement] orders")


SUBJECT = Subject(
    stages=(plan_measurement,),
    names=names_of,
    entries=_entries,
    concerns=lambda case: case.measurement is not None or case.machine.kind == "plate",
    files={
        ("measurement", "record"): "vibecalc.measurement.records:attach_records",
        ("measurement", "spectrum"): "vibecalc.measurement.records:attach_records",
    },
    units={
        "least_squares": Unit(1.0e-2, "harmonics by least squares"),
        "level_motions": Unit(1.5e-2, "harmonics by all motions that levels allow"),
    },
    checks=("vibecalc.measurement.checks:measurement_problems",),
    sections=(
        "vibecalc.measurement.report:measurement",
        "vibecalc.measurement.report:records",
    ),
    pictures={
        "measured_levels": "vibecalc.measurement.pictures:draw_measured_levels",
        "record_orders": "vibecalc.measurement.pictures:draw_record_orders",
        "plate_map": "vibecalc.measurement.pictures:draw_plate_map",
    },
    assumes=("The plate is rigid and moves little: normal to itself, in roll and in pitch.",),
)

"""The stage that [measurement] asks for."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.core.run.stage import Entries, Harmonics, Stage, Subject, Unit, Work, below

if TYPE_CHECKING:
    from vibecalc.measurement.tables import Measurement
    from vibecalc.schema import Case


def plan_measurement(case: "Case") -> Iterator[Stage]:
    """The motion of a plate from its readings; it stands alone, or next to a machine."""
    table = case.measurement
    if table is None:
        return
    by_levels = not set(table.orders) <= _with_phases(table)
    left_out = tuple(
        f"measurement/{part}"
        for part, there in (
            ("frequency", table.base_frequency is not None or case.machine.speed is not None),
            ("candidate/", by_levels),
            ("further/", by_levels),
            ("signal/", _any_phase(table)),
            ("reading/", _any_level(table)),
            ("record/", bool(table.record)),
            ("map/", table.plate is not None),
            ("quiet/", table.plate is not None),
        )
        if not there
    )
    positions = () if table.positions else _OF_POSITIONS
    method = "levels: all motions that they allow" if by_levels else "least squares"
    yield Stage(
        name="measurement",
        adapter="vibecalc.measurement.adapter:run_measurement",
        why="[measurement] is in the case",
        parts=(),
        orders=", ".join(map(str, table.orders)),
        cost=f"{_count(table)} readings, {len(table.orders)} harmonics one by one; {method}",
        quantities=below("measurement/", without=(*left_out, *positions)),
        is_last=True,
        harmonics=_orders_of_measurement,
        work=_work_of_measurement,
    )


def _with_phases(table: "Measurement") -> set[int]:
    """Harmonics whose motion comes from complex amplitudes."""
    found = {
        order
        for reading in table.readings
        if reading.phase and reading.use == "solve"
        for order in reading.orders or table.orders
    }
    if any(one.use == "solve" for one in _phasors(table)):
        found |= set(table.orders)
    scan = table.scan
    return found | (set(scan.order) if scan is not None and scan.phase else set())


def _phasors(table: "Measurement") -> list[Any]:
    """Channels of records, and spectra: each a reading with phases of all harmonics."""
    return [*(one for record in table.record for one in record.channels), *table.spectrum]


def _any_phase(table: "Measurement") -> bool:
    read = any(reading.phase for reading in table.readings) or bool(_phasors(table))
    return read or (table.scan is not None and bool(table.scan.phase))


def _any_level(table: "Measurement") -> bool:
    """Whether anything read is larger than zero and so has a level."""
    scan = table.scan
    if (scan is not None and (scan.level or any(scan.amplitude))) or _phasors(table):
        return True
    return any(
        reading.level or any(reading.amplitude) or any(reading.angular_amplitude)
        for reading in table.readings
    )


def _count(table: "Measurement") -> int:
    single = sum(len(reading.orders or table.orders) for reading in table.readings)
    single += len(_phasors(table)) * len(table.orders)
    return single + (len(table.scan.order) if table.scan is not None else 0)


_OF_POSITIONS = (
    *("measurement/acceleration", "measurement/level/", "measurement/candidate/level"),
    *("measurement/uncertainty/level", "measurement/further/"),
)


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------


def _orders_of_measurement(case: "Case") -> Harmonics:
    assert case.measurement is not None
    orders = case.measurement.orders
    return Harmonics(len(orders), min(orders), max(orders), "[measurement] orders")


def _work_of_measurement(case: "Case", orders: int) -> Work:
    table = case.measurement
    assert table is not None
    phases = any(reading.phase for reading in table.readings) or bool(_phasors(table))
    phases = phases or (table.scan is not None and bool(table.scan.phase))
    return ((orders, "least_squares" if phases else "level_motions"),)


def channel_names(table: "Measurement") -> tuple[str, ...]:
    """How results name the channels of all records: by position, and by record where several."""
    several = len(table.record) > 1
    return tuple(
        f"{place}: {one.at}" if several else one.at
        for place, record in enumerate(table.record, start=1)
        for one in record.channels
    )


def names_of(case: "Case") -> dict[str, tuple[str, ...]]:
    """Entries of the axes that the case names."""
    if case.measurement is None:
        return {}
    table = case.measurement
    named = {"position": tuple(position.name for position in table.positions)}
    channels = channel_names(table)
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
        "vibecalc.measurement.record_report:records",
    ),
    pictures={
        "measured_levels": "vibecalc.measurement.pictures:draw_measured_levels",
        "record_orders": "vibecalc.measurement.record_report:draw_record_orders",
        "plate_map": "vibecalc.measurement.pictures:draw_plate_map",
    },
    assumes=("The plate is rigid and moves little: normal to itself, in roll and in pitch.",),
)

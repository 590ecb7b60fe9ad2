"""Do the readings on a plate make sense, and do their places tell its motion?"""

from collections.abc import Iterator

from vibecalc.case.measurement_tables import Measurement, Reading
from vibecalc.case.raw import listed, nearest
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.measurement_numbers import range_problems, scale_problems

TABLE: KeyPath = ("measurement",)
_WAYS = ("at", "between", "about")
_COLUMNS = ("order", "x", "y", "level", "amplitude", "phase")
_SIZES = ("level", "amplitude", "angular_amplitude")


def measurement_problems(case: Case) -> list[Problem]:
    """Problems of [measurement]: form first, then references, then what can be told at all."""
    table = case.measurement
    if table is None:
        return list(_nothing_read(case))
    problems = [
        *_names(table),
        *_plate(table),
        *_forms(table),
        *_scan(table),
        *_frequency(case, table),
        *range_problems(table),
    ]
    problems = problems or scale_problems(table)
    if problems:
        return problems
    # loads what solves the motion
    from vibecalc.machine.measurement_places import place_problems

    return place_problems(table)


def _nothing_read(case: Case) -> Iterator[Problem]:
    if case.machine.kind == "plate":
        yield Problem(
            path=("machine", "kind"),
            message="nothing is said of the plate: its motion comes from readings",
            found='kind = "plate" without [measurement]',
            allowed="a table [measurement] with positions and readings",
        )


def _names(table: Measurement) -> Iterator[Problem]:
    known = [position.name for position in table.positions]
    for place, name in enumerate(known):
        if name in known[:place]:
            yield Problem(
                path=(*TABLE, "positions", place, "name"),
                message=f"two positions are named {name!r}",
                hint="give each its own name",
                also=(*TABLE, "positions", known.index(name), "name"),
            )
    for place, order in enumerate(table.orders):
        if order in table.orders[:place]:
            yield Problem(
                path=(*TABLE, "orders", place),
                message=f"order {order} stands twice",
                allowed="each harmonic once",
            )
    asked: list[tuple[KeyPath, str]] = []
    for place, reading in enumerate(table.readings):
        path: KeyPath = (*TABLE, "readings", place)
        if reading.at is not None:
            asked.append(((*path, "at"), reading.at))
        asked += [((*path, "between", i), name) for i, name in enumerate(reading.between or ())]
    if table.reference_position is not None:
        asked.append(((*TABLE, "reference_position"), table.reference_position))
    for path, name in asked:
        if name not in known:
            yield Problem(
                path=path,
                message=f"no position is named {name[:60]!r}",
                allowed=listed(known)
                if known
                else "positions = [{ name = ..., x = ..., y = ... }]",
                hint=nearest(name, known),
            )


def _plate(table: Measurement) -> Iterator[Problem]:
    if table.plate is None:
        return
    for key in ("x", "y"):
        first, last = getattr(table.plate, key)
        if not first < last:
            yield Problem(
                path=(*TABLE, "plate", key),
                message=f"the plate has no extent along {key}",
                found=f"from {first:.6g} m to {last:.6g} m",
                allowed="from a smaller to a larger coordinate",
            )


def _forms(table: Measurement) -> Iterator[Problem]:
    if not table.readings and table.scan is None:
        yield Problem(
            path=TABLE,
            message="[measurement] has no readings",
            allowed="readings of instruments, or a scan",
        )
    for place, reading in enumerate(table.readings):
        yield from _form((*TABLE, "readings", place), reading, table)


def _form(path: KeyPath, reading: Reading, table: Measurement) -> Iterator[Problem]:
    for keys, what in (
        (_WAYS, "what it reads: a point, a difference or a rotation"),
        (_SIZES, "how much it reads"),
    ):
        given = [key for key in keys if getattr(reading, key)]
        if len(given) != 1:
            message = f"a reading does not say {what}"
            if given:
                message = f"{' and '.join(given)} exclude each other"
            yield Problem(path=path, message=message, allowed=f"one of {', '.join(keys)}")
    if reading.between is not None and reading.between[0] == reading.between[1]:
        yield Problem(
            path=(*path, "between"),
            message="a difference is between two positions",
            found=f"{reading.between[0]!r} twice",
        )
    wrong = "amplitude" if reading.about else "angular_amplitude"
    if getattr(reading, wrong) and (reading.about or reading.at or reading.between):
        yield Problem(
            path=(*path, wrong),
            message=f"{wrong} does not go with {'about' if reading.about else 'points'}",
            allowed="angular_amplitude with about, amplitude with at and between",
        )
    for place, order in enumerate(reading.orders):
        if order not in table.orders or order in reading.orders[:place]:
            yield Problem(
                path=(*path, "orders", place),
                message="a reading covers harmonics of [measurement], each once",
                found=str(order),
                allowed=", ".join(map(str, table.orders)),
            )
    orders = reading.orders or table.orders
    for key in (*_SIZES, "phase"):
        values = getattr(reading, key)
        if values and len(values) != len(orders):
            yield Problem(
                path=(*path, key),
                message=f"{key} has {len(values)} numbers for {len(orders)} harmonics",
                allowed=f"one for each of the orders {', '.join(map(str, orders))}",
                hint="orders = [...] in the reading says that it covers only some",
            )
    if not reading.phase:
        for key in _SIZES[1:]:
            if 0.0 in getattr(reading, key):
                yield Problem(
                    path=(*path, key, getattr(reading, key).index(0.0)),
                    message="an amplitude of zero without a phase has no level",
                    allowed="the least that the instrument can show, or no reading there",
                )


def _scan(table: Measurement) -> Iterator[Problem]:
    scan = table.scan
    if scan is None:
        return
    path: KeyPath = (*TABLE, "scan")
    given = [key for key in ("level", "amplitude") if getattr(scan, key)]
    if len(given) != 1:
        yield Problem(
            path=path,
            message="level and amplitude exclude each other"
            if given
            else "a scan does not say how much is read",
            allowed="a column level, or a column amplitude",
        )
    columns = {key: len(getattr(scan, key)) for key in _COLUMNS if getattr(scan, key)}
    if len(set(columns.values())) > 1:
        yield Problem(
            path=path,
            message="the columns of the scan are not of one length",
            found=", ".join(f"{count} of {key}" for key, count in columns.items()),
            allowed="as many entries in each",
        )
    for place, order in enumerate(scan.order):
        if order not in table.orders:
            yield Problem(
                path=(*path, "order", place),
                message="a row of the scan is of no harmonic of [measurement]",
                found=str(order),
                allowed=", ".join(map(str, table.orders)),
            )
    for place, size in enumerate(scan.amplitude):
        if size < 0.0 or (size == 0.0 and not scan.phase):
            yield Problem(
                path=(*path, "amplitude", place),
                message="an amplitude is larger than zero"
                if not scan.phase
                else "an amplitude is not negative",
                found=f"{size:.6g} m/s^2 in row {place + 1}",
                hint="its sign is a phase of 180 deg",
            )


def _frequency(case: Case, table: Measurement) -> Iterator[Problem]:
    if table.base_frequency is not None and case.machine.speed is not None:
        yield Problem(
            path=(*TABLE, "base_frequency"),
            message="the frequency of order 1 stands twice: it is that of the crankshaft",
            allowed="machine.speed alone",
            also=("machine", "speed"),
        )

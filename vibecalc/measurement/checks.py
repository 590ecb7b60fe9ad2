"""Physical checks of readings on a plate: numbers within reason, names, forms, frequencies."""

from collections.abc import Iterator

from vibecalc.errors import KeyPath, Problem
from vibecalc.measurement.tables import Measurement, Reading
from vibecalc.schema import Case

TABLE: KeyPath = ("measurement",)
_SIZES = ("level", "amplitude", "angular_amplitude")


def measurement_problems(case: Case) -> list[Problem]:
    """Problems of [measurement]: form first, then references, then what can be found at all."""
    table = case.measurement
    if table is None:
        return list(_nothing_read(case))
    problems = [*_forms(table), *_scan(table)]
    problems = problems or [*_references(table), *_steps(table), *_mismatched(table)]
    if problems:
        return problems
    # loads what solves the motion
    from vibecalc.measurement.model import place_problems

    return place_problems(table)


def _nothing_read(case: Case) -> Iterator[Problem]:
    if case.machine.kind == "plate":
        yield Problem(
            path=("machine", "kind"),
            message="a plate needs readings: its motion is found from them",
            found='kind = "plate" without [measurement]',
            allowed="a table [measurement] with positions and readings",
        )


def _references(table: Measurement) -> Iterator[Problem]:
    """Levels without a reference."""
    read = [(*TABLE, "readings", place, "level") for place in range(len(table.readings))]
    with_levels = [(path, one) for path, one in zip(read, table.readings, strict=True) if one.level]
    linear = [path for path, one in with_levels if not one.about]
    if table.scan is not None and table.scan.level:
        linear.append((*TABLE, "scan"))
    if table.reference_level is None and linear:
        yield Problem(
            path=linear[0],
            message="levels need a reference for 0 dB",
            allowed='reference_level = "1e-5 m/s^2", or the reference of the instrument',
            hint="1e-5 m/s^2 in older and naval work, 1e-6 m/s^2 in ISO 1683",
        )
    angular = [path for path, one in with_levels if one.about]
    if table.angular_reference_level is None and angular:
        yield Problem(
            path=angular[0],
            message="levels of rotation need a reference for 0 dB",
            allowed='angular_reference_level = "1 rad/s^2", or the reference of the instrument',
        )


def _steps(table: Measurement) -> Iterator[Problem]:
    """Readings without their last digit."""
    for key, numbers, example in (
        ("amplitude_step", "amplitude", "0.001 m/s^2"),
        ("angular_step", "angular_amplitude", "0.01 rad/s^2"),
        ("phase_step", "phase", "1 deg"),
    ):
        places: list[KeyPath] = [
            (*TABLE, "readings", place)
            for place, one in enumerate(table.readings)
            if getattr(one, numbers)
        ]
        if key != "angular_step":
            scanned = table.scan is not None and bool(getattr(table.scan, numbers))
            if scanned or table.spectrum:
                places.append((*TABLE, "spectrum" if table.scan is None else "scan"))
        if getattr(table, key) is None and places:
            yield Problem(
                path=places[0],
                message=f"[measurement] does not say the {key.replace('_', ' ')}: how far is a "
                "reading off?",
                allowed=f'{key} = "{example}", the last digit that was read',
            )


def _mismatched(table: Measurement) -> Iterator[Problem]:
    """Differences of accelerometers that are not alike, without what both of them read."""
    if not table.has_mismatch:
        return
    key = "sensitivity_mismatch" if table.sensitivity_mismatch else "phase_mismatch"
    if not any(one.between for one in table.readings):
        yield Problem(
            path=(*TABLE, key),
            message="a mismatch is one of the two accelerometers of a difference, and none is read",
            allowed="readings with between = [...]",
        )
    read = {(order, one.at) for one in table.readings for order in one.orders or table.orders}
    read |= {(order, one.at) for one in table.spectrum for order in table.orders}
    for place, one in enumerate(table.readings):
        missing = [
            (order, at)
            for order in one.orders or table.orders
            for at in one.between or ()
            if (order, at) not in read
        ]
        if missing:
            order, at = missing[0]
            yield Problem(
                path=(*TABLE, "readings", place, "between"),
                message=f"the {key.replace('_', ' ')} of two accelerometers acts by the motion of "
                "both positions",
                found=f"no reading at {at!r} of harmonic {order}",
                allowed='a reading at either position, for which use = "compare" is enough',
            )


def _forms(table: Measurement) -> Iterator[Problem]:
    for place, reading in enumerate(table.readings):
        yield from _form((*TABLE, "readings", place), reading, table)


def _form(path: KeyPath, reading: Reading, table: Measurement) -> Iterator[Problem]:
    yield from _other_orders((*path, "orders"), reading.orders, table, _OF_READING)
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
        if key in _SIZES[1:] and not reading.phase and 0.0 in values:
            yield Problem(
                path=(*path, key, values.index(0.0)),
                message="an amplitude of zero without a phase has no level",
                allowed="the smallest value that the instrument shows, or no reading",
            )


_OF_READING = "a reading covers harmonics of [measurement]"
_OF_SCAN = "a row of the scan is of no harmonic of [measurement]"


def _other_orders(
    path: KeyPath, orders: tuple[int, ...], table: Measurement, message: str
) -> Iterator[Problem]:
    for place, order in enumerate(orders):
        if order not in table.orders:
            allowed = ", ".join(map(str, table.orders))
            yield Problem((*path, place), message, found=str(order), allowed=allowed)


def _scan(table: Measurement) -> Iterator[Problem]:
    scan = table.scan
    if scan is None:
        return
    path: KeyPath = (*TABLE, "scan")
    yield from _other_orders((*path, "order"), scan.order, table, _OF_SCAN)
    words = "is not negative" if scan.phase else "is larger than zero"
    for place, size in enumerate(scan.amplitude):
        if size < 0.0 or (size == 0.0 and not scan.phase):
            yield Problem(
                path=(*path, "amplitude", place),
                message=f"an amplitude {words}",
                found=f"{size:.6g} m/s^2 in row {place + 1}",
                hint="its sign is a phase of 180 deg",
            )

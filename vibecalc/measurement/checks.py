"""Physical checks of readings on a plate: numbers within reason, names, forms, frequencies."""

from collections.abc import Iterator

from vibecalc.errors import KeyPath, Problem
from vibecalc.measurement.tables import Measurement, Reading
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Are the numbers of a measurement within reason, and does it say what they count in?
# ----------------------------------------------------------------------------

TABLE: KeyPath = ("measurement",)


def scale_problems(table: Measurement) -> list[Problem]:
    """Levels without a reference, and readings without their last digit."""
    return [*_references(table), *_steps(table)]


def _references(table: Measurement) -> Iterator[Problem]:
    scanned = table.scan is not None and bool(table.scan.level)
    linear = [n for n, one in enumerate(table.readings) if one.level and not one.about]
    if table.reference_level is None and (linear or scanned):
        path: KeyPath = (*TABLE, "readings", linear[0], "level") if linear else (*TABLE, "scan")
        yield Problem(
            path=path,
            message="levels without a reference: a level says nothing without what 0 dB is",
            allowed='reference_level = "1e-5 m/s^2", or what the instrument refers to',
            hint="1e-5 m/s^2 in older and naval work, 1e-6 m/s^2 in ISO 1683",
        )
    angular = [n for n, one in enumerate(table.readings) if one.level and one.about]
    if table.angular_reference_level is None and angular:
        yield Problem(
            path=(*TABLE, "readings", angular[0], "level"),
            message="levels of rotation without a reference: what is 0 dB?",
            allowed='angular_reference_level = "1 rad/s^2", or what the instrument refers to',
        )


def _steps(table: Measurement) -> Iterator[Problem]:
    scan = table.scan
    needs = {
        "amplitude_step": [n for n, one in enumerate(table.readings) if one.amplitude],
        "angular_step": [n for n, one in enumerate(table.readings) if one.angular_amplitude],
        "phase_step": [n for n, one in enumerate(table.readings) if one.phase],
    }
    scanned = {
        "amplitude_step": (scan is not None and bool(scan.amplitude)) or bool(table.spectrum),
        "phase_step": (scan is not None and bool(scan.phase)) or bool(table.spectrum),
    }
    example = {"amplitude_step": "0.001 m/s^2", "angular_step": "0.01 rad/s^2"}
    for key, readings in needs.items():
        if getattr(table, key) is None and (readings or scanned.get(key)):
            yield Problem(
                path=(*TABLE, "readings", readings[0])
                if readings
                else (*TABLE, "scan" if scan is not None else "spectrum"),
                message=f"[measurement] does not say the {key.replace('_', ' ')}: how far is a "
                "reading off?",
                allowed=f'{key} = "{example.get(key, "1 deg")}", the last digit that was read',
            )


# ----------------------------------------------------------------------------
# Do the readings on a plate make sense, and do their places tell its motion?
# ----------------------------------------------------------------------------

_SIZES = ("level", "amplitude", "angular_amplitude")


def measurement_problems(case: Case) -> list[Problem]:
    """Problems of [measurement]: form first, then references, then what can be found at all."""
    table = case.measurement
    if table is None:
        return list(_nothing_read(case))
    problems = [
        *_forms(table),
        *_scan(table),
    ]
    problems = problems or scale_problems(table)
    if problems:
        return problems
    # loads what solves the motion
    from vibecalc.measurement.model import place_problems

    return place_problems(table)


def _nothing_read(case: Case) -> Iterator[Problem]:
    if case.machine.kind == "plate":
        yield Problem(
            path=("machine", "kind"),
            message="nothing is said of the plate: its motion comes from readings",
            found='kind = "plate" without [measurement]',
            allowed="a table [measurement] with positions and readings",
        )


def _forms(table: Measurement) -> Iterator[Problem]:
    for place, reading in enumerate(table.readings):
        yield from _form((*TABLE, "readings", place), reading, table)


def _form(path: KeyPath, reading: Reading, table: Measurement) -> Iterator[Problem]:
    for place, order in enumerate(reading.orders):
        if order not in table.orders:
            yield Problem(
                path=(*path, "orders", place),
                message="a reading covers harmonics of [measurement]",
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

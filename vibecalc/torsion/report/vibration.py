"""Vibration of a shaft line at the operating speed and over the range of speeds."""

import numpy as np

from vibecalc.core.report.rows import Cells, Found, How, Rows, named_at, part_of, rows_of
from vibecalc.core.report.sections import Section, having, labels
from vibecalc.core.report.writing import paragraph, show, show_phase
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    MILLI,
    TORSION,
    at_speed,
    cell,
    joined,
    line_of,
    meeting,
    meetings,
    mode_names,
    names,
    range_words,
    row_of,
    strongest,
    titled,
    torque_unit,
    turns,
    vector,
    worst_section,
)
from vibecalc.torsion.results import PowerBalance

# ----------------------------------------------------------------------------
# Vibration of a shaft line at the operating speed: sections, stations, dampers, gears, orders.
# ----------------------------------------------------------------------------

_ROOT = TORSION.rstrip("/")
_ORDERS = 12


def in_turns(speed: float, _error: float) -> str:
    """A speed in rad/s as rpm without zeros at its end."""
    return turns(speed)


def torsion_steady(result: Result) -> Section | None:
    """The section, None if the line was not driven at the operating speed."""
    if having(result.record, TORSION + "torque_half_range", "section") is None:
        return None
    details = {"orders in the most loaded section, angles of the stations": (_orders, _stations)}
    return titled(
        result, f"Vibration at the operating speed{at_speed(result, ', ')}",
        _sections(result.record), _dampers(result.record), _gears(result.record), _balance(result),
        details=details,
    )  # fmt: skip


def _table(
    record: Record, axis: str, columns: list[Cells], note: str = "", above: str = ""
) -> list[str]:
    """Of results of the line over an axis, without columns of zeros."""
    return rows_of(record, Rows(axis, axis, columns, _ROOT, note=note, above=above, acting=True))[0]


def _sections(record: Record) -> list[str]:
    unit = torque_unit(record)[1]
    words = "Torque, stress, twist: half ranges. Peak: with the mean. Bound: sum of all orders' "
    words += "amplitudes."
    half = having(record, TORSION + "angle_half_range", "station")
    if half is not None:
        top = int(np.argmax(half.values))
        degrees = cell(half, top, 180.0 / np.pi)
        words += f" Largest angle: {cell(half, top, MILLI)} mrad ({degrees} deg) "
        words += f"half range, at {labels(half.axes[0])[top]}."
    torques = ("half_range", "torque"), ("mean", "mean"), ("peak", "peak"), ("bound", "bound")
    return _table(record, "section", [
        *(Cells(f"torque_{name}", f"{head}\n{unit}", unit) for name, head in torques),
        Cells("stress_half_range", "stress\nN/mm^2", "N/mm^2"),
        Cells("twist_half_range", "twist\nmrad", "mrad"),
        Cells("section_heat", "heat\nW", "W"),
    ], words)  # fmt: skip


def _orders(result: Result) -> list[str]:
    """The strongest orders in the most loaded section."""
    record, unit = result.record, torque_unit(result.record)[1]
    name, torque = worst_section(record), TORSION + "torque"
    count = len(names(record, "torque", "half_order"))
    first = names(record, "excitation/firing_angle", "cylinder")
    angle = vector(record, "excitation/firing_angle", "cylinder")
    since = "crank angle zero" if angle is None else (
        f"the firing of cylinder {first[int(np.argmin(angle))]!r}")  # fmt: skip
    more = f"; the strongest {_ORDERS} of {count}" if count > _ORDERS else ""
    of: tuple[tuple[str, str, How], ...] = (
        (torque, f"torque\n{unit}", unit),
        (torque, "phase\ndeg", show_phase),
        (TORSION + "twist", "twist\nmrad", "mrad"),
        (TORSION + "twist", "twist\ndeg", "deg"),
        (TORSION + "stress", "stress\nN/mm^2", "N/mm^2"),
    )
    columns = [Cells(row_of(path, name), head, how) for path, head, how in of]
    return rows_of(record, Rows(
        "half_order", "order", columns, label="{:.4g}", right=True, places=strongest(_ORDERS),
        above=f"Orders in section {name!r}, 0-to-peak, phase from {since}{more}:",
    ))[0]  # fmt: skip


def _stations(result: Result) -> list[str]:
    of = ("half_range", "half range"), ("peak", "peak")
    return _table(result.record, "station", [
        *(Cells(f"angle_{name}", f"{words}\n{unit}", unit)
          for name, words in of for unit in ("mrad", "deg")),
        Cells("station_heat", "heat\nW", "W"),
    ], above="Angles of the stations against steady rotation, all orders together:")  # fmt: skip


def _dampers(record: Record) -> list[str]:
    columns = [
        Cells("damper/heat", "heat, mean\nW", "W"),
        Cells("damper/travel", "travel, peak\nmrad", "mrad"),
        Cells("damper/travel", "travel, peak\ndeg", "deg"),
    ]
    for name, unit in (("heat", "W"), ("travel", "mrad")):
        if not np.any(vector(record, f"largest/{name}", "damper")):
            continue
        columns.append(Cells(f"largest/{name}", f"largest {name}\nover speeds, {unit}", unit))
        columns.append(Cells(f"largest/{name}_speed", "at\nrpm", in_turns))
    return _table(record, "damper", columns)


_TEETH = ("  stay in contact", "  HAMMER: torque reverses")


def _gears(record: Record) -> list[str]:
    unit = torque_unit(record)[1]

    def teeth(record: Record) -> Quantity | None:
        found = having(record, TORSION + "gear/hammers", "gear")
        words = [] if found is None else [_TEETH[int(one)] for one in found.values]
        return None if found is None else part_of(found, np.array(words), *found.axes)

    of = ("mean", "mean torque"), ("alternating", "half range"), ("minimum", "minimum")
    return _table(record, "gear", [
        *(Cells(f"gear/{name}_torque", f"{words}\n{unit}", unit) for name, words in of),
        Cells(teeth, "  teeth"),
    ], "Torque on the first wheel; minimum: in the sense of the mean, negative: teeth part."
    )  # fmt: skip


def _balance(result: Result) -> list[str]:
    """Mean torque and power of sources and loads, and what the load station does on top."""
    record, line = result.record, line_of(result)
    rest = record.quantities.get(f"{PowerBalance.ROOT}/rest_torque")
    if rest is None or line is None:
        return []
    factor, unit = torque_unit(record)
    torque, power = factor * float(rest.values), record[f"{PowerBalance.ROOT}/rest_power"].values
    does = "takes" if torque >= 0.0 else "has to GIVE"
    words = f"Own shafts. Station '{line.station_names[line.load_station]}' {does} what is left: "
    words += f"{show(abs(torque))} {unit}, {show(1e-3 * abs(float(power)))} kW."
    share = record.quantities.get(f"{PowerBalance.ROOT}/load_share")
    if share is not None and np.isfinite(share.values):
        words += f" The loads take {show(100.0 * float(share.values))} % of the indicated "
        words += "power, MORE THAN ALL of it." if share.values > 1.01 else "power."
    columns = [
        Cells(path, f"{name}\n{{unit}}", how)
        for path, name, how in zip(
            paths_of(PowerBalance), ("cylinders", "cylinders", "loads", "loads"),
            2 * (unit, "kW"), strict=False,
        )
    ]  # fmt: skip
    title = "mean torque and power, of each"
    rows = Rows("station", title, columns, places=_not_zero, merge=True, note=words)
    return rows_of(record, rows)[0]


def _not_zero(found: Found) -> np.ndarray:
    return np.flatnonzero(np.any([one.values != 0.0 for one in found], axis=0))


# ----------------------------------------------------------------------------
# Vibration of a shaft line over the speeds: worst sections, with and without damper, peaks.
# ----------------------------------------------------------------------------

_MOST = 24
#: ranges that nothing damps, by name
_NAMED = 8


def torsion_speeds(result: Result) -> Section | None:
    """The section, None without a range of speeds."""
    title = f"Vibration over the speed range, {range_words(result)}"
    details = {"peaks over the speed": [_peaks]}
    return titled(result, title, _worst(result), _masked(result), details=details)


def _worst(result: Result) -> list[str]:
    """The largest half ranges of each section over the speeds, and those without dampers."""
    unit = torque_unit(result.record)[1]
    return _table(result.record, "section", [
        Cells("largest/torque_half_range", f"torque\n{unit}", unit),
        Cells("largest/stress_half_range", "stress\nN/mm^2", "N/mm^2"),
        Cells("largest/twist_half_range", "twist\nmrad", "mrad"),
        Cells("bare/largest/torque_half_range", f"no dampers\n{unit}", unit),
        Cells("reduction", "ratio"),
        Cells("largest/speed", "at\nrpm", in_turns),
        Cells(meetings(result, f"{TORSION}largest"), "mode, order"),
    ], "Largest half ranges; no mode and order: at an end of the range, or of several orders."
    )  # fmt: skip


def _peaks(result: Result) -> list[str]:
    unit, stem = torque_unit(result.record)[1], f"{TORSION}peak"
    columns = (
        Cells(f"{stem}/speed", "{unit}", "rpm"),
        Cells(f"{stem}/torque_half_range", "torque\n{unit}", unit),
        Cells(named_at(f"{stem}/section", f"{TORSION}torque_half_range"), "in section"),
        Cells(meetings(result, stem), "mode, order"),
    )
    words = (
        "Peaks over the speed of the section with most torque and, where it is another, of the "
        f"most stressed one, the highest {_MOST}; mode and order: of the nearest critical whose "
        "order peaks there:"
    )
    return rows_of(result.record, Rows("peak", "", columns, places=strongest(_MOST, 1),
                                       above=words))[0]  # fmt: skip


def _masked(result: Result) -> list[str]:
    record, known = result.record, mode_names(result)
    low, high, mode, order = (
        vector(record, f"masked/{name}", "masked") for name in ("from", "to", "mode", "half_order")
    )
    if low is None or high is None:
        return []
    words = []
    for i, (start, stop) in enumerate(zip(map(turns, low), map(turns, high), strict=True)):
        met = "" if mode is None or order is None else meeting(known, mode[i], order[i])
        words.append(f"{start}{f' to {stop}' * (start != stop)} rpm{f' ({met})' * bool(met)}")
    more = len(words) - _NAMED
    listed = words[:_NAMED] + [f"{more} more ranges"] * (more > 0)
    return paragraph(f"Nothing damps the line at {joined(listed)}: vibration is unbounded there.")

"""Vibration of a shaft line at speed, over the range, by order, in conditions; barred ranges."""

from collections.abc import Iterator

import numpy as np

from vibecalc.core.report.rows import (
    Cells,
    Found,
    How,
    Made,
    Rows,
    derived,
    named_at,
    part_of,
    rows_of,
)
from vibecalc.core.report.sections import Section, having, labels, magnitudes, speed_of
from vibecalc.core.report.writing import (
    Column,
    number,
    paragraph,
    short,
    show,
    show_phase,
    table,
    turns,
)
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.numerics.rounding import (
    BoolArray,
    FloatArray,
    first_of_largest,
    firsts_of_largest,
    ranked,
)
from vibecalc.torsion.report.excitation import VARIANTS, variant_words
from vibecalc.torsion.report.limits import (
    basis,
    crank_places,
    formulas,
    limited_words,
    numbered,
    origins,
    uses_by_section,
)
from vibecalc.torsion.report.line import (
    MILLI,
    TORSION,
    at_speed,
    cell,
    every,
    joined,
    line_of,
    meeting,
    meetings,
    mode_names,
    names,
    order_text,
    range_words,
    row_of,
    strongest,
    titled,
    torque_unit,
    vector,
    worst_section,
)
from vibecalc.torsion.results import QUANTITIES, PowerBalance
from vibecalc.units import convert

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
    words = "Torque, stress, twist: half ranges. Peak: mean included. Bound: sum of the "
    words += "amplitudes of all orders."
    half = having(record, TORSION + "angle_half_range", "station")
    if half is not None and np.any(half.values):
        top = first_of_largest(half.values)
        degrees = cell(half, top, 180.0 / np.pi)
        words += f" Largest angle: {cell(half, top, MILLI)} mrad ({degrees} deg) "
        words += f"half range, at {labels(half.axes[0])[top]}."
    torques = ("half_range", "torque"), ("mean", "mean"), ("peak", "peak"), ("bound", "bound")
    return _table(record, "section", [
        *(Cells(f"torque_{name}", f"{head}\n{unit}", unit) for name, head in torques),
        Cells("stress_half_range", "stress\nN/mm^2", "N/mm^2"),
        Cells("twist_half_range", "twist\nmrad", "mrad"),
        Cells("section_heat", "heat\n{unit}", "W"),
    ], words)  # fmt: skip


def _orders(result: Result) -> list[str]:
    """The strongest orders in the most loaded section."""
    record, unit = result.record, torque_unit(result.record)[1]
    name, torque = worst_section(record), TORSION + "torque"
    count = len(names(record, "torque", "order"))
    first = names(record, "excitation/firing_angle", "cylinder")
    angle = vector(record, "excitation/firing_angle", "cylinder")
    since = "crank angle zero" if angle is None else (
        f"the firing of cylinder {first[int(np.argmin(angle))]!r}")  # fmt: skip
    more = f"; {_ORDERS} strongest of {count}" if count > _ORDERS else ""
    of: tuple[tuple[str, str, How], ...] = (
        (torque, f"torque\n{unit}", unit),
        (torque, "phase\ndeg", show_phase),
        (TORSION + "twist", "twist\nmrad", "mrad"),
        (TORSION + "twist", "twist\ndeg", "deg"),
        (TORSION + "stress", "stress\nN/mm^2", "N/mm^2"),
    )
    columns = [Cells(row_of(path, name), head, how) for path, head, how in of]
    return rows_of(record, Rows(
        "order", "order", columns, label="{:.4g}", right=True, places=strongest(_ORDERS),
        above=f"Orders in section {name!r}, 0-to-peak, phase relative to {since}{more}:",
    ))[0]  # fmt: skip


def _stations(result: Result) -> list[str]:
    of = ("half_range", "half range"), ("peak", "peak")
    return _table(result.record, "station", [
        *(Cells(f"angle_{name}", f"{words}\n{unit}", unit)
          for name, words in of for unit in ("mrad", "deg")),
        Cells("station_heat", "heat\n{unit}", "W"),
    ], above="Station angles relative to uniform rotation, all orders:")  # fmt: skip


def _dampers(record: Record) -> list[str]:
    columns = [
        Cells("damper/heat", "heat, mean\n{unit}", "W"),
        Cells("damper/travel", "travel, peak\nmrad", "mrad"),
        Cells("damper/travel", "travel, peak\ndeg", "deg"),
    ]
    for name, unit in (("heat", "W"), ("travel", "mrad")):
        if not np.any(vector(record, f"largest/{name}", "damper")):
            continue
        columns.append(Cells(f"largest/{name}", f"largest {name}\nover speeds, {{unit}}", unit))
        columns.append(Cells(f"largest/{name}_speed", "at\nrpm", "rpm"))
    return _table(record, "damper", columns)


_TEETH = ("  in contact", "  HAMMER: torque reverses")


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
    ], "Torque on the first wheel; minimum in the direction of the mean, negative: hammer."
    )  # fmt: skip


def _balance(result: Result) -> list[str]:
    """Mean torque and power of sources and loads, and what the load station does on top."""
    record, line = result.record, line_of(result)
    rest = record.quantities.get(f"{PowerBalance.ROOT}/rest_torque")
    if rest is None or line is None:
        return []
    factor, unit = torque_unit(record)
    torque, power = factor * float(rest.values), record[f"{PowerBalance.ROOT}/rest_power"].values
    does = "absorbs" if torque >= 0.0 else "supplies"
    words = f"Not referred. Station '{line.station_names[line.load_station]}' {does} the balance: "
    words += f"{show(abs(torque))} {unit}, {show(1e-3 * abs(float(power)))} kW."
    share = record.quantities.get(f"{PowerBalance.ROOT}/load_share")
    if share is not None and np.isfinite(share.values):
        words += f" The loads absorb {show(100.0 * float(share.values))} % of the indicated "
        words += "power, MORE THAN THE ENGINE DELIVERS." if share.values > 1.01 else "power."
    columns = [
        Cells(path, f"{name}\n{{unit}}", how)
        for path, name, how in zip(
            paths_of(PowerBalance), ("indicated", "indicated", "absorbed", "absorbed"),
            2 * (unit, "kW"), strict=False,
        )
    ]  # fmt: skip
    title = "mean torque and power, each"
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
        Cells("without_dampers/largest/torque_half_range", f"no dampers\n{unit}", unit),
        Cells("reduction", "ratio"),
        Cells("largest/speed", "at\nrpm", "rpm"),
        Cells(meetings(result, f"{TORSION}largest"), "mode, order"),
    ], "Largest half ranges; mode, order blank: at an end of the range, or from several orders."
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
        "Peaks over the speed range in the section with the largest torque and, if different, the "
        f"largest stress ({_MOST} highest); mode, order: nearest critical speed of the order that "
        "peaks:"
    )
    return rows_of(result.record, Rows("peak", "", columns, places=strongest(_MOST, 1),
                                       above=words))[0]  # fmt: skip


def _masked(result: Result) -> list[str]:
    record, known = result.record, mode_names(result)
    low, high, mode, order = (
        vector(record, f"resonances_skipped/{name}", "resonance_skipped")
        for name in ("from", "to", "mode", "order")
    )
    if low is None or high is None:
        return []
    words = []
    for i, (start, stop) in enumerate(zip(map(turns, low), map(turns, high), strict=True)):
        met = "" if mode is None or order is None else meeting(known, mode[i], order[i])
        words.append(f"{start}{f' to {stop}' * (start != stop)} rpm{f' ({met})' * bool(met)}")
    more = len(words) - _NAMED
    listed = words[:_NAMED] + [f"{more} more ranges"] * (more > 0)
    return paragraph(f"No damping at {joined(listed)}: the vibration is unbounded there.")


# ----------------------------------------------------------------------------
# Curves of orders: the largest of each order over the speeds, and what was measured.
# ----------------------------------------------------------------------------

#: orders of a shaft or station, measured points of a quantity
_STRONGEST, _POINTS = 6, 40
#: what is read in other units than those of results
_READ = {"stress": "N/mm^2", "twist": "mrad", "angle": "mrad"}
_AMPLITUDES = (
    "Single orders: largest amplitude (0-to-peak) over the speed range. Sum of orders: half range "
    "of all orders with their phases, at the speeds of the curves."
)


def drawn(record: Record) -> Iterator[tuple[str, Quantity]]:
    """Names and orders of the quantities that a result has curves of."""
    for name in QUANTITIES:
        found = record.quantities.get(f"{TORSION}curves/{name}/order")
        if found is not None:
            yield name, found


def _unit(record: Record, name: str, of: Quantity) -> tuple[float, str]:
    """Factor from SI and the unit that people read."""
    unit = torque_unit(record)[1] if name == "torque" else _READ.get(name, of.unit)
    return convert(1.0, of.unit, unit), unit


def torsion_curves(result: Result) -> Section | None:
    """The section, None if no curves are asked for."""
    record = result.record
    tables = [_largest(record, name, found) for name, found in drawn(record)]
    if not tables:
        return None
    tables[-1] += paragraph(_AMPLITUDES)
    title = f"Order curves, {range_words(result)}"
    return titled(result, title, *tables, _measured(record))


def _largest(record: Record, name: str, found: Quantity) -> list[str]:
    """For each shaft or station of a quantity its strongest orders, and their sum."""
    factor, unit = _unit(record, name, found)
    stem = f"{TORSION}curves/{name}"
    top, at, half = (record[f"{stem}/{one}"] for one in ("largest", "largest_speed", "half_range"))
    speed, rows = half.axes[1].values, list[list[str]]()
    for place, one in enumerate(labels(found.axes[0])):
        sizes = magnitudes(top)[place]
        best = int(np.argmax(half.values[place]))
        # between the speeds of the curve
        endless = np.isinf(sizes).any()
        whole = show(np.inf) if endless else cell(half, (place, best), factor)
        rows.append([one, "sum of orders", whole, turns(speed[best])])
        rows += [
            ["", order_text(top.axes[1].values[i]), cell(top, (place, i), factor),
             turns(at.values[place, i])]
            for i in np.sort(ranked(sizes)[:_STRONGEST]).tolist()
        ]  # fmt: skip
    heads = [Column(found.axes[0].name), Column("order")]
    return table([*heads, number(f"{name.replace('_', ' ')}\n{unit}"), number("at\nrpm")], rows)


def _measured(record: Record) -> list[str]:
    """Measured points next to what is computed."""
    rows = []
    for name, found in drawn(record):
        stem = f"{TORSION}curves/{name}/measured"
        if f"{stem}/value" not in record:
            continue
        (factor, unit), axis = _unit(record, name, found), found.axes[0]
        value, own, speed, order, computed = (
            record[f"{stem}/{one}"] for one in ("value", axis.name, "speed", "order", "computed")
        )
        for i in range(min(value.values.size, _POINTS)):
            ratio = value.values[i] / computed.values[i] if computed.values[i] else np.inf
            rows.append([
                labels(axis)[int(own.values[i]) - 1], f"{name.replace('_', ' ')}, {unit}",
                order_text(order.values[i]) if order.values[i] else "sum",
                turns(speed.values[i]), cell(value, i, factor), cell(computed, i, factor),
                show(ratio, digits=3),
            ])  # fmt: skip
    heads = ("order", "rpm", "measured", "computed", "ratio")
    return table([Column("measured on"), Column("quantity"), *map(number, heads)], rows)


# ----------------------------------------------------------------------------
# Cyclic irregularity.
# ----------------------------------------------------------------------------

_ALL = f"{TORSION}conditions"


def torsion_irregularity(result: Result) -> Section | None:
    """The section, None if no station is asked for."""
    return titled(result, "Cyclic irregularity", rows_of(result.record, _IRREGULARITY)[0])


def _over(degree: float, _error: float) -> str:
    return short(1.0 / degree) if 0.0 < degree < np.inf else "-"


def _largest_along(path: str, along: str, named: bool = False) -> Made:
    """The largest of each entry along another axis, or the name of where it is."""

    def largest(found: Quantity) -> Quantity:
        over = [axis.name for axis in found.axes].index(along)
        place, other = firsts_of_largest(found.values, axis=over), found.axes[1 - over]
        names = np.array(labels(found.axes[over]), dtype=object)
        values = names[place].astype(str) if named else np.max(found.values, axis=over)
        return part_of(found, values, other)

    return derived(path, largest)


_IRREGULARITY = Rows(
    "station",
    "station",
    (
        Cells("degree", "at speed"),
        Cells("degree", "1 : x", _over),
        Cells("largest/degree", "largest"),
        Cells("largest/degree", "1 : x", _over),
        Cells("largest/speed", "at\nrpm", "rpm"),
        Cells("electrical_angle", "el. angle at\nspeed, deg", "deg"),
        Cells(_largest_along(f"{_ALL}/irregularity", "condition"), "worst"),
        Cells(_largest_along(f"{_ALL}/irregularity", "condition", named=True), "at speed in"),
    ),
    root=f"{TORSION}irregularity",
    note="Cyclic irregularity: (maximum - minimum) / mean angular speed of the station within a "
    "cycle, rigid-body motion and vibration together. Electrical angle: half range of the "
    "vibration times the number of pole pairs.",
)


# ----------------------------------------------------------------------------
# Conditions of the cylinders: which of them is the worst, and what it does.
# ----------------------------------------------------------------------------

_CONDITIONS = 12


def torsion_conditions(result: Result) -> Section | None:
    """The section, None if no conditions are asked for."""
    record, torque = result.record, f"{_ALL}/torque_half_range"
    if torque not in record:
        return None
    unit, stress, largest = torque_unit(record)[1], f"{_ALL}/stress_half_range", f"{_ALL}/largest"
    columns = (
        Cells(row_of(torque, 0), "all fire\n{unit}", unit),
        Cells(_largest_along(torque, "condition"), "worst\n{unit}", unit),
        Cells(_largest_along(stress, "condition"), "stress\n{unit}", "N/mm^2"),
        Cells(_largest_along(torque, "condition", named=True), "condition"),
        Cells(f"{largest}/torque_half_range", "largest\n{unit}", unit),
        Cells(f"{largest}/stress_half_range", "stress\n{unit}", "N/mm^2"),
        Cells(f"{largest}/section_speed", "at\n{unit}", "rpm"),
        Cells(named_at(f"{largest}/section_condition", torque), "condition"),
    )
    words = (
        f"Half ranges in the worst of {len(record[torque].axes[0].values)} cylinder "
        "conditions, at the operating speed and over the speed range."
    )
    title = "Misfire and imbalance: the worst condition of each section"
    blocks = [rows_of(record, one)[0]
              for one in (Rows("section", "section", columns, note=words), _USES)]  # fmt: skip
    blocks.append(exceeded_table(record, "conditions/"))
    details = {"every condition at the operating speed": [_every]}
    return titled(result, title, *blocks, details=details)


def _highest(found: Found) -> np.ndarray:
    """Conditions of the largest uses of limits, the worst first."""
    most = found[0].values.max(axis=1)
    return ranked(most)[:_CONDITIONS]


_USES = Rows(
    "condition",
    "condition",
    (
        Cells("largest_utilisation", "limit {}\nutil., %", "%"),
        Cells("speed", "limit {}\nat rpm", "rpm"),
        Cells("operating_utilisation", "limit {} at\nspeed, %", "%"),
    ),
    root=f"{_ALL}/limit",
    places=_highest,
    note="Utilisation: load / load allowed in continuous operation.",
)


def _every(result: Result) -> list[str]:
    """Largest torque, stress and angle of each condition at the operating speed."""
    unit = torque_unit(result.record)[1]
    torque, angle = (f"{_ALL}/{name}_half_range" for name in ("torque", "angle"))
    columns = (
        Cells(f"{_ALL}/mean_torque", "mean torque\n{unit}", unit),
        Cells(_largest_along(torque, "section"), "torque\n{unit}", unit),
        Cells(_largest_along(torque, "section", named=True), "in section"),
        Cells(_largest_along(f"{_ALL}/stress_half_range", "section"), "stress\n{unit}", "N/mm^2"),
        Cells(_largest_along(angle, "station"), "angle\n{unit}", "mrad"),
        Cells(_largest_along(angle, "station", named=True), "at station"),
    )
    words = "The largest half range of each condition at the operating speed:"
    of = Rows("condition", "condition", columns, above=words)
    return rows_of(result.record, of)[0]


# ----------------------------------------------------------------------------
# Ranges of speeds above the limits of a shaft line, and what is barred for them.
# ----------------------------------------------------------------------------


def torsion_limits(result: Result) -> Section | None:
    """The section, None if the case has no limit of stress or torque."""
    record = result.record
    held = (f"{TORSION}limit/{which}_utilisation" for which in ("largest", "operating"))
    if not {*held} & set(record):
        return None
    blocks = uses_by_section(result), crank_places(result), exceeded_table(record)
    title = f"{limited_words(record).capitalize()} limits and barred ranges"
    return titled(
        result, title, *blocks, details={"rules of the limits": (formulas, basis, origins)}
    )


def barred_ranges(result: Result, *, permitted: bool = True, variant: str = "") -> list[str]:
    """Each range to be barred as words, `44.37 to 53.78 rpm`, or each that may not be.

    Those of the line as it is, or of a variant: `healthy/`, `conditions/`.
    """
    low, high = _ends(result.record, variant)
    chosen = np.flatnonzero(may_be_barred(result, variant) == permitted)
    return [f"{turns(low[i])} to {turns(high[i])} rpm" for i in chosen]


def may_be_barred(result: Result, variant: str = "") -> BoolArray:
    """Which of the ranges (b,) may be barred: none that holds the operating speed."""
    low, high = _ends(result.record, variant)
    may = vector(result.record, f"{variant}barred/permitted", "barred")
    may = np.ones(len(low)) if may is None else may
    inside = (low <= (at := speed_of(result) or 0.0)) & (at <= high)  # as an older file may not say
    return np.asarray((may > 0.0) & ~inside)


def _ends(record: Record, variant: str) -> list[FloatArray]:
    """Both ends of each range (b,), in rad/s; none without limits."""
    ends = [vector(record, f"{variant}barred/{name}", "barred") for name in ("from", "to")]
    return [np.zeros(0) if end is None else end for end in ends]


def acceptable(record: Record, place: int, _path: str) -> str:
    """What stands behind a range in the first table that may not be barred."""
    may = vector(record, "barred/permitted", "barred")
    return "" if may is None or may[place] else "NOT ACCEPTABLE: may not be barred"


def barred_by(record: Record, place: int, _path: str) -> str | None:
    """The limits that bar a range of the first table: `limits 1 and 2`."""
    found = every(record, "exceeded", "exceeded", "from", "to", "limit")
    if not found:
        return None
    start, stop, limit = (one.values for one in found)
    low, high = (float(record[f"{TORSION}barred/{end}"].values[place]) for end in ("from", "to"))
    return numbered(sorted({int(one) for one in limit[(start >= low) & (stop <= high)]}))


def ranges_in_words(result: Result, variant: str = "") -> list[str]:
    """What is barred, and where the line is not acceptable."""
    barred, not_ = (barred_ranges(result, permitted=one, variant=variant) for one in (True, False))
    lead = f"with {variant_words(result, variant)} " * bool(variant)
    words = []
    if barred:
        verb = "are" if len(barred) > 1 else "is"
        words.append(f"{lead}{joined(barred)} {verb} barred for continuous operation")
    if not_:
        why = "a limit for continuous operation is exceeded within, and barring is not permitted"
        words.append(f"{lead}the line is not acceptable from {joined(not_)}: {why}")
    return words


def all_ranges_in_words(result: Result) -> list[str]:
    """Those of the line as it is, of all cylinders firing, and of conditions of the cylinders."""
    of = ("", *VARIANTS)
    return [words for variant in of for words in ranges_in_words(result, variant)]


def exceeded_table(record: Record, variant: str = "") -> list[str]:
    """The ranges above the limits, and which of them may be barred."""
    above = (
        f"Speed ranges in which the {limited_words(record, 'or')} exceeds the limit for "
        "continuous operation:"
    )
    root = f"{TORSION}{variant}exceeded"
    condition = named_at(f"{root}/condition", f"{TORSION}conditions/torque_half_range")
    columns = Cells(condition, "condition"), *_EXCEEDED
    of = Rows("exceeded", "", [one._replace(of=f"{root}/{one.of}") if isinstance(one.of, str)
                               else one for one in columns], above=above)  # fmt: skip
    return rows_of(record, of)[0]


def _turns(speed: float, _error: float) -> str:
    return turns(speed) if speed else ""


def _number(value: float, _error: float) -> str:
    return str(int(value)) if value else ""


_EXCEEDED = (
    Cells("from", "from\nrpm", _turns, right=True),
    Cells("to", "to\nrpm", _turns),
    Cells("limit", "limit", _number),
    Cells("peak_speed", "worst at\nrpm", _turns),
    Cells("formula_from", "by formula\nfrom, rpm", _turns),
    Cells("formula_to", "to\nrpm", _turns),
    Cells("permitted", "barred range", lambda may, _: "acceptable" if may else "NOT ACCEPTABLE"),
)

"""Studies of a shaft line: change in time, variable inertia, modal method, design of a damper."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from vibecalc.core.report.rows import Cells, Found, Rows, part_of, rows_of, whole
from vibecalc.core.report.rows import short as in_short
from vibecalc.core.report.sections import (
    Section,
    by_size,
    having,
    labels,
    magnitudes,
    scalar_of,
    stacked,
    table_of,
)
from vibecalc.core.report.writing import (
    Column,
    hertz,
    number,
    paragraph,
    rpm,
    short,
    show,
    table,
    turns,
)
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.numerics.rounding import first_of_largest, ranked
from vibecalc.torsion.report.line import (
    cell,
    joined,
    mode_names,
    modes_named,
    names,
    order_text,
    strongest,
    titled,
    torque_unit,
    within,
)
from vibecalc.torsion.report.vibration import in_turns
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# A change in time of a shaft line: what happens, in a sentence.
# ----------------------------------------------------------------------------

TRANSIENT, FRICTION = "response/torsion/transient/", "response/torsion/friction_damper/"


def change_in_words(result: Result) -> str:
    """What happens, in a sentence."""
    change = table_of(result.case, "response", "torsion", "transient")
    kind, on = str(change.get("kind", "")), change.get("on")

    def size(key: str, of: Mapping[str, Any] = change) -> str:
        return short(float(of.get(key) or 0.0))

    def speed(key: str) -> str:
        return f"{turns(float(change.get(key) or 0.0))} rpm"

    sines = " and ".join(
        f"{size('amplitude', one)} N m at {short(hertz(float(one.get('frequency') or 0.0)))} Hz"
        for one in change.get("terms") or ()
    )
    over = f"from {speed('from')} to {speed('to')}"
    words = {
        "run_up": f"Run-up {over}",
        "run_down": f"Run-down {over}",
        "start": f"Start from rest to {speed('to')}",
        "stop": f"Stop without fuel from {speed('from')}",
        "load_step": f"Load step of {size('torque')} N m at {on}",
        "short_circuit": f"Short circuit at {on}: decaying air-gap torque, initially {sines}",
        "torque_history": f"Torque history at {on}{_history(change)}",
        "clutch_in": f"Clutch {change.get('clutch')} engages the part that turns at "
        f"{speed('driven_speed')}, friction torque {size('friction_torque')} N m"
        + f", reached in {size('engaging_time')} s"
        * bool(change.get("engaging_time")),
    }.get(kind, f"Cylinder {change.get('cylinder')} stops firing")
    if change.get("acceleration") is not None:
        words += f", acceleration up to {size('acceleration')} rad/s^2, with smooth start and end"
    elif change.get("duration") is not None:
        words += f" in {size('duration')} s"
    return words + "."


def _history(change: Mapping[str, Any]) -> str:
    time, torque = (table_of(change, "history").get(key) for key in ("time", "torque"))
    if not time or not torque:
        return ""
    return f" for {short(time[-1])} s, from {short(min(torque))} to {short(max(torque))} N m"


# ----------------------------------------------------------------------------
# Peaks of the sections, and the steady vibration.
# ----------------------------------------------------------------------------


def torsion_transient(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    words = (change_in_words(result), _supplied(record), _most_loaded(record), _clutch(record),
             _slipping_ring(record))  # fmt: skip
    lines = [line for one in words if one for line in paragraph(one)]
    blocks = lines, _sections(record), _counted(record)
    return titled(result, "Transient response", *blocks, root=TRANSIENT)


def _most_loaded(record: Record) -> str:
    """The peak of the worst section, and what it is next to the steady vibration."""
    worst = scalar_of(record, TRANSIENT + "worst_section")
    place = int(worst or 1) - 1
    entries = {
        name: float(found.values[place])
        for name in ("peak", "peak_speed", "overshoot", "lag", "dynamic_factor")
        if (found := having(record, TRANSIENT + name, "section")) is not None
    }
    if worst is None or not {"peak", "peak_speed"} <= entries.keys():
        return ""
    factor, unit = torque_unit(record)
    name = names(record, "transient/peak", "section")[place]
    words = f"Most loaded section: {name!r}, {show(factor * entries['peak'])} {unit}"
    stress = having(record, TRANSIENT + "peak_stress", "section")
    if stress is not None and name in (known := labels(stress.axes[0])):
        words += f" ({show(1e-6 * float(stress.values[known.index(name)]))} N/mm^2)"
    words += f" at {turns(entries['peak_speed'])} rpm"
    if np.isfinite(over := 100.0 * entries.get("overshoot", np.inf)):
        side = "above" if over > 0.0 else "below"
        words += f"; its half range is {show(abs(over), digits=3)} % {side} the steady maximum"
        if "lag" in entries:
            late, error = rpm(entries["lag"]), rpm(record[TRANSIENT + "lag"].error_estimate)
            when = "later" if late > 0.0 else "earlier"
            words += (
                f", reached {within(abs(late), error)} rpm {when}"
                if abs(late) > error
                else f", at the same speed within {show(error, digits=2)} rpm"
            )
    if "dynamic_factor" in entries:
        words += f", {show(entries['dynamic_factor'])} times "
        both = having(record, TRANSIENT + "steady_before", "section") is not None
        words += "the larger of the steady peaks before and" * both + "the steady one" * (not both)
        words += " after"
    if stress is not None:
        highest = first_of_largest(stress.values)
        if (other := labels(stress.axes[0])[highest]) != name:
            words += f". Highest stress: {other!r}, {show(1e-6 * float(stress.values[highest]))}"
            words += " N/mm^2"
    return words + "."


def _supplied(record: Record) -> str:
    """The torque that speeds the line up, and the station that has to supply it."""
    whole_, given, place = (
        scalar_of(record, f"{TRANSIENT}acceleration_{name}")
        for name in ("torque", "supplied", "supplied_at")
    )
    if whole_ is None:
        return ""
    unit = by_size(torque_unit(record)[1], [whole_])
    factor = convert(1.0, "N*m", unit)
    words = f"The speed change requires up to {show(factor * abs(whole_))} "
    words += f"{unit} at crank speed"
    known = names(record, "angle_half_range", "station")
    if given is not None:
        station = f"station {known[int(place) - 1]!r}" if known and place else "the load station"
        words += f", {show(factor * given)} {unit} of it from {station}"
    return words + ". The peaks include it; the table also lists them without it."


def _clutch(record: Record) -> str:
    """Slip, heat, common speed and what is left of its friction torque; "" without a clutch."""
    slip, heat, held, common, times, use = (
        scalar_of(record, f"{TRANSIENT}clutch/{name}")
        for name in ("slip_time", "heat", "held", "common_speed", "engagements", "utilisation")
    )
    if slip is None or heat is None:
        return ""
    words = f"The clutch slips for {show(slip)} s and dissipates {show(1e-3 * heat)} kJ"
    if held is None or common is None:
        return words + "; it does not lock within the simulated time."
    words += f". It locks {show(held)} s after engagement, at {show(rpm(common))} rpm of the "
    words += "crankshaft"
    if times is not None and times > 1.0:
        words += f"; the vibration makes it slip again {int(times) - 1} times"
    elif use is not None:
        words += f"; then it carries up to {show(100.0 * use, digits=3)} % of its friction torque"
    return words + "."


def _slipping_ring(record: Record) -> str:
    """Slip and heat of a ring on dry friction; "" without one."""
    slip, heat, locks = (
        scalar_of(record, f"{TRANSIENT}friction_damper/{name}")
        for name in ("slip_time", "heat", "locks")
    )
    if slip is None or heat is None or locks is None:
        return ""
    if slip == 0.0:
        return "The ring of the friction damper stays locked on its linings."
    words = f"The ring of the friction damper slips for {show(slip)} s in all, locks "
    return words + f"{int(locks)} times and dissipates {show(1e-3 * heat)} kJ."


def torsion_friction_damper(result: Result) -> Section | None:
    """One order with the ring that dry friction drags along; None without one."""
    record = result.record
    values = [
        scalar_of(record, FRICTION + name)
        for name in (
            *("angle", "locked_angle", "free_angle", "locked_utilisation", "heat"),
            *("best_friction_torque", "best_angle"),
        )
    ]
    known = [one for one in values if one is not None]
    if len(known) < len(values):
        return None
    angle, locked, free, use, heat, best, lowest = known
    given = table_of(result.case, "machine", "shaft_line").get("dampers") or ()
    (damper,) = [one for one in given if one.get("kind") == "friction"]
    slips = "slips" if use > 1.0 else "is locked on its linings"
    factor, unit = torque_unit(record)
    words = (
        f"Damper {damper['name']!r} with a friction torque of "
        f"{show(factor * float(damper['friction_torque']))} {unit}, order "
        f"{order_text(float(damper['order']))} at the operating speed, by the first harmonic of "
        f"the friction: the ring {slips}. Locked it would take {show(100.0 * use, digits=3)} % of "
        f"the friction torque. Its station moves by {show(np.degrees(angle))} deg, by "
        f"{show(np.degrees(locked))} deg with the ring locked and {show(np.degrees(free))} deg "
        f"without friction; the slip takes {show(heat)} W. The most work for its amplitude takes "
        f"a friction torque of {show(factor * best)} {unit}, which leaves "
        f"{show(np.degrees(lowest))} deg."
    )
    return titled(result, "Friction damper", paragraph(words), root=FRICTION)


def _sections(record: Record) -> list[str]:
    """A row for each section; a lag shows the digits that its error leaves."""
    unit = torque_unit(record)[1]
    passage = having(record, TRANSIENT + "steady_half_range", "section") is not None
    columns = [
        Cells("peak", f"peak\n{unit}", unit),
        Cells("peak_time", "at\ns"),
        Cells("peak_without_acceleration", f"without ac-\nceleration\n{unit}", unit),
        Cells("steady_before", f"steady before\n{unit}", unit),
        Cells("steady_after", f"steady after\n{unit}", unit),
        Cells("dynamic_factor", "factor"),
    ]
    words = "Peaks include the mean; times count from the start of the simulation, with time_before"
    if passage:
        columns += [
            Cells("peak_half_range", f"half range\n{unit}", unit),
            Cells("steady_half_range", f"steady\n{unit}", unit),
            Cells("overshoot", "vs. steady\n%", _over),
            Cells("lag", "delay\nrpm", _lag, right=True),
        ]
        words += (
            "; half range: of one cycle; steady: maximum at steady speeds; delay: of the maximum"
        )
    rows = Rows("section", "section", columns, TRANSIENT.rstrip("/"), note=words + ".", acting=True)
    return rows_of(record, rows)[0]


def _lag(lag: float, error: float) -> str:
    return within(rpm(lag), rpm(error))


def _over(share: float, _error: float) -> str:
    return f"{round(100.0 * share, 1) + 0.0:+.1f}" if np.isfinite(share) else show(share)


def _counted(record: Record) -> list[str]:
    """A row for each section whose cycles were counted; [] where none were."""
    unit, stem = torque_unit(record)[1], f"{TRANSIENT}counted"

    def number(record: Record) -> Quantity | None:
        found = having(record, f"{stem}/number", "section", "range_bin")
        return found and part_of(found, found.values.sum(axis=1), found.axes[0])

    columns = [
        Cells(number, "cycles"),
        Cells(f"{stem}/largest_range", f"largest range\n{unit}", unit),
        Cells(f"{stem}/equivalent_number", "equivalent\nnumber"),
        Cells(f"{stem}/largest_stress_range", "stress range\nN/mm^2", "N/mm^2"),
        Cells(f"{stem}/damage", "Miner,\none change"),
        Cells(f"{stem}/damage_of_all", "Miner,\nall changes"),
    ]
    words = (
        "Rainflow cycles; range: peak-to-peak; equivalent number: cycles of the largest range with "
        "the same damage. Miner sum without mean stress; ranges and means by bin: result file."
    )
    return rows_of(record, Rows("section", "section", columns, note=words))[0]


# ----------------------------------------------------------------------------
# Inertias that change over the turn.
# ----------------------------------------------------------------------------

_VARIABLE, _PUBLISHED = "response/torsion/variable_inertia/", "response/torsion/as_published/"
#: orders of secondary vibration, and of the modal method, that are shown
_MOST = 8


def torsion_variable(result: Result) -> Section | None:
    """The section of the variable inertia, None if the result has nothing of it."""
    record, title = result.record, "Variable inertia"
    blocks = _changes(record), _changed_sections(record), _unstable(record)
    details = {"secondary vibration": (_secondary, _wedges)}
    return titled(result, title, *blocks, details=details, root=_VARIABLE)


def _changes(record: Record) -> list[str]:
    variation, change = (
        having(record, f"{_VARIABLE}{name}", axis)
        for name, axis in (("relative_variation", "station"), ("change", "section"))
    )
    if variation is None or change is None:
        return []
    worst = first_of_largest(np.abs(change.values))
    words = (
        f"The inertias vary by up to {_percent(np.max(variation.values))} of their "
        f"mean. At the operating speed this changes the half range of the torque by "
        f"up to {_percent(change.values[worst])} (section {change.axes[0].values[worst]})"
    )
    over, where = (
        having(record, f"{_VARIABLE}largest_change{name}", "section") for name in ("", "_speed")
    )
    if over is not None and where is not None:
        most = first_of_largest(np.abs(over.values))
        words += (
            f", over the speed range by up to {_percent(over.values[most])} "
            f"(section {over.axes[0].values[most]}, {turns(where.values[most])} rpm)"
        )
    growth = record.quantities.get(_VARIABLE + "growth")
    if growth is not None:
        words += ". The motion at the operating speed is stable"
        if growth.values < 0.0:
            decay = show(-float(growth.values), digits=3)
            words += f": disturbances decay at {decay} 1/s or faster"
    return paragraph(words + ".")


def _percent(share: float) -> str:
    return f"{show(100.0 * abs(float(share)), digits=3)} %"


def _changed_sections(record: Record) -> list[str]:
    unit = torque_unit(record)[1]
    columns = (
        Cells("constant_half_range", f"half range\nmean inertia\n{unit}", unit),
        Cells("torque_half_range", f"variable\ninertia\n{unit}", unit),
        Cells("change", "change\n%", "%"),
        Cells("largest_change", "largest over\nspeeds, %", "%"),
        Cells("largest_change_speed", "at\nrpm", "rpm"),
    )
    rows = Rows("section", "section", columns, _VARIABLE.rstrip("/"), merge=True)
    return rows_of(record, rows)[0]


def _secondary(result: Result) -> list[str]:
    """The orders to which the variation adds most, and where that comes from."""
    columns = (
        Cells("twist", "added twist\nmrad", "mrad"),
        Cells("source", "mainly from\norder", in_short),
        Cells("share", "share\n%", partial(_uncertain, factor=100.0), right=True),
    )
    words = (
        "Secondary vibration: orders coupled by the variable inertias, in the section with the "
        "largest change."
    )
    rows = Rows("order", "order", columns, f"{_VARIABLE}secondary", "{:.4g}", right=True,
                places=strongest(_MOST), above=words)  # fmt: skip
    return rows_of(result.record, rows)[0]


def _wedges(result: Result) -> list[str]:
    """What is not known better than its error is shown as below that error."""
    stem = f"{_VARIABLE}wedge"
    columns = (
        Cells(f"{stem}/order", "order", whole),
        Cells(modes_named(result, f"{stem}/first_mode"), "mode"),
        Cells(modes_named(result, f"{stem}/second_mode"), "and mode"),
        Cells(f"{stem}/speed", "speed\nrpm", partial(_uncertain, factor=rpm(1.0))),
        Cells(f"{stem}/half_width", "half width\nrpm", partial(_uncertain, factor=rpm(1.0))),
        Cells(f"{stem}/damping_ratio", "damping ratio\nfor stability", _uncertain),
    )
    words = (
        "Parametric instability without damping, widest ranges first (first order in the inertia "
        "variation, with its error; below: less than the error), and the damping ratio that "
        "prevents it."
    )
    return rows_of(result.record, Rows("wedge", "", columns, above=words))[0]


def _uncertain(value: float, error: float, factor: float = 1.0) -> str:
    value, error = factor * value, factor * error
    return within(value, error) if abs(value) > error else f"below {show(error, digits=2)}"


def _unstable(record: Record) -> list[str]:
    low = record.quantities.get(_VARIABLE + "unstable/from")
    if low is not None and not np.size(low.values):
        return paragraph("With its damping the line is stable over the whole speed range.")
    columns = (
        Cells("from", "from, rpm", "rpm"),
        Cells("to", "to, rpm", "rpm"),
        Cells("growth", "growth, 1/s", "1/s"),
    )
    rows = Rows("unstable", "unstable range", columns, f"{_VARIABLE}unstable", merge=True)
    return rows_of(record, rows)[0]


# ----------------------------------------------------------------------------
# The modal method as it was published.
# ----------------------------------------------------------------------------

_MAGNIFIERS = {
    "damped": "damping ratio of the case for every mode",
    "empirical": "no damping, empirical magnifier 3.8 / Q^(1/4) at resonance",
    "undamped": "no damping",
}


def torsion_published(result: Result) -> Section | None:
    """The section of the modal method, None if the result has nothing of it."""
    record = result.record
    options = table_of(result.case, "response", "torsion", "as_published")
    kind = _MAGNIFIERS[str(options.get("magnifier", "damped"))]
    words = (
        "One mode at a time, angle 1 at the first station, torque of the operating speed at all "
        f"speeds, {kind}. Modal twists at crank angle zero: neither peaks nor twists of a "
        "shaft, not for design; for the loads on the shafts see above."
    )
    scaled, rayleigh = _published_modes(result), list[str]()
    inertia, stiffness = (
        scalar_of(record, f"{_PUBLISHED}rayleigh_{name}") for name in ("inertia", "stiffness")
    )
    if inertia is not None and stiffness is not None:
        rayleigh = paragraph(
            f"Rayleigh damping for this ratio in the two lowest elastic modes: alpha = "
            f"{show(inertia)} 1/s (inertia), beta = {show(stiffness)} s (stiffness)."
        )
    details = {"intensities of the modal method": [_intensities]}
    title, lines = "Modal method as published", stacked(paragraph(words), scaled) + rayleigh
    return titled(result, title, lines, details=details, root=_PUBLISHED)


def _published_modes(result: Result) -> list[str]:
    columns = (
        Cells(modes_named(result, f"{_PUBLISHED}natural_frequency"), "mode"),
        Cells(f"{_PUBLISHED}natural_frequency", "natural\nfrequency\n{unit}", "Hz"),
        Cells(f"{_PUBLISHED}rayleigh_damping_ratio", "damping ratio\nby Rayleigh"),
        Cells(f"{_PUBLISHED}largest_intensity_order", "order of the\nlargest\nintensity", in_short),
        Cells(f"{_PUBLISHED}largest_twist", "largest twist\nat resonance\n{unit}", "mrad"),
        Cells(f"{_PUBLISHED}largest_twist_order", "order", in_short),
    )
    return rows_of(result.record, Rows("elastic_mode", "", columns))[0]


def _intensities(result: Result) -> list[str]:
    """The strongest orders of the first modes."""
    known = mode_names(result)

    def made(record: Record) -> Quantity | None:
        found = having(record, _PUBLISHED + "intensity", "elastic_mode", "order")
        if found is None:
            return None
        modes = [known[int(mode) - 1] for mode in found.axes[0].values[:5]]
        axis = replace(found.axes[0], values=np.array(modes))
        return part_of(found, magnitudes(found)[:5].T, found.axes[1], axis)

    def places(found: Found) -> np.ndarray:
        return np.sort(ranked(found[0].values.max(axis=1))[: 2 * _MOST])

    cells = Cells(made, "intensity\n{}, N m")
    rows = Rows("order", "order", [cells], label="{:.4g}", places=places)
    return rows_of(result.record, rows)[0]


DESIGN = "damper_design/"
#: objective -> unit that people read
OBJECTIVES = {"torque": "N*m", "twist": "mrad", "stress": "N/mm^2"}
#: what a damper without springs has not
_OF_SPRINGS = ("stiffness", "natural_frequency", "damping_ratio")
_KINDS = {0: "section", 1: "heat", 2: "travel"}
_CERTIFIED = (
    "Local optimum: the weighted gradients of these peaks cancel (residual {}), so no small change "
    "lowers all of them. Global optimum: by a map of the whole range only."
)


def damper_design(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    blocks = _compared(result), _sensitivity(result.record), _rings(result)
    details = {"check of the optimum": (_proof, _basins)}
    return titled(result, "Design of the damper", *blocks, details=details, root=DESIGN)


def objective_of(result: Result) -> str:
    """What was made small: torque, twist or stress."""
    return str(table_of(result.case, "damper_design").get("objective", "torque"))


def _unit(record: Record, name: str) -> str:
    """As in `OBJECTIVES`, torques in the unit of the report."""
    return torque_unit(record)[1] if name == "torque" else OBJECTIVES[name]


def _section_name(record: Record, number_: float) -> str:
    """Name of a section by its number from 1; the number where no name is known."""
    known = names(record, "torque_half_range", "section")
    known = known or names(record, "speeds/torque_half_range", "section")
    place = int(number_)
    return known[place - 1] if 0 < place <= len(known) else f"number {place}"


def _compared(result: Result) -> list[str]:
    """The optimal damper and the one to compare it with."""
    record, name = result.record, objective_of(result)
    given = table_of(result.case, "damper_design", "compare")
    stiff = scalar_of(record, f"{DESIGN}table/stiffness") or given.get("stiffness")
    rows = []
    for title, key, unit in (
        ("ring inertia", "inertia", "kg*m^2"),
        ("stiffness", "stiffness", "kN*m/rad"),
        ("damping", "damping", "N*m*s/rad"),
        ("ring natural frequency, station fixed", "natural_frequency", "Hz"),
        ("ring damping ratio, station fixed", "damping_ratio", ""),
        (f"largest {name}, half range", f"worst_{name}", _unit(record, name)),
        ("  at", "worst_speed", "rpm"),
        ("  ratio to the optimum", "gain", ""),
        ("mean heat in the damper", "heat", "W"),
        ("  at", "heat_speed", "rpm"),
        ("ring travel, peak", "travel", "mrad"),
        ("  at", "travel_speed", "rpm"),
    ):
        quantity = record.quantities.get(DESIGN + key)
        known = quantity or record.quantities.get(f"{DESIGN}table/{key}")
        if known is None:
            continue
        scale = convert(1.0, known.unit, unit) if unit else 1.0
        other = scalar_of(record, f"{DESIGN}table/{key}")
        other = given.get(key) if other is None else other
        if key in _OF_SPRINGS and not (scalar_of(record, f"{DESIGN}stiffness") or stiff):
            continue
        compared = "" if other is None else show(scale * other)
        rows.append([title, cell(quantity, (), scale), compared, unit])
    columns = (Column("quantity"), number("optimum"), number("compared"), Column("unit"))
    held, speed = _held(record), having(record, DESIGN + "active/speed", "active")
    if held is not None and speed is not None:
        both = zip(held.values, speed.values, strict=True)
        peaks = dict.fromkeys(f"{of} at {turns(w)} rpm" for of, w in both)
        words = f"Decisive at the optimum: {joined(peaks)}."
    else:
        place = scalar_of(record, DESIGN + "worst_section")
        section = "-" if place is None else _section_name(record, place)
        words = f"The largest half range is in section {section}."
    pull = having(record, DESIGN + "bound_sensitivity", "design_value")
    if pull is not None and np.any(pull.values):
        bounds = ", ".join(str(name) for name in pull.axes[0].values[pull.values != 0.0])
        words += f" At the end of its allowed range: {bounds}."
    return [*table(columns, rows), *paragraph(words)]


def _held(record: Record) -> Quantity | None:
    """What holds the optimum: a section, heat or travel."""
    kind, section = (having(record, f"{DESIGN}active/{n}", "active") for n in ("kind", "section"))
    if kind is None or section is None:
        return None
    words = [
        _KINDS[int(code)] + (f" {_section_name(record, place)}" if code == 0 else "")
        for code, place in zip(kind.values, section.values, strict=True)
    ]
    return part_of(kind, np.array(words), *kind.axes)


_ACTIVE = Rows("active", "", (
    Cells(_held, "decisive"),
    Cells("speed", "at, rpm", in_turns),
    Cells("level", "level"),
    Cells("weight", "weight"),
), f"{DESIGN}active")  # fmt: skip


def _proof(result: Result) -> list[str]:
    """What carries the optimum, and that no small change lowers it."""
    lines, _ = rows_of(result.record, _ACTIVE)
    left = scalar_of(result.record, DESIGN + "certificate")
    if lines and left is not None:
        lines += paragraph(_CERTIFIED.format(show(left, digits=2)))
    return lines


def _sensitivity(record: Record) -> list[str]:
    above = "Increase of the largest half range with other stiffness and damping:"
    cells = Cells(_increases, "damping\ntimes {}", right=True)
    rows = Rows("stiffness_factor", "stiffness times", [cells], label="{:g}", above=above)
    return rows_of(record, rows)[0]


def _increases(record: Record) -> Quantity | None:
    """In percent, below the factors on the damping in words."""
    found = having(record, f"{DESIGN}sensitivity", "stiffness_factor", "damping_factor")
    if found is None:
        return None
    share = found.values - 1.0
    words = [[f"{100.0 * one:+.2f} %" if abs(one) > 5e-5 else "0" for one in row] for row in share]
    times = replace(found.axes[1], values=np.array([f"{one:g}" for one in found.axes[1].values]))
    return part_of(found, np.array(words), found.axes[0], times)


def _rings(result: Result) -> list[str]:
    name = objective_of(result)
    unit = _unit(result.record, name)
    columns = (
        Cells(name, f"largest half\nrange, {unit}", unit),
        Cells("stiffness", "stiffness\nkN*m/rad", "kN*m/rad"),
        Cells("damping", "damping\nN*m*s/rad", "N*m*s/rad"),
    )
    rows = Rows("ring_inertia", "ring, kg m^2", columns, f"{DESIGN}ring", merge=True)
    return rows_of(result.record, rows)[0]


def _basins(result: Result) -> list[str]:
    worst = having(result.record, DESIGN + "basin/worst", "basin")
    if worst is None or len(worst.values) < 2:
        return []
    apart = show(100.0 * (float(np.max(worst.values)) - 1.0), digits=2)
    words = f"{len(worst.values)} local searches from minima of the map ended within {apart} % of "
    return paragraph(words + "the best.")

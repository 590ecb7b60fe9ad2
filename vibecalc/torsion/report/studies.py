"""Studies of a shaft line: change in time, variable inertia, the modal method."""

from collections.abc import Callable
from functools import partial

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, by_axis, rows_of, whole
from vibecalc.core.report.rows import short as in_short
from vibecalc.core.report.sections import Section, having, labels, scalar_of, table_of
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    Detail,
    mode_names,
    modes_named,
    order_text,
    rows_by,
    short,
    torque_unit,
    within,
)
from vibecalc.torsion.report.transient import clutch_in_words, counted_table, jolt_in_words

# ----------------------------------------------------------------------------
# A change in time of a shaft line: peaks of the sections, and the steady vibration.
# ----------------------------------------------------------------------------

TRANSIENT = "response/torsion/transient/"


def torsion_transient(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(TRANSIENT))
    if not shown:
        return None
    lines = paragraph(change_in_words(result))
    for words in (_supplied(result), _verdict(record), clutch_in_words(record)):
        lines += paragraph(words) if words else []
    return Section("Change in time", [*lines, "", *_table(record), *counted_table(record)], shown)


def change_in_words(result: Result) -> str:
    """What happens, in a sentence."""
    change = table_of(result.case, "response", "torsion", "transient")
    kind = str(change.get("kind", ""))

    def turns(key: str) -> str:
        return f"{short(rpm(float(change.get(key) or 0.0)))} rpm"

    if kind in ("run_up", "run_down"):
        words = f"{kind.replace('_', '-').capitalize()} from {turns('from')} to {turns('to')}"
    elif kind == "start":
        words = f"Start from rest to {turns('to')}"
    elif jolt := jolt_in_words(change):
        words = jolt
    elif kind == "load_step":
        words = (
            f"Step of the load by {short(float(change.get('torque') or 0.0))} N m at "
            f"{change.get('on')}"
        )
    else:
        words = f"Cylinder {change.get('cylinder')} stops firing"
    acceleration, duration = change.get("acceleration"), change.get("duration")
    if acceleration is not None:
        words += (
            f" with up to {short(float(acceleration))} rad/s^2, growing from zero and fading to "
            "zero"
        )
    elif duration is not None:
        words += f" in {short(float(duration))} s"
    return words + "."


def _verdict(record: Record) -> str:
    peak = having(record, TRANSIENT + "peak", "section")
    speed = having(record, TRANSIENT + "peak_speed", "section")
    worst = scalar_of(record, TRANSIENT + "worst_section")
    if peak is None or speed is None or worst is None:
        return ""
    place = int(worst) - 1
    name = str(peak.axes[0].values[place])
    factor, unit = torque_unit(record)
    words = f"Most loaded is section {name!r}: {show(factor * peak.values[place], digits=4)} {unit}"
    stress = having(record, TRANSIENT + "peak_stress", "section")
    if stress is not None and name in (known := labels(stress.axes[0])):
        words += f" ({show(1e-6 * float(stress.values[known.index(name)]), digits=4)} N/mm2)"
    words += f" at {short(rpm(float(speed.values[place])))} rpm"
    over = having(record, TRANSIENT + "overshoot", "section")
    if over is not None and np.isfinite(over.values[place]):
        share = 100.0 * float(over.values[place])
        side = "above" if share > 0.0 else "below"
        words += f"; its half range is {show(abs(share), digits=3)} % {side} the steady one"
        lag = having(record, TRANSIENT + "lag", "section")
        if lag is not None:
            late = float(lag.values[place])
            if abs(late) > lag.error_estimate:
                when = "later" if late > 0.0 else "earlier"
                words += f" and comes {within(rpm(abs(late)), rpm(lag.error_estimate))} rpm {when}"
            else:
                words += f", at the same speed within {show(rpm(lag.error_estimate), digits=2)} rpm"
    dynamic = having(record, TRANSIENT + "dynamic_factor", "section")
    if dynamic is not None:
        words += f", {show(float(dynamic.values[place]), digits=4)} times "
        both = having(record, TRANSIENT + "steady_before", "section") is not None
        words += (
            "the larger of the steady peaks before and after" if both else "the steady one after"
        )
    return words + "."


def _supplied(result: Result) -> str:
    """The torque that speeds the line up, and the station that has to supply it."""
    record = result.record
    whole = scalar_of(record, TRANSIENT + "acceleration_torque")
    given = scalar_of(record, TRANSIENT + "acceleration_supplied")
    if whole is None:
        return ""
    factor, unit = torque_unit(record)
    words = f"To change the speed of the line takes up to {show(factor * abs(whole), digits=4)} "
    words += f"{unit} at crank speed"
    station = _station(record, scalar_of(record, TRANSIENT + "acceleration_supplied_at"))
    if given is not None:
        words += f", {show(factor * given, digits=4)} {unit} of it from "
        words += f"station {station!r}" if station else "where the load acts"
    return words + ". It is part of the peaks; the table has them without it, too."


def _station(record: Record, place: float | None) -> str:
    known = having(record, "response/torsion/angle_half_range", "station")
    found = [] if known is None else labels(known.axes[0])
    return found[int(place) - 1] if place and 0 < place <= len(found) else ""


def _table(record: Record) -> list[str]:
    """A row for each section; a lag shows the digits that its error leaves."""
    torque, unit = torque_unit(record)
    columns: list[tuple[str, float, str]] = [
        ("peak", torque, f"peak\n{unit}"), ("peak_time", 1.0, "at\ns"),
        ("peak_without_acceleration", torque, f"without ac-\nceleration\n{unit}"),
        ("steady_before", torque, f"steady before\n{unit}"),
        ("steady_after", torque, f"steady after\n{unit}"),
        ("dynamic_factor", 1.0, "factor"),
    ]  # fmt: skip
    over, lag = (having(record, TRANSIENT + name, "section") for name in ("overshoot", "lag"))
    more: list[tuple[Column, Callable[[int], str]]] = []
    if having(record, TRANSIENT + "steady_half_range", "section") is not None:
        columns += [("peak_half_range", torque, f"half range\n{unit}"),
                    ("steady_half_range", torque, f"steady\n{unit}")]  # fmt: skip
        if over is not None:
            more.append((number("to steady\n%"), lambda i: _over(float(over.values[i]))))
        if lag is not None:
            more.append((number("later by\nrpm"), lambda i: _lag(lag, i)))
    paths = [(f"transient/{path}", by, title) for path, by, title in columns]
    lines = rows_by(record, "section", paths, more)
    words = "Peaks have the mean in them"
    words += "; half range: of one cycle, steady: largest at these speeds." if more else "."
    return [*lines, *paragraph(words)] if lines else []


def _over(share: float) -> str:
    return f"{round(100.0 * share, 1) + 0.0:+.1f}" if np.isfinite(share) else show(share)


def _lag(lag: Quantity, place: int) -> str:
    return within(rpm(float(lag.values[place])), rpm(lag.error_estimate))


# ----------------------------------------------------------------------------
# Inertias that change over the turn; the modal method as it was published.
# ----------------------------------------------------------------------------

_VARIABLE, _PUBLISHED = "response/torsion/variable_inertia/", "response/torsion/as_published/"
#: orders of secondary vibration, and of the modal method, that are shown
_MOST = 8


def torsion_variable(result: Result) -> Section | None:
    """The section of the variable inertia, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_VARIABLE))
    if not shown:
        return None
    lines = _variable_verdict(record)
    for block in (_variable_sections(record), _unstable(record)):
        lines += ["", *block] if block else []
    return Section(
        "Inertia that changes over the revolution",
        lines,
        shown,
        "secondary vibration",
        Detail(result, lambda one: _secondary(one.record), _wedges),
    )


def _variable_verdict(record: Record) -> list[str]:
    variation = having(record, _VARIABLE + "relative_variation", "station")
    change = having(record, _VARIABLE + "change", "section")
    if variation is None or change is None:
        return []
    size = np.abs(change.values)
    worst = int(np.argmax(size))
    words = (
        f"The inertias vary by up to {_percent(float(np.max(variation.values)))} of their "
        f"mean over the turn. At the operating speed this changes the half range of the torque by "
        f"up to {_percent(float(size[worst]))} (section {change.axes[0].values[worst]})"
    )
    over = having(record, _VARIABLE + "largest_change", "section")
    where = having(record, _VARIABLE + "largest_change_speed", "section")
    if over is not None and where is not None:
        most = int(np.argmax(np.abs(over.values)))
        words += (
            f", over the range of speeds by up to {_percent(abs(float(over.values[most])))} "
            f"(section {over.axes[0].values[most]}, "
            f"{short(rpm(float(where.values[most])))} rpm)"
        )
    growth = scalar_of(record, _VARIABLE + "growth")
    if growth is not None:
        words += ". The motion at the operating speed is stable"
        value = float(record[_VARIABLE + "growth"].values)
        if value < 0.0:
            words += f": disturbances decay by {show(-value, digits=3)} 1/s or faster"
    return paragraph(words + ".")


def _percent(share: float) -> str:
    return f"{show(100.0 * share, digits=3)} %"


def _variable_sections(record: Record) -> list[str]:
    unit = torque_unit(record)[1].replace(" ", "*")
    return by_axis(
        record, "section", "section",
        [(_VARIABLE + name, *words) for name, *words in (
            ("constant_half_range", "half range\nmean inertia\n", unit),
            ("torque_half_range", "variable\ninertia\n", unit), ("change", "change\n", "%"),
            ("largest_change", "largest over\nspeeds,", "%"),
            ("largest_change_speed", "at\n", "rpm"),
        )],
        digits=4,
    )  # fmt: skip


def _secondary(record: Record) -> list[str]:
    """The orders to which the variation adds most, and where that comes from."""
    twist = having(record, _VARIABLE + "secondary/twist", "half_order")
    source = having(record, _VARIABLE + "secondary/source", "half_order")
    share = having(record, _VARIABLE + "secondary/share", "half_order")
    if twist is None or source is None or share is None:
        return []
    size = np.abs(twist.values)
    chosen = np.sort(np.argsort(-size, kind="stable")[:_MOST])
    columns = (number("order"), number("added twist\nmrad"), number("most from\norder"),
               number("share\n%"))  # fmt: skip
    rows = [
        [order_text(twist.axes[0].values[i]), show(1e3 * size[i], 1e3 * twist.error_estimate, 4),
         order_text(source.values[i]),
         _uncertain(float(share.values[i]), share.error_estimate, 100.0)]
        for i in chosen
    ]  # fmt: skip
    words = (
        "Secondary vibration: what orders feed into each other through the inertias, in the "
        "section that changes most."
    )
    return [*paragraph(words), *table(columns, rows)]


def _wedges(result: Result) -> list[str]:
    """What is not known better than its error is shown as below that error."""
    record = result.record
    stem = f"{_VARIABLE}wedge"
    columns = (
        Cells(f"{stem}/order", "order", whole),
        Cells(modes_named(result, f"{stem}/first_mode"), "mode"),
        Cells(modes_named(result, f"{stem}/second_mode"), "and mode"),
        Cells(f"{stem}/speed", "speed\nrpm", partial(_uncertain, factor=rpm(1.0))),
        Cells(f"{stem}/half_width", "half width\nrpm", partial(_uncertain, factor=rpm(1.0))),
        Cells(f"{stem}/damping_ratio", "prevented by\nratio", _uncertain),
    )
    lines, _ = rows_of(record, Rows("wedge", "", columns))
    if not lines:
        return []
    words = (
        "Speeds near which vibration would grow without damping (to first order of the variation, "
        "with the error of that; below: less than the error), and the damping ratio that prevents "
        "it; the widest first."
    )
    return [*paragraph(words), *lines]


def _uncertain(value: float, error: float, factor: float = 1.0) -> str:
    value, error = factor * value, factor * error
    return within(value, error) if abs(value) > error else f"below {show(error, digits=2)}"


def _unstable(record: Record) -> list[str]:
    low = record.quantities.get(_VARIABLE + "unstable/from")
    if low is None:
        return []
    if not np.size(low.values):
        return paragraph("With the damping of the line, vibration grows at no speed of the range.")
    return by_axis(
        record, "unstable", "unstable range",
        [(f"{_VARIABLE}unstable/{name}", words, unit) for name, words, unit in (
            ("from", "from,", "rpm"), ("to", "to,", "rpm"), ("growth", "growth,", "1/s"))],
        digits=4,
    )  # fmt: skip


def torsion_published(result: Result) -> Section | None:
    """The section of the modal method, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_PUBLISHED))
    if not shown:
        return None
    options = table_of(result.case, "response", "torsion", "as_published")
    kinds = {
        "damped": "the damping ratio of the case for every mode",
        "empirical": "no damping, and the empirical magnifier 3.8 / Q^(1/4) on a critical",
        "undamped": "no damping",
    }
    kind = kinds.get(str(options.get("magnifier", "damped")), "")
    words = (
        "One mode at a time, angle 1 at the first station, torque of the operating speed at all "
        f"speeds, {kind}. Twists at crank angle zero, not peaks: of no shaft, and no basis of a "
        "design; what the shafts bear stands above."
    )
    lines = [*paragraph(words), "", *_published_modes(result)]
    alpha = [scalar_of(record, f"{_PUBLISHED}rayleigh_{name}") for name in ("inertia", "stiffness")]
    if alpha[0] is not None and alpha[1] is not None:
        lines += paragraph(
            f"Rayleigh damping through this ratio at the two lowest elastic modes: "
            f"{show(alpha[0], digits=4)} 1/s of the inertia and {show(alpha[1], digits=4)} s of "
            "the stiffness."
        )
    return Section(
        "Modal method as published",
        lines,
        shown,
        "intensities of the modal method",
        Detail(result, _intensities),
    )


def _published_modes(result: Result) -> list[str]:
    columns = (
        Cells(modes_named(result, f"{_PUBLISHED}natural_frequency"), "mode"),
        Cells(f"{_PUBLISHED}natural_frequency", "natural\nfrequency\n{unit}", "Hz"),
        Cells(f"{_PUBLISHED}rayleigh_damping_ratio", "damping ratio\nby Rayleigh"),
        Cells(f"{_PUBLISHED}largest_intensity_order", "order of the\nlargest\nintensity", in_short),
        Cells(f"{_PUBLISHED}largest_twist", "largest twist\non a critical\n{unit}", "mrad"),
        Cells(f"{_PUBLISHED}largest_twist_order", "of order", in_short),
    )
    return rows_of(result.record, Rows("elastic_mode", "", columns, digits=4))[0]


def _intensities(result: Result) -> list[str]:
    """The strongest orders of the first modes."""
    intensity = having(result.record, _PUBLISHED + "intensity", "elastic_mode", "half_order")
    if intensity is None:
        return []
    known = mode_names(result)
    modes = [known[int(mode) - 1] for mode in intensity.axes[0].values][:5]
    size = np.abs(intensity.values)[: len(modes)]
    chosen = np.sort(np.argsort(-size.max(axis=0), kind="stable")[: 2 * _MOST])
    columns = (Column("order"), *(number(f"intensity\n{m}, N m") for m in modes))
    rows = [
        [order_text(intensity.axes[1].values[j]), *(show(float(row[j]), digits=4) for row in size)]
        for j in chosen
    ]
    return table(columns, rows)

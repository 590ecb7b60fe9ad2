"""Studies beside the steady vibration: change in time, variable inertia, the modal route."""

import numpy as np

from vibecalc.core.report.sections import Section, by_axis, having, labels, scalar_of, table_of
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import order_text, within

# ----------------------------------------------------------------------------
# A change in time of a shaft line: peaks of the sections beside the steady vibration.
# ----------------------------------------------------------------------------

TRANSIENT = "response/torsion/transient/"


def torsion_transient(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(TRANSIENT))
    if not shown:
        return None
    lines = paragraph(change_in_words(result))
    lines += paragraph(
        "Crank speed as prescribed; torques with the mean, on the section's own shaft. A half "
        "range is that of one cycle, the steady one the largest between the same speeds."
    )
    supplied = _supplied(result)
    if supplied:
        lines += paragraph(supplied)
    verdict = _verdict(record)
    if verdict:
        lines += paragraph(verdict)
    lines += ["", *_table(record)]
    return Section("Change in time", lines, shown)


def change_in_words(result: Result) -> str:
    """What happens, in a sentence."""
    change = table_of(result.case, "response", "torsion", "transient")
    kind = str(change.get("kind", ""))

    def turns(key: str) -> str:
        return f"{show(rpm(float(change.get(key) or 0.0)), digits=5)} rpm"

    if kind in ("run_up", "run_down"):
        words = f"{kind.replace('_', '-').capitalize()} from {turns('from')} to {turns('to')}"
    elif kind == "start":
        words = f"Start from rest to {turns('to')}"
    elif kind == "load_step":
        words = (
            f"Step of the load by {show(float(change.get('torque') or 0.0))} N*m at "
            f"{change.get('on')}"
        )
    else:
        words = f"Cylinder {change.get('cylinder')} stops firing"
    acceleration, duration = change.get("acceleration"), change.get("duration")
    if acceleration is not None:
        words += (
            f" with up to {show(float(acceleration), digits=4)} rad/s^2, growing from zero "
            "at the beginning and fading to zero at the end"
        )
    elif duration is not None:
        words += f" in {show(float(duration), digits=4)} s"
    return words + "."


def _verdict(record: Record) -> str:
    peak = having(record, TRANSIENT + "peak", "section")
    speed = having(record, TRANSIENT + "peak_speed", "section")
    worst = scalar_of(record, TRANSIENT + "worst_section")
    if peak is None or speed is None or worst is None:
        return ""
    place = int(worst) - 1
    name = peak.axes[0].values[place]
    words = (
        f"Most loaded is section {name}: {show(float(peak.values[place]), digits=5)} N*m at "
        f"{show(rpm(float(speed.values[place])), digits=5)} rpm"
    )
    over = having(record, TRANSIENT + "overshoot", "section")
    if over is not None and np.isfinite(over.values[place]):
        share = 100.0 * float(over.values[place])
        side = "above" if share > 0.0 else "below"
        words += f"; its half range stays {show(abs(share), digits=3)} % {side} the steady one"
        if share > 0.0:
            words = words.replace("stays", "goes")
        lag = having(record, TRANSIENT + "lag", "section")
        if lag is not None:
            late = float(lag.values[place])
            if abs(late) > lag.error_estimate:
                when = "later" if late > 0.0 else "earlier"
                words += f" and comes {within(rpm(abs(late)), rpm(lag.error_estimate))} rpm {when}"
            else:
                words += f", at the same speed within {show(rpm(lag.error_estimate), digits=2)} rpm"
    factor = having(record, TRANSIENT + "dynamic_factor", "section")
    if factor is not None:
        words += (
            f", {show(float(factor.values[place]), digits=4)} times the larger of the steady peaks "
            "before and after"
        )
    return words + "."


def _supplied(result: Result) -> str:
    """The torque that speeds the line up, and where the case has to find it."""
    record = result.record
    whole = scalar_of(record, TRANSIENT + "acceleration_torque")
    given = scalar_of(record, TRANSIENT + "acceleration_supplied")
    if whole is None:
        return ""
    words = f"To change the speed of the line takes up to {show(abs(whole), digits=4)} N*m"
    words += " at the crankshaft's speed"
    mean = scalar_of(record, "response/torsion/excitation/mean_torque")
    if mean is not None:
        words += f"; the cylinders give {show(mean, digits=4)} N*m in the mean at operating speed"
    words += ". The speed is prescribed, so what the cylinders do not give is supplied"
    place = scalar_of(record, TRANSIENT + "acceleration_supplied_at")
    station = _station(record, place)
    words += f" at station {station!r}" if station else " where the load acts"
    if given is not None:
        words += f": {show(given, digits=4)} N*m on its own shaft, positive on the line"
    return words + ". This torque is in the peaks; the table has them without it too."


def _station(record: Record, place: float | None) -> str:
    known = having(record, "response/torsion/angle_half_range", "station")
    found = [] if known is None else labels(known.axes[0])
    return found[int(place) - 1] if place and 0 < place <= len(found) else ""


def _table(record: Record) -> list[str]:
    """A row for each section; a lag shows the digits that its error leaves."""
    quantities = {
        name: quantity
        for name in ("peak", "peak_time", "steady_before", "steady_after", "dynamic_factor",
                     "peak_without_acceleration", "peak_half_range", "steady_half_range",
                     "overshoot", "lag")
        if (quantity := having(record, TRANSIENT + name, "section")) is not None
    }  # fmt: skip
    first = quantities.get("peak")
    if first is None:
        return []
    ways: dict[str, tuple[str, float, int]] = {
        "peak": ("peak\nN*m", 1.0, 11), "peak_time": ("at\ns", 1.0, 8),
        "peak_without_acceleration": ("without\nits torque\nN*m", 1.0, 11),
        "steady_before": ("steady before\nN*m", 1.0, 14),
        "steady_after": ("steady after\nN*m", 1.0, 14), "dynamic_factor": ("factor", 1.0, 10),
        "peak_half_range": ("half range\nN*m", 1.0, 11),
        "steady_half_range": ("steady\nN*m", 1.0, 11),
        "overshoot": ("more than\nsteady, %", 100.0, 9), "lag": ("later by\nrpm", rpm(1.0), 13),
    }  # fmt: skip
    shown = [name for name in ways if name in quantities]
    if "steady_before" in quantities:
        shown = [name for name in shown if name not in ("peak_half_range", "steady_half_range",
                                                        "overshoot", "lag")]  # fmt: skip
    columns = [Column("section", 17)]
    columns += [number(ways[name][0], ways[name][2]) for name in shown]
    rows = []
    for i, label in enumerate(labels(first.axes[0])):
        row = [label]
        for name in shown:
            quantity, factor = quantities[name], ways[name][1]
            value, error = factor * float(quantity.values[i]), factor * quantity.error_estimate
            row.append(within(value, error) if name == "lag" else show(value, error, 5))
        rows.append(row)
    return table(columns, rows)


# ----------------------------------------------------------------------------
# Beside the steady vibration of a line: inertias that change over the turn, the modal route.
# ----------------------------------------------------------------------------

_VARIABLE, _PUBLISHED = "response/torsion/variable_inertia/", "response/torsion/as_published/"
_MOST = 8


def torsion_variable(result: Result) -> Section | None:
    """The section of the variable inertia, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_VARIABLE))
    if not shown:
        return None
    lines = _variable_verdict(record)
    for block in (
        _variable_sections(record),
        _secondary(record),
        _wedges(record),
        _unstable(record),
    ):
        if block:
            lines += ["", *block]
    return Section("Inertia that changes over the revolution", lines, shown)


def _variable_verdict(record: Record) -> list[str]:
    variation = having(record, _VARIABLE + "relative_variation", "station")
    change = having(record, _VARIABLE + "change", "section")
    if variation is None or change is None:
        return []
    size = np.abs(change.values)
    worst = int(np.argmax(size))
    words = (
        f"The inertias vary by up to {show(float(np.max(variation.values)), digits=3)} of their "
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
            f"{show(rpm(float(where.values[most])), digits=5)} rpm)"
        )
    growth = scalar_of(record, _VARIABLE + "growth")
    if growth is not None:
        words += ". The motion at the operating speed is stable"
        value = float(record[_VARIABLE + "growth"].values)
        if value < 0.0:
            words += f": what disturbs it dies out with {show(-value, digits=3)} 1/s at least"
    words += (
        ". A line that is free to turn as a whole has its mean turn, weighted by the mean "
        "inertias, at zero: this sets the origin of time and belongs to these numbers"
    )
    return paragraph(words + ".")


def _percent(share: float) -> str:
    return f"{show(100.0 * share, digits=3)} %"


def _variable_sections(record: Record) -> list[str]:
    return by_axis(
        record, "section", "section",
        [(_VARIABLE + name, words) for name, words in (
            ("constant_half_range", "half range\nmean inertia\nN*m"),
            ("torque_half_range", "as they turn\nN*m"), ("change", "change\n%"),
            ("largest_change", "largest over\nspeeds, %"),
            ("largest_change_speed", "there\nrpm"),
        )],
        factors=[1.0, 1.0, 100.0, 100.0, rpm(1.0)], digits=5,
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
    columns = (number("order", 8), number("added twist\nurad", 13), number("most from\norder", 10),
               number("its share\n%", 10))  # fmt: skip
    rows = [
        [order_text(twist.axes[0].values[i]), show(1e6 * size[i], 1e6 * twist.error_estimate, 4),
         order_text(source.values[i]),
         within(100.0 * float(share.values[i]), 100.0 * share.error_estimate, 3)]
        for i in chosen
    ]  # fmt: skip
    words = (
        "Secondary vibration: what orders feed into each other through the inertias, in the "
        "section that changes most."
    )
    return [*paragraph(words), *table(columns, rows)]


def _wedges(record: Record) -> list[str]:
    """What is not known better than its error is shown as below that error."""
    speed, half, order, first, second, ratio = (
        having(record, f"{_VARIABLE}wedge/{name}", "wedge")
        for name in ("speed", "half_width", "order", "first_mode", "second_mode", "damping_ratio")
    )
    if not (speed and half and order and first and second and ratio):
        return []
    columns = (number("order", 8), number("mode", 6), number("and mode", 9),
               number("speed\nrpm", 16), number("half width\nrpm", 16),
               number("cured by\nratio", 18))  # fmt: skip
    rows = [
        [order_text(order.values[i]), f"{first.values[i]:g}", f"{second.values[i]:g}",
         _doubtful(speed, i, rpm(1.0)), _doubtful(half, i, rpm(1.0)), _doubtful(ratio, i)]
        for i in range(len(speed.values))
    ]  # fmt: skip
    words = (
        "Speeds near which vibration would grow without damping (to the first order of the "
        "variation, with the doubt of that; below: less than the doubt), and the damping ratio "
        "that keeps it from growing; the widest first."
    )
    return [*paragraph(words), *table(columns, rows)]


def _doubtful(quantity: Quantity, place: int, factor: float = 1.0) -> str:
    value, error = factor * float(quantity.values[place]), factor * quantity.error_estimate
    return within(value, error) if abs(value) > error else f"below {show(error, digits=2)}"


def _unstable(record: Record) -> list[str]:
    low = record.quantities.get(_VARIABLE + "unstable/from")
    if low is None:
        return []
    if not np.size(low.values):
        return paragraph("With the damping of the line none of them is left in the range.")
    return by_axis(
        record, "unstable", "unstable range",
        [(f"{_VARIABLE}unstable/{name}", words) for name, words in (
            ("from", "from, rpm"), ("to", "to, rpm"), ("growth", "growth, 1/s"))],
        factors=[rpm(1.0), rpm(1.0), 1.0],
    )  # fmt: skip


def torsion_published(result: Result) -> Section | None:
    """The section of the modal route, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_PUBLISHED))
    if not shown:
        return None
    options = table_of(result.case, "response", "torsion", "as_published")
    ways = {
        "damped": "the damping ratio of the case for every mode",
        "empirical": "no damping, and the empirical magnifier 3.8 / Q^(1/4) on a critical",
        "undamped": "no damping",
    }
    way = ways.get(str(options.get("magnifier", "damped")), "")
    words = (
        "One mode at a time, with the angle 1 at the first freedom and the torque of the operating "
        f"speed at all speeds; {way}. A modal twist follows the scale of its shape and is read at "
        "crank angle zero, not at its peak: it is the twist of no shaft, and no basis of a design. "
        "What the shafts bear stands in the sections before."
    )
    lines = paragraph(words)
    lines += ["", *_published_modes(record)]
    alpha = [scalar_of(record, f"{_PUBLISHED}rayleigh_{name}") for name in ("inertia", "stiffness")]
    if alpha[0] is not None and alpha[1] is not None:
        lines += paragraph(
            f"Rayleigh damping through this ratio at the two lowest elastic modes: "
            f"{show(alpha[0])} 1/s of the inertia and {show(alpha[1])} s of the stiffness."
        )
    intensity = having(record, _PUBLISHED + "intensity", "elastic_mode", "half_order")
    if intensity is not None:
        lines += ["", *_intensities(intensity.values, intensity.axes)]
    return Section("Modal route as published", lines, shown)


def _published_modes(record: Record) -> list[str]:
    natural = having(record, _PUBLISHED + "natural_frequency", "elastic_mode")
    if natural is None:
        return []
    ways = (
        ("natural_frequency", "natural\nfrequency\nrad/s", show),
        ("rayleigh_damping_ratio", "damping ratio\nby Rayleigh", show),
        ("largest_intensity_order", "order of the\nlargest\nintensity", order_text),
        ("largest_twist", "largest twist\non a critical\nrad", show),
        ("largest_twist_order", "its order", order_text),
    )
    found = [
        (quantity, title, way)
        for name, title, way in ways
        if (quantity := having(record, _PUBLISHED + name, "elastic_mode")) is not None
    ]
    columns = [Column("mode", 8), *(number(title, 15) for _, title, _ in found)]
    rows = [
        [label, *(way(float(quantity.values[i])) for quantity, _, way in found)]
        for i, label in enumerate(labels(natural.axes[0]))
    ]
    return table(columns, rows)


def _intensities(values: np.ndarray, axes: tuple) -> list[str]:  # type: ignore[type-arg]
    """The strongest orders of the first modes."""
    modes = [int(mode) for mode in axes[0].values][:5]
    size = np.abs(values)[: len(modes)]
    chosen = np.sort(np.argsort(-size.max(axis=0), kind="stable")[: 2 * _MOST])
    columns = (Column("order", 8), *(number(f"intensity\nmode {m}, N*m", 15) for m in modes))
    rows = [
        [order_text(axes[1].values[j]), *(show(float(row[j]), digits=5) for row in size)]
        for j in chosen
    ]
    return table(columns, rows)

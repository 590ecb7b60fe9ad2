"""Beside the steady vibration of a line: inertias that change over the turn, the modal route."""

import numpy as np

from vibecalc.report.lookup import having, labels, scalar_of, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.by_axis import by_axis
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.torsion_terms import order_text, within
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

_VARIABLE, _PUBLISHED = "response/torsion/variable_inertia/", "response/torsion/as_published/"
_MOST = 8


def torsion_variable(result: Result) -> Section | None:
    """The section of the variable inertia, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_VARIABLE))
    if not shown:
        return None
    lines = _verdict(record)
    for block in (_sections(record), _secondary(record), _wedges(record), _unstable(record)):
        if block:
            lines += ["", *block]
    return Section("Inertia that changes over the revolution", lines, shown)


def _verdict(record: Record) -> list[str]:
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


def _sections(record: Record) -> list[str]:
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
    lines += ["", *_modes(record)]
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


def _modes(record: Record) -> list[str]:
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

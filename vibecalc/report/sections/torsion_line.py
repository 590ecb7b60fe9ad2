"""Identity of an engine and its shaft line: cycle, firing order, stations, shafts, dampers."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having, labels, speed_of, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    asked,
    line_of,
    order_text,
    range_words,
    short,
    turns,
    vector,
)
from vibecalc.report.tables import Column, number, pairs, paragraph, table
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from vibecalc.machine.shaft_line import ShaftLine

_KINDS = {"viscous": "ring in oil", "spring": "ring on springs", "pendulum": "pendulums"}
#: absolute difference in rad of firing intervals that are called even
_EVEN = 1e-9


def torsion_line(result: Result) -> Section | None:
    """The section, None without a shaft line or without results of it."""
    if not any(path.startswith(TORSION) for path in result.record):
        return None
    line = line_of(result)
    if line is None:
        return None
    lines = pairs(_identity(result, line))
    for block in (_stations(line), _sections(line), _dampers(line), _gears(line), _loads(line)):
        if block:
            lines += ["", *block]
    return Section("Engine and shaft line", lines, frozenset())


def _identity(result: Result, line: "ShaftLine") -> list[tuple[str, str]]:
    machine = table_of(result.case, "machine")
    train = table_of(machine, "crank_train")
    speed, torsion = speed_of(result), asked(result)
    cycle = str(machine.get("cycle") or "four_stroke").replace("_", "-")
    rows = [("engine", f"{cycle}, {len(train.get('cylinders') or ())} cylinders{_banks(train)}")]
    lengths = [(name, train.get(key)) for name, key in (("bore", "bore"), ("rod", "rod_length"))]
    words = [f"{name} {short(1e3 * float(size))} mm" for name, size in lengths if size]
    if train.get("crank_radius"):
        words.insert(1, f"stroke {short(2e3 * float(train['crank_radius']))} mm")
    rows.append(("cylinder", ", ".join(words)))
    rows += [("firing order", words) for words in [firing_words(result.record, cycle)] if words]
    rows.append(("gas", _gas(train)))
    if speed is not None:
        rows.append(("operating speed", f"{show(rpm(speed))} rpm ({show(speed)} rad/s)"))
    if torsion.get("speeds"):
        rows.append(("speeds looked at", range_words(result)))
    orders = having(result.record, TORSION + "excitation/total", "half_order")
    if orders is not None:
        values = np.asarray(orders.axes[0].values, dtype=float)
        every = f"every {order_text(values[1] - values[0])}" if values.size > 1 else "alone"
        rows.append(("orders", f"{order_text(values[0])} to {order_text(values[-1])}, {every}"))
    rows.append(("misfire", _misfire(torsion)))
    rows.append(("damping", _damping(torsion)))
    total = float(np.sum(line.line.inertia))
    rows.append(("inertia of the line", f"{show(total)} kg*m^2, referred to the crankshaft"))
    return rows


def firing_words(record: Record, cycle: str = "") -> str:
    """`1-5-3-6-2-4, every 120 deg`, of the firing angles; empty without them."""
    angle = vector(record, "excitation/firing_angle", "cylinder")
    if angle is None:
        return ""
    whole = 2.0 * math.pi if cycle == "two-stroke" else 4.0 * math.pi
    order = np.argsort(angle, kind="stable")
    quantity = record[TORSION + "excitation/firing_angle"]
    label = labels(quantity.axes[0])
    steps = np.diff([*angle[order], angle[order[0]] + whole])
    degrees = [short(math.degrees(step)) for step in steps]
    even = np.ptp(steps) < _EVEN
    text = "-".join(label[i] for i in order)
    return f"{text}, " + (f"every {degrees[0]} deg" if even else f"after {', '.join(degrees)} deg")


def first_firing(record: Record) -> str:
    """`cylinder '1'`, from whose firing position crank angles and phases count."""
    quantity = record.quantities.get(TORSION + "excitation/firing_angle")
    if quantity is None:
        return "the cylinder that fires first"
    return f"cylinder {labels(quantity.axes[0])[int(np.argmin(quantity.values))]!r}"


def _banks(train: Mapping[str, Any]) -> str:
    angles = sorted({float(one.get("bank_angle") or 0.0) for one in train.get("cylinders") or ()})
    if len(angles) < 2:
        return " in line"
    return f" in banks at {', '.join(short(math.degrees(angle)) for angle in angles)} deg"


def _gas(train: Mapping[str, Any]) -> str:
    cards, cycle = train.get("gas_cards") or (), table_of(train, "gas_cycle")
    way = str(train.get("gas_interpolation") or "linear")
    if cards:
        speeds = ", ".join(turns(float(card["speed"])) for card in cards)
        return f"pressure cards at {speeds} rpm, {way} between their rows"
    if cycle:
        return f"computed cycle ({cycle.get('kind')})"
    if train.get("gas_pressure"):
        return f"one pressure card for all speeds, {way} between its rows"
    return "none"


def _misfire(torsion: Mapping[str, Any]) -> str:
    silent: Any = torsion.get("misfire") or ()
    if not silent:
        return "none: all cylinders fire"
    kind = {"no_gas": "no gas torque", "motored": "compression and expansion without combustion"}
    words = kind.get(str(torsion.get("misfire_kind") or "no_gas"), "")
    plural = "s" if len(silent) > 1 else ""
    return f"cylinder{plural} {', '.join(map(str, silent))}: {words}"


def _damping(torsion: Mapping[str, Any]) -> str:
    model = torsion.get("damping_model")
    if not isinstance(model, Mapping):
        return "as given for shafts, stations and dampers below"
    ratios = ", ".join(f"{100.0 * float(ratio):g} %" for ratio in model.get("ratios") or ())
    if model.get("kind") == "rayleigh":
        modes = ", ".join(str(mode) for mode in model.get("modes") or ())
        return f"Rayleigh, {ratios} in modes {modes}; not that of shafts and dampers"
    return f"ratios of the modes: {ratios}; not that of shafts and dampers"


def _stations(line: "ShaftLine") -> list[str]:
    columns = [number("no.", 4), Column("station", 22), number("speed\nratio", 9),
               number("inertia\nkg*m^2", 12), number("damping to\nthe frame\nN*m*s/rad", 12),
               number("stiffness\nto it\nN*m/rad", 12), number("cylinders", 10)]  # fmt: skip
    counts = np.bincount(line.cylinder_station, minlength=len(line.station_names))
    rows = []
    for i, name in enumerate(line.station_names):
        own = line.station_values[:, i] / line.station_ratio[i] ** 2
        rows.append([
            str(i + 1), name, short(line.station_ratio[i]), show(own[0]),
            *(show(value, digits=5) for value in own[1:]), str(counts[i]) if counts[i] else "",
        ])  # fmt: skip
    return [*paragraph("Stations, with what they have at their own speed:"),
            *table(columns, rows)]  # fmt: skip


def _sections(line: "ShaftLine") -> list[str]:
    columns = [Column("section", 25), Column("kind", 6), number("stiffness\nN*m/rad", 12),
               number("damping\nN*m*s/rad", 11), number("loss\nfactor", 8)]  # fmt: skip
    # only what some section has
    sizes = [
        (values, factor, column)
        for values, factor, column in (
            (line.section_diameter, 1e3, number("diameter\nmm", 9)),
            (line.section_bore, 1e3, number("bore\nmm", 8)),
            (line.section_modulus, 1e6, number("section\nmodulus\ncm^3", 10)),
        )
        if np.any(values)
    ]
    columns += [column for _, _, column in sizes]
    rows = []
    for e, name in enumerate(line.section_names):
        square = line.section_ratio[e] ** 2
        stiffness = float(line.line.stiffness[e]) / square
        text = show(stiffness)
        if line.speed_stiffness[e]:
            text = f"{show(float(line.speed_stiffness[e]) / square**2, digits=4)} w^2"
        rows.append([
            name, line.section_kinds[e], text, show(line.line.damping[e] / square, digits=5),
            show(line.line.loss_factor[e], digits=4),
            *(short(factor * values[e]) if values[e] else "" for values, factor, _ in sizes),
        ])  # fmt: skip
    words = "Sections, on their own shafts"
    if np.any(line.section_modulus):
        words += "; stress is torque over the section modulus"
    words += ":"
    return [*paragraph(words), *table(columns, rows)] if rows else []


def _dampers(line: "ShaftLine") -> list[str]:
    columns = [Column("damper", 22), Column("kind", 16), Column("on", 18),
               number("ring\nkg*m^2", 11), number("stiffness\nN*m/rad", 12),
               number("damping\nN*m*s/rad", 12)]  # fmt: skip
    rows = [
        [one.name, _KINDS.get(one.kind, one.kind), line.station_names[one.station],
         show(one.inertia), show(one.stiffness) + (" w^2" if one.kind == "pendulum" else ""),
         show(one.damping)]
        for one in line.dampers
    ]  # fmt: skip
    return table(columns, rows) if rows else []


def _gears(line: "ShaftLine") -> list[str]:
    columns = [Column("gear", 26), Column("from", 18), Column("to", 18), number("ratio", 11),
               Column("teeth", 20)]  # fmt: skip
    rows = []
    for gear in line.gears:
        teeth = "rigid"
        if gear.element >= 0:
            teeth = f"elastic, pitch {short(1e3 * gear.pitch_radius)} mm"
        first, second = line.station_names[gear.first], line.station_names[gear.second]
        rows.append([gear.name, first, second, show(gear.ratio), teeth])
    return table(columns, rows) if rows else []


def _loads(line: "ShaftLine") -> list[str]:
    words = f"The mean torque is taken up at station {line.station_names[line.load_station]!r}"
    taken = [
        f"{short(torque)} N*m at {line.station_names[place]!r}"
        + (f" (speed to the power {power:g})" if power else "")
        for place, torque, power in zip(
            line.taken_station, line.taken_torque, line.taken_exponent, strict=True
        )
    ]
    return paragraph(words + (f", besides {', '.join(taken)}." if taken else "."))

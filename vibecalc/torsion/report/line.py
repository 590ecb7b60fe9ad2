"""The shaft line in words: its parts, identity of the engine, terms that all sections share."""

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, magnitudes, speed_of, table_of
from vibecalc.core.report.writing import Column, number, pairs, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from vibecalc.torsion.model import ShaftLineModel

# ----------------------------------------------------------------------------
# What all sections on a shaft line share: its parts, words for orders, speeds and sections.
# ----------------------------------------------------------------------------

TORSION = "response/torsion/"
#: rad -> mrad, rad -> degrees, Pa -> N/mm^2
MILLI, DEGREES, MEGA = 1e3, 180.0 / math.pi, 1e-6
#: orders and modes beyond these are in the result file only
MOST_ORDERS, MOST_MODES = 60, 6
#: a speed of so many times the operating one still counts where the case names no range
_BEYOND = 1.25


def line_of(result: Result) -> "ShaftLineModel | None":
    """The shaft line of the case with what its dimensions give; None if the case has none."""
    if not table_of(result.case, "machine", "shaft_line"):
        return None
    from vibecalc.core.case.load import validate
    from vibecalc.torsion.model import build_shaft_line

    return build_shaft_line(validate(dict(result.case)))


def asked(result: Result) -> dict[str, object]:
    """The table `response.torsion` of the case."""
    return dict(table_of(result.case, "response", "torsion"))


def has_pendulums(result: Result) -> bool:
    """Whether natural frequencies change with the speed, as a pendulum's field does."""
    line = line_of(result)
    return line is not None and bool(np.any(line.speed_stiffness))


def speed_range(result: Result) -> tuple[float, float]:
    """Lowest and highest crank speed in rad/s that count, of the case or about its own speed."""
    speeds = table_of(result.case, "response", "torsion", "speeds")
    if "from" in speeds and "to" in speeds:
        return float(speeds["from"]), float(speeds["to"])
    return 0.0, _BEYOND * (speed_of(result) or 0.0)


def range_words(result: Result) -> str:
    """`300 to 1000 rpm`."""
    low, high = (turns(speed) for speed in speed_range(result))
    return f"{low} to {high} rpm"


def turns(speed: float) -> str:
    """A speed in rad/s as rpm, short: `300`, `859.87`."""
    return short(rpm(speed))


def short(value: float) -> str:
    """Five digits at most, without zeros at the end."""
    return f"{float(value):.5g}" if math.isfinite(value) else show(value)


def order_text(order: float) -> str:
    """`0.5`, `3`; `-` for none."""
    return f"{float(order):g}" if order else "-"


def within(value: float, error: float, digits: int = 4) -> str:
    """A number with no more digits than its error leaves: `40 +- 20`; plain where all are known.

    The error is rounded up to one digit.
    """
    if not math.isfinite(value) or not math.isfinite(error) or abs(value) <= error:
        return show(value, error, digits)
    if error < 0.5 * 10.0 ** (math.floor(math.log10(abs(value))) + 1 - digits):
        return show(value, digits=digits)
    power = math.floor(math.log10(error))
    doubt = math.ceil(error / 10.0**power - 1e-9) * 10.0**power
    places = max(-power, 0)
    return f"{round(value, -power):.{places}f} +- {doubt:.{places}f}"


def meeting(mode: float, order: float) -> str:
    """`mode 2, order 3`, or nothing where no critical is near."""
    return f"mode {int(mode)}, order {order_text(order)}" if mode and order else ""


def vector(record: Record, name: str, axis: str) -> np.ndarray | None:
    """Real values of a quantity of one axis under `TORSION`, None if it is missing or empty."""
    quantity = having(record, TORSION + name, axis)
    return None if quantity is None else magnitudes(quantity)


def names(record: Record, path: str, axis: str) -> list[str]:
    """Labels of an axis of a quantity under `TORSION`, none if the record does not have it."""
    quantity = record.quantities.get(TORSION + path)
    found = [own for own in quantity.axes if own.name == axis] if quantity is not None else []
    return labels(found[0]) if found else []


def cell(
    quantity: Quantity | None, place: int | tuple[int, ...], factor: float = 1.0, digits: int = 5
) -> str:
    """One entry in the unit that `factor` makes of SI; blank if the quantity is missing."""
    if quantity is None:
        return ""
    value = np.asarray(quantity.values)[place]
    size = float(abs(value)) if np.iscomplexobj(value) else float(value)
    return show(factor * size, abs(factor) * quantity.error_estimate, digits)


def undamped_frequency(record: Record) -> np.ndarray | None:
    """Frequencies of the line without damping, which Holzer's tables are of."""
    found = vector(record, "modes/undamped_frequency", "mode")
    return vector(record, "modes/natural_frequency", "mode") if found is None else found


def elastic_modes(result: Result, undamped: bool = False) -> list[int]:
    """Places of the modes that an order of the case meets within its speeds, the lowest first.

    At most `MOST_MODES`; the lowest elastic one in any case.
    """
    natural = vector(result.record, "modes/natural_frequency", "mode")
    if undamped:
        natural = undamped_frequency(result.record)
    if natural is None:
        return []
    top = highest_frequency(result)
    elastic = [int(i) for i in np.flatnonzero(natural > 0.0)]
    return [i for n, i in enumerate(elastic) if n == 0 or natural[i] <= top][:MOST_MODES]


def highest_frequency(result: Result) -> float:
    """Of the highest order of the case at its highest speed, rad/s."""
    excited = having(result.record, TORSION + "excitation/total", "half_order")
    highest = 12.0 if excited is None else float(np.max(np.asarray(excited.axes[0].values)))
    return highest * speed_range(result)[1]


def entry(quantity: Quantity | None, name: str, factor: float = 1.0, digits: int = 5) -> str:
    """The entry of a section as in `cell`; blank if the quantity does not have this section.

    Stresses belong to sections with a section modulus, what a line has without dampers to others.
    """
    place = place_of(quantity, name)
    return "" if place is None else cell(quantity, place, factor, digits)


def place_of(quantity: Quantity | None, name: str) -> int | None:
    """Where a section, station or other thing with a name stands on the first axis."""
    found = [] if quantity is None else labels(quantity.axes[0])
    return found.index(name) if name in found else None


def worst_section(record: Record) -> str | None:
    """The most loaded section, at the worst speed or at the operating one.

    Of shafts whose stress is known the most stressed one, else the one of the largest torque;
    where some speeds have no bound, at the operating speed.
    """
    for name in ("largest/stress_half_range", "largest/torque_half_range", "stress_half_range",
                 "torque_half_range"):  # fmt: skip
        load = vector(record, name, "section")
        if load is not None and 0.0 < np.max(load) < np.inf:
            return names(record, name, "section")[int(np.argmax(load))]
    return None


def joined(words: Iterable[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    found = list(words)
    return " and ".join([", ".join(found[:-1]), found[-1]] if len(found) > 1 else found)


# ----------------------------------------------------------------------------
# Identity of an engine and its shaft line: cycle, firing order, stations, shafts, dampers.
# ----------------------------------------------------------------------------

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


def _identity(result: Result, line: "ShaftLineModel") -> list[tuple[str, str]]:
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


def _stations(line: "ShaftLineModel") -> list[str]:
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


def _sections(line: "ShaftLineModel") -> list[str]:
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


def _dampers(line: "ShaftLineModel") -> list[str]:
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


def _gears(line: "ShaftLineModel") -> list[str]:
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


def _loads(line: "ShaftLineModel") -> list[str]:
    words = f"The mean torque is taken up at station {line.station_names[line.load_station]!r}"
    taken = [
        f"{short(torque)} N*m at {line.station_names[place]!r}"
        + (f" (speed to the power {power:g})" if power else "")
        for place, torque, power in zip(
            line.taken_station, line.taken_torque, line.taken_exponent, strict=True
        )
    ]
    return paragraph(words + (f", besides {', '.join(taken)}." if taken else "."))

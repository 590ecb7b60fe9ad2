"""The shaft line in words: its parts, identity of the engine, terms that all sections share."""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.headline import large_torques
from vibecalc.core.report.rows import Made, part_of
from vibecalc.core.report.sections import Section, having, labels, magnitudes, speed_of, table_of
from vibecalc.core.report.writing import Column, number, pairs, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.given_torques import given_rows

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
#: the case of the last line that was built, and that line
_BUILT: "list[tuple[Mapping[str, Any], ShaftLineModel]]" = []


class Detail:
    """Blocks of lines for the full report only, made where they are read."""

    def __init__(self, result: Result, *makers: Callable[[Result], list[str]]) -> None:
        self.result, self.makers = result, makers

    def __iter__(self) -> Iterator[str]:
        for make in self.makers:
            block = make(self.result)
            yield from ["", *block] if block else []


def line_of(result: Result) -> "ShaftLineModel | None":
    """The shaft line of the case with what its dimensions give; None if the case has none."""
    if not table_of(result.case, "machine", "shaft_line"):
        return None
    if not _BUILT or _BUILT[0][0] is not result.case:
        from vibecalc.core.case.load import validate
        from vibecalc.torsion.model import build_shaft_line

        _BUILT[:] = [(result.case, build_shaft_line(validate(dict(result.case))))]
    return _BUILT[0][1]


def is_chain(line: "ShaftLineModel") -> bool:
    """Whether springs join all freedoms in one row without branch, loop or spring to the frame."""
    springs = (line.line.stiffness != 0.0) | (line.speed_stiffness != 0.0)
    ends = np.stack([line.line.first, line.line.second], axis=1)[springs]
    # not numpy.unique, which imports numpy's masked arrays for rows
    ends = np.array(sorted({(min(pair), max(pair)) for pair in ends.tolist()}))
    met = np.bincount(ends.ravel(), minlength=1)
    # a ring in oil without springs is in no row and has no mode
    row = int(np.max(met)) <= 2 and len(ends) == np.count_nonzero(met) - 1
    return row and not np.any(line.line.ground_stiffness)


def mode_names(result: Result, undamped: bool = False) -> list[str]:
    """`1-node`, `2-node` of a line in one row, `elastic 1` of any other, `rigid`, `overdamped`.

    The n-th elastic mode of a row of inertias has n nodes, those in the springs of dampers counted.
    """
    natural = vector(result.record, "modes/natural_frequency", "mode")
    if undamped:
        natural = undamped_frequency(result.record)
    if natural is None:
        return []
    ratio = vector(result.record, "modes/damping_ratio", "mode")
    line, elastic, names = line_of(result), 0, []
    form = "{}-node" if line is not None and is_chain(line) else "elastic {}"
    for i, value in enumerate(natural):
        elastic += int(value > 0.0)
        still = "overdamped" if ratio is not None and ratio[i] == 1.0 else "rigid"
        names.append(form.format(elastic) if value > 0.0 else still)
    return names


def torque_unit(record: Record) -> tuple[float, str]:
    """Factor from N m and unit of all torques of a report, as in the first table."""
    return (1e-3, "kN m") if large_torques(record, "torsion") else (1.0, "N m")


def asked(result: Result) -> dict[str, object]:
    """The table `response.torsion` of the case."""
    return dict(table_of(result.case, "response", "torsion"))


def has_pendulums(result: Result) -> bool:
    """Whether natural frequencies change with the speed, as a pendulum's field does."""
    line = line_of(result)
    return line is not None and bool(np.any(line.speed_stiffness))


def speed_range(result: Result) -> tuple[float, float]:
    """Lowest and highest crank speed in rad/s that count, of the case or from the operating one."""
    speeds = table_of(result.case, "response", "torsion", "speeds")
    if "from" in speeds and "to" in speeds:
        return float(speeds["from"]), float(speeds["to"])
    return 0.0, _BEYOND * (speed_of(result) or 0.0)


def range_words(result: Result) -> str:
    """`300 to 1000 rpm`."""
    low, high = (turns(speed) for speed in speed_range(result))
    return f"{low} to {high} rpm"


def turns(speed: float) -> str:
    """A speed in rad/s as rpm, short: `300`, `859.9`."""
    return short(rpm(speed))


def short(value: float) -> str:
    """Four significant digits, without zeros at the end."""
    text = show(float(value), digits=4)
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text


def order_text(order: float) -> str:
    """`0.5`, `3`; `-` for none."""
    return f"{float(order):.4g}" if order else "-"


def within(value: float, error: float, digits: int = 4) -> str:
    """A number with no more digits than its error leaves: `40 +- 20`; plain where all are known.

    The error is rounded up to one digit.
    """
    if not math.isfinite(value) or not math.isfinite(error) or abs(value) <= error:
        return show(value, error, digits)
    if error < 0.5 * 10.0 ** (math.floor(math.log10(abs(value))) + 1 - digits):
        return show(value, digits=digits)
    power = math.floor(math.log10(error))
    shown = math.ceil(error / 10.0**power - 1e-9) * 10.0**power
    places = max(-power, 0)
    return f"{round(value, -power):.{places}f} +- {shown:.{places}f}"


def meeting(names_: list[str], mode: float, order: float) -> str:
    """`1-node, order 3`, or nothing where no critical is near."""
    if not mode or not order:
        return ""
    place = int(mode) - 1
    name = names_[place] if place < len(names_) else f"mode {int(mode)}"
    return f"{name}, order {order_text(order)}"


def modes_named(result: Result, path: str) -> Made:
    """Names of the modes whose numbers, from 1, stand at a path, or are its first axis."""
    known = np.array(mode_names(result))

    def made(record: Record) -> Quantity | None:
        found = record.quantities.get(path)
        if found is None:
            return None
        of_axis = found.axes[0].name.endswith("mode")
        numbers = found.axes[0].values if of_axis else found.values
        return part_of(found, known[np.asarray(numbers, dtype=int) - 1], found.axes[0])

    return made


def vector(record: Record, name: str, axis: str) -> np.ndarray | None:
    """Real values of a quantity of one axis under `TORSION`, None if it is missing or empty."""
    quantity = having(record, TORSION + name, axis)
    return None if quantity is None else magnitudes(quantity)


def names(record: Record, path: str, axis: str) -> list[str]:
    """Labels of an axis of a quantity under `TORSION`, none if the record does not have it."""
    quantity = record.quantities.get(TORSION + path)
    found = [one for one in quantity.axes if one.name == axis] if quantity is not None else []
    return labels(found[0]) if found else []


def cell(
    quantity: Quantity | None, place: int | tuple[int, ...], factor: float = 1.0, digits: int = 4
) -> str:
    """One entry in the unit that `factor` makes of SI; blank if the quantity is missing."""
    if quantity is None:
        return ""
    value = np.asarray(quantity.values)[place]
    size = float(abs(value)) if np.iscomplexobj(value) else float(value)
    return show(factor * size, abs(factor) * quantity.error_estimate, digits)


def rows_by(
    record: Record,
    axis: str,
    columns: Iterable[tuple[str, float, str]],
    more: Iterable[tuple[Column, Callable[[int], str]]] = (),
) -> list[str]:
    """Lines of a table with a row for each name of an axis, none where nothing is there.

    Columns: path under `TORSION`, factor from SI and title, left out where all is zero;
    `more` are made of the place.
    """
    shown = [
        (quantity, factor, number(title))
        for path, factor, title in columns
        if (quantity := having(record, TORSION + path, axis)) and np.any(quantity.values)
    ]
    if not shown:
        return []
    heads = [Column(axis), *(head for *_, head in shown), *(head for head, _ in more)]
    rows = [
        [name, *(entry(quantity, name, factor) for quantity, factor, _ in shown),
         *(text(i) for _, text in more)]
        for i, name in enumerate(labels(shown[0][0].axes[0]))
    ]  # fmt: skip
    return table(heads, rows)


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
    excited = having(result.record, TORSION + "excitation/station_torque", "station", "half_order")
    highest = 12.0 if excited is None else float(np.max(np.asarray(excited.axes[1].values)))
    return highest * speed_range(result)[1]


def entry(quantity: Quantity | None, name: str, factor: float = 1.0, digits: int = 4) -> str:
    """The entry of a section as in `cell`; blank if the quantity does not have this section.

    Stresses belong to sections with a section modulus, what a line has without dampers to others.
    """
    place = place_of(quantity, name)
    return "" if place is None else cell(quantity, place, factor, digits)


def place_of(quantity: Quantity | None, name: str) -> int | None:
    """Where a section, station or other thing with a name stands on the first axis."""
    found = [] if quantity is None else np.flatnonzero(quantity.axes[0].values == name).tolist()
    return found[0] if found else None


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
    lines = [*pairs(_identity(result, line)), "", *_parts(line)]
    gears = _gears(line)
    return Section(
        "Engine and shaft line" if line.cylinder_station.size else "Shaft line",
        [*lines, *(["", *gears] if gears else [])],
        frozenset(),
        "section moduli",
        Detail(result, _moduli) if np.any(line.section_modulus) else (),
    )


def _identity(result: Result, line: "ShaftLineModel") -> list[tuple[str, str]]:
    machine, torsion = table_of(result.case, "machine"), asked(result)
    rows = _engine(result, machine) if line.cylinder_station.size else []
    orders = having(result.record, TORSION + "excitation/station_torque", "station", "half_order")
    words = [range_words(result)] if torsion.get("speeds") else []
    if orders is not None:
        values = np.asarray(orders.axes[1].values, dtype=float)
        even = values.size > 1 and np.ptp(np.diff(values)) < _EVEN
        every = f" every {order_text(values[1] - values[0])}" if even else ""
        words.append(f"orders {order_text(values[0])} to {order_text(values[-1])}{every}")
    rows += [("speeds and orders", ", ".join(words))] if words else []
    rows += given_rows(result, torque_unit(result.record))
    rows += _misfire(torsion) + _damping(torsion)
    total = short(float(np.sum(line.line.inertia)))
    speed = "" if line.cylinder_station.size else f" of {line.station_names[_reference(line)]!r}"
    at = f"kg m^2 at the speed{speed}" if speed else "kg m^2 at crank speed"
    rows.append(("whole line", f"{total} {at}; {_loads(result, line)}"))
    return rows


def _reference(line: "ShaftLineModel") -> int:
    """The station whose speed is that of the machine."""
    return int(np.argmin(np.abs(line.station_ratio - 1.0)))


def _engine(result: Result, machine: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Cycle, cylinders, firing order and gas."""
    train = table_of(machine, "crank_train")
    cycle = str(machine.get("cycle") or "four_stroke").replace("_", "-")
    count = len(train.get("cylinders") or ())
    words = [f"{cycle}, {count} cylinder{'s' * (count != 1)}{_banks(train)}"]
    sizes = ("bore", "bore", 1e3), ("stroke", "crank_radius", 2e3), ("rod", "rod_length", 1e3)
    words += [
        f"{name} {short(factor * float(train[key]))} mm"
        for name, key, factor in sizes
        if train.get(key)
    ]
    rows = [("engine", ", ".join(words))]
    rows += [("firing order", words) for words in [firing_words(result.record, cycle)] if words]
    rows.append(("gas", _gas(train)))
    pressure = result.record.quantities.get(TORSION + "excitation/mean_indicated_pressure")
    if pressure is not None:
        rows[-1] = ("gas", f"{_gas(train)}; mean indicated pressure {cell(pressure, (), 1e-5)} bar")
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
    """`the firing of cylinder '1'`, from which crank angles and phases count."""
    quantity = record.quantities.get(TORSION + "excitation/firing_angle")
    if quantity is None:
        return "crank angle zero"
    return f"the firing of cylinder {labels(quantity.axes[0])[int(np.argmin(quantity.values))]!r}"


def _banks(train: Mapping[str, Any]) -> str:
    angles = sorted({float(one.get("bank_angle") or 0.0) for one in train.get("cylinders") or ()})
    if len(angles) < 2:
        return " in line"
    return f" in banks at {', '.join(short(math.degrees(angle)) for angle in angles)} deg"


def _gas(train: Mapping[str, Any]) -> str:
    cards, cycle = train.get("gas_cards") or (), table_of(train, "gas_cycle")
    interpolation = str(train.get("gas_interpolation") or "linear")
    if cards:
        speeds = ", ".join(turns(float(card["speed"])) for card in cards)
        return f"pressure cards at {speeds} rpm ({interpolation})"
    if cycle:
        return f"computed cycle ({cycle.get('kind')})"
    if train.get("tangential_effort"):
        return "tangential effort over mean indicated pressure"
    if train.get("gas_pressure"):
        return f"one pressure card for all speeds ({interpolation})"
    return "none"


def _misfire(torsion: Mapping[str, Any]) -> list[tuple[str, str]]:
    silent: Any = torsion.get("misfire") or ()
    kind = {"no_gas": "no gas torque", "motored": "compression and expansion without combustion"}
    words = kind.get(str(torsion.get("misfire_kind") or "no_gas"), "")
    plural = "s" if len(silent) > 1 else ""
    return [("misfire", f"cylinder{plural} {joined(map(str, silent))}: {words}")] if silent else []


def _damping(torsion: Mapping[str, Any]) -> list[tuple[str, str]]:
    model = torsion.get("damping_model")
    if not isinstance(model, Mapping):
        return []
    ratios = ", ".join(f"{100.0 * float(ratio):g} %" for ratio in model.get("ratios") or ())
    words = f"ratios of the modes: {ratios}"
    if model.get("kind") == "rayleigh":
        modes = ", ".join(str(mode) for mode in model.get("modes") or ())
        words = f"Rayleigh, {ratios} in modes no. {modes}"
    return [("damping", f"{words}; not that of shafts and dampers")]


def _parts(line: "ShaftLineModel") -> list[str]:
    """Stations, sections and dampers in one table, equal ones in a row run together."""
    columns = [Column("part"), Column("kind"), number("speed\nratio"),
               number("inertia\nkg m^2"), number("stiffness\nkN m/rad"),
               number("damping\nN m s/rad"), number("loss")]  # fmt: skip
    columns += [number("dia.\nmm")] if not np.any(line.section_bore) else [
        number("dia./bore\nmm")]  # fmt: skip
    cylinders = np.bincount(line.cylinder_station, minlength=len(line.station_names))
    geared = bool(np.any(line.station_ratio != 1.0))
    rows: list[list[str]] = []
    for i, name in enumerate(line.station_names):
        values = line.station_values[:, i] / line.station_ratio[i] ** 2
        kind = f"station, {cylinders[i]} cyl." if cylinders[i] else "station"
        ratio = short(line.station_ratio[i]) if geared else ""
        rows.append([name, kind, ratio, _some(values[0]), _some(1e-3 * values[2]), _some(values[1]),
                     "", ""])  # fmt: skip
    rings = {one.name: one for one in line.dampers}
    for e, name in enumerate(line.section_names):
        if name in rings:
            continue
        square = line.section_ratio[e] ** 2
        wide = short(1e3 * line.section_diameter[e]) if line.section_diameter[e] else ""
        wide += f"/{short(1e3 * line.section_bore[e])}" if line.section_bore[e] else ""
        stiffness = _some(1e-3 * line.line.stiffness[e] / square)
        coupling = next((one for one in line.couplings if one.element == e), None)
        kind = line.section_kinds[e]
        if coupling is not None:
            kind = "coupling, nominal" if coupling.varies else "coupling"
        rows.append([name, kind, "", "", stiffness,
                     _some(line.line.damping[e] / square), _some(line.line.loss_factor[e]),
                     wide])  # fmt: skip
    for one in line.dampers:
        kind = f"{_KINDS.get(one.kind, one.kind)}, {line.station_names[one.station]}"
        power = " w^2" if one.kind == "pendulum" else ""
        loss = [line.line.loss_factor[e] for e, n in enumerate(line.section_names) if n == one.name]
        rows.append([one.name, kind, "", _some(one.inertia), _some(1e-3 * one.stiffness) + power,
                     _some(one.damping), _some(loss[0]) if loss else "", ""])  # fmt: skip
    words = "Actual values, not referred; stiffness and damping of a station: to the frame."
    return [*table(columns, together(rows)), *paragraph(words)]


def _moduli(result: Result) -> list[str]:
    line = line_of(result)
    assert line is not None  # or there is no section
    rows = [
        [name, show(1e6 * modulus, digits=4)]
        for name, modulus in zip(line.section_names, line.section_modulus, strict=True)
        if modulus
    ]
    return table((Column("section"), number("section modulus\ncm^3")), rows)


def _some(value: float) -> str:
    """A number of the case, nothing for zero."""
    return short(value) if value else ""


def together(rows: list[list[str]]) -> Iterator[list[str]]:
    """Rows that follow each other with numbered names and equal entries, as one: `throw 1 to 5`."""
    start = 0
    for end in range(1, len(rows) + 1):
        group = [row[0] for row in rows[start : end + 1]]
        if end < len(rows) and rows[end][1:] == rows[start][1:] and _stem(group):
            continue
        first, last = rows[start][0], rows[end - 1][0]
        number_ = last.removeprefix(_stem([first, last]))
        last = last if " " in number_ else number_
        yield [first if end - start == 1 else f"{first} to {last}", *rows[start][1:]]
        start = end


def _stem(names_: list[str]) -> str:
    """What names share in front of their numbers, nothing if they are not numbered so."""
    stem = re.split(r"\d", names_[0])[0]
    same = all(name.startswith(stem) and name[len(stem) :][:1].isdigit() for name in names_)
    return stem if same else ""


def _gears(line: "ShaftLineModel") -> list[str]:
    columns = [Column("gear"), Column("from"), Column("to"), number("ratio"),
               Column("teeth")]  # fmt: skip
    rows = []
    for gear in line.gears:
        teeth = "rigid"
        if gear.element >= 0:
            teeth = f"elastic, pitch {short(1e3 * gear.pitch_radius)} mm"
        first, second = line.station_names[gear.first], line.station_names[gear.second]
        rows.append([gear.name, first, second, short(gear.ratio), teeth])
    return table(columns, rows) if rows else []


def _loads(result: Result, line: "ShaftLineModel") -> str:
    factor, unit = torque_unit(result.record)
    words = f"mean torque taken up at {line.station_names[line.load_station]!r}"
    taken = [
        f"{short(factor * torque)} {unit} at {line.station_names[place]!r}"
        + (" (over the speed by a table)" if len(law.entry) else "")
        + (f" (speed to the power {law.exponent:g})" if law.exponent else "")
        for place, torque, law in zip(
            line.taken_station, line.taken_torque, line.taken_laws, strict=True
        )
    ]
    return words + (f", besides {joined(taken)}" if taken else "")

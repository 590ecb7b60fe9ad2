"""The shaft line in words: its parts, its engine, given torques, dampings; what sections share."""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.headline import large_torques
from vibecalc.core.report.rows import Found, Made, derived, part_of
from vibecalc.core.report.sections import (
    Section,
    having,
    labels,
    magnitudes,
    speed_of,
    stacked,
    table_of,
)
from vibecalc.core.report.writing import (
    Column,
    many,
    number,
    pairs,
    paragraph,
    short,
    show,
    table,
    turns,
)
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.numerics.rounding import first_of_largest, ranked
from vibecalc.torsion.speed_damping import ARCHER

if TYPE_CHECKING:
    from vibecalc.torsion.model import ShaftLineModel

# ----------------------------------------------------------------------------
# What all sections on a shaft line share: its parts, words for orders, speeds and sections.
# ----------------------------------------------------------------------------

TORSION = "response/torsion/"
#: rad -> mrad, Pa -> N/mm^2
MILLI, MEGA = 1e3, 1e-6
#: orders and modes beyond these are in the result file only
MOST_ORDERS, MOST_MODES = 60, 6
#: a speed of so many times the operating one still counts where the case names no range
_BEYOND = 1.25
#: the case of the last line that was built, and that line
_BUILT: "list[tuple[Mapping[str, Any], ShaftLineModel]]" = []

Maker = Callable[[Result], list[str]]


class Detail:
    """Blocks of lines for the full report only, made where they are read."""

    def __init__(self, result: Result, *makers: Maker) -> None:
        self.result, self.makers = result, makers

    def __iter__(self) -> Iterator[str]:
        for make in self.makers:
            block = make(self.result)
            yield from ["", *block] if block else []


def titled(
    result: Result,
    title: str,
    *blocks: list[str],
    details: Mapping[str, Iterable[Maker]] = {},
    root: str = "",
) -> Section | None:
    """A section of blocks, None without any; `details` have one name for all of their makers.

    With a `root` it shows all results below that, and there is none without one.
    """
    lines = stacked(*blocks)
    shown = frozenset(path for path in result.record if root and path.startswith(root))
    if not (shown if root else lines):
        return None
    for name, makers in details.items():
        return Section(title, lines, shown, name, Detail(result, *makers))
    return Section(title, lines, shown)


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
    natural = frequencies(result.record, undamped)
    ratio = vector(result.record, "modes/damping_ratio", "mode")
    line, elastic, found = line_of(result), 0, []
    form = "{}-node" if line is not None and is_chain(line) else "elastic {}"
    for i, value in enumerate([] if natural is None else natural):
        elastic += int(value > 0.0)
        still = "overdamped" if ratio is not None and ratio[i] == 1.0 else "rigid"
        found.append(form.format(elastic) if value > 0.0 else still)
    return found


def frequencies(record: Record, undamped: bool = False) -> np.ndarray | None:
    """Natural frequencies, or those of the line without damping, which Holzer's tables are of."""
    found = vector(record, "modes/undamped_frequency", "mode") if undamped else None
    return vector(record, "modes/natural_frequency", "mode") if found is None else found


def torque_unit(record: Record) -> tuple[float, str]:
    """Factor from N m and unit of all torques of a report, as in the first table."""
    return (1e-3, "kN*m") if large_torques(record, "torsion") else (1.0, "N*m")


def asked(result: Result) -> Mapping[str, Any]:
    """The table `response.torsion` of the case."""
    return table_of(result.case, "response", "torsion")


def silent(result: Result) -> list[str]:
    """Names of the cylinders that do not fire in this case."""
    return [str(name) for name in asked(result).get("misfire") or ()]


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


def at_speed(result: Result, lead: str = " at ") -> str:
    """` at 300 rpm`, the operating speed; nothing without one."""
    speed = speed_of(result)
    return "" if speed is None else f"{lead}{turns(speed)} rpm"


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


def meetings(result: Result, stem: str) -> Made:
    """`meeting` of each mode and order below a path."""
    known = mode_names(result)

    def made(record: Record) -> Quantity | None:
        mode, order = (record.quantities.get(f"{stem}/{one}") for one in ("mode", "order"))
        if mode is None or order is None:
            return None
        words = [meeting(known, *one) for one in zip(mode.values, order.values, strict=True)]
        return part_of(mode, np.array(words), *mode.axes)

    return made


def modes_named(result: Result, path: str) -> Made:
    """Names of the modes whose numbers, from 1, stand at a path, or are its first axis."""
    known = np.array(mode_names(result))

    def named(found: Quantity) -> Quantity:
        of_axis = found.axes[0].name.endswith("mode")
        numbers = found.axes[0].values if of_axis else found.values
        return part_of(found, known[np.asarray(numbers, dtype=int) - 1], found.axes[0])

    return derived(path, named)


def vector(record: Record, name: str, axis: str) -> np.ndarray | None:
    """Real values of a quantity of one axis under `TORSION`, None if it is missing or empty."""
    quantity = having(record, TORSION + name, axis)
    return None if quantity is None else magnitudes(quantity)


def every(record: Record, stem: str, axes: str, *names_: str) -> list[Quantity]:
    """Quantities below a stem under `TORSION` over the same axes; none unless all are there."""
    found = (having(record, f"{TORSION}{stem}/{name}", *axes.split()) for name in names_)
    there = [one for one in found if one is not None]
    return there if len(there) == len(names_) else []


def row_of(path: str, place: int | str | None) -> Made:
    """One entry of the first axis, by place or name, over the second one; none without it."""

    def row(found: Quantity) -> Quantity | None:
        i = place if isinstance(place, int) else place_of(found, place)
        if i is None or len(found.axes) != 2:
            return None
        return part_of(found, found.values[i], found.axes[1])

    return derived(path, row)


def strongest(most: int, column: int = 0) -> Callable[[Found], np.ndarray]:
    """The largest entries of a column, in the order of the axis."""

    def places(found: Found) -> np.ndarray:
        return np.sort(ranked(magnitudes(found[column]))[:most])

    return places


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
    return show(factor * abs(value) if np.iscomplexobj(value) else factor * float(value),
                abs(factor) * quantity.error_estimate, digits)  # fmt: skip


def elastic_modes(result: Result, undamped: bool = False) -> list[int]:
    """Places of the modes that an order of the case meets within its speeds, the lowest first.

    At most `MOST_MODES`; the lowest elastic one in any case.
    """
    natural = frequencies(result.record, undamped)
    if natural is None:
        return []
    top = highest_frequency(result)
    elastic = [int(i) for i in np.flatnonzero(natural > 0.0)]
    return [i for n, i in enumerate(elastic) if n == 0 or natural[i] <= top][:MOST_MODES]


def highest_frequency(result: Result) -> float:
    """Of the highest order of the case at its highest speed, rad/s."""
    excited = having(result.record, TORSION + "excitation/station_torque", "station", "order")
    if excited is not None and not np.any(excited.values):  # the case names no order
        return math.inf
    highest = 12.0 if excited is None else float(np.max(np.asarray(excited.axes[1].values)))
    return highest * speed_range(result)[1]


def place_of(quantity: Quantity | None, name: str | None) -> int | None:
    """Where a section, station or other thing with a name stands on the first axis."""
    found = [] if quantity is None else np.flatnonzero(quantity.axes[0].values == name).tolist()
    return found[0] if found else None


def worst_section(record: Record) -> str | None:
    """The most loaded section, at the worst speed or at the operating one.

    Of shafts whose stress is known the most stressed one, else the one of the largest torque;
    where some speeds have no bound, at the operating speed.
    """
    for name in (f"{at}{of}_half_range" for at in ("largest/", "") for of in ("stress", "torque")):
        load = vector(record, name, "section")
        if load is not None and 0.0 < np.max(load) < np.inf:
            return names(record, name, "section")[first_of_largest(load)]
    return None


def joined(words: Iterable[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    found = list(words)
    return " and ".join([", ".join(found[:-1]), found[-1]] if len(found) > 1 else found)


# ----------------------------------------------------------------------------
# Identity of an engine and its shaft line: cycle, firing order, stations, shafts, dampers.
# ----------------------------------------------------------------------------

_KINDS = {"viscous": "ring in oil", "spring": "ring on springs", "pendulum": "pendulums",
          "friction": "ring on dry friction"}  # fmt: skip
_MISFIRES = {"motored": "compression and expansion without combustion"}
#: absolute difference in rad of firing intervals that are called even
_EVEN = 1e-9


def torsion_line(result: Result) -> Section | None:
    """The section, None without a shaft line or without results of it."""
    line = line_of(result)
    if line is None or not any(path.startswith(TORSION) for path in result.record):
        return None
    moduli = {"section moduli": [_moduli]} if np.any(line.section_modulus) else {}
    title = "Engine and shaft line" if line.cylinder_station.size else "Shaft line"
    blocks = pairs(_identity(result, line)), _parts(line), _gears(line)
    return titled(result, title, *blocks, details=moduli)


def _identity(result: Result, line: "ShaftLineModel") -> list[tuple[str, str]]:
    machine, torsion = table_of(result.case, "machine"), asked(result)
    rows = _engine(result, machine) if line.cylinder_station.size else []
    ranges = [range_words(result)] if torsion.get("speeds") else []
    orders = having(result.record, TORSION + "excitation/station_torque", "station", "order")
    if orders is not None and np.any(orders.values):
        ranges.append(orders_words(orders.axes[1].values))
    rows += [("speeds and orders", ", ".join(ranges))] if ranges else []
    rows += given_rows(result, torque_unit(result.record))
    if ill := silent(result):
        kind = _MISFIRES.get(str(torsion.get("misfire_kind")), "no gas torque")
        rows.append(("misfire", f"cylinder{'s' * (len(ill) > 1)} {joined(ill)}: {kind}"))
    rows += _damping(torsion)
    total = short(float(np.sum(line.line.inertia)))
    inertia = f"{total} kg m^2 referred to {first_shaft(line)}; {_loads(result, line)}"
    return [*rows, ("total inertia", inertia)]


#: whole and half orders that are named one by one
_MOST_ORDERS = 6


def orders_words(orders: np.ndarray, step: bool = True) -> str:
    """`orders 0.5 to 12 every 0.5`; of unequal steps the whole and half orders that there are.

    A frequency that does not follow the speed, or an order of another shaft, is a broken number
    that nobody gave.
    """
    values = np.asarray(orders, dtype=float)
    first, last = order_text(values[0]), order_text(values[-1])
    if values.size > 1 and np.ptp(np.diff(values)) < _EVEN:
        return f"orders {first} to {last}" + f" every {order_text(values[1] - values[0])}" * step
    plain = [order_text(one) for one in values if abs(2.0 * one - round(2.0 * one)) < _EVEN]
    told = plain if len(plain) <= _MOST_ORDERS else [f"up to {plain[-1]}"]
    others = len(values) - len(plain)
    told = [*told, *[f"{others} of other shafts or constant frequencies"] * bool(others)]
    return f"order{'s' * (len(values) > 1)} {joined(told)}"


def first_shaft(line: "ShaftLineModel") -> str:
    """The shaft whose speed is that of the machine: `the crankshaft`, `the shaft of 'motor'`."""
    own = line.station_names[int(np.argmin(np.abs(line.station_ratio - 1.0)))]
    return "the crankshaft" if line.cylinder_station.size else f"the shaft of {own!r}"


def _engine(result: Result, machine: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Cycle, cylinders, firing order and gas."""
    train = table_of(machine, "crank_train")
    cycle = str(machine.get("cycle") or "four_stroke").replace("_", "-")
    words = [f"{cycle}, {many(len(train.get('cylinders') or ()), 'cylinder')}{_banks(train)}"]
    sizes = ("bore", "bore", 1e3), ("stroke", "crank_radius", 2e3), ("rod", "rod_length", 1e3)
    words += [
        f"{name} {short(factor * float(train[key]))} mm"
        for name, key, factor in sizes
        if train.get(key)
    ]
    rows = [("engine", ", ".join(words)), ("firing order", firing_words(result.record, cycle))]
    pressure = result.record.quantities.get(TORSION + "excitation/mean_indicated_pressure")
    gas = _gas(train)
    if pressure is not None:
        gas += f"; mean indicated pressure {cell(pressure, (), 1e-5)} bar"
    return [row for row in (*rows, ("gas", gas)) if row[1]]


def firing_words(record: Record, cycle: str = "") -> str:
    """`1-5-3-6-2-4, every 120 deg`, of the firing angles; empty without them."""
    angle = vector(record, "excitation/firing_angle", "cylinder")
    if angle is None:
        return ""
    whole = 2.0 * math.pi if cycle == "two-stroke" else 4.0 * math.pi
    order = np.argsort(angle, kind="stable")
    label = names(record, "excitation/firing_angle", "cylinder")
    steps = np.diff([*angle[order], angle[order[0]] + whole])
    degrees = [short(math.degrees(step)) for step in steps]
    even = np.ptp(steps) < _EVEN
    text = "-".join(label[i] for i in order)
    return f"{text}, " + (f"every {degrees[0]} deg" if even else f"after {', '.join(degrees)} deg")


def _banks(train: Mapping[str, Any]) -> str:
    angles = sorted({float(one.get("bank_angle") or 0.0) for one in train.get("cylinders") or ()})
    if len(angles) < 2:
        return " in line"
    return f" in banks at {', '.join(short(math.degrees(angle)) for angle in angles)} deg"


def _gas(train: Mapping[str, Any]) -> str:
    cycle = table_of(train, "gas_cycle")
    interpolation = str(train.get("gas_interpolation") or "linear")
    if cards := train.get("gas_cards"):
        speeds = ", ".join(turns(float(card["speed"])) for card in cards)
        return f"pressure cards at {speeds} rpm ({interpolation})"
    if cycle:
        return f"computed cycle ({cycle.get('kind')})"
    if train.get("tangential_effort"):
        return "tangential effort over mean indicated pressure"
    card = train.get("gas_pressure")
    return f"one pressure card for all speeds ({interpolation})" if card else "none"


def _damping(torsion: Mapping[str, Any]) -> list[tuple[str, str]]:
    model = table_of(torsion, "damping_model")
    if not model:
        return []
    words = ", ".join(f"{100.0 * float(ratio):g} %" for ratio in model.get("ratios") or ())
    if model.get("kind") == "rayleigh":
        words = f"Rayleigh, {words} in modes no. {', '.join(map(str, model.get('modes') or ()))}"
    else:
        words = f"ratios of the modes: {words}"
    return [("damping", f"{words}; replaces that of shafts and dampers")]


def _loads(result: Result, line: "ShaftLineModel") -> str:
    factor, unit = torque_unit(result.record)
    words = f"mean torque balanced at {line.station_names[line.load_station]!r}"
    taken = [
        f"{short(factor * torque)} {unit} at {line.station_names[place]!r}"
        + " (speed table)" * bool(len(law.entry))
        + f" (~ speed^{law.exponent:g})" * bool(law.exponent)
        for place, torque, law in zip(
            line.taken_station, line.taken_torque, line.taken_laws, strict=True
        )
    ]
    return words + (f", absorbed: {joined(taken)}" if taken else "")


def _parts(line: "ShaftLineModel") -> list[str]:
    """Stations, sections and dampers in one table, equal ones in a row run together."""
    columns = [Column("part"), Column("kind"), number("speed\nratio"),
               number("inertia\nkg m^2"), number("stiffness\nkN m/rad"),
               number("damping\nN m s/rad"), number("loss"),
               number("dia./bore\nmm" if np.any(line.section_bore) else "dia.\nmm")]  # fmt: skip
    cylinders = np.bincount(line.cylinder_station, minlength=len(line.station_names))
    geared = bool(np.any(line.station_ratio != 1.0))
    rows: list[list[str]] = []
    for i, name in enumerate(line.station_names):
        inertia, damping, stiffness = line.station_values[:, i] / line.station_ratio[i] ** 2
        kind = f"station, {cylinders[i]} cyl." if cylinders[i] else "station"
        ratio = short(line.station_ratio[i]) if geared else ""
        values = map(_some, (inertia, 1e-3 * stiffness, damping))
        rows.append([name, kind, ratio, *values, "", ""])
    whole, elastic = line.line, {one.element: one for one in line.couplings}
    loss = dict(zip(line.section_names, map(_some, whole.loss_factor), strict=False))
    for e, name in enumerate(line.section_names):
        if name in {one.name for one in line.dampers}:
            continue
        square, coupling = line.section_ratio[e] ** 2, elastic.get(e)
        wide, bore = (_some(1e3 * one[e]) for one in (line.section_diameter, line.section_bore))
        kind = line.section_kinds[e]
        if coupling is not None:
            kind = "coupling" + ", nominal" * coupling.varies
        values = map(_some, (1e-3 * whole.stiffness[e] / square, whole.damping[e] / square))
        rows.append([name, kind, "", "", *values, loss[name], wide + f"/{bore}" * bool(bore)])
    for one in line.dampers:
        kind = f"{_KINDS[one.kind]}, {line.station_names[one.station]}"
        stiffness = _some(1e-3 * one.stiffness) + " w^2" * (one.kind == "pendulum")
        rows.append([one.name, kind, "", _some(one.inertia), stiffness, _some(one.damping),
                     loss.get(one.name, ""), ""])  # fmt: skip
    words = "Actual values (not referred); stiffness and damping of stations: to the frame."
    return [*table(columns, together(rows)), *paragraph(words)]


def _moduli(result: Result) -> list[str]:
    line = line_of(result)
    assert line is not None  # or there is no section
    both = zip(line.section_names, line.section_modulus, strict=True)
    rows = [[name, show(1e6 * modulus, digits=4)] for name, modulus in both if modulus]
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
        last = number_ if number_.isdigit() else last
        yield [first if end - start == 1 else f"{first} to {last}", *rows[start][1:]]
        start = end


def _stem(names_: list[str]) -> str:
    """What names share in front of their numbers, nothing if they are not numbered so."""
    stem = re.split(r"\d", names_[0])[0]
    same = all(name.startswith(stem) and name[len(stem) :][:1].isdigit() for name in names_)
    return stem if same else ""


def _gears(line: "ShaftLineModel") -> list[str]:
    columns = [Column("gear"), Column("from"), Column("to"), number("ratio"), Column("teeth")]
    rows = [
        [gear.name, line.station_names[gear.first], line.station_names[gear.second],
         short(gear.ratio),
         f"elastic, pitch {short(1e3 * gear.pitch_radius)} mm" if gear.element >= 0 else "rigid"]
        for gear in line.gears
    ]  # fmt: skip
    return table(columns, rows)


def given_rows(result: Result, unit: tuple[float, str]) -> list[tuple[str, str]]:
    """A row for each of the excitations; `unit`: factor from N m, and what torques are read in."""
    given: Any = table_of(result.case, "machine", "shaft_line").get("excitations") or ()
    return [
        (f"torque on {one.get('on')!r}", f"{_orders(one)}: {_sizes(one, *unit)}{_law(one)}")
        for one in given
    ]


def _orders(one: Mapping[str, Any]) -> str:
    if one.get("record"):
        return f"record over its angle, {one.get('harmonics') or 24} orders"
    if one.get("frequencies"):
        return f"{_list(w / (2.0 * math.pi) for w in one['frequencies'])} Hz"
    for wheel in ("blades", "teeth"):
        if one.get(wheel):
            count = len(one.get("torques") or one.get("shares") or ())
            return f"{one[wheel]} {wheel}, order " + _list(
                one[wheel] * (k + 1) for k in range(count)
            )
    whose = "of the crankshaft" if one.get("orders_of") == "crankshaft" else "of its shaft"
    return f"order {_list(one.get('orders') or ())} {whose}"


def _sizes(one: Mapping[str, Any], factor: float, unit: str) -> str:
    if one.get("record"):
        torque = one["record"]["torque"]
        return f"{factor * min(torque):.4g} to {factor * max(torque):.4g} {unit}"
    if one.get("shares"):
        return f"{_list(100.0 * share for share in one['shares'])} % of its mean torque"
    return f"{_list(factor * torque for torque in one.get('torques') or ())} {unit}"


def _law(one: Mapping[str, Any]) -> str:
    if one.get("over_speed"):
        return ", speed table"
    power = one.get("exponent") or 0.0
    return f" at the operating speed, ~ speed^{power:g}" if power else ""


def _list(numbers: Any) -> str:
    return ", ".join(f"{float(number):.4g}" for number in numbers)


# ----------------------------------------------------------------------------
# Which damping each station and shaft has: its law, and its value at the operating speed.
# ----------------------------------------------------------------------------


def torsion_damping(result: Result) -> Section | None:
    """The section, None where all dampings are numbers of the case."""
    record, line = result.record, table_of(result.case, "machine", "shaft_line")
    station = having(record, TORSION + "damping/station", "station")
    dashpot, loss = (
        having(record, f"{TORSION}damping/{name}", "section") for name in ("section", "loss_factor")
    )
    if station is None:
        return None
    rows = [
        [name, "; ".join(_of_station(line, given)), cell(station, place), ""]
        for place, (name, given) in enumerate(
            zip(labels(station.axes[0]), line["stations"], strict=True)
        )
        if station.values[place]
    ]
    shafts = list(line.get("shafts") or ())
    for place, name in enumerate(labels(dashpot.axes[0]) if dashpot is not None else ()):
        values = [cell(one, place) if one is not None and one.values[place] else ""
                  for one in (dashpot, loss)]  # fmt: skip
        if any(values):
            words = _of_shaft(shafts[place]) if place < len(shafts) else "as given"
            rows.append([name, words, *values])
    columns = Column("part"), Column("damping"), number("N m s/rad"), number("loss\nfactor")
    words = (
        "Values at the operating speed, actual (not referred). T: mean torque of the load, n: its "
        "speed in rpm, w: in rad/s; J: inertia of the station."
    )
    return titled(result, "Damping", [*table(columns, together(rows)), *paragraph(words)])


def _of_station(line: Mapping[str, Any], station: Mapping[str, Any]) -> list[str]:
    """The laws of a station in words, each with its source."""
    found = []
    if station.get("absolute_damping"):
        found.append("as given" + _over(station.get("over_speed")))
    engine = line.get("engine_damping")
    if engine and (station.get("cylinder") or station.get("cylinders")):
        found.append(_of_engine(engine) + _over(engine.get("over_speed")))
    for load in line.get("absorbed_torques") or ():
        if load["on"] == station["name"] and load.get("propeller_damping"):
            found.append(_of_propeller(load))
    return found


def _of_engine(given: Mapping[str, Any]) -> str:
    mode = given.get("mode")
    w = f"w of mode {mode}" if mode else "w of the lowest elastic mode"
    for key, law in (
        ("magnifier", "J w / M, magnifier M = {}"),
        ("damping_ratio", "2 D J w, Lehr's D = {}"),
        ("loss_factor", "d J w, loss factor d = {}"),
    ):
        if given.get(key) is not None:
            return f"engine, {law.format(short(given[key]))}, {w}"
    return "engine, viscous"


def _of_propeller(load: Mapping[str, Any]) -> str:
    given, power = load["propeller_damping"], load.get("exponent") or 0.0
    torque = "T of a table" if load.get("curve") else f"T as speed^{power:g}"
    factor = given.get("coefficient")
    if given["method"] == "archer":
        return f"Archer (1951), a T / n, a = {short(factor or ARCHER)}, {torque}"
    if given["method"] == "slope":
        return f"slope of the load, {power:g} T / w, {torque}"
    return f"{short(factor)} T / w, {torque}"


def _of_shaft(given: Mapping[str, Any]) -> str:
    laws = {
        "damping": "viscous",
        "damping_ratio": "damping ratio {} with both adjacent inertias",
        "magnifier": "magnifier {}",
        "lehr_ratio": "Lehr's ratio {}",
        "loss_factor": "loss factor",
    }
    found = [words.format(short(given[key])) for key, words in laws.items() if given.get(key)]
    return ", ".join(found) + _over(given.get("over_speed"))


def _over(given: Mapping[str, Any] | None) -> str:
    """How it follows the speed."""
    if not given:
        return ""
    whose = "shaft speed" if given.get("of") == "own" else "speed"
    if given.get("exponent") is not None:
        power = "" if given["exponent"] == 1.0 else f"^{given['exponent']:g}"
        return f", ~ {whose}{power}, reference {turns(given['reference'])} rpm"
    factor, speed = (given["table"][key] for key in ("factor", "speed"))
    ends = f"{turns(speed[0])} to {turns(speed[-1])} rpm"
    return f", times {short(factor[0])} to {short(factor[-1])} over {ends} {whose}".replace(
        " rpm speed", " rpm"
    )

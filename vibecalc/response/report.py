"""Report of the body on its suspension: modes, motion, energies, operations, changes."""

import math
from collections.abc import Sequence

import numpy as np

from vibecalc.core.report.rows import (
    Cells,
    Found,
    Rows,
    others,
    part_of,
    relative,
    rows_of,
    whole,
)
from vibecalc.core.report.sections import (
    FAINT,
    Part,
    Section,
    along,
    having,
    labels,
    magnitudes,
    scalar_of,
    section,
    stacked,
    table_of,
    together,
)
from vibecalc.core.report.writing import (
    Column,
    number,
    paragraph,
    rpm,
    show,
    table,
)
from vibecalc.core.results.record import Quantity, Record, Result

# ----------------------------------------------------------------------------
# The body on its suspension: modes, motion over one turn, force on the ground, energies.
# ----------------------------------------------------------------------------

_MODES = "response/modes/"
_MOTION = Rows(
    "direction",
    "largest over a turn",
    (
        Cells("translation_peak", "reference point", "mm"),
        Cells("rotation_peak", "rotation", "mrad"),
        Cells("ground_force_peak", "force on the ground"),
        Cells("ground_couple_peak", "couple on the ground"),
    ),
    width=24,
    root="response",
    across=True,
)
#: coordinates are named until they hold so much of the energy of a mode together
_ENOUGH = 0.9
#: what pictures and the file keep
_ARRAYS = (
    "translation_harmonics",
    "rotation_harmonics",
    "ground_force",
    "ground_couple",
    "modes/shape",
    "modes/assurance",
    "run_up/kinetic_energy",
    "run_up/potential_energy",
)


def main_coordinates(share: Quantity | None, mode: int) -> str:
    """`y 87 %, rz 12 %`: coordinates with most of the energy of a mode, the largest first."""
    if share is None:
        return ""
    names, row = labels(share.axes[1]), np.asarray(share.values[mode], dtype=float)
    words, held = [], 0.0
    for j in np.argsort(-row, kind="stable"):
        words.append(f"{names[j]} {100.0 * row[j]:.0f} %")
        held += float(row[j])
        if held >= _ENOUGH or len(words) == 3:
            break
    return ", ".join(words)


def _moves_most(record: Record) -> Quantity | None:
    share = having(record, _MODES + "energy_fraction", "mode", "coordinate")
    if share is None:
        return None
    words = [f"  {main_coordinates(share, i)}" for i in range(len(share.values))]
    return part_of(share, np.array(words), share.axes[0])


_OF_MODES = Rows(
    "mode",
    "mode",
    (
        Cells("natural_frequency", "Hz", "Hz", 11),
        Cells("damping_ratio", "damping ratio"),
        Cells(_moves_most, "  moves most (share of energy)", "", 32),
        Cells(
            "nearest_order",
            "nearest",
            whole,
            8,
            "nearest: the excited order that comes closest at operating speed; off: its frequency "
            "over the natural frequency, less 1",
        ),
        Cells("distance", "it is off", relative, 11),
    ),
    width=5,
    root="response/modes",
)


def response(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = {path for name in _ARRAYS if (path := f"response/{name}") in record}
    by_order, totals = energies(record)
    modes, blocks = rows_of(record, _OF_MODES), [rows_of(record, _MOTION), totals, _run_up(record)]
    details = {"energies by order": by_order}
    if "isolation/modes/natural_frequency" in record:
        details["orders next to the modes"] = modes
    else:
        blocks.insert(0, modes)
    return section("Response: body on its suspension", blocks, details, shown)


def _run_up(record: Record) -> tuple[list[str], set[str]]:
    """Where over the speeds the energy is largest, and the speeds left out.

    A driven resonance without damping among the speeds leaves no largest value: what was computed
    at the edge of the speeds left out is not one.
    """
    rows: list[list[str]] = []
    shown: set[str] = set()
    masked = {path for path in record if path.startswith("response/masked/")}
    centre = having(record, "response/masked/centre", "masked")
    for kind in ("kinetic", "potential"):
        hit = along(record, f"response/run_up/{kind}_energy", "speed")
        if hit is None or not hit[1].size:
            continue
        quantity, speed = hit
        top = int(np.argmax(quantity.values))
        value, unit = show(float(quantity.values[top]), quantity.error_estimate), quantity.unit
        at = float(speed[top])
        if centre is not None and centre.values.size:
            value, unit, at = "without bound", "", float(centre.values[0])
        rows.append([f"{kind}, mean over a turn", value, unit, show(rpm(at))])
    if not rows:
        return [], masked
    columns = (
        Column("largest energy of the run-up, as sampled", 42),
        number("value", 14),
        Column("unit", 6),
        number("at rpm", 14),
    )
    lines = table(columns, rows)
    if centre is not None:
        order, mode = (record.quantities.get(f"response/masked/{n}") for n in ("order", "mode"))
        words = []
        for i, speed_out in enumerate(centre.values):
            which = ""
            if order is not None and mode is not None:
                which = f" (order {int(order.values[i])}, mode {int(mode.values[i])})"
            words.append(f"{show(rpm(float(speed_out)))} rpm{which}")
        lines += paragraph("left out, an undamped resonance without bound: " + ", ".join(words))
    return lines, shown | masked


# ----------------------------------------------------------------------------
# Energies of the moving body: order by order until they no longer count, then altogether.
# ----------------------------------------------------------------------------

_FIELDS = (
    ("kinetic", "mean"),
    ("kinetic", "peak"),
    ("potential", "mean"),
    ("potential", "peak"),
)
_ROWS = 16
#: energies that end below this end because smaller numbers do not exist
_NEAR_UNDERFLOW = 1e-280
#: the smallest double with all its digits
SMALLEST = float(np.finfo(float).tiny)


def energies(record: Record) -> tuple[Part, Part]:
    """Tables of mean and peak energies: by order, and their totals."""
    totals = {path for field in _FIELDS if (path := _path(field)) in record}
    below = []
    if any(scalar_of(record, path) is not None for path in totals):
        columns = [number(f"{kind} {what}", 18) for kind, what in _FIELDS]
        row = ["all orders", *(_total(record, _path(field)) for field in _FIELDS)]
        below = table([Column("energy in J", 14), *columns], [row]) + paragraph(
            "mean: over one turn; peak: the largest at any moment, all orders with their phases"
        )
    return rows_of(record, _BY_ORDER), (below, totals)


def last_normal(values: np.ndarray) -> tuple[int, bool]:
    """Place of the last entry that is a full double (-1: none); whether underflow ends them."""
    above = np.flatnonzero(values >= SMALLEST)
    if not above.size:
        return -1, False
    last = int(above[-1])
    return last, last + 1 < values.size and bool(values[last] < _NEAR_UNDERFLOW)


def _path(field: tuple[str, str]) -> str:
    kind, what = field
    return f"response/{kind}_energy/{what}"


def _chosen(found: Found) -> np.ndarray:
    """Places of the orders to show."""
    rows = np.array([one.values for one in found])
    largest = rows.max(axis=1, keepdims=True, initial=0.0)
    return np.flatnonzero(np.any((rows > FAINT * largest) & (rows > 0.0), axis=0))[:_ROWS]


def _further_orders(found: Found, places: np.ndarray) -> str:
    """How many orders are not shown, how small they get, and where they underflow."""
    acting = np.any([one.values >= SMALLEST for one in found], axis=0)
    more, first = int(acting.sum()) - len(places), found[0]
    if not more:
        return ""
    last, underflows = last_normal(first.values)
    kind, what = first.path.removesuffix("_by_order").split("/")[1:]
    noun = "order" if more == 1 else "orders"
    limit = f"each below {FAINT:.0e} of the largest" if len(places) < _ROWS else "smaller ones too"
    words = f"{more} further {noun} up to {int(first.axes[0].values[last])}, {limit}; the {what} "
    words += f"{kind.replace('_', ' ')} of the last is {show(float(first.values[last]))} J"
    if underflows:
        return words + ", and beyond it they are below the smallest double"
    return words + ", still above the smallest double"


_BY_ORDER = Rows(
    "order",
    "energy in J",
    [Cells(_path(field) + "_by_order", " ".join(field)) for field in _FIELDS],
    width=14,
    each=18,
    label="order {:.0f}",
    places=_chosen,
    rest=_further_orders,
)


def _total(record: Record, path: str) -> str:
    value = scalar_of(record, path)
    return "" if value is None else show(value, record[path].error_estimate)


# ----------------------------------------------------------------------------
# Energies of every operation with every balance, in one table that can be read across.
# ----------------------------------------------------------------------------

_OPERATIONS = "response/operations/"
_AXES = ("operation", "balance")
_WORDS = {"mean": "mean over a turn", "peak": "largest over a turn"}
#: of an energy, and of the ends of its range
_DIGITS, _FEWER = 4, 4
#: ends closer than this share of the value are one number
_SAME = 1e-9


def operations(result: Result) -> Section | None:
    """The section, None if the result compares no operations."""
    record = result.record
    further = together(
        _combinations(record, "kinetic", "peak"),
        _combinations(record, "potential", "mean"),
        _combinations(record, "potential", "peak"),
        _turning(record, "kinetic"),
        _turning(record, "potential"),
    )
    details = {"further energies of the operations": further}
    title = "Operations and balances: energies of every combination"
    return section(title, [_reading(record), _combinations(record, "kinetic", "mean")], details)


def _reading(record: Record) -> list[str]:
    """The one line to read first: which balance is best, by which measure."""
    found = []
    for name, words in (("weighted", "least weighted"), ("difference", "smallest difference of")):
        quantity = having(record, f"{_OPERATIONS}kinetic_energy/{name}", "balance")
        if quantity is not None:
            best = int(np.argmin(quantity.values))
            value = show(quantity.values[best], quantity.error_estimate)
            balance = labels(quantity.axes[0])[best]
            found.append(f"{words} kinetic energy: {value} {quantity.unit} with balance {balance}")
    if not found:
        return []
    reach = "in brackets, how far the angle of the balance weights to the pistons can move it"
    return paragraph("; ".join([*found, reach]))


def _combinations(record: Record, kind: str, what: str) -> tuple[list[str], set[str]]:
    stem = f"{_OPERATIONS}{kind}_energy/"
    values = having(record, stem + what, *_AXES)
    if values is None:
        return [], set()
    ends = [having(record, f"{stem}{what}_{end}", *_AXES) for end in ("low", "high")]
    sums = []
    if what == "mean":
        sums = [
            (words, quantity)
            for name, words in (("difference", "largest - smallest"), ("weighted", "weighted"))
            if (quantity := having(record, stem + name, "balance")) is not None
        ]
    lines = [f"  {kind.capitalize()} energy, {_WORDS[what]}, {values.unit}"]
    places = range(len(values.axes[1].values))
    rows = [
        [name, *(_operation_cell(values, ends, i, j) for j in places)]
        for i, name in enumerate(labels(values.axes[0]))
    ]
    below = [[text, *(_short(one, q) for one in q.values)] for text, q in sums]
    lines += ["", *table(_operation_columns(values), rows, below)]
    shown = {values.path} | {end.path for end in ends if end is not None}
    return lines, shown | {quantity.path for _, quantity in sums}


def _turning(record: Record, kind: str) -> tuple[list[str], set[str]]:
    """Throws and balance weights without all else that moves: what balancing alone leaves."""
    stem = f"{_OPERATIONS}{kind}_energy/rotating_"
    mean, peak = (having(record, stem + what, *_AXES) for what in ("mean", "peak"))
    if mean is None or peak is None:
        return [], set()
    lines = [
        f"  {kind.capitalize()} energy of throws and balance weights, without counterweights and "
        "shafts,",
        f"  mean / largest, {mean.unit}",
    ]
    rows = [
        [name, *(_pair(_short(m, mean), _short(p, peak)) for m, p in zip(*both, strict=True))]
        for name, *both in zip(labels(mean.axes[0]), mean.values, peak.values, strict=True)
    ]
    lines += ["", *table(_operation_columns(mean), rows)]
    return lines, {mean.path, peak.path}


def _operation_columns(quantity: Quantity) -> list[Column]:
    """A column for each balance, three of which fit side by side."""
    balances = labels(quantity.axes[1])
    return [Column("operation", 20), *(number(f"balance {one}", 25) for one in balances)]


def _operation_cell(values: Quantity, ends: Sequence[Quantity | None], i: int, j: int) -> str:
    """The energy, and below it from where to where it goes with the angle of the weights."""
    text = _short(values.values[i, j], values)
    low, high = ends
    if low is None or high is None:
        return text
    least, most = float(low.values[i, j]), float(high.values[i, j])
    uncertainty = low.error_estimate + high.error_estimate + _SAME * abs(most)
    if most - least <= uncertainty:
        return text
    ends_text = [
        show(value, end.error_estimate, _FEWER) for value, end in ((least, low), (most, high))
    ]
    return f"{text}\n({ends_text[0]} .. {ends_text[1]})"


def _pair(mean: str, peak: str) -> str:
    return mean if mean == peak == "0" else f"{mean} / {peak}"


def _short(value: float, quantity: Quantity) -> str:
    return show(value, quantity.error_estimate, _DIGITS)


# ----------------------------------------------------------------------------
# The change from one operation to the other: how far it moves the body, and for how long.
# ----------------------------------------------------------------------------

_SWITCHING = "response/switching/"
_CHANGE_KINDS = (("reversal", "through rest"), ("instant", "at once"))
_VECTORS = (
    ("translation_peak", "largest displacement mm"),
    ("rotation_peak", "largest rotation mrad"),
    ("ground_force_peak", "force on the ground N"),
    ("ground_couple_peak", "couple on the ground N*m"),
)
_SCALARS = (
    ("kinetic_energy_peak", "largest kinetic energy J"),
    ("slow_kinetic_energy", "  if infinitely slow J"),
    ("worst_kinetic_energy_peak", "  at the worst crank angle J"),
    ("worst_angle", "  which is deg"),
    ("peak_time", "  time from start of change s"),
    ("peak_speed", "  at a crank speed of rpm"),
    ("potential_energy_peak", "largest potential energy J"),
    ("settle_time", "settles, from end of change s"),
)
_CHANGE_DIGITS = 4


def _changes(record: Record) -> Quantity | None:
    """In which change each resonance is passed."""
    which = having(record, _SWITCHING + "passage/change", "passage")
    changes = having(record, _SWITCHING + "reversal/kinetic_energy_peak", "change")
    if which is None or changes is None:
        return None
    names = np.array(labels(changes.axes[0]))
    return part_of(which, names[which.values.astype(int) - 1], which.axes[0])


def _low(found: Found) -> np.ndarray:
    """Low orders carry the large forces: they are shown first, in the order of time."""
    order = next((one for one in found if one.path.endswith("/order")), found[0])
    return np.sort(np.argsort(order.values, kind="stable")[:16])


def _haste(found: Found, places: np.ndarray) -> str:
    further = others("; {left} further passages of higher order are in the result file")
    return "haste above 1: the resonance has no time to build up" + further(found, places)


#: resonances that the crank runs through on its way
_PASSAGES = Rows(
    "passage",
    "",
    (
        Cells(_changes, "resonance passed in", "", 24),
        Cells("mode", "mode", whole, 6),
        Cells("order", "order", whole, 6),
        Cells("speed", "at rpm", "rpm"),
        Cells("time", "after s"),
        Cells("haste", "haste"),
    ),
    each=12,
    root="response/switching/passage",
    places=_low,
    rest=_haste,
)

#: title of a column, way and place on the axis of changes
_Case = tuple[str, str, int]


def switching(result: Result) -> Section | None:
    """The section, None if the result has no change between operations."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_SWITCHING))
    cases = _cases(record)
    if not cases:
        return None
    lines = stacked(_steady(result), _table(record, cases))
    details = {"resonances passed on the way": rows_of(record, _PASSAGES)}
    return section("Switching between operations", [lines], details, shown)


def _cases(record: Record) -> list[_Case]:
    cases: list[_Case] = []
    for kind, words in _CHANGE_KINDS:
        quantity = having(record, f"{_SWITCHING}{kind}/kinetic_energy_peak", "change")
        if quantity is not None:
            names = labels(quantity.axes[0])
            cases += [(f"{name} {words}", kind, i) for i, name in enumerate(names)]
    return cases


def _steady(result: Result) -> list[str]:
    steady = having(result.record, _SWITCHING + "steady_energy", "operation")
    if steady is None:
        return []
    each = [
        f"{name} {show(value, steady.error_estimate)} {steady.unit}"
        for name, value in zip(labels(steady.axes[0]), steady.values, strict=True)
    ]
    words = "largest kinetic energy of the steady states: " + ", ".join(each)
    options = table_of(result.case, "response", "switching")
    settled = options.get("settled")
    if isinstance(settled, int | float):
        words += f"; settled means within {100.0 * settled:g} % of the steady motion"
    return paragraph(words)


def _table(record: Record, cases: list[_Case]) -> list[str]:
    columns = (Column("on the way", 30), *(number(title, 16) for title, _, _ in cases))
    rows = []
    for name, words in _VECTORS:
        cells = []
        for _, kind, i in cases:
            quantity = having(record, f"{_SWITCHING}{kind}/{name}", "change", "direction")
            cells.append("" if quantity is None else _largest(quantity, i))
        rows.append([words, *cells])
    for name, words in _SCALARS:
        shown = [
            (having(record, f"{_SWITCHING}{kind}/{name}", "change"), i) for _, kind, i in cases
        ]
        rows.append([words, *("" if q is None else _scalar(q, i) for q, i in shown)])
        if name == "kinetic_energy_peak":
            rows.append(["  times the larger steady one", *_ratios(record, shown)])
    return table(columns, [row for row in rows if any(row[1:])])


def _largest(quantity: Quantity, change: int) -> str:
    """Largest of the directions, with its name."""
    values = magnitudes(quantity)[change]
    top = int(np.argmax(values))
    factor = 1e3 if quantity.unit in ("m", "rad") else 1.0
    text = show(values[top] * factor, quantity.error_estimate * factor, _CHANGE_DIGITS)
    return text if text == "0" else f"{text} {labels(quantity.axes[1])[top]}"


def _scalar(quantity: Quantity, change: int) -> str:
    """One reading; angles in degrees and speeds in rpm, as the titles say."""
    value, error = float(quantity.values[change]), quantity.error_estimate
    if quantity.unit == "rad":
        return f"{math.degrees(value):.1f}"
    if quantity.unit == "rad/s":
        value, error = rpm(value), rpm(error)
    return show(value, error, _CHANGE_DIGITS)


def _ratios(record: Record, entries: Sequence[tuple[Quantity | None, int]]) -> list[str]:
    steady = having(record, _SWITCHING + "steady_energy", "operation")
    larger = 0.0 if steady is None else float(np.max(steady.values))
    if not larger > 0.0:
        return [""] * len(entries)
    return ["" if q is None else show(float(q.values[i]) / larger, digits=3) for q, i in entries]

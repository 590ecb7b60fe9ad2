"""Report of the body on its suspension: modes, motion, energies, operations, changes."""

from collections.abc import Callable, Sequence

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
    having,
    labels,
    magnitudes,
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
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.response.results import ModesOfBody, MotionOfBody, OverSpeed
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# The body on its suspension: modes, motion over one turn, force on the ground, energies.
# ----------------------------------------------------------------------------

_MOTION = Rows(
    "direction",
    "largest over a turn",
    (
        Cells("translation_peak", "reference point", "mm"),
        Cells("rotation_peak", "rotation", "mrad"),
        Cells("ground_force_peak", "force on the ground"),
        Cells("ground_couple_peak", "couple on the ground"),
    ),
    root="response",
    across=True,
)
#: coordinates are named until they hold so much of the energy of a mode together
_ENOUGH = 0.9


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
    share = having(record, "response/modes/energy_fraction", "mode", "coordinate")
    if share is None:
        return None
    words = [f"  {main_coordinates(share, i)}" for i in range(len(share.values))]
    return part_of(share, np.array(words), share.axes[0])


_OF_MODES = Rows(
    "mode",
    "mode",
    (
        Cells("natural_frequency", "Hz", "Hz"),
        Cells("damping_ratio", "damping ratio"),
        Cells(_moves_most, "  moves most (share of energy)", ""),
        Cells(
            "nearest_order",
            "nearest",
            whole,
            note="nearest: the excited order that comes closest at operating speed; off: its "
            "frequency over the natural frequency, less 1",
        ),
        Cells("distance", "it is off", relative),
    ),
    root="response/modes",
)


def response(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    paths = [path for group in (ModesOfBody, MotionOfBody, OverSpeed) for path in paths_of(group)]
    modes = rows_of(record, _OF_MODES)
    blocks = [rows_of(record, _MOTION), _totals(record), _run_up(record)]
    details = {"energies by order": rows_of(record, _BY_ORDER)}
    if "isolation/modes/natural_frequency" in record:
        details["orders next to the modes"] = modes
    else:
        blocks.insert(0, modes)
    shown = {path for path in paths if path in record}
    return section("Response: body on its suspension", blocks, details, shown)


def _run_up(record: Record) -> tuple[list[str], set[str]]:
    """Where over the speeds the energy is largest, and the speeds left out.

    A driven resonance without damping among the speeds leaves no largest value: what was computed
    at the edge of the speeds left out is not one.
    """
    masked = {path for path in record if path.startswith("response/masked/")}
    centre = having(record, "response/masked/centre", "masked")
    rows = []
    for kind in ("kinetic", "potential"):
        found = having(record, f"response/run_up/{kind}_energy", "speed")
        if found is None:
            continue
        top = int(np.argmax(found.values))
        cells = [show(float(found.values[top]), found.error_estimate), found.unit]
        at = found.axes[0].values[top]
        if centre is not None:
            cells, at = ["without bound", ""], centre.values[0]
        rows.append([f"{kind}, mean over a turn", *cells, show(rpm(float(at)))])
    if not rows:
        return [], masked
    columns = (
        Column("largest energy of the run-up, as sampled"),
        number("value"),
        Column("unit"),
        number("at rpm"),
    )
    lines = table(columns, rows)
    if centre is not None:
        words = [f"{show(rpm(float(speed)))} rpm" for speed in centre.values]
        met = [record.quantities.get(f"response/masked/{name}") for name in ("order", "mode")]
        which = zip(*(one.values for one in met if one is not None), strict=True)
        for i, (order, mode) in enumerate(which if None not in met else ()):
            words[i] += f" (order {int(order)}, mode {int(mode)})"
        lines += paragraph("left out, an undamped resonance without bound: " + ", ".join(words))
    return lines, masked


# ----------------------------------------------------------------------------
# Energies of the moving body: order by order until they no longer count, then altogether.
# ----------------------------------------------------------------------------

_ENERGIES = {
    f"response/{kind}_energy/{what}": f"{kind} {what}"
    for kind in ("kinetic", "potential")
    for what in ("mean", "peak")
}
_ROWS = 16
#: energies that end below this end because smaller numbers do not exist
_NEAR_UNDERFLOW = 1e-280
#: the smallest double with all its digits
SMALLEST = float(np.finfo(float).tiny)


def _totals(record: Record) -> Part:
    """Mean and peak energies of all orders together."""
    found = [record.quantities.get(path) for path in _ENERGIES]
    cells = [show(one.values[()], one.error_estimate) if one else "" for one in found]
    if not any(cells):
        return []
    columns = [Column("energy in J"), *(number(words) for words in _ENERGIES.values())]
    words = "mean: over one turn; peak: the largest at any moment, all orders with their phases"
    lines = table(columns, [["all orders", *cells]]) + paragraph(words)
    return lines, {one.path for one in found if one}


def last_normal(values: np.ndarray) -> tuple[int, bool]:
    """Place of the last entry that is a full double (-1: none); whether underflow ends them."""
    above = np.flatnonzero(values >= SMALLEST)
    if not above.size:
        return -1, False
    last = int(above[-1])
    return last, last + 1 < values.size and bool(values[last] < _NEAR_UNDERFLOW)


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
    kind, what = _ENERGIES[first.path.removesuffix("_by_order")].split()
    noun = "order" if more == 1 else "orders"
    limit = f"each below {FAINT:.0e} of the largest" if len(places) < _ROWS else "smaller ones too"
    words = f"{more} further {noun} up to {int(first.axes[0].values[last])}, {limit}; the {what} "
    words += f"{kind} energy of the last is {show(float(first.values[last]))} J"
    if underflows:
        return words + ", and beyond it they are below the smallest double"
    return words + ", still above the smallest double"


_BY_ORDER = Rows(
    "order",
    "energy in J",
    [Cells(f"{path}_by_order", words) for path, words in _ENERGIES.items()],
    label="order {:.0f}",
    places=_chosen,
    rest=_further_orders,
)


# ----------------------------------------------------------------------------
# Energies of every operation with every balance, in one table that can be read across.
# ----------------------------------------------------------------------------

_OPERATIONS = "response/operations/"
_WORDS = {"mean": "mean over a turn", "peak": "largest over a turn"}
_SUMS = {"difference": "largest - smallest", "weighted": "weighted"}
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
    reach = "in brackets, how far the angle of the balance weights to the pistons can move it"
    return paragraph("; ".join([*found, reach])) if found else []


def _of_pairs(record: Record, kind: str, *names: str) -> list[Quantity]:
    """Those of the energies that a result has."""
    found = [
        having(record, f"{_OPERATIONS}{kind}_energy/{name}", "operation", "balance")
        for name in names
    ]
    return [one for one in found if one is not None]


def _combinations(record: Record, kind: str, what: str) -> tuple[list[str], set[str]]:
    """The energies, each with from where to where it goes with the angle of the weights."""
    values = _of_pairs(record, kind, what)
    if not values:
        return [], set()
    ends = _of_pairs(record, kind, f"{what}_low", f"{what}_high")
    sums = [
        (words, quantity)
        for name, words in _SUMS.items()
        if (quantity := having(record, f"{_OPERATIONS}{kind}_energy/{name}", "balance")) is not None
    ] * (what == "mean")

    def cell(*place: int) -> str:
        text, *reach = (show(one.values[place], one.error_estimate) for one in (*values, *ends))
        near = [(float(one.values[place]), one.error_estimate) for one in ends]
        if len(near) < 2:
            return text
        (least, error), (most, more) = near
        apart = most - least > error + more + _SAME * abs(most)
        return f"{text}\n({reach[0]} .. {reach[1]})" if apart else text

    title = f"  {kind.capitalize()} energy, {_WORDS[what]}, {values[0].unit}"
    shown = {one.path for one in (*values, *ends, *(quantity for _, quantity in sums))}
    return [title, "", *_over_balances(values[0], cell, sums)], shown


def _turning(record: Record, kind: str) -> tuple[list[str], set[str]]:
    """Throws and balance weights without all else that moves: what balancing alone leaves."""
    both = _of_pairs(record, kind, "rotating_mean", "rotating_peak")
    if len(both) < 2:
        return [], set()

    def cell(*place: int) -> str:
        texts = [show(one.values[place], one.error_estimate) for one in both]
        return "0" if texts == ["0", "0"] else " / ".join(texts)

    lines = [
        f"  {kind.capitalize()} energy of throws and balance weights, without counterweights and "
        "shafts,",
        f"  mean / largest, {both[0].unit}",
        "",
    ]
    return lines + _over_balances(both[0], cell), {one.path for one in both}


def _over_balances(
    of: Quantity, cell: Callable[..., str], sums: Sequence[tuple[str, Quantity]] = ()
) -> list[str]:
    """A row for each operation and a column for each balance, three of which fit side by side."""
    names, balances = (labels(axis) for axis in of.axes)
    columns = [Column("operation"), *(number(f"balance {one}") for one in balances)]
    rows = [[name, *(cell(i, j) for j in range(len(balances)))] for i, name in enumerate(names)]
    below = [[text, *(show(x, one.error_estimate) for x in one.values)] for text, one in sums]
    return table(columns, rows, below)


# ----------------------------------------------------------------------------
# The change from one operation to the other: how far it moves the body, and for how long.
# ----------------------------------------------------------------------------

_SWITCHING = "response/switching/"
_CHANGE_KINDS = (("reversal", "through rest"), ("instant", "at once"))
#: results of a change, their words and the unit that they are read in
_ON_THE_WAY = (
    ("translation_peak", "largest displacement", "mm"),
    ("rotation_peak", "largest rotation", "mrad"),
    ("ground_force_peak", "force on the ground", "N"),
    ("ground_couple_peak", "couple on the ground", "N*m"),
    ("kinetic_energy_peak", "largest kinetic energy", "J"),
    ("slow_kinetic_energy", "  if infinitely slow", "J"),
    ("worst_kinetic_energy_peak", "  at the worst crank angle", "J"),
    ("worst_angle", "  which is", "deg"),
    ("peak_time", "  time from start of change", "s"),
    ("peak_speed", "  at a crank speed of", "rpm"),
    ("potential_energy_peak", "largest potential energy", "J"),
    ("settle_time", "settles, from end of change", "s"),
)


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
        Cells(_changes, "resonance passed in", ""),
        Cells("mode", "mode", whole),
        Cells("order", "order", whole),
        Cells("speed", "at rpm", "rpm"),
        Cells("time", "after s"),
        Cells("haste", "haste"),
    ),
    root="response/switching/passage",
    places=_low,
    rest=_haste,
)


def switching(result: Result) -> Section | None:
    """The section, None if the result has no change between operations."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_SWITCHING))
    lines = _way_table(record)
    if not lines:
        return None
    details = {"resonances passed on the way": rows_of(record, _PASSAGES)}
    blocks = [stacked(_steady(result), lines)]
    return section("Switching between operations", blocks, details, shown)


def _steady(result: Result) -> list[str]:
    steady = having(result.record, _SWITCHING + "steady_energy", "operation")
    if steady is None:
        return []
    each = [
        f"{name} {show(value, steady.error_estimate)} {steady.unit}"
        for name, value in zip(labels(steady.axes[0]), steady.values, strict=True)
    ]
    words = "largest kinetic energy of the steady states: " + ", ".join(each)
    settled = table_of(result.case, "response", "switching").get("settled")
    if isinstance(settled, int | float):
        words += f"; settled means within {100.0 * settled:g} % of the steady motion"
    return paragraph(words)


def _way_table(record: Record) -> list[str]:
    """A column for each change of each way, a row for each result."""
    cases = [
        (f"{name} {words}", kind, i)
        for kind, words in _CHANGE_KINDS
        if (peak := having(record, f"{_SWITCHING}{kind}/kinetic_energy_peak", "change")) is not None
        for i, name in enumerate(labels(peak.axes[0]))
    ]
    steady = having(record, _SWITCHING + "steady_energy", "operation")
    larger = 0.0 if steady is None else float(np.max(steady.values))
    rows = []
    for name, words, unit in _ON_THE_WAY:
        found = [(record.quantities.get(f"{_SWITCHING}{kind}/{name}"), i) for _, kind, i in cases]
        rows.append([f"{words} {unit}", *(_cell(one, i, unit) for one, i in found)])
        if name == "kinetic_energy_peak" and larger > 0.0:
            times = [show(float(one.values[i]) / larger, digits=3) for one, i in found if one]
            rows.append(["  times the larger steady one", *times])
    columns = (Column("on the way"), *(number(title) for title, *_ in cases))
    return table(columns, [row for row in rows if any(row[1:])]) if cases else []


def _cell(quantity: Quantity | None, change: int, unit: str) -> str:
    """A result of a change; of directions the largest, with its name."""
    if quantity is None:
        return ""
    factor = convert(1.0, quantity.unit, unit)
    values = factor * np.atleast_1d(magnitudes(quantity)[change])
    top = int(np.argmax(values))
    if unit == "deg":
        return f"{values[top]:.1f}"
    text = show(values[top], factor * quantity.error_estimate)
    return text if text == "0" or len(values) == 1 else f"{text} {labels(quantity.axes[1])[top]}"

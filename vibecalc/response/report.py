"""Report of the body on its suspension: modes, motion, energies, operations, changes."""

from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import (
    Cells,
    Found,
    Made,
    Rows,
    by_name,
    left_out,
    named_at,
    others,
    over_natural,
    part_of,
    rows_of,
    whole,
)
from vibecalc.core.report.sections import (
    FAINT,
    Part,
    Section,
    having,
    labels,
    section,
    table_of,
    together,
    turns_of,
)
from vibecalc.core.report.writing import many, number, paragraph, rpm, show, table
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.numerics.rounding import ranked
from vibecalc.response.results import (
    BesidesChanges,
    Change,
    Instant,
    LeftOut,
    ModesOfBody,
    MotionOfBody,
    OverSpeed,
    Passages,
    Reversal,
)

# ----------------------------------------------------------------------------
# The body on its suspension: modes, motion over one turn, force on the ground, energies.
# ----------------------------------------------------------------------------

_MOTION = Rows("direction", "largest over {turn}", paths_of(MotionOfBody), across=True)
#: coordinates are named until they hold so much of the energy of a mode together
_ENOUGH = 0.9


def main_coordinates(share: Quantity | None, mode: int) -> str:
    """`y 87 %, rz 12 %`: coordinates with most of the energy of a mode, the largest first."""
    if share is None:
        return ""
    names, row = labels(share.axes[1]), np.asarray(share.values[mode], dtype=float)
    words, held = [], 0.0
    for j in ranked(row):
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


_NEAREST = "f / f_n: frequency of the nearest excited order at operating speed / natural frequency"
_OF_MODES = (
    Cells("natural_frequency", "Hz", "Hz"),
    Cells("damping_ratio", "damping ratio"),
    Cells(_moves_most, "  dominant motion (energy share)", ""),
    Cells("nearest_order", "nearest\norder", whole, note=_NEAREST),
    Cells("distance", "f / f_n", over_natural),
)


def response(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    paths = [path for group in (ModesOfBody, MotionOfBody, OverSpeed) for path in paths_of(group)]
    modes = rows_of(record, Rows("mode", "mode", _OF_MODES, "response/modes"))
    totals = by_name(record, "energy of all orders", {k: (k,) for k in _KINDS}, _TOTALS, "response")
    tables = [rows_of(record, one) for one in (_MOTION, left_out(LeftOut.ROOT))]
    blocks: list[Part] = [tables[0], totals, _run_up(record), tables[1]]
    details = {"energies by order": rows_of(record, _BY_ORDER)}
    if "isolation/modes/natural_frequency" in record:
        details["modes and nearest orders"] = modes
    else:
        blocks.insert(0, modes)
    shown = {path for path in paths if path in record}
    return section("Response: body on its suspension", blocks, details, shown)


def _run_up(record: Record) -> list[str]:
    """Where over the speeds the energy is largest.

    A driven resonance without damping among the speeds leaves no largest value: what was computed
    at the edge of the speeds left out is not one.
    """
    rows, centre = [], having(record, f"{LeftOut.ROOT}/centre", "resonance_skipped")
    for found in (record[path] for path in paths_of(OverSpeed) if having(record, path, "speed")):
        top = int(np.argmax(found.values))
        value, at = show(found.values[top], found.error_estimate), found.axes[0].values[top]
        if centre is not None:
            value, at = "unbounded", centre.values[0]
        name = f"{found.long_name.split()[1]}, mean over {turns_of(record, found.path)}"
        rows.append([name, value, show(rpm(at))])
    heads = ("maximum energy in the run-up, sampled", number("J"), number("at rpm"))
    return table(heads, rows)


# ----------------------------------------------------------------------------
# Energies of the moving body: order by order until they no longer count, then altogether.
# ----------------------------------------------------------------------------

_KINDS = ("kinetic", "potential")
_ENERGIES = {f"response/{kind}_energy/{what}": f"{kind} {what}"
             for kind in _KINDS for what in ("mean", "peak")}  # fmt: skip
_ROWS = 16
#: energies that end below this end because smaller numbers do not exist
_NEAR_UNDERFLOW = 1e-280
#: the smallest double with all its digits
SMALLEST = float(np.finfo(float).tiny)


_TOTALS = (Cells("{}_energy/mean", "mean over {turn}"), Cells("{}_energy/peak", "peak"))


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
    first = found[0]
    more = int(np.any([one.values >= SMALLEST for one in found], axis=0).sum()) - len(places)
    if not more:
        return ""
    last, underflows = last_normal(first.values)
    kind, what = _ENERGIES[first.path.removesuffix("_by_order")].split()
    limit = f"each below {FAINT:.0e} of the largest" if len(places) < _ROWS else "smaller ones too"
    end = "beyond it they are below" if underflows else "still above"
    return (
        f"{many(more, 'further order')} up to {int(first.axes[0].values[last])}, {limit}; the "
        f"{what} {kind} energy of the last is {show(float(first.values[last]))} J, "
        f"{'and ' * underflows}{end} the smallest double"
    )


_ALONE = [Cells(f"{path}_by_order", words) for path, words in _ENERGIES.items()]
_BY_ORDER = Rows("order", "energy in J", _ALONE, label="order {:.0f}", places=_chosen,
                 rest=_further_orders)  # fmt: skip


# ----------------------------------------------------------------------------
# Energies of every operation with every balance, in one table that can be read across.
# ----------------------------------------------------------------------------

_OPERATIONS = "response/operations/"
_WORDS = {"mean": "mean over a turn", "peak": "peak over a turn"}
#: ends closer than this share of the value are one number
_SAME = 1e-9


def operations(result: Result) -> Section | None:
    """The section, None if the result compares no operations."""
    record = result.record
    tables = [rows_of(record, one) for kind in _KINDS for one in _of_kind(kind)]
    details = {"further energies of the operations": together(*tables[2:])}
    title = "Operations and balances: energies of all combinations"
    shown = {path for path in record if path.startswith(_OPERATIONS)}
    return section(title, [_reading(record), *tables[:2]], details, shown)


#: measures of a balance: below the kinetic energy, which is best, and words
_JUDGED = (
    ("weighted", "lowest", "weighted mean kinetic energy"),
    ("difference", "smallest", "range of the mean kinetic energy over the operations"),
)


def _reading(record: Record) -> list[str]:
    """The one line to read first: which balance is best, by which measure."""
    found = []
    for name, best_of, words in _JUDGED:
        quantity = having(record, f"{_OPERATIONS}kinetic_energy/{name}", "balance")
        if quantity is not None and len(quantity.values) > 1:
            best = int(np.argmin(quantity.values))
            value = show(quantity.values[best], quantity.error_estimate)
            names = labels(quantity.axes[0])
            found.append(f"{best_of} {words}: {value} {quantity.unit} with balance {names[best]}")
    return paragraph("; ".join(found)) if found else []


def _with_range(path: str) -> Made:
    """The energies, each with from where to where it goes with the angle of the weights."""

    def made(record: Record) -> Quantity | None:
        paths = (path, f"{path}_low", f"{path}_high")
        found = [one for each in paths if (one := having(record, each, "operation", "balance"))]
        if not found or found[0].path != path:
            return None
        words = np.empty(found[0].values.shape, dtype=object)
        for place in np.ndindex(words.shape):
            values = [one.values[place] for one in found]
            text, *ends = (show(value, one.error_estimate)
                           for value, one in zip(values, found, strict=True))  # fmt: skip
            errors = sum(one.error_estimate for one in found[1:]) + _SAME * abs(values[-1])
            apart = len(ends) == 2 and values[2] - values[1] > errors
            words[place] = f"{text}\n({' .. '.join(ends)})" if apart else text
        return part_of(found[0], words.astype(str), *found[0].axes)

    return made


def _of_kind(kind: str) -> tuple[Rows, ...]:
    """Means, how far they are apart, peaks; and what balancing alone leaves."""
    root = f"{_OPERATIONS}{kind}_energy"
    note = "in brackets: range over the angle of the balance weights to the pistons"
    mean, peak = (Rows("operation", f"{kind} energy, {words}, J",
                       (Cells(_with_range(f"{root}/{what}"), "balance {}"),), note=note)
                  for what, words in _WORDS.items())  # fmt: skip
    sums = ("difference", "weighted")
    apart = Rows("balance", f"{kind} energy, means", sums, root, across=True)
    turning = Cells("rotating_mean", "mean, balance {}"), Cells("rotating_peak", "peak, balance {}")
    words = f"{kind} energy of throws and balance weights, without counterweights and shafts, J"
    return mean, apart, peak, Rows("operation", words, turning, root=root)


# ----------------------------------------------------------------------------
# The change from one operation to the other: how far it moves the body, and for how long.
# ----------------------------------------------------------------------------

_SWITCHING = "response/switching/"


def _times(root: str) -> Made:
    """The largest energy of a change over that of the larger steady state."""

    def made(record: Record) -> Quantity | None:
        peak = having(record, f"{root}/kinetic_energy_peak", "change")
        steady = having(record, "response/switching/steady_energy", "operation")
        if peak is None or steady is None or not np.max(steady.values):
            return None
        return replace(peak, values=peak.values / np.max(steady.values), unit="")

    return made


def _way(group: type[Change], words: str) -> Rows:
    """A column for each change of a way, a row for each result."""
    times = Cells(_times(group.ROOT), "kinetic energy peak / larger steady peak")
    return Rows("change", words, (*paths_of(group), times), across=True)


_WAYS = (_way(Reversal, "change via standstill"), _way(Instant, "instantaneous change"))


def _low(found: Found) -> np.ndarray:
    """Low orders carry the large forces: they are shown first, in the order of time."""
    order = next((one for one in found if one.path.endswith("/order")), found[0])
    return np.sort(np.argsort(order.values, kind="stable")[:16])


#: resonances that the crank runs through on its way
_CHANGE = named_at(f"{Passages.ROOT}/change", f"{Reversal.ROOT}/peak_time")
_PASSAGES = Rows(
    "passage", "", (Cells(_CHANGE, "change"), *paths_of(Passages)[1:]), places=_low,
    note="haste above 1: passed too fast for the resonance to build up",
    rest=others("{left} more passages of higher order in the result file"),
)  # fmt: skip


def switching(result: Result) -> Section | None:
    """The section, None if the result has no change between operations."""
    record = result.record
    shown = {path for path in record if path.startswith(_SWITCHING)}
    tables = [rows_of(record, one) for one in _WAYS]
    settled = table_of(result.case, "response", "switching").get("settling_tolerance")
    words = f"settled: within {100.0 * (settled or 0.0):g} % of the steady motion"
    details = {"resonances passed": rows_of(record, _PASSAGES)}
    return section(
        "Switching between operations",
        [tables[0], rows_of(record, _STATES), tables[1], paragraph(words)]
        if any(map(any, tables)) else [],
        details, shown,
    )  # fmt: skip


_STATES = Rows("operation", "steady state", paths_of(BesidesChanges), across=True)

"""What of the rod and the piston moves how: masses, and the rod's inertia beyond two points."""

import numpy as np

from vibecalc.report.lookup import having, labels, scalar_of
from vibecalc.report.numbers import show, show_phase
from vibecalc.report.sections.response_energies import FAINT
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

_STEM = "excitation/rod/"
_MASSES = (("reciprocating", "moves with the piston"), ("rotating", "turns with the pin"))
_ROWS = 12


def rod(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    lines, shown = _masses(record)
    for block, paths in (_inertia(record), _orders(record)):
        lines += ["", *block] if block and lines else block
        shown |= paths
    return (
        Section("Running gear: masses and rod inertia", lines, frozenset(shown)) if lines else None
    )


def _masses(record: Record) -> tuple[list[str], set[str]]:
    found = [
        (quantity, words)
        for name, words in _MASSES
        if (quantity := having(record, f"excitation/mass/{name}", "cylinder")) is not None
    ]
    if not found:
        return [], set()
    columns = (
        Column("cylinder", 20),
        *(number(f"{words} {quantity.unit}", 27) for quantity, words in found),
    )
    rows = [
        [name, *(show(quantity.values[i], quantity.error_estimate) for quantity, _ in found)]
        for i, name in enumerate(labels(found[0][0].axes[0]))
    ]
    return table(columns, rows), {quantity.path for quantity, _ in found}


def _inertia(record: Record) -> tuple[list[str], set[str]]:
    names = ("split_inertia", "couple_peak", "couple_bound")
    lines, shown = scalars(record, [_STEM + name for name in names], "excitation/")
    if not lines:
        return [], set()
    if scalar_of(record, _STEM + "couple_peak") is not None:
        words = "couple: of one rod about the crankshaft, beyond that of its two point masses"
    else:
        words = (
            "the case does not give the rod's moment of inertia; a rod whose material lies between "
            "its bearings cannot add more than the bound to the couple about the crankshaft"
        )
    return lines + paragraph(words), shown


def _orders(record: Record) -> tuple[list[str], set[str]]:
    quantity = having(record, _STEM + "couple", "order")
    if quantity is None:
        return [], set()
    error = quantity.error_estimate
    sizes = np.abs(quantity.values)
    acting = np.flatnonzero(sizes > error)
    loud = [int(i) for i in acting if sizes[i] > FAINT * sizes.max()][:_ROWS]
    names = labels(quantity.axes[0])
    columns = (
        Column("couple of the rod", 20),
        number(f"amplitude {quantity.unit}", 18),
        number("phase deg", 10),
    )
    rows = [
        [
            f"order {names[i]}",
            show(abs(quantity.values[i]), error),
            show_phase(complex(quantity.values[i]), error),
        ]
        for i in loud
    ]
    if not rows:
        return paragraph("couple of the rod: zero at every order"), {quantity.path}
    lines = table(columns, rows)
    rest = len(acting) - len(rows)
    if rest:
        lines += paragraph(f"{rest} further orders, faint or high, are in the result file")
    return lines, {quantity.path}

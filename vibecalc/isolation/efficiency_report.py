"""Isolation efficiency in the report and as a picture."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibecalc.core.report.curves import Curve, Curves, Ends, Panel, Plot, level
from vibecalc.core.report.rows import (
    OTHERS,
    Cells,
    Made,
    Rows,
    loud,
    others,
    part_of,
    reduced,
    rows_of,
)
from vibecalc.core.report.sections import Section, having, scalar_of, section, stacked
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.isolation.efficiency_results import ByDirection, OfCouples, OfForces

#: orders below this share of the largest stay in the result file
_SMALL = 1e-3
_MOST = 12
_NAMES = ((OfForces.ROOT, "force", "N"), (OfCouples.ROOT, "couple", "N m"))


def isolation_efficiency(result: Result) -> Section | None:
    """What the mounts keep from the ground; None where the case does not ask."""
    record = result.record
    if f"{ByDirection.ROOT}/transmissibility" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{ByDirection.ROOT}/")}
    lines = _overall(record) + paragraph(
        "held still: what acts on the body would reach the ground. Efficiency is 1 less the ratio "
        "of what does reach it; below zero the mounts send more than acts."
    )
    details = {f"isolation of the {word} by order": rows_of(record, _by_order(path, unit))
               for path, word, unit in _NAMES}  # fmt: skip
    return section("Isolation efficiency", [(lines, shown)], details)


def _overall(record: Record) -> list[str]:
    """A line for the root mean square and the peak of forces and couples each."""
    columns = (
        Column("on the ground"), number("held still"), number("on mounts"),
        number("efficiency"), number("dB")
    )  # fmt: skip
    rows = []
    for path, word, unit in _NAMES:
        for name, said in (("rms", "r.m.s."), ("peak", "peak")):
            if f"{path}/held_{name}" not in record:
                continue
            pair = [record[f"{path}/{one}_{name}"] for one in ("held", "ground")]
            share = scalar_of(record, f"{path}/{name}")
            decibels = scalar_of(record, f"{path}/{name}_level")
            rows.append(
                [
                    f"{word}, {said}",
                    *(f"{show(float(one.values), one.error_estimate)} {unit}" for one in pair),
                    _percent(share),
                    "-" if decibels is None else f"{decibels:.1f}",
                ]
            )
    lines = table(columns, rows)
    return stacked(lines, rows_of(record, _BY_DIRECTION)[0])


def _percent(share: float | None, _error: float = 0.0) -> str:
    """Nothing where no load acts: the ratio is then of what arrives or of nothing."""
    known = share is not None and np.isfinite(share) and share != 1.0
    return f"{100.0 * share:.2f} %" if share is not None and known else "-"


_BY_DIRECTION = Rows(
    "coordinate",
    "r.m.s. along and about",
    (Cells("by_direction", "efficiency", _percent),),
    root=ByDirection.ROOT,
    across=True,
)


def _level(share: float, _error: float) -> str:
    """Of the load held still over what arrives."""
    known = np.isfinite(share) and share != 1.0
    return f"{-20.0 * np.log10(1.0 - share):.1f}" if known else "-"


def _sizes(path: str) -> tuple[Made, Made]:
    """Load that acts and that arrives, by order."""
    return reduced(f"{path}/held"), reduced(f"{path}/ground")


def _resultant(path: str) -> Made:
    """Efficiency by order for all components together."""

    def made(record: Record) -> Quantity | None:
        share = having(record, f"{path}/by_order", "half_order", "component")
        return None if share is None else part_of(share, share.values[:, -1], share.axes[0])

    return made


def _by_order(path: str, unit: str) -> Rows:
    held, ground = _sizes(path)
    columns = (
        Cells(held, f"held still {unit}", ""),
        Cells(ground, f"on mounts {unit}", ""),
        Cells("by_order", "{} %", lambda share, _: _percent(share).removesuffix(" %")),
        Cells(_resultant(path), "dB", _level),
    )
    return Rows(
        "half_order", "order", columns, root=path, label="{:g}",
        places=loud(_SMALL, _MOST, 2), rest=others(OTHERS),
    )  # fmt: skip


# ----------------------------------------------------------------------------
# Efficiency by order as bars; transmissibility over frequency.
# ----------------------------------------------------------------------------


def of_loud(of: Made, *sizes: Made) -> Callable[[Result], Quantity | None]:
    """A quantity of those orders alone at which one of the `sizes` is worth a bar."""

    def made(result: Result) -> Quantity | None:
        found, *every = (one(result.record) for one in (of, *sizes))
        beside = [one for one in every if one is not None]
        if found is None or len(beside) != len(sizes):
            return None
        large = loud(_SMALL, _MOST, len(sizes))(beside)
        axis = replace(found.axes[0], values=found.axes[0].values[large])
        return replace(found, values=found.values[large], axes=(axis,))

    return made


def _ends(plot: Plot) -> Ends:
    """To twice over at most where orders next to a resonance would hide the rest."""
    least = min(float(np.nanmin(y, initial=0.0)) for _, y in plot.drawn)
    return max(-200.0, 1.08 * least), 104.0


def _panel(path: str, word: str) -> Panel:
    bars = Curve(of_loud(_resultant(path), *_sizes(path)), "", bars=True)
    return Panel("efficiency", (bars,), f"{word} on the ground, by order", unit="%", ends=_ends)


EFFICIENCY = Curves(
    "isolation efficiency",
    (
        *(_panel(path, word) for path, word, _ in _NAMES),
        Panel(
            "transmissibility",
            (Curve(f"{ByDirection.ROOT}/transmissibility", "{}"), level(lambda _: 1.0)),
            "load on the ground over a load of one size at all frequencies",
            log="xy",
            height=1.4,
        ),
    ),
    names=6,
)

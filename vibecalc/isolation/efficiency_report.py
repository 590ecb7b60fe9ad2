"""Isolation efficiency in the report and as a picture."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibecalc.core.report.curves import Curve, Curves, Ends, Panel, Plot, level
from vibecalc.core.report.sections import Section, having, labels, magnitudes, scalar_of, section
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.isolation.efficiency_results import COUPLES, FORCES, ROOT

#: orders below this share of the largest stay in the result file
_SMALL = 1e-3
_MOST = 12
_NAMES = ((FORCES, "force", "N"), (COUPLES, "couple", "N m"))


def isolation_efficiency(result: Result) -> Section | None:
    """What the mounts keep from the ground; None where the case does not ask."""
    record = result.record
    if f"{ROOT}/transmissibility" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{ROOT}/")}
    lines = _overall(record) + paragraph(
        "held still: what acts on the body would reach the ground. Efficiency is 1 less the ratio "
        "of what does reach it; below zero the mounts send more than acts."
    )
    details = {f"isolation of the {word} by order": _by_order(record, path, word, unit)
               for path, word, unit in _NAMES}  # fmt: skip
    return section("Isolation efficiency", [(lines, shown)], details)


def _overall(record: Record) -> list[str]:
    """A line for the root mean square and the peak of forces and couples each."""
    columns = (
        Column("on the ground", 16), number("held still", 14), number("on mounts", 14),
        number("efficiency", 12), number("dB", 8),
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
    by = having(record, f"{ROOT}/by_direction", "coordinate")
    if by is None:
        return lines
    names = labels(by.axes[0])
    cells = [_percent(float(one)) for one in by.values]
    by_axis = (Column("r.m.s. along and about", 22), *(number(one, 10) for one in names))
    return [*lines, "", *table(by_axis, [["efficiency", *cells]])]


def _percent(share: float | None) -> str:
    """Nothing where no load acts: the ratio is then of what arrives or of nothing."""
    known = share is not None and np.isfinite(share) and share != 1.0
    return f"{100.0 * share:.2f} %" if share is not None and known else "-"


def _large(record: Record, path: str) -> np.ndarray:
    """Places of the orders that act or arrive with a thousandth of the largest."""
    sizes = [
        np.linalg.norm(magnitudes(record[f"{path}/{one}"]), axis=1) for one in ("held", "ground")
    ]
    size = np.max(sizes, axis=0)
    return np.flatnonzero(size > _SMALL * np.max(size, initial=0.0))[:_MOST]


def _by_order(record: Record, path: str, word: str, unit: str) -> list[str]:
    held = having(record, f"{path}/held", "half_order", "coordinate")
    ground = having(record, f"{path}/ground", "half_order", "coordinate")
    share = having(record, f"{path}/by_order", "half_order", "component")
    if held is None or ground is None or share is None:
        return []
    acting, arrived = (np.linalg.norm(magnitudes(one), axis=1) for one in (held, ground))
    components = [f"{name} %" for name in labels(share.axes[1])]
    columns = (
        Column("order", 6), number(f"held still {unit}", 15), number(f"on mounts {unit}", 15),
        *(number(name, 11) for name in components), number("dB", 8),
    )  # fmt: skip
    rows = []
    for place in _large(record, path):
        cells = [_percent(float(one)).removesuffix(" %") for one in share.values[place]]
        known = acting[place] > 0.0 and arrived[place] > 0.0
        gain = 20.0 * np.log10(acting[place] / arrived[place]) if known else np.inf
        rows.append(
            [
                f"{held.axes[0].values[place]:g}",
                show(acting[place], held.error_estimate),
                show(arrived[place], ground.error_estimate),
                *cells,
                f"{gain:.1f}" if np.isfinite(share.values[place, -1]) and known else "-",
            ]
        )
    left = len(acting) - len(rows)
    words = f"the other {left} orders are zero or weaker, and in the result file"
    return (table(columns, rows) + (paragraph(words) if left else [])) if rows else []


# ----------------------------------------------------------------------------
# Efficiency by order as bars; transmissibility over frequency.
# ----------------------------------------------------------------------------


def _resultant(path: str) -> Callable[[Result], Quantity | None]:
    """Efficiency of the resultant of those orders that are worth a bar."""

    def made(result: Result) -> Quantity | None:
        share = having(result.record, f"{path}/by_order", "half_order", "component")
        if share is None:
            return None
        large = _large(result.record, path)
        axis = replace(share.axes[0], values=share.axes[0].values[large])
        return replace(share, values=share.values[large, -1], axes=(axis,))

    return made


def _ends(plot: Plot) -> Ends:
    """To twice over at most where orders next to a resonance would hide the rest."""
    least = min(float(np.nanmin(y, initial=0.0)) for _, y in plot.drawn)
    return max(-200.0, 1.08 * least), 104.0


def _panel(path: str, word: str) -> Panel:
    bars = Curve(_resultant(path), "", bars=True)
    return Panel("efficiency", (bars,), f"{word} on the ground, by order", unit="%", ends=_ends)


EFFICIENCY = Curves(
    "isolation efficiency",
    (
        *(_panel(path, word) for path, word, _ in _NAMES),
        Panel(
            "transmissibility",
            (Curve(f"{ROOT}/transmissibility", "{}"), level(lambda _: 1.0)),
            "load on the ground over a load of one size at all frequencies",
            log="xy",
            height=1.4,
        ),
    ),
    names=6,
)

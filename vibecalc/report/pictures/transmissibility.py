"""Transmissibility of the pitch model against the frequency ratio, with the orders marked."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import along, scalar_of, speed_of
from vibecalc.report.pictures.canvas import COLOURS, QUIET, TOTAL, canvas
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BASE = "isolation/pitch/"
#: Orders named in the legend; a long rod ratio has 70, which no picture has room for.
_NAMED = 8


def picture(result: Result) -> "Figure | None":
    """Magnitude in dB and phase; None without a pitch model.

    The curve comes from `transmissibility_curve` (axis `frequency_ratio`); without it the
    orders alone are marked.
    """
    hit = along(result.record, _BASE + "transmissibility", "order")
    natural = scalar_of(result.record, _BASE + "natural_frequency")
    speed = speed_of(result)
    if hit is None or not natural or speed is None:
        return None
    quantity, orders = hit
    ratios = np.asarray(orders, dtype=float) * speed / natural
    figure = canvas(result, "transmissibility of the mounts, pitch", 8.0, 6.2)
    level, phase = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    curve = along(result.record, _BASE + "transmissibility_curve", "frequency_ratio")
    if curve is not None:
        level.plot(curve[1], _decibel(curve[0].values), color=TOTAL)
        phase.plot(curve[1], np.degrees(np.angle(curve[0].values)), color=TOTAL)
    for i, (order, ratio, value) in enumerate(zip(orders, ratios, quantity.values, strict=True)):
        colour = COLOURS[i % len(COLOURS)]
        decibel = float(_decibel(value))
        words = f"order {int(order)}: {decibel:.1f} dB" if i < _NAMED else None
        level.plot([ratio], [decibel], "o", color=colour, label=words)
        phase.plot([ratio], [float(np.degrees(np.angle(value)))], "o", color=colour)
    if len(orders) > _NAMED:
        level.plot([], [], " ", label=f"and up to order {int(orders[-1])}")
    level.axhline(0.0, color=QUIET, linewidth=1.0)
    level.axvline(np.sqrt(2.0), color=QUIET, linestyle=":", linewidth=1.2)
    level.annotate(
        "isolates beyond $\\sqrt{2}$",
        (np.sqrt(2.0), 1.0),
        xycoords=level.get_xaxis_transform(),
        xytext=(5, -12),
        textcoords="offset points",
        color=QUIET,
        fontsize=9,
    )
    level.set_xscale("log")
    level.xaxis.set_major_formatter("{x:g}")
    level.xaxis.set_minor_formatter("")
    level.margins(y=0.12)
    level.set_ylabel("|force out / force in| in dB")
    level.legend(loc="lower left", fontsize=9)
    phase.set_ylabel("phase in deg")
    phase.set_ylim(-185.0, 5.0)
    phase.set_yticks([-180, -90, 0])
    phase.set_xlabel("excitation frequency / natural frequency")
    return figure


def _decibel(values: Any) -> Any:
    """20 log10 |T|; what is zero or infinite is a gap."""
    size = np.abs(np.asarray(values))
    return 20.0 * np.log10(np.where((size > 0.0) & np.isfinite(size), size, np.nan))

"""What a tuned absorber becomes while its oil warms."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, scalar_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, canvas
from vibecalc.report.pictures.scales import plain_ticks
from vibecalc.report.sections.absorber_parts import HARDWARE, ICE
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def picture(result: Result) -> "Figure | None":
    """Peak above, damping below, over the temperature of the oil."""
    record = result.record
    peak = having(record, HARDWARE + "warming/peak", "temperature")
    damping = having(record, HARDWARE + "warming/secondary_damping", "temperature")
    if peak is None or damping is None:
        return None
    figure = canvas(result, "peak and damping as the oil warms", 8.0, 6.0)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.7, 1.0])
    warm = np.asarray(peak.axes[0].values, dtype=float) - ICE
    above.plot(warm, peak.values, color=COLOURS[0], label="springs kept")
    best = having(record, HARDWARE + "warming/best_peak", "temperature")
    if best is not None:
        above.plot(warm, best.values, "--", color=COLOURS[2],
                   label="springs that suit the damping of each temperature")  # fmt: skip
    least = scalar_of(record, "tuning/peak")
    if least is not None:
        above.axhline(least, color=LIMIT, linestyle=":", label=f"tuning, {show(least, digits=4)}")
    above.set_ylim(0.0, None)
    above.set_ylabel("largest response")
    above.legend(fontsize=9)
    below.semilogy(warm, damping.values, color=COLOURS[1])
    wanted = scalar_of(record, "tuning/secondary_damping")
    if wanted is not None:
        below.axhline(wanted, color=QUIET, linestyle=":")
        below.annotate("wanted", (warm[-1], wanted), xytext=(-2, 3), textcoords="offset points",
                       ha="right", color=QUIET, fontsize=9)  # fmt: skip
    plain_ticks(below.yaxis)
    below.set_ylabel(r"damping $c_2 / (2 \sqrt{K_1 J_1})$")
    below.set_xlabel("temperature of the oil in $\\degree$C")
    below.set_xlim(warm[0], warm[-1])
    return figure

"""Response of a primary with its absorber over the frequency: a family of curves."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels, table_of
from vibecalc.report.pictures.absorber_surface import FEWEST, varied
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.report.pictures.scales import plain_ticks
from vibecalc.report.sections.absorber import ABSORBER
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OWN = ("tuned", "as given")
_LIMITS = {"locked": "--", "free": ":"}
#: of the highest finite maximum, or of the fixed points, the top of the picture
_ROOM = 2.5


def picture(result: Result) -> "Figure | None":
    """Magnitude on a logarithmic scale, and phase below; maxima as dots, fixed points as rings."""
    record = result.record
    curve = having(record, ABSORBER + "curve", "curve", "frequency_ratio")
    if curve is None:
        return None
    options = table_of(result.case, "response", "absorber")
    what = str(options.get("response") or "displacement").replace("_", " ")
    figure = canvas(result, f"{what} of the primary over the frequency", 9.0, 7.0)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.6, 1.0])
    hertz = having(record, ABSORBER + "frequency", "frequency_ratio")
    x = np.asarray(curve.axes[1].values, dtype=float)
    if hertz is not None:
        x = np.asarray(hertz.values) / (2.0 * np.pi)
    names, colours = labels(curve.axes[0]), iter(COLOURS * 12)
    # a long family is a surface, with a picture of its own
    hidden = set(varied(curve)[2]) if len(varied(curve)[1]) >= FEWEST else set()
    for place, (name, row) in enumerate(zip(names, np.asarray(curve.values), strict=True)):
        if place in hidden:
            continue
        colour = TOTAL if name in _OWN else QUIET if name in _LIMITS else next(colours)
        style = _LIMITS.get(name, "-")
        width = 2.4 if name in _OWN else 1.3
        size = np.abs(row)
        seen = np.where(np.isfinite(size) & (size > 0.0), size, np.nan)
        above.plot(x, seen, style, color=colour, linewidth=width, label=name)
        turned = np.where(np.isfinite(size), np.degrees(np.angle(row)), np.nan)
        turned = np.where(turned > 1.0, turned - 360.0, turned)
        below.plot(x, turned, style, color=colour, linewidth=width)
    scale = _scale(record, curve, x)
    _dots(above, record, names, scale)
    _rings(above, record, scale)
    above.set_yscale("log")
    above.set_ylim(*_limits(record, curve))
    plain_ticks(above.yaxis)
    above.set_ylabel("amplitude ratio")
    below.set_ylabel("phase in deg")
    below.set_yticks(range(-360, 1, 90))
    below.set_ylim(*_phase_limits(below))
    below.set_xlabel("frequency in Hz" if hertz is not None else "frequency over the primary's own")
    below.set_xlim(x[0], x[-1])
    figure.legend(loc="outside right upper", fontsize=8)
    return figure


def _scale(record: Record, curve: Quantity, x: np.ndarray) -> float:
    """What a frequency ratio is on the axis: itself, or Hz."""
    ratios = np.asarray(curve.axes[1].values, dtype=float)
    return float(x[-1] / ratios[-1]) if ratios[-1] else 1.0


def _dots(axes: "Axes", record: Record, names: list[str], scale: float) -> None:
    height = having(record, ABSORBER + "summit/magnitude", "curve", "summit")
    place = having(record, ABSORBER + "summit/frequency_ratio", "curve", "summit")
    if height is None or place is None:
        return
    first = True
    for name, tops, spots in zip(names, height.values, place.values, strict=True):
        there = np.isfinite(tops) & (tops > 0.0)
        if name in _OWN and np.any(there):
            axes.plot(
                scale * spots[there], tops[there], "o", color=TOTAL, ms=6, zorder=5,
                label="its maxima" if first else None,
            )  # fmt: skip
            first = False


def _rings(axes: "Axes", record: Record, scale: float) -> None:
    height = having(record, ABSORBER + "fixed_point/magnitude", "fixed_point")
    place = having(record, ABSORBER + "fixed_point/frequency_ratio", "fixed_point")
    if height is None or place is None:
        return
    axes.plot(
        scale * np.asarray(place.values), np.asarray(height.values), "o", color=LIMIT, ms=9,
        markerfacecolor="none", markeredgewidth=1.6, zorder=6, label="fixed points P, Q",
    )  # fmt: skip
    for name, x, y in zip(labels(height.axes[0]), place.values, height.values, strict=True):
        axes.annotate(
            name, (scale * float(x), float(y)), xytext=(0, 9), textcoords="offset points",
            ha="center", color=LIMIT, fontsize=9,
        )  # fmt: skip


def _limits(record: Record, curve: Quantity) -> tuple[float, float]:
    size = np.abs(np.asarray(curve.values))
    own = size[0][np.isfinite(size[0]) & (size[0] > 0.0)]
    height = having(record, ABSORBER + "summit/magnitude", "curve", "summit")
    tops = np.asarray(height.values, dtype=float) if height is not None else own
    tops = tops[np.isfinite(tops) & (tops > 0.0)]
    top = float(np.max(tops, initial=float(np.max(own, initial=1.0))))
    low = float(np.min(own, initial=1.0))
    return max(0.5 * low, 0.02 * min(1.0, top)), _ROOM * top


def _phase_limits(axes: "Axes") -> tuple[float, float]:
    low = min(float(np.nanmin(line.get_ydata())) for line in axes.get_lines())
    return (-370.0 if low < -185.0 else -190.0), 10.0

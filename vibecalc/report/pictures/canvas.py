"""What the pictures share: a figure without a window, colours, and marks."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibecalc.report.lookup import scalar_of
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Okabe and Ito's colours, which readers with a colour vision deficiency can tell apart.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
TOTAL = "#222222"
LIMIT = "#B00020"
QUIET = "#777777"
#: ratio of the ends of a logarithmic axis up to which 2 and 5 have numbers as well
_FEW = 150.0
ORDER_NAMES: Mapping[int, str] = {1: "primary (order 1)", 2: "secondary (order 2)"}


class Titled(Protocol):
    """What a picture is titled with: a result, or a sweep."""

    @property
    def name(self) -> str:
        """Name of the case."""

    @property
    def case(self) -> Mapping[str, Any]:
        """The resolved case."""


def canvas(result: Titled, subtitle: str, width: float, height: float) -> "Figure":
    """A figure for files only, titled with the case and what is shown."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    title = str(result.case.get("title") or result.name)
    figure.suptitle(f"{title}\n{subtitle}".rstrip(), fontsize=12)
    return figure


def order_name(order: int) -> str:
    """`primary (order 1)`, `secondary (order 2)`, `order 3`."""
    return ORDER_NAMES.get(order, f"order {order}")


def crank_angle_axis(axes: "Axes") -> None:
    """Crank angle in degrees over one turn, marked at its eighths."""
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 45))
    axes.set_xlabel("crank angle in deg")


def waves(orders: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """exp(i n angle), shape (orders, angles); x = Re(X @ waves) is the signal of harmonics X."""
    turned = np.multiply.outer(np.asarray(orders, dtype=float), angle)
    return np.asarray(np.exp(1j * turned))


def natural_frequencies(record: Record) -> np.ndarray:
    """Natural frequencies in rad/s: the modes of the rigid body, else that of the pitch model."""
    modes = record.quantities.get("isolation/modes/natural_frequency")
    if modes is not None:
        return np.atleast_1d(np.asarray(modes.values, dtype=float))
    pitch = scalar_of(record, "isolation/pitch/natural_frequency")
    return np.array([]) if pitch is None else np.array([pitch])


def plain_log(axes: "Axes", low: float, high: float) -> None:
    """A logarithmic axis from low to high with plain numbers, more of them over few decades."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axes.set_yscale("log")
    axes.set_ylim(low, high)
    subs = (1.0, 2.0, 5.0) if high < _FEW * low else (1.0,)
    axes.yaxis.set_major_locator(LogLocator(subs=subs, numticks=99))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def limit_line(axes: "Axes", value: float, words: str) -> None:
    """A horizontal limit with its words above the line, at the right."""
    axes.axhline(value, color=LIMIT, linestyle="--", linewidth=1.3)
    axes.annotate(
        words,
        (1.0, value),
        xycoords=axes.get_yaxis_transform(),
        xytext=(-4, 3),
        textcoords="offset points",
        ha="right",
        va="bottom",
        color=LIMIT,
        fontsize=9,
    )


def bounds_of(result: Result, quantity: str) -> list[tuple[str, float]]:
    """Upper bounds that the case puts on `quantity` at the optimum, in SI, with their words."""
    from vibecalc.report.limits import judge_limits
    from vibecalc.units import convert

    found = []
    for row in judge_limits(result):
        if row.quantity == quantity and row.max is not None and row.at != "start":
            unit: Any = result.record[quantity].unit
            value = convert(row.max, row.unit, unit)
            found.append((f"limit {row.max:g} {row.unit}".rstrip(), value))
    return found

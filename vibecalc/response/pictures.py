"""Pictures of the body on its suspension: energies by order, speed, operation; changes."""

from dataclasses import replace
from functools import partial

import numpy as np

from vibecalc.core.report.canvas import COLOURS, QUIET, TOTAL
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Mark,
    Panel,
    Plot,
    decades,
    operating,
    spans,
    usual_ends,
)
from vibecalc.core.report.marks import first_of, peak, resonances
from vibecalc.core.report.sections import having, labels, speed_of
from vibecalc.core.report.sources import entry_of
from vibecalc.core.results.record import Quantity, Result

# ----------------------------------------------------------------------------
# Kinetic and potential energy of each order alone, over as many decades as there are.
# ----------------------------------------------------------------------------

_KINDS = ("kinetic", "potential")
#: powers of ten below the largest that are drawn
_DECADES = 6

_BARS = tuple(Curve(f"response/{k}_energy/peak_by_order", k, bars=True) for k in _KINDS)
ENERGY_BY_ORDER = Curves(
    "peak energy of each order alone",
    (Panel("energy", _BARS, log="y", ends=decades(_DECADES)),),
)


# ----------------------------------------------------------------------------
# Mean energies of the body over a range of speeds, with the speeds left out as bands.
# ----------------------------------------------------------------------------

_MASKED = "response/resonances_skipped"


def _mean(i: int) -> tuple[Curve, Mark]:
    curve = Curve(f"response/run_up/{_KINDS[i]}_energy", f"{_KINDS[i]} energy, mean",
                  {"color": COLOURS[i]})  # fmt: skip
    return curve, peak(colour=COLOURS[i], below=i > 0, unless=f"{_MASKED}/low")


_LEFT_OUT = spans(_MASKED, "left out: unbounded", zorder=3)
_MET = resonances("response/modes/natural_frequency")
_MEANS = (*_mean(0), *_mean(1), _LEFT_OUT, _MET, operating)
RESPONSE_RUN_UP = Curves(
    "run-up: mean energies of the body at each speed",
    (Panel("mean energy over a turn", _MEANS, log="xy", ends=partial(usual_ends, far=1e4)),),
    high=3.5,
)


# ----------------------------------------------------------------------------
# Energies of the operations with each balance: mean, peak, what the weights' angle can do.
# ----------------------------------------------------------------------------

#: of the mean energies of the operations: results that stand with them, their words and marks
_SUMS = {
    "weighted": ("weighted mean", "_", 20),
    "difference": ("largest less smallest mean", "x", 6),
}


def _known(result: Result, path: str) -> Quantity | None:
    return having(result.record, path, "operation", "balance")


def _energies(kind: str, what: str, words: str) -> Panel:
    """Bars for each operation with their range over the angle of the weights."""
    stem = f"response/operations/{kind}_energy"
    within = (f"{stem}/{what}_low", f"{stem}/{what}_high")
    parts = [Curve(f"{stem}/{what}", "operation {}", bars=True, most=16, within=within)]
    for name, (said, marker, size) in _SUMS.items() if what == "mean" else ():
        look = {"color": TOTAL, "linestyle": "none", "marker": marker, "markersize": size}
        parts.append(Curve(f"{stem}/{name}", said, look))
    known = partial(_known, path=f"{stem}/{what}")
    return Panel(f"{kind} energy", tuple(parts), words, ends=(0.0, None), needs=(known,))


OPERATIONS = Curves(
    "energies of the operations with each balance; ranges over the angle of the weights",
    tuple(
        _energies(kind, what, words)
        for kind in _KINDS
        for what, words in (("mean", "mean over a turn"), ("peak", "peak over a turn"))
    ),
    columns=2,
)


# ----------------------------------------------------------------------------
# The change between two operations in time: displacement, energy, and the speed of the crank.
# ----------------------------------------------------------------------------

_SWITCHING = "response/switching"
_WAYS = {"reversal": "change via standstill", "instant": "instantaneous change"}
#: the energy is drawn as the largest of so many intervals: single ones follow every swing
_INTERVALS = 25


def _moved(result: Result, way: str, end: str, change: int) -> Quantity | None:
    """Displacement in a change, of the direction that moves most in any of them."""
    paths = (f"{_SWITCHING}/{one}/translation_peak" for one in _WAYS)
    peaks = next((result.record[path] for path in paths if path in result.record), None)
    found = result.record.quantities.get(f"{_SWITCHING}/{way}/translation_{end}")
    if found is None or peaks is None:
        return None
    most = int(np.argmax(peaks.values[change]))
    words = f"{labels(found.axes[0])[change]}, {labels(found.axes[1])[most]}"
    axis = replace(found.axes[0], values=np.array([words], dtype=object))
    return replace(found, values=found.values[[change], most], axes=(axis, found.axes[2]))


def _displacement(way: str, change: int) -> Panel:
    low, high = (partial(_moved, way=way, end=end, change=change) for end in ("low", "high"))
    band = Curve(low, "{}", {"color": COLOURS[change], "linewidth": 0.6}, upto=high)
    return Panel("displacement\n", (band,), "" if change else _WAYS[way])


def _energy(result: Result, way: str) -> Quantity | None:
    found = result.record.quantities.get(f"{_SWITCHING}/{way}/kinetic_energy_high")
    return found and replace(found, path="", values=envelope(found.values))


def envelope(values: np.ndarray) -> np.ndarray:
    """Largest of each entry and its neighbours along the last axis; near an end there are fewer."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(values, _INTERVALS, axis=-1, mode="nearest"))


def _peaks(plot: Plot, way: str) -> None:
    """The largest energy of each change, and those of the steady states."""
    stem, record = f"{_SWITCHING}/{way}", plot.result.record
    found = (first_of(record, f"{stem}/{one}") for one in ("peak_time", "kinetic_energy_peak"))
    for x, y, colour in zip(*found, COLOURS, strict=False):
        plot.axes.plot([x], [plot.factor * y], "o", color=colour)
    if (steady := having(record, f"{_SWITCHING}/steady_energy", "operation")) is None:
        return
    for name, value, style in zip(labels(steady.axes[0]), steady.values, ("--", ":"), strict=False):
        height, label = plot.factor * float(value), f"steady {name}"
        plot.axes.axhline(height, color=QUIET, linestyle=style, label=label)


def _speed(result: Result, way: str) -> Quantity | None:
    """The crank speed, which an instantaneous change leaves as it is."""
    found = result.record.quantities.get(f"{_SWITCHING}/{way}/speed")
    energy, speed = _energy(result, way), speed_of(result)
    if found is not None or energy is None or speed is None:
        return found
    same = np.full(len(energy.axes[-1].values), speed)
    return replace(energy, values=same, axes=energy.axes[-1:], unit="rad/s")


_ENERGIES = [
    Panel("largest kinetic\nenergy",
          (*(Curve(entry_of(partial(_energy, way=way), i), "{}", {"color": COLOURS[i]})
             for i in range(2)), partial(_peaks, way=way)),
          log="y", ends=decades(_DECADES), height=1.2)
    for way in _WAYS
]  # fmt: skip
_SPEEDS = [
    Panel("crank speed\n", (Curve(partial(_speed, way=way), look={"color": QUIET}, most=1),),
          unit="rpm", height=0.8)
    for way in _WAYS
]  # fmt: skip
SWITCHING = Curves(
    "change between operations",
    (*(_displacement(way, i) for i in range(2) for way in _WAYS), *_ENERGIES, *_SPEEDS),
    high=1.9,
    columns=2,
    level="row",
)

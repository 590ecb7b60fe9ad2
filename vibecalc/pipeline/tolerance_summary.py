"""How many results reach `[accuracy] rtol`, which one is worst, and which are not held to it."""

from typing import NamedTuple

from vibecalc.pipeline.tolerance import (
    CANCELLING,
    CHAOTIC,
    CHECKS,
    DIFFERENCES,
    LINE_STUDIES,
    LOOKED,
    LOOKED_AT,
    MARCH,
    PLACES,
    SEARCHED,
    SPECTRA,
    UNCERTAIN,
    cancels,
    reached,
)
from vibecalc.results.record import Quantity, Record

#: why results are not held to the tolerance, by the beginnings of their paths; the first that fits
_STARTS: tuple[tuple[tuple[str, ...], str], ...] = (
    ((CANCELLING,), "sums that are there to show what cancels"),
    (SPECTRA, "levels and phases, for which the harmonics behind them stand"),
    (UNCERTAIN, "uncertainties, of which two digits tell all"),
    (SEARCHED, "ends of searches, where a minimum is flat"),
    (LOOKED_AT, "the largest of what is looked at"),
    (LINE_STUDIES, "marches in time, differences, maps and ends of searches of a shaft line"),
    ((CHAOTIC,), "statistics, whose standard error is far larger"),
)
_PLACE = "places of summits, which are flat there"
_DIFFERENCE = "differences of results, with the digits that are left"
_LOOKED = "read off a march in time, as well as its steps show"
_CHECK = "checks that are zero for the exact solution, so that all of them is error"
_ZERO = "zero to rounding of their own terms"


class ToleranceSummary(NamedTuple):
    """Of all results with entries: how many are held to `rtol`, how many of these `met` it.

    `worst` is the path with the largest error estimate over size (`share`), empty for none;
    `exempt` pairs reasons with how many results they keep from being held to it.
    """

    rtol: float
    held: int
    met: int
    worst: str
    share: float
    exempt: tuple[tuple[str, int], ...]


def summarised(record: Record, rtol: float) -> ToleranceSummary:
    """Read off the error estimates of a record; what is exempt is decided by `tolerance.reached`.

    Counts, numbers of rows and texts, which have no error, are neither held nor exempt.
    """
    worst, share, held, met = "", -1.0, 0, 0
    exempt: dict[str, int] = {}
    for path, quantity in record.items():
        if not _has_error(quantity):
            continue
        own = reached(quantity, record)
        if own is None:
            why = _why(quantity)
            exempt[why] = exempt.get(why, 0) + 1
            continue
        held, met = held + 1, met + int(own <= rtol)
        if own > share:
            worst, share = path, own
    ranked = sorted(exempt.items(), key=lambda one: (-one[1], one[0]))
    return ToleranceSummary(rtol, held, met, worst, max(share, 0.0), tuple(ranked))


def _has_error(quantity: Quantity) -> bool:
    return quantity.values.size > 0 and quantity.values.dtype.kind in "fc"


def _why(quantity: Quantity) -> str:
    path = quantity.path
    if not cancels(quantity) and path.endswith(CHECKS):
        return _CHECK
    for starts, words in _STARTS:
        if path.startswith(starts):
            return words
    if path.endswith(PLACES):
        return _PLACE
    if any(part in path for part in DIFFERENCES):
        return _DIFFERENCE
    if quantity.standard_error is not None:
        return _STARTS[-1][1]
    if path.startswith(MARCH) and (path.endswith(LOOKED) or "/start_angles/" in path):
        return _LOOKED
    return _ZERO
